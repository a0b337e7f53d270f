"""Rows of parts: which are shown, what is new in them."""

from __future__ import annotations

from dataclasses import dataclass

from bozzetto.plugin import switched_on, unused_id, unused_name, with_part


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


def test_a_part_takes_the_place_of_the_one_of_its_id_or_comes_last() -> None:
    row = (Thing("a"), Thing("b"))
    assert with_part(row, Thing("a", name="new")) == (Thing("a", name="new"), Thing("b"))
    assert with_part(row, Thing("c")) == (*row, Thing("c"))


def test_new_ids_and_names_are_free() -> None:
    row = (Thing("n1", name="Curve 2"), Thing("n3", name="Curve 1"))
    assert unused_id(row) == "n2"
    assert unused_name(row, "Curve") == "Curve 3"
    assert unused_id(()) == "n1"
