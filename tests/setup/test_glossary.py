"""Every word in the name of a module stands in the glossary, and the glossary in the code."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "glossary.md"
FORBIDDEN = {"util", "utils", "helper", "helpers", "misc", "common", "stuff"}


def words_of_modules() -> set[str]:
    found: set[str] = set()
    for folder in ("core", "app", "plugins"):
        for path in (ROOT / folder).rglob("*.py"):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts[1:]
            names = [part for part in parts if not part.startswith("__")]
            found.update(word for name in names for word in name.split("_"))
    return found - {""}


def test_every_word_is_explained_or_plain() -> None:
    page = PAGE.read_text(encoding="utf-8")
    terms, _, plain = page.partition("## Plain words")
    explained = {
        word
        for cell in re.findall(r"^\| ([^|]+) \| [^|]+ \|$", terms, re.MULTILINE)
        for word in cell.split()
    }
    known = explained | set(re.findall(r"\w+", plain))
    unknown = {word for word in words_of_modules() if not {word, _singular(word)} & known}
    assert not unknown, "explain these in docs/glossary.md, or take a word that stands there"


def test_no_room_is_named_after_nothing() -> None:
    assert not words_of_modules() & FORBIDDEN


def _singular(word: str) -> str:
    return word.removesuffix("s")
