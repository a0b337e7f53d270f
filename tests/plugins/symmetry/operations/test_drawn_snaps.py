"""Snapping while drawing: places, tangents, planes and axes that a drawn curve goes to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink
from bozzetto_symmetry.commands import all_commands
from bozzetto_symmetry.model.state import EndSnap, Line, SymmetryState
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.draw_curve import DrawCurve
from tests.plugins.symmetry import scenes as s
from tests.previews import preview_of

VIEW = s.camera(40, 22, pixels=800.0)
CONTEXT = Context(camera=VIEW)
SHARE = np.linspace(0.0, 1.0, 300)[:, None]


def bow(begin: tuple[float, ...], end: tuple[float, ...], bulge: tuple[float, ...]) -> s.Array:
    """A parabola between two places."""
    straight = np.asarray(begin) + SHARE * (np.asarray(end) - begin)
    return np.asarray(straight + 4.0 * SHARE * (1.0 - SHARE) * np.asarray(bulge))


def drawn(
    state: SymmetryState, curve: s.Array, noise: float = 1.0, seed: int = 7, both: bool = True
) -> SymmetryState:
    random = np.random.default_rng(seed)
    for side in (np.ones(3), MIRROR) if both else (np.ones(3),):
        pixels = s.drawn(curve * side, VIEW, noise=noise, random=random)
        stroke = Stroke(pixels[:, 0], pixels[:, 1], VIEW)
        state = DrawCurve().apply(state, Ink((stroke,)), CONTEXT)
    return state


def places(state: SymmetryState) -> s.Array:
    assert state.chosen is not None
    curve = trace_of(state.chosen, state).curve
    assert curve is not None
    ends = np.vstack([spline.value(spline.range) for spline in curve.curves()])
    return np.asarray(state.plane.placement.points(ends))


def nearest(state: SymmetryState, place: tuple[float, ...]) -> float:
    return float(np.linalg.norm(places(state) - place, axis=1).min())


CORNER = (100.0, 50.0, 50.0)
ARCH = bow((0.0, 30.0, 10.0), CORNER, (0.0, 0.0, 18.0))


@pytest.mark.parametrize("seed", range(4))
def test_an_end_drawn_to_a_corner_of_the_box_lies_in_it(seed: int) -> None:
    state = drawn(SymmetryState(), ARCH, seed=seed)
    assert nearest(state, CORNER) < 1e-9
    assert nearest(state, (100.0, -50.0, 50.0)) < 1e-9
    free = drawn(SymmetryState(snapping=False), ARCH, seed=seed)
    assert nearest(free, CORNER) > 1e-3
    assert free.chosen is not None
    assert not free.chosen.end_snaps


def test_a_curve_that_only_passes_before_a_corner_is_left_alone() -> None:
    """It ends on the corner as it is seen, but 40 mm in front of it."""
    eye = np.asarray(VIEW.eye)
    corner = np.array((100.0, 50.0, 50.0))
    way = (eye - corner) / np.linalg.norm(eye - corner)
    end = corner + 40.0 * way
    box = SymmetryState(length=600.0, width=400.0, height=400.0)
    lines = replace(box, nodes=(Line(id="l", begin=(150, 50, 50), end=tuple(corner)),))
    state = drawn(lines, bow((0.0, 30.0, 10.0), tuple(end), (0.0, 0.0, 18.0)), noise=0.3)
    assert nearest(state, tuple(corner)) > 20.0


def test_a_curve_goes_on_smoothly_from_another_one() -> None:
    first = bow((-80.0, 20.0, 0.0), (0.0, 30.0, 20.0), (0.0, 0.0, 10.0))
    state = drawn(SymmetryState(), first, noise=0.5)
    before = state.chosen
    assert before is not None
    way = first[-1] - first[-2]
    on = first[-1] + SHARE * 70.0 * way / np.linalg.norm(way) + SHARE**2 * (0.0, 5.0, -12.0)
    state = drawn(state, on, noise=0.5, seed=9)
    assert state.chosen is not None
    assert state.chosen.id != before.id
    (one, other) = (trace_of(curve, state).curve for curve in state.curves)
    assert one is not None
    assert other is not None
    gaps = []
    for a in (one.spline, one.spline.reversed()):
        for b in (*other.curves(), *(curve.reversed() for curve in other.curves())):
            gap = float(np.linalg.norm(a.value(a.range[1:]) - b.value(b.range[:1])))
            ways = a.derivative(a.range[1:])[0], b.derivative(b.range[:1])[0]
            cosine = float(ways[0] @ ways[1] / np.prod(np.linalg.norm(ways, axis=1)))
            gaps.append((gap, cosine))
    gap, cosine = min(gaps)
    assert gap < 1e-9
    assert cosine > 1.0 - 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_a_straight_side_along_an_axis_is_exactly_that(seed: int) -> None:
    side = np.array((-70.0, 30.0, -20.0)) + SHARE * (120.0, 0.0, 0.0)
    state = drawn(SymmetryState(), side, seed=seed)
    assert state.chosen is not None
    assert state.chosen.axis == 0
    trace = trace_of(state.chosen, state)
    assert trace.reading == "pair"
    assert np.ptp(trace.points[:, 1:], axis=0).max() < 1e-9
    off = min(np.median(s.distances(trace.points * way, side)) for way in (np.ones(3), MIRROR))
    assert off < 0.02 * 120.0
    bent = drawn(SymmetryState(), bow(side[0], side[-1], (0.0, 0.0, 6.0)), seed=seed)
    assert bent.chosen is not None
    assert bent.chosen.axis == -1


def test_an_end_near_the_centre_plane_lies_in_it() -> None:
    state = drawn(SymmetryState(), bow((0.0, 0.6, 30.0), (60.0, 30.0, -10.0), (10.0, 0.0, 5.0)))
    assert np.abs(places(state)[:, 1]).min() < 1e-9


def test_what_was_snapped_to_is_in_the_recipe_and_solves_to_the_same() -> None:
    state = drawn(SymmetryState(), ARCH)
    assert state.chosen is not None
    assert state.chosen.end_snaps
    before = places(state)
    moved = replace(state, nodes=(*state.nodes, Line(id="x", begin=CORNER, end=(0, 0, 0))))
    np.testing.assert_array_equal(places(moved), before)
    # With all that it snapped to gone, the recipe knows it.
    bare = replace(state, length=210.0)
    np.testing.assert_array_equal(places(bare), before)


def test_a_side_that_waits_snaps_to_nothing_and_x_lets_no_end_jump() -> None:
    one = drawn(SymmetryState(), ARCH, both=False)
    assert one.chosen is not None
    waiting = trace_of(replace(one.chosen, reading="half"), one)
    assert waiting.curve is None
    state = drawn(SymmetryState(), ARCH)
    (switch,) = (c for c in all_commands() if c.id == "switch-reading")
    other = switch.run(state, CONTEXT)
    assert other.chosen is not None
    trace = trace_of(other.chosen, other)
    if trace.curve is not None:
        free = trace_of(replace(other.chosen, end_snaps=()), other)
        assert free.curve is not None
        off = np.linalg.norm(np.diff([trace.points[[0, -1]], free.points[[0, -1]]], axis=0), axis=2)
        assert off.max() < 20.0


def test_a_key_suspends_it() -> None:
    (command,) = (c for c in all_commands() if c.id == "snapping")
    off = command.run(SymmetryState(), CONTEXT)
    assert not off.snapping
    assert command.run(off, CONTEXT) == SymmetryState()


def test_the_magnet_is_shown_on_the_sheet() -> None:
    (seen,), _ = VIEW.project([CORNER])

    def layers(state: SymmetryState, shift: float) -> set[str]:
        x = np.array((seen[0] - 60.0, seen[0] - 40.0, seen[0] + shift))
        y = np.array((seen[1] + 50.0, seen[1] + 20.0, seen[1]))
        shown = preview_of(DrawCurve(), state, Ink((Stroke(x, y, VIEW),)), CONTEXT)
        return {layer.name for layer in shown.layers}

    assert "magnets" in layers(SymmetryState(), 5.0)
    assert "magnets" not in layers(SymmetryState(), 25.0)
    assert "magnets" not in layers(SymmetryState(snapping=False), 5.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("end", "face"),
    [((20.0, 30.0, 50.0), 50.0), ((20.0, 30.0, 49.0), 50.0), ((20.0, 30.0, 30.0), None)],
)
def test_a_face_of_the_box_that_holds_an_end_is_shown(
    side: float, end: tuple[float, ...], face: float | None
) -> None:
    """Once the second side gives its first a depth; the curve ends there when the pen is lifted."""
    curve = bow((-40.0, 20.0, 0.0), end, (0.0, 10.0, 0.0))
    first = drawn(SymmetryState(), curve * (1.0, side, 1.0), noise=0.0, both=False)
    pixels = s.drawn(curve * (1.0, -side, 1.0), VIEW, noise=0.0)
    ink = Ink((Stroke(pixels[:, 0], pixels[:, 1], VIEW),))
    shown = {layer.name: layer for layer in preview_of(DrawCurve(), first, ink, CONTEXT).layers}
    if face is None:
        marks = shown["magnets"].items if "magnets" in shown else ()
        held = np.array([mark.points[0] for mark in marks]).reshape(-1, 3)
        assert not (np.abs(np.abs(held) - (100.0, 50.0, 50.0)) < 1e-3).any()
        return
    (mark,) = shown["magnets"].items
    assert mark.points[0, 2] == pytest.approx(face, abs=1e-4)
    assert np.linalg.norm(mark.points[0] - np.array(end) * (1.0, side, 1.0)) < 6.0
    done = DrawCurve().apply(first, ink, CONTEXT)
    assert np.abs(places(done)[:, 2] - face).min() < 1e-6
    off = preview_of(DrawCurve(), replace(first, snapping=False), ink, CONTEXT)
    assert "magnets" not in {layer.name for layer in off.layers}


@pytest.mark.parametrize("degrees", [-60.0, -20.0, -4.0, 0.0, 4.0, 20.0, 60.0])
@pytest.mark.parametrize("last", [False, True])
def test_a_direction_that_the_curve_will_take_is_shown(degrees: float, last: bool) -> None:
    """A line stands where a stroke leaves the end of another curve as that goes on, either way."""
    first = bow((-80.0, 20.0, 0.0), (0.0, 30.0, 20.0), (0.0, 0.0, 10.0))
    state = drawn(SymmetryState(), first, noise=0.0)
    assert state.chosen is not None
    curve = trace_of(state.chosen, state).curve
    assert curve is not None
    spline = curve.curves()[0]
    end = state.plane.placement.points(spline.value(spline.range[1:]))
    before = state.plane.placement.points(spline.value([0.98 * spline.range[1]]))
    begun, seen = VIEW.project(before)[0][0], VIEW.project(end)[0][0]
    way = (seen - begun) / np.linalg.norm(seen - begun)
    turn = np.deg2rad(degrees)
    way = np.array(((np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn)))) @ way
    pixels = seen + np.linspace(2.0, 60.0, 30)[:, None] * way
    pixels = pixels[::-1] if last else pixels

    def layers(of: SymmetryState) -> dict[str, s.Array]:
        stroke = Stroke(pixels[:, 0], pixels[:, 1], VIEW)
        shown = preview_of(DrawCurve(), of, Ink((stroke,)), CONTEXT)
        return {layer.name: layer.points for layer in shown.layers}

    shown = layers(state)
    assert ("tangents" in shown) == (abs(degrees) < 12.0)
    assert "tangents" not in layers(replace(state, snapping=False))
    if "tangents" in shown:
        line = VIEW.project(shown["tangents"])[0]
        assert s.distances(seen[None], line).max() < 1.0
        assert np.linalg.norm(np.diff(line, axis=0)) > 40.0


def test_catches_of_a_damaged_file_change_nothing() -> None:
    state = drawn(SymmetryState(snapping=False), ARCH)
    assert state.chosen is not None
    node = replace(state.chosen, end_snaps=(EndSnap(99, 0, CORNER), EndSnap(0, 1, (1e6, 0.0, 0.0))))
    broken = state.with_node(node)
    np.testing.assert_array_equal(places(broken), places(state))
