"""The file of a document: container, records, codecs, migrations."""
