"""Where ink belongs: the flow of a hand that draws one side, then the other, and again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke
from bozzetto.plugin import Job
from bozzetto.view import Camera
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.modeler import Symmetry
from bozzetto_symmetry.operations.assign_stroke import add_drawing, add_strokes
from bozzetto_symmetry.operations.second_sides import shares_lines
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s

VIEW = s.camera(35, 20)


def stroke(curve: np.ndarray, view: Camera = VIEW, **hand) -> Stroke:
    pixels = s.drawn(curve, view, **hand)
    return Stroke(pixels[:, 0], pixels[:, 1], view)


def reading(state: SymmetryState, number: int = -1) -> str:
    return trace_of(state.curves[number], state).reading


@pytest.mark.parametrize("name", list(s.PAIRS))
def test_the_second_side_joins_the_one_that_waits(name: str) -> None:
    side = s.PAIRS[name]
    state = add_strokes(SymmetryState(), (stroke(side),))
    assert len(state.curves) == 1
    state = add_strokes(state, (stroke(side * MIRROR, sense=-1),))
    assert len(state.curves) == 1
    assert reading(state) == "pair"
    made = trace_of(state.curves[0], state)
    assert np.median(s.distances(made.points, side)) < 5e-4 * s.DIAGONAL


def test_two_sides_wait_until_their_partners_come() -> None:
    first, second = s.PAIRS["roof rail"], s.PAIRS["wheel arch"]
    state = SymmetryState()
    for curve in (first, second, second * MIRROR, first * MIRROR):
        state = add_strokes(state, (stroke(curve),))
    assert len(state.curves) == 2
    for number, side in enumerate((first, second)):
        assert reading(state, number) == "pair"
        made = trace_of(state.curves[number], state)
        assert np.median(s.distances(made.points, side)) < 2e-3 * s.DIAGONAL


@pytest.mark.parametrize("seed", range(4))
def test_sides_of_a_pair_share_lines_in_every_view(seed: int) -> None:
    random = np.random.default_rng(7100 + seed)
    for name, side in {**s.PAIRS, **s.LOOPS}.items():
        kind = "orthographic" if random.random() < 0.3 else "perspective"
        view = s.camera(random.uniform(-180, 180), random.uniform(-80, 80), kind=kind)
        near, far = (
            stroke(curve, view, noise=1.5, random=random, sense=int(random.choice([-1, 1])))
            for curve in (side, side * MIRROR)
        )
        for one, other in ((near, far), (far, near)):
            state = add_strokes(SymmetryState(), (one,))
            assert shares_lines(state.curves[0], (other,), state), name


def test_what_is_drawn_far_above_shares_no_line() -> None:
    low, high = (
        stroke(s.PAIRS["S-wave"] * (1.0, 1.0, 0.3) + (0.0, 0.0, height)) for height in (-60, 60)
    )
    state = add_strokes(SymmetryState(), (low,))
    assert not shares_lines(state.curves[0], (high,), state)
    turned = stroke(s.PAIRS["S-wave"] + (0.0, 0.0, 60.0), s.camera(-40, 10))
    assert shares_lines(state.curves[0], (turned,), state), "another view has other lines"


@pytest.mark.slow
def test_straight_tubes_in_the_plane_take_no_part_of_other_lines_for_their_other_side() -> None:
    right = 0
    for seed in range(301, 306):
        drawn, counts = m.bicycle(1.0, np.random.default_rng(seed))
        state = add_drawing(SymmetryState(), drawn)
        right += [len(curve.strokes) for curve in state.curves] == counts
    assert right >= 3  # elsewhere a stay ends where the mirror image of the top tube would


@pytest.mark.parametrize("share", [1.0, 0.6])
@pytest.mark.parametrize("azimuth", [40, 50])
def test_straight_sides_pair_whole_and_not_in_part(share: float, azimuth: float) -> None:
    line = np.array((-60.0, 30.0, -20.0)) + np.outer(m.SHARE, (110.0, 8.0, 45.0))
    view = s.camera(azimuth, 20, pixels=800.0)
    rest = round(share * len(line))
    state = add_strokes(SymmetryState(), (stroke(line, view),))
    state = add_strokes(state, (stroke((line * MIRROR)[:rest], view, noise=1.0),))
    assert len(state.curves) == (1 if share == 1.0 else 2)


def test_ink_along_the_chosen_curve_is_more_of_it() -> None:
    side = s.PAIRS["S-wave"]
    state = SymmetryState()
    hands = [(side, 1), (side * MIRROR, 2), (side, 3), (side * MIRROR, 4)]
    for curve, seed in hands:
        random = np.random.default_rng(seed)
        state = add_strokes(state, (stroke(curve, noise=1.5, random=random),))
    assert len(state.curves) == 1
    assert len(state.curves[0].strokes) == 4
    assert reading(state) == "pair"


def test_a_stroke_across_is_a_curve_of_its_own_and_so_is_the_next_one() -> None:
    state = add_strokes(SymmetryState(), (stroke(s.ACROSS["windscreen base"]),))
    assert reading(state) == "self"
    state = add_strokes(state, (stroke(s.ACROSS["wavy bumper"]),))
    assert len(state.curves) == 2
    assert reading(state, 0) == reading(state, 1) == "self"


def test_a_curve_that_is_drawn_again_from_elsewhere_is_known_better() -> None:
    side = s.PAIRS["roof rail"]
    state = SymmetryState()
    for view in (s.camera(10, 15), s.camera(60, 25)):
        for number, curve in enumerate((side, side * MIRROR)):
            random = np.random.default_rng(number)
            state = add_strokes(state, (stroke(curve, view, noise=1.0, random=random),))
            if view == s.camera(10, 15):
                once = state
    assert len(state.curves) == 1
    before, after = trace_of(once.curves[0], once), trace_of(state.curves[0], state)
    assert np.median(after.sigma) < 0.7 * np.median(before.sigma)
    errors = [np.median(s.distances(t.points, side)) for t in (before, after)]
    assert errors[1] < errors[0]


def test_beside_another_curve_a_new_one_begins() -> None:
    state = add_strokes(SymmetryState(), (stroke(s.ACROSS["wavy bumper"]),))
    lower = s.ACROSS["wavy bumper"] - (0.0, 0.0, 15.0)
    state = add_strokes(state, (stroke(lower),))
    assert len(state.curves) == 2


def test_groups_of_a_drawing_are_curves_by_their_names() -> None:
    side = s.PAIRS["hook"]
    strokes = []
    for curve in (side, side * MIRROR):
        pixels = s.drawn(curve, VIEW)
        strokes.append(Stroke(pixels[:, 0], pixels[:, 1], VIEW, group="rail", color=(1, 2, 3)))
    state = add_drawing(SymmetryState(), strokes, {"rail": "pair"})
    (curve,) = state.curves
    assert (curve.id, curve.name, curve.reading, curve.color) == ("rail", "rail", "pair", (1, 2, 3))


def test_a_dot_is_refused() -> None:
    with pytest.raises(UserError):
        add_strokes(SymmetryState(), (Stroke([5.0], [5.0], VIEW),))
    with pytest.raises(UserError):
        add_strokes(SymmetryState(), (Stroke([5.0, 5.0], [5.0, 5.0], VIEW),))


@pytest.mark.parametrize("name", ["roof rail", "S-wave"])
def test_one_side_drawn_again_from_elsewhere_makes_no_other_curve_of_a_pair(name: str) -> None:
    side = s.PAIRS[name]
    state = add_strokes(SymmetryState(), (stroke(side),))
    state = add_strokes(state, (stroke(side * MIRROR),))
    state = add_strokes(state, (stroke(side, s.camera(70, 30)),))
    assert len(state.curves) == 1
    made = trace_of(state.curves[0], state)
    assert made.reading == "pair"
    assert len(made.views) == 2
    assert np.median(s.distances(made.points, side)) < 1e-3 * s.DIAGONAL


def test_half_of_a_curve_across_drawn_again_from_elsewhere() -> None:
    whole = s.ACROSS["wavy bumper"]
    state = add_strokes(SymmetryState(), (stroke(whole),))
    again = state.with_node(
        replace(
            state.curves[0],
            strokes=state.curves[0].strokes.extended(
                (stroke(s.HALVES["wavy bumper"], s.camera(60, 35)),)
            ),
        )
    )
    made = trace_of(again.curves[0], again)
    assert made.reading == "self"
    assert np.median(s.distances(made.points, whole)) < 2e-3 * s.DIAGONAL


def test_a_window_that_is_resized_shows_the_same_view() -> None:
    side = s.PAIRS["S-wave"]
    state = add_strokes(SymmetryState(), (stroke(side),))
    other = VIEW.with_viewport(900.0, 1300.0)
    state = add_strokes(state, (stroke(side * MIRROR, other),))
    assert len(state.curves) == 1
    made = trace_of(state.curves[0], state)
    assert made.reading == "pair"
    assert len(made.views) == 1
    assert np.median(s.distances(made.points, side)) < 5e-4 * s.DIAGONAL
    again = add_strokes(state, (stroke(side, VIEW.with_viewport(500.0, 400.0)),))
    assert len(again.curves) == 1


def test_the_way_back_to_the_view_of_a_side_that_waits() -> None:
    modeler, aside = Symmetry(), s.camera(70, 40)
    state = add_strokes(SymmetryState(), (stroke(s.PAIRS["S-wave"]),))
    told = modeler.view_advice(state, aside, Job())
    assert told.better == VIEW
    assert "waits" in told.message
    assert (
        "waits" not in modeler.view_advice(state, VIEW.with_viewport(700.0, 500.0), Job()).message
    )
    there_and_back = VIEW.moved(Placement(offset=(3.0, 4.0, 5.0))).moved(
        Placement(offset=(-3, -4, -5))
    )
    assert there_and_back != VIEW
    assert "waits" not in modeler.view_advice(state, there_and_back, Job()).message
    whole = add_strokes(state, (stroke(s.PAIRS["S-wave"] * MIRROR),))
    assert "waits" not in modeler.view_advice(whole, aside, Job()).message
