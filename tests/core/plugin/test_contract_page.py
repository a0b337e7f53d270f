"""The page that is the contract: current, whole, and not longer than promised."""

from __future__ import annotations

import bozzetto.plugin
from docs import write_contract

MOST_NAMES = 50
"""Public names of `bozzetto.plugin`: what an author can come to know in an afternoon."""

PAGE = write_contract.PAGE.read_text("utf-8")


def test_the_page_is_current():
    assert write_contract.page() == PAGE, "run: python docs/write_contract.py"


def test_every_public_name_stands_there_once():
    public = bozzetto.plugin.__all__
    assert len(set(public)) == len(public) <= MOST_NAMES
    for name in set(public) - set(write_contract.BESIDE):
        first = write_contract.outline("bozzetto.plugin", name)
        assert PAGE.count(f"```python\n{first}\n```") == 1, name
    for name in write_contract.BESIDE:
        assert f"`{name}`" in PAGE or f".{name}`" in PAGE


def test_the_reading_order_names_nothing_twice_and_nothing_private():
    named = [name for names in write_contract.CHAPTERS.values() for name in names]
    assert len(set(named)) == len(named)
    assert set(named) | set(write_contract.BESIDE) <= set(bozzetto.plugin.__all__)
