"""The guide that is shipped is whole: its pages, their links and their pictures."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from bozzetto_app.dialogs.guide_pages import FIRST_PAGE, guide_folder, headings_of, shown_text, slug

ROOT = Path(__file__).parents[3]
PACKED = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["build"][
    "targets"
]["wheel"]["force-include"]
LINK = re.compile(r"\]\(([^)\s]+)\)")


def packed_files():
    """What a wheel holds of the guide, by its name there below the guide's folder."""
    for source, name in PACKED.items():
        here, there = ROOT / source, name.removeprefix("bozzetto_app/guide/")
        for path in here.rglob("*") if here.is_dir() else (here,):
            yield f"{there}/{path.name}" if here.is_dir() else there


@pytest.mark.parametrize("page", [name for name in packed_files() if name.endswith(".md")])
def test_whatever_a_page_names_is_shipped_with_it(page):
    names = set(packed_files())
    text = (ROOT / "docs" / page).read_text("utf-8")
    for link in LINK.findall(text):
        if link.startswith(("http:", "https:")):
            continue
        name, _, anchor = link.partition("#")
        assert (name or page) in names, link
        if anchor:
            target = (ROOT / "docs" / (name or page)).read_text("utf-8")
            assert anchor in [one.anchor for one in headings_of(target)], link


def test_the_guide_is_found_and_its_first_page_is_there():
    text = (guide_folder() / FIRST_PAGE).read_text("utf-8")
    assert next(headings_of(text)).words == "The guide"
    assert "<kbd>" in text
    assert "<" not in re.sub(r"```.*?```|<-|->", "", shown_text(text), flags=re.DOTALL)


def test_headings_and_anchors():
    assert slug("Marks files (`marks_file`)") == "marks-files-marks_file"
    text = "# One\n\n```sh\n# no heading\n```\n\n## <kbd>Q</kbd> and more\n"
    assert [(one.words, one.depth) for one in headings_of(text)] == [("One", 1), ("Q and more", 2)]
