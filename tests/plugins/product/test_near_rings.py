"""Rings of points that stop short of their start, run past it, or come back beside it."""

import itertools

import numpy as np
import pytest

from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.near_rings import ring_of_row
from bozzetto_product.hand_over.point_fit import closed_spline_through
from bozzetto_product.model.curves import Curve
from tests.plugins.product.test_rough_files import facts, solved, turned

RADIUS = 50.0
SIZE = 173.0


def arc(gap, count, seed=0, start=0.7, rise=0.0):
    """A circle that stops short by an angle, or runs past its start, and climbs by a height."""
    at = np.linspace(start, start + 2.0 * np.pi - gap, count)[:, None]
    one, two, up = turned(seed)
    climb = rise * (at - start) / (2.0 * np.pi)
    return RADIUS * (np.cos(at) * one + np.sin(at) * two) + climb * up


def off_circle(spline, seed=0):
    local = spline.sampled(400) @ np.transpose(turned(seed))
    return float(np.hypot(np.hypot(local[:, 0], local[:, 1]) - RADIUS, local[:, 2]).max())


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("gap", [0.06, 0.02, -0.02, -0.1, -0.2])
@pytest.mark.parametrize("count", [20, 61, 400])
def test_a_circle_that_nearly_closes_is_that_circle(gap, count, scale):
    row = arc(gap, count)
    for order in (row, row[::-1]):
        ring = ring_of_row(scale * order, scale * SIZE, scale * 1e-3)
        spline = closed_spline_through(ring, scale * 0.017, scale * 0.0017)
        assert off_circle(spline.__class__(spline.knots, spline.control_points / scale, True)) < (
            0.03 if count == 20 else 0.005
        )


@pytest.mark.parametrize("rise", [0.3, 1.0, 1.6])
@pytest.mark.parametrize("gap", [0.05, 0.0, -0.05])
def test_what_comes_back_beside_its_start_moves_by_half_of_that(gap, rise):
    row = arc(gap, 120, rise=rise)
    ring = ring_of_row(row, SIZE, 1e-3)
    moved = np.linalg.norm(ring - row[: len(ring)], axis=1)
    assert moved.max() < 0.55 * rise
    spline = closed_spline_through(ring, 0.017, 0.0017)
    at = np.linspace(0.0, 1.0, 2000, endpoint=False)
    slopes = spline.derivative(at)
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    turns = np.arccos(np.clip((slopes * np.roll(slopes, -1, axis=0)).sum(axis=1), -1.0, 1.0))
    assert np.degrees(turns.max()) < 3.0 * 360.0 / 2000.0


def square(count=30):
    corners = RADIUS * np.array([(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0), (0.97, 0, 0)])
    at = np.linspace(0.0, 1.0, count)[:, None]
    return np.vstack([a + at[1:] * (b - a) for a, b in itertools.pairwise(corners)])


@pytest.mark.parametrize(
    "row",
    [
        arc(0.2, 100),  # a clip
        arc(0.0, 100, rise=5.0),  # one turn of a spring
        square(),  # a corner where it comes back
        arc(np.pi, 100),
        np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 0, 0.1), (0.1, 0, 0.1), (0.01, 0, 0)]),
        arc(-2.0 * np.pi, 200, rise=8.0),  # two turns of a spring
    ],
)
def test_what_is_open_or_has_a_corner_is_no_ring(row):
    assert ring_of_row(row, SIZE, 1e-3) is None
    assert ring_of_row(row[::-1], SIZE, 1e-3) is None


def test_three_rings_that_stop_short_bound_the_ball():
    axes = turned(5)
    rings = {
        f"r{k}": arc(gap, 61)
        @ np.transpose(turned(0))
        @ np.array((axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]))
        for k, gap in enumerate((0.05, -0.08, 0.03))
    }
    result, told = solved(facts(rings))
    assert told["closed"]
    assert len(told["patches"]) == 8
    assert max(one["g1_deg"] for one in told["patches"]) <= 0.05
    away = [np.abs(np.linalg.norm(one.mesh.vertices, axis=1) - RADIUS) for one in result.filled]
    assert np.concatenate(away).max() < 2e-4 * SIZE


@pytest.mark.parametrize("fifth", [0.0, 1e-3])
def test_a_slot_that_other_curves_bound_stays_open(fifth):
    """Where another curve ends at the end of a row, it is meant to end there."""
    row = arc(0.05, 120)
    lead = np.linspace(row[-1] + fifth, 1.3 * row[-1], 5)
    state = product_of_network(facts({"ring": row, "lead": lead}))
    assert not next(one for one in state.of_kind(Curve) if one.name == "ring").spline.closed


@pytest.mark.parametrize("count", [25, 60, 200])
def test_rings_of_a_trembling_hand_close(count):
    """Ends as far apart as noise of 0.2 % of the diagonal brings them, and a gap besides."""
    noise = 0.002 * SIZE
    found = 0
    for seed in range(40, 60):
        random = np.random.default_rng(seed)
        row = arc(random.choice((0.0, 0.03)), count, seed)
        row = row + noise * random.normal(size=row.shape)
        ring = ring_of_row(row, SIZE, 3.5 * noise, noise)
        if ring is not None:
            found += 1
            assert off_circle(closed_spline_through(ring, 3.5 * noise), seed) < 5.0 * noise
    assert found >= 19
