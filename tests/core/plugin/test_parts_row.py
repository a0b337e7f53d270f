"""Rows of parts: which are shown, what is new in them."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from bozzetto.plugin import Group, Part, PartsState


@dataclass(frozen=True)
class Thing(Part):
    size: float = 1.0


def row(*nodes: Part, selected: str = "") -> PartsState:
    return PartsState(nodes, selected)


def test_a_part_needs_all_groups_around_it() -> None:
    inner, outer = Group("inner", within="outer"), Group("outer", visible=False)
    parts = row(Thing("a"), Thing("b", within="inner"), inner, outer, Thing("c", visible=False))
    assert [part.id for part in parts.shown(Part)] == ["a"]


def test_a_group_that_is_not_there_hides_nothing() -> None:
    assert row(Thing("a", within="gone")).shown(Thing)[0].id == "a"


def test_groups_in_a_ring_end() -> None:
    assert len(row(Thing("a", within="b"), Thing("b", within="a")).shown(Thing)) == 2


def test_parts_are_found_by_their_kind_and_id() -> None:
    parts = row(Thing("a"), Group("g"), Thing("b"), selected="b")
    assert [part.id for part in parts.of_kind(Thing)] == ["a", "b"]
    assert parts.chosen_of(Thing) is parts.node("b")
    assert parts.chosen_of(Group) is None
    with pytest.raises(KeyError):
        parts.node("c")


def test_a_part_takes_the_place_of_the_one_of_its_id_or_comes_last() -> None:
    parts = row(Thing("a"), Thing("b"))
    changed = parts.with_node(Thing("a", name="new"))
    assert changed.nodes == (Thing("a", name="new"), Thing("b"))
    assert changed.selected == "a"
    assert parts.with_node(Thing("c")).nodes == (*parts.nodes, Thing("c"))


def test_what_goes_is_no_longer_chosen() -> None:
    parts = row(Thing("a"), Thing("b"), selected="a")
    assert parts.without_nodes("a") == row(Thing("b"))
    assert parts.without_nodes("b").selected == "a"


def test_new_ids_and_names_are_free() -> None:
    parts = row(Thing("n1", name="Curve 2"), Thing("n3", name="Curve 1"))
    assert parts.unused_id() == "n2"
    assert parts.unused_name("Curve") == "Curve 3"
    assert row().unused_id() == "n1"
