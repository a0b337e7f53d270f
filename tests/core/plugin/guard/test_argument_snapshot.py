from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.ink import Strokes
from bozzetto.plugin.guard.argument_snapshot import MOST_OBJECTS, ArgumentSnapshot
from bozzetto.testing import Pen


@dataclass(frozen=True)
class Leaf:
    number: float = 1.0
    word: str = "a"


@dataclass(frozen=True)
class Branch:
    leaves: tuple[Leaf, ...] = ()
    extra: dict = field(default_factory=dict)
    numbers: list = field(default_factory=list)


leaves = st.builds(Leaf, st.floats(allow_nan=False), st.text(max_size=3))
branches = st.builds(
    Branch,
    st.lists(leaves, max_size=4).map(tuple),
    st.dictionaries(st.text(max_size=2), leaves, max_size=3),
    st.lists(st.integers(), max_size=3),
)


@given(st.lists(branches, min_size=1, max_size=3), st.data())
def test_whatever_is_overwritten_is_put_back(arguments, data):
    before, text = ArgumentSnapshot(arguments), repr(arguments)
    assert before.restore() == []
    branch = data.draw(st.sampled_from(arguments))
    targets = [branch, *branch.leaves, *branch.extra.values()]
    target = data.draw(st.sampled_from(targets))
    name = data.draw(st.sampled_from([entry.name for entry in fields(target)]))
    value = object()
    # A deleted field with a default shows that default: only these two are missed.
    if name in ("extra", "numbers") and data.draw(st.booleans()):
        object.__delattr__(target, name)
    else:
        object.__setattr__(target, name, value)
    assert before.restore() == [f"{type(target).__name__}.{name}"]
    assert repr(arguments) == text
    branch.numbers.append(value)
    branch.extra["new"] = value
    assert sorted(before.restore()) == ["a dict", "a list"]
    assert repr(arguments) == text


def test_arrays_that_can_be_written_to():
    array = np.arange(5.0)
    before = ArgumentSnapshot([(array,)])
    array[2] = np.nan
    assert before.restore() == ["an array"]
    assert array.tolist() == [0, 1, 2, 3, 4]


def test_strokes_within_strokes():
    strokes = Strokes([Pen().circle(radius=r) for r in range(100, 300)])
    before = ArgumentSnapshot([strokes])
    column = strokes[150].x
    object.__setattr__(strokes[150], "x", strokes[0].x)
    object.__setattr__(strokes[3], "camera", None)
    assert before.restore() == ["Stroke.camera", "Stroke.x"]
    assert strokes[150].x is column


def test_rings_and_crowds_come_to_an_end():
    ring: list = []
    ring.append(ring)
    assert ArgumentSnapshot([ring]).restore() == []
    crowd = [Leaf(float(i)) for i in range(MOST_OBJECTS * 20)]
    before = ArgumentSnapshot(crowd)
    object.__setattr__(crowd[0], "number", 7.0)
    assert before.restore() == ["Leaf.number"]


def test_classes_and_functions_among_the_arguments_are_left_alone():
    class Odd:
        __slots__ = ("missing",)

    assert ArgumentSnapshot([Leaf, print, Odd(), 1j, ..., {Leaf}]).restore() == []
