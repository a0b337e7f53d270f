"""Steps of ink files: read strictly, written so that they read back equal."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.errors import FormatError
from bozzetto.exchange.ink.ink_json import read_drawing, write_drawing
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.ink.steps import (
    DeleteStep,
    DragStep,
    DrawStep,
    DuplicateStep,
    GroupStep,
    MoveStep,
    RenameStep,
    SelectStep,
    SetStep,
    ShowStep,
    TapStep,
)
from bozzetto.view import Camera

SIDE = Camera("orthographic", (300.0, 0.0, 0.0), viewport=(640.0, 480.0))


def drawing(*steps):
    strokes = Strokes([Stroke([1.0, 2.0], [3.0, 4.0], Camera()) for _ in range(3)])
    return Drawing(strokes, Camera(), "d", steps=steps)


def file_with(steps):
    top = json.loads(write_drawing(drawing()))
    return json.dumps(top | {"steps": steps}).encode()


text = st.text(st.characters(codec="utf-8"), max_size=12)
value = st.booleans() | st.integers(-9, 9) | st.floats(-9, 9) | text | st.none()
place = st.integers(0, 2)
steps = st.one_of(
    st.builds(DrawStep, text, st.lists(place, min_size=1, max_size=4).map(tuple)),
    st.builds(DragStep, text, text, place, st.booleans(), st.booleans()),
    st.builds(
        TapStep,
        text,
        st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)),
        st.booleans(),
        st.booleans(),
        st.sampled_from([None, Camera(), SIDE]),
    ),
    st.builds(SetStep, st.dictionaries(text, value, max_size=3), text),
    st.builds(SelectStep, text),
    st.builds(RenameStep, text, text),
    st.builds(ShowStep, st.booleans(), text),
    st.builds(DeleteStep, text),
    st.builds(DuplicateStep, text),
    st.builds(MoveStep, text, st.integers(-5, 5), text),
    st.builds(GroupStep, st.lists(text, max_size=3).map(tuple)),
)


@given(st.lists(steps, max_size=6))
def test_steps_read_back_equal(made):
    one = drawing(*made)
    other = read_drawing(write_drawing(one), "d")
    assert other.steps == tuple(made)
    assert [repr(step) for step in other.steps] == [repr(step) for step in made], "types too"
    assert other.facts == {}


def test_colours_are_values():
    (step,) = read_drawing(file_with([{"set": {"color": [1, 2, 3], "other": None}}]), "d").steps
    assert step == SetStep({"color": (1, 2, 3), "other": None})


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ({}, "needs one of"),
        ({"tool": "draw"}, "needs one of"),
        ({"tool": "draw", "strokes": [0], "tap": [1, 2]}, "only one"),
        ({"tool": "draw", "strokes": [0], "colour": 1}, "there is no “colour”"),
        ({"tool": "draw", "strokes": [0], "camera": {}}, "there is no “camera”"),
        ({"tool": "draw", "strokes": []}, "names no stroke"),
        ({"tool": "draw", "strokes": [3]}, "no stroke 3; the file has 3"),
        ({"tool": "draw", "strokes": [-1]}, "no stroke -1"),
        ({"tool": "draw", "strokes": [True]}, "int"),
        ({"tool": "draw", "strokes": 0}, "array"),
        ({"strokes": [0]}, "tool"),
        ({"tool": 3, "strokes": [0]}, "str"),
        ({"tool": "turn", "drag": "joint", "stroke": 9}, "no stroke 9"),
        ({"tool": "turn", "drag": "joint"}, "stroke"),
        ({"tool": "pick", "tap": [1]}, "length"),
        ({"tool": "pick", "tap": [1, 1e12]}, "beyond all bounds"),
        ({"tool": "pick", "tap": [1, 2], "camera": {"kind": "fisheye"}}, "camera"),
        ({"tool": "pick", "tap": [1, 2], "canvas": 3, "camera": 3}, "camera"),
        ({"tool": "pick", "tap": [1, 2], "shift": 1}, "bool"),
        ({"set": [1]}, "object"),
        ({"set": {"a": [1, 2]}}, "set"),
        ({"set": {"a": {"b": 1}}}, "set"),
        ({"set": {}, "part": 3}, "str"),
        ({"show": "yes"}, "bool"),
        ({"rename": None}, "str"),
        ({"move": "Head"}, "at"),
        ({"move": "Head", "at": 1.5}, "int"),
        ({"group": "Head"}, "array"),
        ([], "object"),
        (7, "object"),
    ],
)
def test_what_is_no_step_is_refused_by_its_number(step, words):
    with pytest.raises(FormatError, match=words) as caught:
        read_drawing(file_with([{"select": ""}, step]), "d")
    if isinstance(step, dict):
        assert caught.value.message.startswith("step 2"), caught.value.message


@pytest.mark.parametrize("steps", [3, {}, "draw", None])
def test_steps_are_a_list(steps):
    with pytest.raises(FormatError, match="steps"):
        read_drawing(file_with(steps), "d")


def test_a_tap_has_the_sheets_canvas_unless_it_brings_its_own():
    camera = {"kind": "orthographic", "eye": [1, 0, 0], "target": [0, 0, 0], "height": 100}
    tap = {"tool": "t", "tap": [1, 2], "camera": camera}
    own = tap | {"canvas": {"width": 10, "height": 20}}
    sheets, its = read_drawing(file_with([tap, own]), "d").steps
    assert sheets.camera.viewport == Camera().viewport
    assert its.camera.viewport == (10.0, 20.0)
