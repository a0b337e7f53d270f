"""Curves that are moved in places only, and the nodes of their images."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import contour_nodes, displaced_spline, held_solution, spline_weights


def ring(random, closed):
    turn = np.linspace(0.0, 2 * np.pi if closed else 4.0, 12, endpoint=not closed)
    points = 40.0 * np.column_stack((np.cos(turn), np.sin(turn), 0.2 * np.sin(3 * turn)))
    points += random.normal(scale=1.0, size=points.shape)
    return Spline.uniform(points, closed=closed)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", [9301, 9302, 9303])
def test_weights_give_the_curve_and_its_derivatives(seed, closed):
    spline = ring(np.random.default_rng(seed), closed)
    at = np.linspace(*spline.range, 50)
    rows = spline_weights(spline, at)
    points = spline.control_points[: rows.shape[1]]
    assert np.allclose(rows @ points, spline.value(at), atol=1e-11)
    assert np.allclose(spline_weights(spline, at, 1) @ points, spline.derivative(at), atol=1e-9)
    assert np.allclose(rows.sum(axis=1), 1.0)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", [9311, 9312, 9313])
def test_a_bump_is_followed_where_it_is_and_the_rest_stays(seed, closed):
    spline = ring(np.random.default_rng(seed), closed)
    begin, end = spline.range
    at = np.linspace(begin, end, 400)
    share = (at - begin) / (end - begin)
    bump = np.where(np.abs(share - 0.5) < 0.1, np.cos(5 * np.pi * (share - 0.5)) ** 2, 0.0)
    shifts = 3.0 * bump[:, None] * np.array((0.0, 0.0, 1.0))

    def change(finer):
        rows = spline_weights(finer, at)
        free = (rows[bump == 0.0] == 0.0).all(axis=0) & (rows > 0.0).any(axis=0)
        moved = np.zeros((rows.shape[1], 3))
        moved[free] = held_solution(rows[:, free], shifts)
        return moved, np.linalg.norm(rows @ moved - shifts, axis=1)

    made = displaced_spline(spline, at, change, close=0.1, halvings=7)
    off = np.linalg.norm(made.value(at) - spline.value(at) - shifts, axis=1)
    assert off.max() <= 0.1
    assert off[bump == 0.0].max() <= 1e-10
    assert made.closed == closed


def test_nodes_are_even_along_the_image_of_the_part_that_is_seen():
    spline = ring(np.random.default_rng(9321), closed=True)

    def see(points):
        return np.where(points[:, :1] > 0.0, points[:, :2], np.nan)

    at, closes = contour_nodes(spline, see, 2.0)
    assert not closes
    steps = np.linalg.norm(np.diff(spline.value(at)[:, :2], axis=0), axis=1)
    assert np.ptp(steps) <= 0.02 * steps.mean()
    assert (spline.value(at)[:, 0] >= 0.0).all()
    whole, closes = contour_nodes(spline, lambda points: points[:, :2], 2.0)
    assert closes
    assert len(whole) > len(at)
    with pytest.raises(UserError, match="not seen"):
        contour_nodes(spline, lambda points: np.full((len(points), 2), np.inf), 2.0)
