"""The documentation's links lead somewhere: to files, and to headings in them."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("docs/gallery/**/*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_to_a_file_leads_to_one(page):
    targets = re.findall(r"\]\((?!https?:|#|mailto:)([^)#\s]+)", page.read_text(encoding="utf-8"))
    missing = [target for target in targets if not (page.parent / target).exists()]
    assert not missing


def headings(page: Path) -> set[str]:
    """What links call the headings of a page, as GitHub makes it of their words."""
    found: dict[str, int] = {}
    names = set()
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for title in re.findall(r"^#+ (.+)$", text, re.M):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).lower()
        name = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        number = found[name] = found.get(name, -1) + 1
        names.add(f"{name}-{number}" if number else name)
    return names


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_to_a_heading_leads_to_one(page):
    links = re.findall(r"\]\((?!https?:|mailto:)([^)#\s]*)#([^)\s]+)\)", page.read_text("utf-8"))
    pages = [(page.parent / file if file else page, name) for file, name in links]
    missing = [
        f"{target.name}#{name}"
        for target, name in pages
        if target.suffix == ".md" and name not in headings(target)
    ]
    assert not missing


@pytest.mark.parametrize(("names", "made"), [((), "ab"), (("figures_a",), "a"), (("a",), "")])
def test_tables_are_made_anew_whatever_their_commands_are_given(monkeypatch, names, made):
    spec = importlib.util.spec_from_file_location("write_figures", ROOT / "docs/write_figures.py")
    writer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(writer)
    monkeypatch.setattr(writer, "output_of", lambda command: command.split()[1][-1])
    block = "<!-- figures: python -m tests.x.figures_{} -->\n\nold\n\n<!-- /figures -->\n"
    page = block.format("a 1200") + block.format("b")
    assert "".join(re.findall(r"^[ab]$", writer.written(page, names), re.M)) == made
    assert writer.written(page, names).count("old") == 2 - len(made)
