"""The tree of parts: whatever a person does to it, it stays a tree, and nothing is lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.plugin import Parameter, Part
from bozzetto.plugin.guard.answer_validation import sound_parts
from bozzetto.plugin.part_tree import PartTree


@dataclass(frozen=True)
class Piece(Part):
    size: Annotated[float, Parameter("Size", 0.0, 9.0)] = 1.0


def tree_of(text, selected=""):
    """A tree from words such as "a b(c d(e)) f"; what has brackets is a group."""
    parts, groups, stack, last = [], set(), [""], ""
    for letter in text.replace(" ", ""):
        if letter == "(":
            groups.add(last)
            stack.append(last)
        elif letter == ")":
            stack.pop()
        else:
            last = letter
            parts.append(Piece(letter, letter.upper(), within=stack[-1]))
    return PartTree(tuple(parts), frozenset(groups), selected)


def words(tree, group=""):
    """The tree as such words again."""
    said = []
    for part in tree.within(group):
        inner = words(tree, part.id)
        said.append(f"{part.id}({inner})" if part.id in tree.groups else part.id)
    return " ".join(said)


@pytest.mark.parametrize(
    ("gone", "left", "chosen"),
    [
        ("a", "b(c d(e)) f", "b"),
        ("bf", "a", "a"),
        ("ec", "a b(d()) f", "d"),
        ("be", "a f", "f"),
        ("abf", "", ""),
    ],
)
def test_several_parts_go_at_once(gone, left, chosen):
    tree = tree_of("a b(c d(e)) f", gone[0]).without(*gone)
    assert words(tree) == left
    assert tree.selected == chosen
    sound_parts(tree)


@pytest.mark.parametrize(
    ("kept", "left"),
    [("a", "a"), ("e", "b(d(e))"), ("ce", "b(c d(e))"), ("d", "b(d(e))"), ("", "")],
)
def test_only_some_parts_are_kept_with_the_groups_around_them(kept, left):
    tree = tree_of("a b(c d(e)) f", "f").only(kept)
    assert words(tree) == left
    assert tree.selected == ""
    sound_parts(tree)


@pytest.mark.parametrize(
    ("group", "left", "chosen"),
    [("b", "a c d(e) f", "c"), ("d", "a b(c e) f", "e")],
)
def test_what_is_in_a_dissolved_group_stands_where_it_stood(group, left, chosen):
    tree = tree_of("a b(c d(e)) f", group).ungrouped(group)
    assert words(tree) == left
    assert tree.selected == chosen
    sound_parts(tree)


def test_an_empty_group_is_dissolved_without_a_trace():
    tree = tree_of("a b() f", "b")
    assert words(tree.ungrouped("b")) == "a f"
    assert tree.ungrouped("b").selected == ""


def test_a_hidden_groups_parts_stay_hidden():
    tree = tree_of("a b(c d)").shown("b", False).ungrouped("b")
    assert [part.visible for part in tree.parts] == [True, False, False]


def test_no_group_is_not_dissolved():
    with pytest.raises(UserError, match="“A” is not a group"):
        tree_of("a b(c)").ungrouped("a")


def test_grouping_and_ungrouping_is_the_way_there_and_back():
    tree = tree_of("a b(c d(e)) f")
    there = tree.grouped("ab", Piece("g", "G"))
    assert words(there.ungrouped("g")) == words(tree)


def test_rows_are_listed_group_by_group_whatever_order_they_are_kept_in():
    kept = tree_of("a b(c d(e)) f")
    mixed = PartTree(tuple(reversed(kept.parts)), kept.groups)
    assert [(part.id, depth) for part, depth in kept.rows()] == [
        ("a", 0), ("b", 0), ("c", 1), ("d", 1), ("e", 2), ("f", 0),
    ]  # fmt: skip
    assert words(mixed) == "f b(d(e) c) a"


@pytest.mark.parametrize(
    ("part", "group", "at", "expected"),
    [
        ("a", "", 0, "a b(c d(e)) f"),
        ("a", "", 1, "b(c d(e)) a f"),
        ("a", "", 99, "b(c d(e)) f a"),
        ("a", "", -5, "a b(c d(e)) f"),
        ("f", "", 0, "f a b(c d(e))"),
        ("f", "b", 0, "a b(f c d(e))"),
        ("f", "b", 1, "a b(c f d(e))"),
        ("f", "b", 2, "a b(c d(e) f)"),
        ("f", "d", 1, "a b(c d(e f))"),
        ("d", "", 0, "d(e) a b(c) f"),
        ("e", "", 2, "a b(c d()) e f"),
        ("b", "", 2, "a f b(c d(e))"),
    ],
)
def test_a_part_goes_where_it_is_put(part, group, at, expected):
    assert words(tree_of("a b(c d(e)) f").moved(part, group, at)) == expected


@pytest.mark.parametrize("group", ["b", "d"])
def test_a_group_is_not_put_into_itself(group):
    with pytest.raises(UserError, match="into itself"):
        tree_of("a b(c d(e)) f").moved("b", group, 0)


def test_only_groups_take_others_in():
    with pytest.raises(UserError, match="“F” is not a group"):
        tree_of("a b(c) f").moved("a", "f", 0)


@pytest.mark.parametrize(
    ("chosen", "expected", "now"),
    [
        ("ac", "g(a c) b(d(e)) f", "g"),
        ("fa", "g(a f) b(c d(e))", "g"),
        ("cd", "a b(g(c d(e))) f", "g"),
        ("de", "a b(c g(d(e))) f", "g"),
        ("b", "a g(b(c d(e))) f", "g"),
    ],
)
def test_parts_become_a_group_where_the_first_of_them_stood(chosen, expected, now):
    made = tree_of("a b(c d(e)) f").grouped(chosen, Piece("g", "Group 1"))
    assert (words(made), made.selected) == (expected, now)


@pytest.mark.parametrize(
    ("part", "left", "now"),
    [("a", "b(c d(e)) f", "b"), ("f", "a b(c d(e))", "b"), ("b", "a f", "f"),
     ("e", "a b(c d()) f", "d"), ("d", "a b(c) f", "c")],
)  # fmt: skip
def test_a_part_goes_with_what_is_in_it_and_its_neighbour_is_chosen(part, left, now):
    tree = tree_of("a b(c d(e)) f", part).without(part)
    assert (words(tree), tree.selected) == (left, now)
    kept = tree_of("a b(c d(e)) f", "a")
    if part != "a":
        assert kept.without(part).selected == "a"


def test_a_copy_stands_behind_with_new_ids_and_names():
    tree = tree_of("a b(c d(e)) f").doubled("b")
    assert words(tree) == "a b(c d(e)) n1(n2 n3(n4)) f"
    assert tree.selected == "n1"
    assert [tree.part(f"n{k}").name for k in (1, 2, 3, 4)] == ["B 2", "C 2", "D 2", "E 2"]
    again = tree.renamed("a", "B 3").doubled("n1")
    assert again.part(again.selected).name == "B 4"


@pytest.mark.parametrize("name", ["", "  ", "two\nlines", "x" * 201])
def test_a_name_that_no_list_could_show_is_refused(name):
    with pytest.raises(UserError, match="A name has"):
        tree_of("a").renamed("a", name)
    assert tree_of("a").renamed("a", " Kopf 👨‍👩‍👧 ").part("a").name == "Kopf 👨‍👩‍👧"


def test_parts_are_found_by_name_and_then_by_id():
    tree = tree_of("a b c").renamed("a", "b").renamed("c", "b")
    assert tree.renamed("c", "C").find("b") == "a"
    assert tree.find("B") == "b"
    with pytest.raises(UserError, match="2 parts are called “b”"):
        tree.find("b")
    with pytest.raises(UserError, match="there are: b, B, b"):
        tree.find("x")


def test_values_are_checked_and_told_apart():
    with pytest.raises(UserError, match="“A” has: size"):
        tree_of("a").valued("a", {"girth": 1.0})
    with pytest.raises(UserError, match="from 0 to 9"):
        tree_of("a").valued("a", {"size": 10.0})
    assert tree_of("a b").valued("a", {"size": 2}).part("a").size == 2.0


@pytest.mark.parametrize(
    "act",
    [
        lambda tree: tree.chosen("x"),
        lambda tree: tree.renamed("x", "X"),
        lambda tree: tree.shown("x", False),
        lambda tree: tree.without("x"),
        lambda tree: tree.doubled("x"),
        lambda tree: tree.moved("x", "", 0),
        lambda tree: tree.moved("a", "x", 0),
        lambda tree: tree.grouped(["x"], Piece("g", "G")),
        lambda tree: tree.grouped([], Piece("g", "G")),
    ],
)
def test_what_is_not_there_is_refused(act):
    with pytest.raises(UserError):
        act(tree_of("a b(c)"))


@st.composite
def acts(draw):
    kind = draw(st.sampled_from(("move", "group", "double", "delete")))
    return kind, draw(st.integers(0, 30)), draw(st.integers(0, 30)), draw(st.integers(-2, 12))


@given(st.lists(acts(), max_size=12))
def test_whatever_is_done_it_stays_a_tree_in_which_nothing_is_lost(steps):
    tree = tree_of("a b(c d(e)) f")
    for number, (kind, one, other, at) in enumerate(steps):
        if not tree.parts or len(tree.parts) > 60:
            break
        part = tree.parts[one % len(tree.parts)].id
        before = {p.id for p in tree.parts}
        family = {p.id for p in tree.family(part)}
        if kind == "move":
            goals = ["", *sorted(tree.groups)]
            goal = goals[other % len(goals)]
            if goal in family:
                with pytest.raises(UserError):
                    tree.moved(part, goal, at)
                continue
            tree = tree.moved(part, goal, at)
            assert {p.id for p in tree.parts} == before
            assert {p.id for p in tree.family(part)} == family
            row = [p.id for p in tree.within(goal)]
            assert row.index(part) == max(0, min(at, len(row) - 1))
        elif kind == "group":
            second = tree.parts[other % len(tree.parts)].id
            tree = tree.grouped({part, second}, Piece(f"g{number}", "G"))
            assert {p.id for p in tree.parts} == before | {f"g{number}"}
            assert {part, second} <= {p.id for p in tree.family(f"g{number}")}
        elif kind == "double":
            tree = tree.doubled(part)
            assert len(tree.parts) == len(before) + len(family)
            assert len(tree.family(tree.selected)) == len(family)
        else:
            tree = tree.without(part)
            assert {p.id for p in tree.parts} == before - family
        assert sound_parts(tree) is tree
        assert sorted(p.id for p, _ in tree.rows()) == sorted(p.id for p in tree.parts)
