"""The strokes of a state, whatever its types are called."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Group, Part, PartsState
from bozzetto.plugin.state_ink import ink_of_state
from bozzetto.view import Camera


def stroke(x, tool="pen"):
    return Stroke([x, x + 1.0], [0.0, 1.0], Camera(), tool=tool)


A, B, C, D, RUBBED = (*(stroke(10.0 * n) for n in range(4)), stroke(50.0, "eraser"))


@dataclass(frozen=True)
class Leaf:
    one: Stroke
    name: str = "leaf"


@dataclass(frozen=True)
class Nest:
    size: float = 1.0
    first: Strokes = Strokes()
    rest: tuple[object, ...] = ()
    by_name: object = None


@dataclass(frozen=True)
class Line(Part):
    strokes: Strokes = Strokes()


@dataclass(frozen=True)
class Lines(PartsState):
    edits: tuple[Leaf, ...] = ()


def found(state):
    return [next(n for n, one in enumerate((A, B, C, D, RUBBED)) if one is x)
            for x in ink_of_state(state)]  # fmt: skip


@pytest.mark.parametrize(
    ("state", "order"),
    [
        (Nest(), []),
        (Nest(first=Strokes([B, A])), [1, 0]),
        (Nest(first=Strokes([A]), rest=(Leaf(C), Nest(first=Strokes([B])))), [0, 2, 1]),
        (Nest(rest=((Leaf(D), Leaf(C)), 3, "text", None), by_name={"x": Leaf(A)}), [3, 2, 0]),
        (Nest(first=Strokes([A, RUBBED, B])), [0, 1]),
        (Nest(first=Strokes([A]), rest=(Leaf(A), Leaf(B))), [0, 1]),
    ],
    ids=["none", "row", "nested", "mixed", "eraser", "twice"],
)
def test_all_strokes_come_in_the_order_of_fields(state, order):
    assert found(state) == order


def test_hidden_parts_are_left_out_with_what_is_in_a_hidden_group():
    nodes = (
        Line("n1", "One", strokes=Strokes([A])),
        Line("n2", "Two", visible=False, strokes=Strokes([B])),
        Line("n3", "Three", within="g1", strokes=Strokes([C])),
        Group("g1", "Group", visible=False),
    )
    assert found(Lines(nodes=nodes, edits=(Leaf(D),))) == [0, 3]


def test_a_recipe_may_be_nested_deeper_than_the_interpreter_calls():
    nest = Nest(first=Strokes([A]))
    for _ in range(5000):
        nest = Nest(rest=(nest,))
    assert found(nest) == [0]
