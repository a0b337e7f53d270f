"""States taken apart and put together: everything comes back, nothing else gets in."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, TypeVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from typing_extensions import TypeAliasType

from bozzetto.arrays import frozen
from bozzetto.document.storage.side_tables import Refusal
from bozzetto.document.storage.state_codec import (
    EncodedState,
    OpaqueState,
    check_encodable,
    decode_state,
    encode_state,
    state_digest,
)
from bozzetto.document.storage.type_forms import MAX_DEPTH, form_of
from bozzetto.errors import DocumentError
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.parameters import Parameter, parameter_fields
from tests.document_kit import (
    Disc,
    Everything,
    Ink,
    Line,
    Tree,
    everything,
    full_stroke,
    same_state,
    stroke,
)

number = st.floats(allow_nan=False, allow_infinity=False)
text = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
mark = st.builds(Disc, number, st.tuples(number, number)) | st.builds(Line, number)
tree = st.recursive(
    st.builds(Tree, text), lambda t: st.builds(Tree, text, st.lists(t, max_size=3).map(tuple))
)
ink = st.integers(0, 5).map(full_stroke) | st.integers(0, 5).map(stroke)
states = st.builds(
    Everything,
    strokes=st.lists(ink, max_size=4).map(Strokes),
    softness=st.floats(1.25, 2.0),
    cells=st.integers(8, 512),
    kind=st.sampled_from(["round", "flat"]),
    closed=st.booleans(),
    note=text,
    marks=st.lists(mark, max_size=4).map(tuple),
    best=st.none() | ink,
    weights=st.lists(number, max_size=5).map(lambda v: frozen(v, np.float64)),
    flags=st.none() | st.binary(max_size=6).map(lambda b: frozen(list(b), np.uint8)),
    tree=tree,
    pair=st.tuples(st.integers(-(2**63) + 1, 2**63 - 1), st.none() | text),
)


@settings(max_examples=150, deadline=None)
@given(states)
def test_every_state_comes_back_bit_for_bit(state):
    check_encodable(Everything, state)
    encoded = encode_state(state)
    json.loads(encoded.json, parse_constant=pytest.fail)  # strict JSON, no NaN
    again = decode_state(Everything, encoded)
    assert same_state(state, again)
    assert encode_state(again).json == encoded.json


def test_a_stroke_that_is_used_twice_is_kept_once_and_stays_one_object():
    state = everything()
    encoded = encode_state(state)
    assert len(encoded.strokes) == 3
    again = decode_state(Everything, encoded)
    assert again.best is again.strokes[1]


def test_equal_states_have_equal_digests_and_others_do_not():
    state = everything()
    assert state_digest(state) == state_digest(everything())
    changed = [
        replace(state, softness=1.76),
        replace(state, strokes=state.strokes.replaced(0, stroke(99))),
        replace(state, weights=frozen([[0.1, 1 / 3], [1e-300, -7.5]], np.float64)),
        replace(state, weights=frozen([0.1, 1 / 3, 1e-300, -7.0], np.float64)),
    ]
    assert len({state_digest(s) for s in [state, *changed]}) == 5


writable = np.zeros(3)
view = np.zeros(3)[:]
view.flags.writeable = False


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"softness": float("nan")}, "state.softness"),
        ({"softness": 3.0}, "state.softness"),
        ({"cells": 7}, "state.cells"),
        ({"cells": True}, "state.cells"),
        ({"cells": 2**63}, "state.cells"),
        ({"closed": 1}, "state.closed"),
        ({"kind": "oval"}, "state.kind"),
        ({"note": "\ud800"}, "state.note"),
        ({"note": None}, "state.note"),
        ({"marks": [Disc(1.0)]}, "state.marks"),
        ({"marks": (Disc(1.0), Line(float("inf")))}, "state.marks[1].radius"),
        ({"marks": (Disc(1.0, (0.0, float("nan"))),)}, "state.marks[0].at[1]"),
        ({"marks": (Disc(1.0, (0.0,)),)}, "state.marks[0].at"),
        ({"pair": (1, 2)}, "state.pair[1]"),
        ({"strokes": (stroke(),)}, "state.strokes"),
        ({"weights": writable}, "state.weights"),
        ({"weights": view}, "state.weights"),
        ({"weights": frozen([1], np.float32)}, "state.weights"),
        ({"weights": [1.0]}, "state.weights"),
        ({"weights": frozen(np.zeros((1, 1, 1, 1, 1)), np.float64)}, "state.weights"),
        ({"flags": np.frombuffer(b"x", np.int8)}, "state.flags"),
        ({"tree": Tree("a", (Tree("b", (3,)),))}, "state.tree.children[0].children[0]"),
        ({"camera": {"kind": "perspective"}}, "state.camera"),
    ],
)
def test_what_cannot_be_kept_is_refused_with_its_place(changes, place):
    before = everything()
    state = replace(before, **changes)
    with pytest.raises(ValueError, match=place.replace("[", r"\[")) as told:
        check_encodable(Everything, state)
    with pytest.raises(ValueError, match=place.replace("[", r"\[")) as told_of_change:
        check_encodable(Everything, state, before)
    assert str(told_of_change.value) == str(told.value)


def test_a_change_of_numbers_alone_is_not_encoded_as_a_whole(monkeypatch):
    before = everything()
    monkeypatch.setattr("bozzetto.document.storage.state_codec.encode_state", None)
    check_encodable(Everything, replace(before, softness=1.5, cells=9, closed=False), before)
    with pytest.raises(TypeError):
        check_encodable(Everything, replace(before, note="another"), before)


def test_a_tree_as_deep_as_allowed_comes_back_and_a_deeper_one_is_refused():
    def deep(levels: int) -> Everything:
        node = Tree("leaf")
        for _ in range(levels - 1):
            node = Tree("node", (node,))
        return Everything(tree=node)

    state = deep(MAX_DEPTH - 1)  # the state itself is the first
    assert decode_state(Everything, encode_state(state)).tree == state.tree
    with pytest.raises(ValueError, match="deep"):
        encode_state(deep(MAX_DEPTH))
    with pytest.raises(ValueError, match="deep"):
        encode_state(deep(100_000))


@dataclass
class Loose:
    x: float = 0.0


@dataclass(frozen=True)
class HoldsLoose:
    part: Loose = field(default_factory=Loose)


@dataclass(frozen=True)
class HoldsList:
    row: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class HoldsWide:
    row: NDArray[np.complex128] | None = None


@dataclass(frozen=True)
class HoldsAnything:
    thing: Any = None


def another_disc() -> type:
    @dataclass(frozen=True)
    class Disc:
        size: float = 0.0

    return Disc


@dataclass(frozen=True)
class HoldsTwins:
    mark: Disc | None = None


HoldsTwins.__annotations__["mark"] = Disc | another_disc() | None


@pytest.mark.parametrize("kind", [HoldsTwins, HoldsLoose, HoldsList, HoldsWide, HoldsAnything])
def test_types_that_documents_cannot_keep_are_named(kind):
    with pytest.raises(TypeError, match=kind.__name__):
        check_encodable(kind, kind())


def test_what_to_write_in_place_of_a_list_is_told():
    with pytest.raises(TypeError, match=r"list\[int\] cannot be kept .* tuple"):
        form_of(list[int])
    with pytest.raises(TypeError, match=r"cannot be kept in a document$"):
        form_of(complex)


def test_a_state_of_another_type_is_refused():
    with pytest.raises(TypeError, match="Ink"):
        check_encodable(Everything, Ink())


def decoded(text: str, kind: type = Ink, **more: Any) -> Any:
    return decode_state(kind, EncodedState(text.encode(), (stroke(), stroke(1))), **more)


def test_missing_fields_take_their_defaults():
    assert decoded("{}") == Ink()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "null",
        '{"thickness": "1"}',
        '{"thickness": null}',
        '{"thickness": 11}',
        '{"thickness": 1e999}',
        '{"thickness": ' + "9" * 400 + "}",
        '{"thicknes": 1}',
        '{"strokes": {"$strokes": [[0, 3]]}}',
        '{"strokes": {"$strokes": [[-1, 2]]}}',
        '{"strokes": {"$strokes": [[0, 0]]}}',
        '{"strokes": {"$strokes": [[0, true]]}}',
        '{"strokes": {"$strokes": [0, 1]}}',
        '{"strokes": {"$strokes": [[0, 2]], "x": 1}}',
        '{"strokes": []}',
        '{"strokes": {"$strokes": [' + ",".join(["[0,2]"] * 60_000) + "]}}",
        "[" * 200_000,
        '{"a":' * 200_000,
        "\xff",
    ],
)
def test_stored_states_that_do_not_fit_are_one_error(text):
    with pytest.raises(DocumentError):
        decoded(text)


@dataclass(frozen=True)
class Moody:
    """A state type whose own check fails in a way of its own."""

    size: Annotated[float, Parameter("Size", 0.0, 1.0)] = 0.5

    def __post_init__(self) -> None:
        if self.size == 0.25:
            raise ZeroDivisionError("not today")


def test_faults_in_the_plugins_own_checks_are_that_error_too():
    assert decoded('{"size": 1}', Moody) == Moody(1.0)
    with pytest.raises(DocumentError, match="not today"):
        decoded('{"size": 0.25}', Moody)
    with pytest.raises(DocumentError, match="KeyError"):
        decoded("{}", Moody, upgrade=lambda state: state["gone"])


def test_upgrade_sees_the_stored_form():
    assert decoded('{"weight": 2}', upgrade=lambda s: {"thickness": s["weight"] * 2}) == Ink(
        thickness=4.0
    )


def test_a_closed_state_comes_out_as_it_went_in():
    closed = OpaqueState(3, b' {"any": [ 1 ]}', (stroke(),), (frozen([1, 2], np.uint8),))
    encoded = encode_state(closed)
    assert encoded.json is closed.json
    assert encoded.strokes[0] is closed.strokes[0]
    assert encoded.arrays[0] is closed.arrays[0]


def test_one_dataclass_in_a_union_needs_no_name_and_two_do():
    assert b"$type" not in encode_state(Everything(best=None)).json
    names = [m["$type"] for m in json.loads(encode_state(everything()).json)["marks"]]
    assert names == ["Disc", "Line", "Disc"]


def test_strokes_are_equal_after_the_shortcut_constructor():
    made = full_stroke()
    columns = (made.x, made.y, made.pressure, made.t, made.tilt_x, made.tilt_y, made.twist)
    assert made == Stroke.from_columns(
        columns, made.camera, made.tool, made.color, made.group, True, True
    )


Scalar = TypeVar("Scalar", bound=np.generic)
ArrayOf = TypeAliasType("ArrayOf", np.ndarray[Any, np.dtype[Scalar]], type_params=(Scalar,))
Name = TypeAliasType("Name", str)
Scale = TypeAliasType("Scale", Annotated[float, Parameter("Scale")])


@dataclass(frozen=True)
class OfAliases:
    """A state whose types have names (PEP 695), as `NDArray` has from NumPy 2.5 on."""

    places: ArrayOf[np.float32]
    name: Name = ""
    names: tuple[Name, ...] | None = None
    scale: Scale = 1.0


def test_a_named_alias_of_a_type_is_that_type():
    state = OfAliases(frozen([1.0, 2.5], np.float32), "a", ("b", "ü"), 0.5)
    assert same_state(decode_state(OfAliases, encode_state(state)), state)
    with pytest.raises(Refusal, match="float32"):
        encode_state(replace(state, places=frozen([1.0], np.float64)))
    (scale,) = parameter_fields(OfAliases)
    assert (scale.name, scale.kind, scale.default) == ("scale", "number", 1.0)
