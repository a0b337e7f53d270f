"""Curves across the plane where the rays say nothing: straight bars and flat curves."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.ink import distances_to_polyline
from bozzetto_symmetry.ink.sides import Side
from bozzetto_symmetry.interpretation.flat_places import coverage_of
from bozzetto_symmetry.interpretation.side_reading import read
from bozzetto_symmetry.interpretation.simple_form import information_of_two
from bozzetto_symmetry.interpretation.straight_crossing import as_bar
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s
from tests.plugins.symmetry.scenes import TURN, camera

BOX = SymmetryState().bounds
BAR = np.array((40.0, 0.0, 10.0)) + np.outer(np.linspace(-1, 1, 100), (0.0, 30.0, 0.0))
HOOP = np.column_stack((20 + 30 * np.cos(TURN), 40 * np.sin(TURN), 5 - 15 * np.cos(TURN)))


def solved(meant: m.Meant) -> Trace:
    state = add_drawing(SymmetryState(), meant.strokes)
    return trace_of(state.curves[0], state)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("azimuth", [-60, -20, 30, 70])
def test_a_bar_is_exact(azimuth: float, sense: int, kind) -> None:
    view = camera(azimuth, 20, kind, pixels=800.0)
    pixels = s.drawn(BAR, view, sense=sense)
    (found,) = as_bar(Stereo(view), pixels, 0.0)
    made = found.whole
    np.testing.assert_allclose(made.points[[0, -1]], BAR[::sense][[0, -1]], atol=1e-6)
    np.testing.assert_allclose(made.points, made.points[::-1] * MIRROR, atol=1e-12)
    np.testing.assert_allclose(made.covariances, np.swapaxes(made.covariances, 1, 2))
    assert made.cost < 1e-6


def test_the_doubt_about_a_bar_is_that_of_erring_ends() -> None:
    view = camera(35, 20, pixels=800.0)
    pixels = s.drawn(BAR, view)
    random = np.random.default_rng(7)
    missed = []
    for _ in range(300):
        ends = pixels[[0, -1]] + 1.5 * random.standard_normal((2, 2))
        drawn = np.linspace(*ends, 100) + 0.3 * random.standard_normal(2)
        for each in as_bar(Stereo(view), drawn, 0.0):
            missed.append(each.whole.points[0] - BAR[0])
    form = next(as_bar(Stereo(view), pixels, 0.0)).whole.form
    assert form is not None
    told = np.trace(form.covariance) ** 0.5
    measured = float(np.sqrt(np.mean(np.sum(np.array(missed)[:, [0, 2]] ** 2, axis=1))))
    assert len(missed) > 150
    assert 0.7 < measured / told < 1.3


def test_a_line_across_the_epipolar_lines_is_no_bar() -> None:
    view = camera(35, 20, pixels=800.0)
    rail = np.linspace((-60.0, 20.0, 0.0), (60.0, 20.0, 0.0), 100)
    assert not list(as_bar(Stereo(view), s.drawn(rail, view), 0.0))


def test_what_turns_back_is_no_bar() -> None:
    view = camera(35, 20, pixels=800.0)
    pixels = s.drawn(np.vstack((BAR, BAR[::-1][:80])), view)
    assert not list(as_bar(Stereo(view), pixels, 0.0))


@pytest.mark.parametrize("line", [np.zeros((1, 2)), np.zeros((4, 2)), np.full((2, 2), 1e6)])
def test_dots_are_no_bars(line: np.ndarray) -> None:
    assert not list(as_bar(Stereo(camera(35, 20)), line, 0.0))


@pytest.mark.parametrize("seed", range(400, 406))
def test_bars_by_hand_are_straight(seed: int) -> None:
    meant = m.bar(1.0, np.random.default_rng(seed))
    trace = solved(meant)
    assert trace.reading == "self"
    assert np.ptp(trace.points[:, [0, 2]], axis=0).max() < 0.01 * meant.size
    np.testing.assert_allclose(trace.points, trace.points[::-1] * MIRROR, atol=1e-9)
    assert trace.choices > 1  # bent, or in the plane: the X key has them


@pytest.mark.parametrize("azimuth", [25, 50, 65])
def test_a_flat_ring_is_flat_and_says_so(azimuth: float) -> None:
    view = camera(azimuth, 20, pixels=800.0)
    random = np.random.default_rng(azimuth)
    pixels = s.drawn(HOOP, view, noise=1.0, random=random, closed=True)
    side = Side(pixels, True, 0.1, (0,))
    best = read(Stereo(view), [side], box=BOX)[0]
    assert best.ring
    assert best.form is not None
    normal, away = best.form.planes[0, :3], best.form.planes[0, 3]
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert normal[1] == 0.0
    np.testing.assert_allclose(best.points @ normal, away, atol=1e-3)
    assert s.distances(best.points, HOOP, closed=True).max() < 0.05 * 100.0


@pytest.mark.parametrize("name", s.RINGS)
def test_a_ring_that_is_not_flat_is_not_flattened(name: str) -> None:
    view = camera(30, 20, pixels=800.0)
    side = Side(s.drawn(s.RINGS[name], view), True, 0.0, (0,))
    form = read(Stereo(view), [side], box=BOX)[0].form
    assert form is None or not form.flat


def test_a_curve_off_its_ink_is_told() -> None:
    told = [
        solved(m.spiral(1.0, np.random.default_rng(seed))) for seed in (107, 120)
    ]  # matched from one turn to the next, or reaching out of the box
    assert any("off its ink" in text for trace in told for text in trace.warnings)


@pytest.mark.parametrize("bow", [0.1, 0.3])
@pytest.mark.parametrize("azimuth", [30, 55])
def test_a_hoop_that_bows_evenly_is_read_on_a_bowed_plane(azimuth: float, bow: float) -> None:
    bowed = HOOP + np.outer(bow * HOOP[:, 1] ** 2 / 40.0, (0.4, 0.0, 0.9))
    random = np.random.default_rng(azimuth)
    pixels = s.drawn(
        bowed, camera(azimuth, 20, pixels=800.0), noise=1.0, random=random, closed=True
    )
    best = read(
        Stereo(camera(azimuth, 20, pixels=800.0)), [Side(pixels, True, 0.1, (0,))], box=BOX
    )[0]
    assert best.ring
    assert np.quantile(s.distances(best.points, bowed, closed=True), 0.95) < 0.06 * 100.0


@pytest.mark.parametrize("seed", [7001, 7004, 7018])
def test_a_flat_tube_by_a_slow_hand_is_flat(seed: int) -> None:
    # Read as free curves, whose tremor can hardly be told, they were 7 to 17 % off.
    meant = m.hoop(1.0, np.random.default_rng(seed))
    found = solved(meant)
    assert found.planes == 1
    assert np.quantile(s.distances(found.points, meant.truth), 0.95) < 0.05 * meant.size


@pytest.mark.parametrize("alike", [0.0, 0.3, 0.8])
def test_two_measurements_that_err_alike_say_as_much_as_their_covariance(alike: float) -> None:
    moves, spread = np.array((2.0, 3.0)), np.array(((1.0, alike), (alike, 1.0)))
    told = information_of_two(moves[:1], moves[1:], np.array([alike]))
    np.testing.assert_allclose(told, moves @ np.linalg.inv(spread) @ moves)


def test_one_measurement_that_is_seen_twice_counts_once() -> None:
    twice = np.array([3.0])
    np.testing.assert_allclose(information_of_two(twice, twice, np.ones(1)), 9.0)


def test_what_has_no_partner_between_others_is_not_covered() -> None:
    even = np.linspace(0.01, 1.0, 100)
    assert coverage_of(even) == pytest.approx(1.0)
    assert coverage_of(even[::-1]) == pytest.approx(1.0)
    assert coverage_of(even[even <= 0.6]) == pytest.approx(0.6)
    leapt = np.append(0.45 * even, 1.0)  # the last place found the end of a leg that runs back
    assert coverage_of(leapt) == pytest.approx(0.45)


def test_a_tube_seen_nearly_on_its_edge_is_not_read_without_one_of_its_legs() -> None:
    # One leg runs back beside the tube: the end of the other one was seen near its end, and all
    # before that counted as covered. The curve was 27 px off its ink, and half its size in space.
    meant = m.hoop(1.0, np.random.default_rng(46035))
    trace = solved(meant)
    ink = np.column_stack((meant.strokes[0].x, meant.strokes[0].y))
    image = trace.views[0].stereo.project(trace.points)
    off = distances_to_polyline(ink, image)
    assert float(np.sqrt(np.mean(off**2))) < 3.0
    assert float(np.quantile(s.distances(trace.points, meant.truth), 0.95)) < 0.1 * meant.size
