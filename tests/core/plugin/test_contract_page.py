"""The page that is the contract: current, whole, and not longer than promised."""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

import bozzetto.plugin

DOCS = Path(__file__).resolve().parents[3] / "docs"

MOST_NAMES = 50
"""Public names of `bozzetto.plugin`: what an author can come to know in an afternoon."""


@pytest.fixture(scope="module")
def writer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("write_contract", DOCS / "write_contract.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_current(writer):
    written = (DOCS / "contract.md").read_text("utf-8")
    assert written == writer.page(), "run: python docs/write_contract.py"


def test_every_public_name_stands_there_once(writer):
    page = (DOCS / "contract.md").read_text("utf-8")
    public = bozzetto.plugin.__all__
    assert len(set(public)) == len(public) <= MOST_NAMES
    for name in set(public) - set(writer.BESIDE):
        first = writer.outline("bozzetto.plugin", name)
        assert page.count(f"```python\n{first}\n```") == 1, name
    for name in writer.BESIDE:
        assert f"`{name}`" in page or f".{name}`" in page
    for room in writer.ROOMS:
        section = page.partition(f"## `bozzetto.{room}`\n")[2].partition("\n## ")[0]
        for name in importlib.import_module(f"bozzetto.{room}").__all__:
            assert section.count(f"\n* `{name}") >= 1, f"{room}.{name}"


def test_the_reading_order_names_nothing_twice_and_nothing_private(writer):
    named = [name for names in writer.CHAPTERS.values() for name in names]
    assert len(set(named)) == len(named)
    assert set(named) | set(writer.BESIDE) <= set(bozzetto.plugin.__all__)
