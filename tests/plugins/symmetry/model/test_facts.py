"""Box and plane out of ink files: what is understood, and what is refused in words."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Job
from bozzetto.view import Camera
from bozzetto_symmetry.model.facts import box_around, box_facts, readings_of
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.modeler import Symmetry
from bozzetto_symmetry.stereo.mirror_camera import Stereo


def state(**facts: Any) -> SymmetryState:
    return replace(SymmetryState(), **box_facts(json.loads(json.dumps(facts))))


@pytest.mark.parametrize(
    "box",
    [
        {"center": [10, 0, 25], "size": [200, 100.5, 50]},
        {"min": [-90, -50.25, 0], "max": [110, 50.25, 50]},
        {"length": 200, "width": 100.5, "height": 50, "center": [10, 0, 25]},
    ],
)
def test_one_box_in_three_ways(box: dict[str, Any]) -> None:
    made = state(box=box)
    assert made.size == (200.0, 100.5, 50.0)
    assert made.centre == (10.0, 0.0, 25.0)


@pytest.mark.parametrize(
    "box", [[200, 100, 50], {"size": [200, 100, 50]}, {"length": 200, "width": 100, "height": 50}]
)
def test_a_box_without_a_place_stands_around_the_origin(box: Any) -> None:
    made = state(box=box)
    assert (made.size, made.centre) == ((200.0, 100.0, 50.0), (0.0, 0.0, 0.0))


def test_nothing_told_changes_nothing() -> None:
    assert box_facts({}) == {}
    assert box_facts({"box": None, "plane": None, "marks": [1, 2]}) == {}


@pytest.mark.parametrize(
    ("axis", "symmetry", "normal"),
    [("x", "length", (1, 0, 0)), ("y", "width", (0, 1, 0)), ("z", "height", (0, 0, 1))],
)
def test_a_plane_by_its_axis_is_the_box_s_own(axis: str, symmetry: str, normal: Any) -> None:
    made = state(box={"center": [10, 20, 30], "size": [40, 40, 40]}, plane=axis)
    assert made.symmetry == symmetry
    assert made.plane == CentrePlane((10.0, 20.0, 30.0), normal)


@pytest.mark.parametrize(
    "plane",
    [
        {"point": [3, 7, 1], "normal": [1, 2, 2]},
        {"normal": [1, 2, 2], "offset": 19},
        {"normal": [-2, -4, -4], "offset": -38},
        [1, 2, 2, -19],
        [0.5, 1, 1, -9.5],
    ],
)
def test_one_tilted_plane_in_several_ways(plane: Any) -> None:
    made = state(plane=plane)
    assert made.symmetry == "free"
    normal = np.asarray(made.plane.normal)
    assert np.abs(np.cross(normal, (1, 2, 2))).max() < 1e-12
    assert float(normal @ made.plane.point) == pytest.approx(float(normal @ (3, 7, 1)))


@pytest.mark.parametrize("plane", [[0, 2, 0, 0], [0, -1, 0, 0], {"normal": [0, 1, 0], "offset": 0}])
def test_a_plane_through_the_middle_is_the_box_s_own(plane: Any) -> None:
    assert state(plane=plane).symmetry == "width"
    aside = state(plane=plane, box={"center": [0, 5, 0], "size": [50, 50, 50]})
    assert aside.symmetry == "free"
    assert aside.plane.point[1] == 0.0


BAD_BOXES: list[tuple[Any, str]] = [
    ("large", "box"),
    ([1, 2], "box"),
    ([1, 2, "3"], "box"),
    ([1, 2, True], "box"),
    ([1, 2, None], "box"),
    ([1, 2, -3], "box"),
    ([1, 2, 0], "box"),
    ([1, 2, 1e7], "box"),
    ([1, 2, 10**400], "box"),
    ([1, 2, float("nan")], "box"),
    ([1, 2, float("inf")], "box"),
    ({}, "box"),
    ({"size": [1, 2, 3], "colour": "red"}, "box"),
    ({"size": [1, 2]}, "box.size"),
    ({"center": [0, 0], "size": [1, 2, 3]}, "box.center"),
    ({"center": [0, 0, 1e9], "size": [1, 2, 3]}, "box.center"),
    ({"min": [0, 0, 0], "max": [1, 0, 1]}, "min"),
    ({"min": [0, 0, 0]}, "box"),
    ({"min": 5, "max": [1, 1, 1]}, "box.min"),
    ({"length": 1, "width": 2}, "box"),
    ({"length": [1], "width": 2, "height": 3}, "box"),
]


@pytest.mark.parametrize(("box", "named"), BAD_BOXES)
def test_a_box_that_cannot_be_is_refused_by_name(box: Any, named: str) -> None:
    with pytest.raises(UserError, match=f"“{named}”"):
        box_facts({"box": box})


BAD_PLANES: list[tuple[Any, str]] = [
    ("w", "plane"),
    ("", "plane"),
    (3, "plane"),
    ([0, 1, 0], "plane"),
    ([0, 0, 0, 5], "plane"),
    ([1e-9, 0, 0, 1e6], "plane"),
    ({"normal": [0, 0, 0], "offset": 1}, "plane.normal"),
    ({"normal": [0, 1, 0]}, "plane"),
    ({"normal": [0, 1, 0], "offset": "1"}, "plane.offset"),
    ({"normal": [0, 1, 0], "offset": 1e300}, "plane.offset"),
    ({"normal": [0, 1, 0], "point": [0, 0]}, "plane.point"),
    ({"normal": [1e300, 1e300, 0], "point": [0, 0, 0]}, "plane.normal"),
    ({"normal": [0, 1, 0], "point": [0, 0, 0], "offset": 1}, "plane"),
]


@pytest.mark.parametrize(("plane", "named"), BAD_PLANES)
def test_a_plane_that_cannot_be_is_refused_by_name(plane: Any, named: str) -> None:
    with pytest.raises(UserError, match=f"“{named}”"):
        box_facts({"plane": plane})


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["center", "size", "min", "max", "normal", "point", "offset"]), inner
        )
    ),
    max_leaves=8,
)


@given(json_values, json_values)
@settings(max_examples=300, deadline=None)
def test_anything_else_makes_a_state_or_a_sentence(box: Any, plane: Any) -> None:
    try:
        made = replace(SymmetryState(), **box_facts({"box": box, "plane": plane}))
    except UserError as problem:
        assert "“" in problem.message  # noqa: PT017
        return
    assert np.isfinite((*made.size, *made.centre, *made.plane.point, *made.plane.normal)).all()


@pytest.mark.parametrize(
    "made",
    [
        SymmetryState(),
        SymmetryState(centre=(1.5, -2.25, 1 / 3), length=10.1, symmetry="length"),
        SymmetryState(
            height=77.0, symmetry="free", free_plane=CentrePlane((1, 2, 3), (0.3, 0.2, 0.9))
        ),
    ],
)
def test_what_is_written_is_read(made: SymmetryState) -> None:
    plane: object = {"width": "y", "length": "x", "height": "z"}.get(made.symmetry)
    if plane is None:
        plane = {"point": made.free_plane.point, "normal": made.free_plane.normal}
    facts = {"box": {"center": made.centre, "size": made.size}, "plane": plane}
    again = replace(SymmetryState(), **box_facts(json.loads(json.dumps(facts))))
    assert again.size == made.size
    assert again.centre == made.centre
    assert again.symmetry == made.symmetry
    assert again.plane.normal == pytest.approx(made.plane.normal, abs=1e-15)
    assert again.plane.point == made.plane.point


VIEWS = [(20, 15), (35, 20), (60, 30), (-50, -20)]


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize(("azimuth", "elevation"), VIEWS)
@pytest.mark.parametrize("size", [(200.0, 100.0, 100.0), (400.0, 180.0, 120.0), (90.0, 60.0, 30.0)])
def test_a_box_around_ink_holds_what_was_drawn(
    kind: Any, azimuth: float, elevation: float, size: tuple[float, float, float]
) -> None:
    """A thing of these proportions about the target, drawn on both sides, lies in the box."""
    a, e = np.radians((azimuth, elevation))
    eye = 4.0 * size[0] * np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
    camera = Camera(kind=kind, eye=tuple(eye), height=2.0 * size[0])
    turn = np.linspace(0, 2 * np.pi, 60)
    side = 0.5 * np.column_stack((np.cos(turn), 0.5 + 0.5 * np.sin(turn), np.sin(turn))) * size
    stereo = Stereo(camera)
    ink = [
        Stroke(*stereo.project(side).T, camera),
        Stroke(*stereo.project(side * (1, -1, 1)).T, camera),
    ]
    made = replace(SymmetryState(), **box_around(ink, CentrePlane()))
    assert (np.abs(side) <= 0.6 * np.asarray(made.size)).all()  # with the fifth that is allowed
    assert max(made.size) < 5.0 * size[0]
    assert made.centre == (0.0, 0.0, 0.0)


def test_a_box_around_ink_stands_on_both_sides_of_the_plane() -> None:
    camera = Camera(eye=(300.0, -400.0, 200.0), target=(40.0, 25.0, 10.0))
    ink = [Stroke([500.0, 700.0], [300.0, 500.0], camera)]
    made = replace(SymmetryState(), **box_around(ink, CentrePlane()))
    assert made.centre == (40.0, 0.0, 10.0)
    assert made.plane == CentrePlane((40.0, 0.0, 10.0))
    tiny = replace(SymmetryState(), **box_around([Stroke([600.0], [450.0], camera)], CentrePlane()))
    assert min(tiny.size) >= 0.1


def test_a_drawing_without_a_box_gets_one_with_room_and_one_with_a_box_keeps_it() -> None:
    camera = Camera(eye=(1500.0, -2000.0, 900.0))
    side = np.column_stack(
        (np.linspace(-500, 500, 80), np.full(80, 260.0), 150 * np.sin(np.linspace(0, 3, 80)))
    )
    stereo = Stereo(camera)
    ink = Strokes(
        Stroke(*stereo.project(side * sign).T, camera, group="rail")
        for sign in (np.ones(3), np.array([1.0, -1.0, 1.0]))
    )
    drawing = Drawing(ink, camera)
    roomy = Symmetry().read_drawing(drawing, Context(camera=camera), Job())
    assert (np.abs(side) <= 0.6 * np.asarray(roomy.size)).all()
    facts = {"box": [1200, 600, 400]}
    told = Symmetry().read_drawing(drawing, Context(camera=camera, facts=facts), Job())
    assert told.size == (1200.0, 600.0, 400.0)


@pytest.mark.parametrize("told", ["y = 0", "y=0", " y =0.0 "])
def test_a_coordinate_names_a_plane_wherever_the_box_stands(told: str) -> None:
    facts = {"box": {"centre": [0.0, 30.0, 0.0], "size": [200, 100, 50]}, "plane": told}
    state = replace(SymmetryState(), **box_facts(facts))
    assert state.centre == (0.0, 30.0, 0.0)
    assert state.plane.normal == (0.0, 1.0, 0.0)
    assert state.plane.point[1] == 0.0


@pytest.mark.parametrize("told", ["w = 0", "y = nan", "y = ", "y = 1e99", "= 3", ""])
def test_a_coordinate_that_is_none_is_refused(told: str) -> None:
    with pytest.raises(UserError, match="plane"):
        box_facts({"plane": told})


def test_readings_are_told_by_name() -> None:
    assert readings_of({}) == {}
    assert readings_of({"readings": {"spine": "plane"}}) == {"spine": "plane"}
    for told in ({"spine": "flat"}, {"spine": 3}, {"spine": ["plane"]}, ["plane"], "plane"):
        with pytest.raises(UserError, match="readings"):
            readings_of({"readings": told})
