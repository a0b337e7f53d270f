"""Marks are moved a little toward the template, by what the hand leaves open and no farther."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_car.solver.initial_cameras import view_of
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.prior import Cost
from bozzetto_car.solver.shrinkage import MOST, SHARE, UNMOVED, moderated
from bozzetto_car.template.loader import bundled
from tests.plugins.car.marked_points import marked
from tests.plugins.car.sketched import FRONT_QUARTER, apart, rms, styled

TEMPLATE = bundled("sedan")


@pytest.fixture(scope="module")
def view():
    case = marked(TEMPLATE, styled(TEMPLATE, 4), (FRONT_QUARTER,), 4)
    return view_of(solve_car(case.state).placed["s0"], TEMPLATE)


def test_marks_move_toward_where_the_template_is_seen(view):
    moved = moderated(TEMPLATE, view, 1.0)
    seen = view.camera.project(TEMPLATE.positions[view.nodes])[0] + view.shift
    before, after = view.marks - seen, moved.marks - seen
    share = 1.0 - np.linalg.norm(after) / np.linalg.norm(before)
    assert 0.0 < share <= MOST
    assert np.allclose(after, (1.0 - share) * before), "all by one share"


@pytest.mark.parametrize("hand", [1.0, 2.0, 4.0])
def test_they_move_by_what_the_hand_leaves_open(view, hand):
    moved = moderated(TEMPLATE, view, hand).marks - view.marks
    diagonal = np.linalg.norm(np.ptp(view.marks, axis=0))
    usual = SHARE * (hand - UNMOVED) * Cost.balanced().hand * diagonal
    missed = view.marks - view.camera.project(TEMPLATE.positions[view.nodes])[0] - view.shift
    farthest = MOST * np.sqrt((missed**2).mean())
    assert np.sqrt((moved**2).mean()) == pytest.approx(min(usual, farthest))


def test_no_say_moves_nothing_and_a_larger_picture_moves_alike(view):
    assert np.array_equal(moderated(TEMPLATE, view, 3.0, 0.0).marks, view.marks)
    camera = view.camera.with_viewport(*(10.0 * side for side in view.camera.viewport))
    large = replace(view, camera=camera, marks=10.0 * view.marks)
    here, there = moderated(TEMPLATE, view, 2.0).marks, moderated(TEMPLATE, large, 2.0).marks
    assert np.allclose(there, 10.0 * here, rtol=1e-9)


def test_marks_of_the_template_stay(view):
    seen = view.camera.project(TEMPLATE.positions[view.nodes])[0]
    exact = replace(view, marks=seen, shift=(0.0, 0.0))
    assert np.array_equal(moderated(TEMPLATE, exact, 5.0).marks, seen)


def test_unsteady_marks_are_followed_less_far():
    """The car is nearer to the true one than with all that the marks say."""
    ratios = []
    for seed in range(6):
        true = styled(TEMPLATE, seed)
        case = marked(TEMPLATE, true, (FRONT_QUARTER,), seed, hand=8.0)
        usual, traced = (
            solve_car(replace(case.state, trace=trace)).positions for trace in (0.6, 1.0)
        )
        ratios.append(rms(apart(usual, true)) / rms(apart(traced, true)))
    assert np.median(ratios) < 1.0
