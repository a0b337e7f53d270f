"""Files of other programs: one module a format, one table of formats.

`bozzetto.exchange.formats` holds the table, `bozzetto.exchange.export` writes and
`bozzetto.exchange.import_file` reads. The modules of the formats work on bytes and values
alone, never on files, and are imported when first needed.
"""
