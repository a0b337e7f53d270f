"""The file: what goes in comes out, and other programs can read it."""

from __future__ import annotations

from tests.document_kit import FakeRegistry, rich_document, same_document

from bozzetto.document.file import read_document, write_document


def test_a_document_comes_back_as_it_was(tmp_path):
    document = rich_document()
    write_document(document, tmp_path / "a.bozz")
    again, report = read_document(tmp_path / "a.bozz", FakeRegistry())
    assert same_document(document, again)
    assert not report.read_only
    assert len(report.warnings) == 1
    assert "absent.modeler" in report.warnings[0]
