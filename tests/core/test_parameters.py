from __future__ import annotations

import math
from dataclasses import dataclass, make_dataclass, replace
from typing import Annotated, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.parameters import (
    Parameter,
    idle_parameters,
    parameter_fields,
    parse_parameter,
    set_parameters,
    valued_fields,
)


@dataclass(frozen=True)
class State:
    plain: int = 5
    width: Annotated[float, Parameter("Width", 0.5, 20.0, unit="mm")] = 2.0
    cells: Annotated[int, Parameter("Cells", 4, 64)] = 8
    free: Annotated[float, Parameter("Free")] = 0.0
    mirrored: Annotated[bool, Parameter("Mirrored")] = False
    style: Annotated[Literal["round", "flat"], Parameter("Style")] = "round"
    words: Annotated[str, Parameter("Words")] = ""


FIELDS = {field.name: field for field in parameter_fields(State)}
anything = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.lists(st.integers(), max_size=3),
    st.sampled_from([10**400, -(10**400), "round", "flat", 1e308, -0.0, "x" * 5000]),
)


def test_fields_are_found_in_order():
    assert [(f.name, f.kind) for f in FIELDS.values()] == [
        ("width", "number"),
        ("cells", "integer"),
        ("free", "number"),
        ("mirrored", "switch"),
        ("style", "choice"),
        ("words", "text"),
    ]
    assert FIELDS["style"].values == ("round", "flat")
    assert FIELDS["width"].default == 2.0


@given(st.sampled_from(sorted(FIELDS)), anything)
def test_any_value_is_taken_as_it_should_be_or_refused(name, value):
    field = FIELDS[name]
    try:
        state = set_parameters(State(), {name: value})
    except UserError:
        with pytest.raises(UserError, match=field.parameter.label):
            field.check(value)
        return
    kept = getattr(state, name)
    kinds = {"number": float, "integer": int, "switch": bool, "choice": str, "text": str}
    assert type(kept) is kinds[field.kind]
    assert kept == value
    if field.kind in ("number", "integer"):
        assert math.isfinite(kept)
        assert field.parameter.minimum is None or kept >= field.parameter.minimum
        assert field.parameter.maximum is None or kept <= field.parameter.maximum
    assert set_parameters(state, {name: kept}) == state


@given(st.floats(0.5, 20.0), st.integers(4, 64), st.booleans(), st.sampled_from(["round", "flat"]))
def test_what_is_allowed_is_set_and_the_rest_stays(width, cells, mirrored, style):
    values = {"width": width, "cells": cells, "mirrored": mirrored, "style": style}
    start = State(plain=9, words="kept")
    state = set_parameters(start, values)
    assert (state.width, state.cells, state.mirrored, state.style) == tuple(values.values())
    assert (state.plain, state.words) == (9, "kept")
    assert start == State(plain=9, words="kept")


@given(st.floats(0.5, 20.0))
def test_numbers_are_read_as_they_are_written(width):
    assert parse_parameter(FIELDS["width"], repr(width)) == width
    assert parse_parameter(FIELDS["width"], f"  {width!r} ") == width


@given(st.integers(4, 64))
def test_whole_numbers_are_read(cells):
    assert parse_parameter(FIELDS["cells"], str(cells)) == cells


@given(st.sampled_from(sorted(FIELDS)), st.text(max_size=30))
def test_any_text_gives_a_value_that_can_be_set_or_a_sentence(name, text):
    try:
        value = parse_parameter(FIELDS[name], text)
    except UserError:
        return
    assert getattr(set_parameters(State(), {name: value}), name) == value


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("width", "nan"),
        ("width", "inf"),
        ("width", "0.49999"),
        ("width", "20.0001"),
        ("width", "2,5"),
        ("width", ""),
        ("cells", "8.5"),
        ("cells", "1e400"),
        ("free", "1e300"),
        ("mirrored", "perhaps"),
        ("style", "Round"),
    ],
)
def test_what_is_not_allowed_is_refused(name, text):
    with pytest.raises(UserError):
        parse_parameter(FIELDS[name], text)


@pytest.mark.parametrize(
    ("text", "value"), [("on", True), ("OFF", False), ("yes", True), ("0", False), (" true ", True)]
)
def test_switches(text, value):
    assert parse_parameter(FIELDS["mirrored"], text) is value


def test_range_is_told_with_its_unit():
    with pytest.raises(UserError, match=r"from 0\.5 to 20 mm; 30 is outside"):
        set_parameters(State(), {"width": 30.0})


@pytest.mark.parametrize("name", ["plain", "nothing", "__class__", ""])
def test_other_fields_are_no_parameters(name):
    with pytest.raises(UserError, match="width, cells"):
        set_parameters(State(), {name: 1})


@dataclass(frozen=True)
class WithoutDefault:
    size: Annotated[float, Parameter("Size")]


@dataclass(frozen=True)
class OfAnotherKind:
    size: Annotated[tuple[int, ...], Parameter("Size")] = ()


@dataclass(frozen=True)
class NumbersToChoose:
    size: Annotated[Literal[1, 2], Parameter("Size")] = 1


@pytest.mark.parametrize("kind", [WithoutDefault, OfAnotherKind, NumbersToChoose])
def test_states_that_cannot_be_shown_in_a_form(kind):
    with pytest.raises(TypeError, match="size"):
        parameter_fields(kind)


# -- parameters that count only sometimes ---------------------------------------------------------

Motor = Literal["off", "steady", "swing"]


@dataclass(frozen=True)
class Driven:
    motor: Annotated[Motor, Parameter("Motor", choices=(("off", "Turns freely"),))] = "off"
    speed: Annotated[float, Parameter("Speed", idle_while=(("motor", ("off", "swing")),))] = 90.0
    wall: Annotated[float, Parameter("Wall", 0.0, 9.0, zero="none")] = 0.0
    inward: Annotated[bool, Parameter("Inward", idle_while=(("wall", (0.0,)),))] = True
    lit: Annotated[bool, Parameter("Lit")] = False
    color: Annotated[
        str, Parameter("Light", idle_while=(("lit", (False,)), ("motor", ("off",))))
    ] = ""


def test_what_changes_nothing_is_told_with_the_reason():
    assert idle_parameters(valued_fields(Driven())) == {
        "speed": "“Speed” changes nothing while “Motor” is “Turns freely”.",
        "inward": "“Inward” changes nothing while “Wall” is none.",
        "color": "“Light” changes nothing while “Lit” is off and “Motor” is “Turns freely”.",
    }
    turning = Driven(motor="steady", wall=2.0)
    assert idle_parameters(valued_fields(turning)) == {}
    assert set(idle_parameters(valued_fields(replace(turning, motor="swing")))) == {"speed"}


@pytest.mark.parametrize(
    "condition",
    [
        (("moter", ("off",)),),
        (("speed", (90.0,)),),
        (("motor", ("of",)),),
        (("motor", (1,)),),
        (("lit", (0,)),),
        (("lit", (False,)), ("motor", "off")),
        ("motor", ("off",)),
        "motor",
    ],
)
def test_a_condition_that_cannot_be_is_refused(condition):
    note = Parameter("Speed", idle_while=condition)
    made = make_dataclass(
        "Made",
        [
            ("motor", Annotated[Motor, Parameter("Motor")], "off"),
            ("lit", Annotated[bool, Parameter("Lit")], False),
            ("speed", Annotated[float, note], 90.0),
        ],
    )
    with pytest.raises(TypeError, match="speed"):
        parameter_fields(made)


@pytest.mark.parametrize(
    "hint", [str, int, Literal["round", "sharp"]], ids=["a text", "a number", "another value"]
)
def test_choices_are_values_that_the_field_can_have(hint):
    ends = Parameter("Ends", choices=(("round", "Round"), ("flat", "Flat")))
    kind = make_dataclass("Kind", [("ends", Annotated[hint, ends], "round")], frozen=True)
    with pytest.raises(TypeError, match=r"Kind\.ends: .*'(flat|round)'"):
        parameter_fields(kind)
    fine = Annotated[Literal["round", "flat"], ends]
    kind = make_dataclass("Kind", [("ends", fine, "round")], frozen=True)
    assert parameter_fields(kind)[0].kind == "choice"
