"""A left side in one view and its right side in another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto_symmetry.interpretation.candidate import Read
from bozzetto_symmetry.interpretation.view_pairing import pair_of_views
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s

BOX = SymmetryState().bounds

EXACT = 2.0
"""Cost, px, of a pair that was drawn without tremor, at most: sides reach differently far."""

TOLD = 3.0
"""Largest error, in those that are told: 3 of a normal distribution, at 1 place of 20."""


def read(one: Stroke, other: Stroke, box: s.Array | None = BOX) -> Read | None:
    return pair_of_views(Stereo(one.camera), one.points, Stereo(other.camera), other.points, box)


def percent(points: s.Array, meant: m.Meant) -> float:
    apart = min(float(np.quantile(s.distances(points * way, meant.truth), 0.95)) for way in
                (np.ones(3), MIRROR))  # fmt: skip
    return 100.0 * apart / meant.size


def turned(stroke: Stroke) -> Stroke:
    return Stroke(stroke.x[::-1].copy(), stroke.y[::-1].copy(), stroke.camera)


@pytest.mark.parametrize("seed", range(300, 306))
def test_rays_through_the_ink_meet_on_the_curve(seed: int) -> None:
    meant = m.two_views(0.0, np.random.default_rng(seed))
    found = read(*meant.strokes)
    assert found is not None
    assert found.cost < EXACT
    near = Stereo(meant.strokes[0].camera).project(found.points)
    image = Stereo(meant.strokes[1].camera).project(found.points * MIRROR)
    for places, stroke in ((near, meant.strokes[0]), (image, meant.strokes[1])):
        assert np.median(distances_to_polyline(places, stroke.points)) < 1.0


def test_drawings_stroke_by_stroke_are_one_pair_each() -> None:
    off = []
    for seed in range(300, 312):
        meant = m.two_views(1.0, np.random.default_rng(seed))
        state = add_drawing(SymmetryState(), meant.strokes)
        (curve,) = state.curves
        trace = trace_of(curve, state)
        assert trace.reading == "pair"
        off.append(percent(trace.points, meant))
        # Where the epipolar lines run along a curve, nothing says which places belong together,
        # and a hand of 1 px errs by more than 6 % there: then that is told.
        assert off[-1] < max(6.0, TOLD * 100.0 * float(trace.sigma.max()) / meant.size)
    assert sum(each < 3.0 for each in off) >= 10


@pytest.mark.parametrize("seed", [65001, 65019, 65037])
def test_the_curve_ends_where_both_sides_end(seed: int) -> None:
    """Where rays hardly tell an end, ink beyond the first, smooth guess was left out."""
    meant = m.two_views(1.0, np.random.default_rng(seed))
    state = add_drawing(SymmetryState(), meant.strokes)
    trace = trace_of(state.curves[0], state)
    for stroke in meant.strokes:
        images = [Stereo(stroke.camera).project(trace.points * way) for way in (1.0, MIRROR)]
        for tip in stroke.points[[0, -1]]:
            ends = np.vstack([image[[0, -1]] for image in images])
            assert np.linalg.norm(ends - tip, axis=1).min() < 8.0


def test_views_that_are_nearly_mirror_images_are_told() -> None:
    side = m.smooth_side(np.random.default_rng(3))

    def told(azimuth: float) -> str:
        views = s.camera(30, 20, pixels=800.0), s.camera(azimuth, 20, pixels=800.0)
        one, other = (
            s.drawn(side * way, view) for way, view in zip((1.0, MIRROR), views, strict=True)
        )
        found = read(Stroke(*one.T, views[0]), Stroke(*other.T, views[1]))
        assert found is not None
        return " ".join(found.warnings)

    assert "next to no depth" in told(-33)
    assert "little depth" in told(-40)
    assert "depth" not in told(40)


def test_either_side_may_come_first_and_run_either_way() -> None:
    meant = m.two_views(0.5, np.random.default_rng(320))
    one, other = meant.strokes
    places = []
    for drawn in ((one, other), (other, one), (turned(one), other), (one, turned(other))):
        state = add_drawing(SymmetryState(), drawn)
        assert len(state.curves) == 1
        places.append(trace_of(state.curves[0], state).points)
    for made in places:
        assert percent(made, meant) < 3.0


def test_the_mirrored_drawing_gives_the_mirrored_curve() -> None:
    # Places on the sheet are kept as 32 bits: only those on a grid have an exact mirror image.
    one, other = (
        Stroke(np.round(each.x * 16.0) / 16.0, np.round(each.y * 16.0) / 16.0, each.camera)
        for each in m.two_views(1.0, np.random.default_rng(321)).strokes
    )

    def reflected(stroke: Stroke) -> Stroke:
        x, y, z = stroke.camera.eye
        width = stroke.camera.viewport[0]
        return Stroke(width - stroke.x, stroke.y, replace(stroke.camera, eye=(x, -y, z)))

    found, image = read(one, other), read(reflected(one), reflected(other))
    assert found is not None
    assert image is not None
    np.testing.assert_allclose(image.points, found.points * MIRROR, atol=1e-6)
    assert image.cost == pytest.approx(found.cost, rel=1e-6)


@pytest.mark.parametrize("kinds", [("orthographic", "perspective"), ("orthographic",) * 2])
def test_parallel_views_pair_as_well(kinds: tuple[str, str]) -> None:
    random = np.random.default_rng(322)
    side = m.smooth_side(random)
    views = s.camera(30, 20, kinds[0], pixels=800.0), s.camera(65, 10, kinds[1], pixels=800.0)  # type: ignore[arg-type]
    strokes = m.stroke(side, views[0], 0.0, random), m.stroke(side * MIRROR, views[1], 0.0, random)
    found = read(*strokes)
    assert found is not None
    assert found.cost < EXACT
    assert np.median(s.distances(found.points, side)) < 0.5


@pytest.mark.parametrize("seed", range(330, 342))
def test_sides_of_different_curves_stay_apart(seed: int) -> None:
    meant = m.strangers_in_two_views(1.0, np.random.default_rng(seed))
    assert len(add_drawing(SymmetryState(), meant.strokes).curves) == 2


def test_more_ink_in_a_third_view_stays_with_the_pair() -> None:
    meant = m.two_views(0.5, np.random.default_rng(323))
    state = add_drawing(SymmetryState(), meant.strokes)
    third = m.stroke(meant.truth, s.camera(5, 40, pixels=800.0), 0.5, np.random.default_rng(1))
    curve = state.curves[0]
    more = replace(curve, strokes=curve.strokes.extended((third,)))
    trace = trace_of(more, state.with_node(more))
    assert trace.reading == "pair"
    assert percent(trace.points, meant) < 3.0


def test_dots_and_one_and_the_same_ray_make_no_pair_and_no_trouble() -> None:
    view, other = s.camera(30, 20), s.camera(60, 20)
    line = s.drawn(s.PAIRS["S-wave"], view)
    dot = np.full((5, 2), 100.0)
    assert pair_of_views(Stereo(view), line, Stereo(other), dot) is None
    assert pair_of_views(Stereo(view), line[:1], Stereo(other), line) is None
    # The mirror image of the first view sees along the very same rays.
    image = Stereo(s.camera(-30, 20))
    flipped = (view.viewport[0] - line[:, 0], line[:, 1])
    found = pair_of_views(Stereo(view), line, image, np.column_stack(flipped))
    assert found is None or np.isfinite(found.points).all()
