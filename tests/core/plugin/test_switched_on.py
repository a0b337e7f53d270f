"""Which parts are shown."""

from __future__ import annotations

from dataclasses import dataclass

from bozzetto.plugin import switched_on


@dataclass(frozen=True)
class Thing:
    id: str
    within: str = ""
    visible: bool = True
    name: str = ""


def test_a_part_needs_all_groups_around_it() -> None:
    inner, outer = Thing("inner", "outer"), Thing("outer", visible=False)
    parts = (Thing("a"), Thing("b", "inner"), inner, outer, Thing("c", visible=False))
    assert [part.id for part in switched_on(parts)] == ["a"]


def test_a_group_that_is_not_there_hides_nothing() -> None:
    assert switched_on([Thing("a", "gone")])[0].id == "a"


def test_groups_in_a_ring_end() -> None:
    assert len(switched_on([Thing("a", "b"), Thing("b", "a")])) == 2
