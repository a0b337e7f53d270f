from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.parameters import (
    Parameter,
    needed_first,
    parameter_fields,
    parse_parameter,
    set_parameters,
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


def test_a_parameter_that_needs_others_names_them_until_one_is_set() -> None:
    @dataclass(frozen=True)
    class Car:
        complete: Annotated[bool, Parameter("Complete")] = False
        length: Annotated[float, Parameter("Length")] = 0.0
        keep: Annotated[bool, Parameter("Keep", needs=("complete", "length"))] = False

    fields = parameter_fields(Car)
    values = {
        (False, 0.0): ("Complete", "Length"),
        (True, 0.0): (),
        (False, 4300.0): (),
    }
    for (complete, length), labels in values.items():
        found = list(zip(fields, (complete, length, True), strict=True))
        assert needed_first(fields[2], found) == labels
        assert needed_first(fields[0], found) == ()

    @dataclass(frozen=True)
    class Misspelt:
        keep: Annotated[bool, Parameter("Keep", needs=("lenght",))] = False

    with pytest.raises(TypeError, match="needs"):
        parameter_fields(Misspelt)
