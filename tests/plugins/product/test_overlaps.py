"""Curves of a file that were drawn a little into one another are cut where they were to meet."""

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.overlaps import without_overlaps
from bozzetto_product.hand_over.point_fit import spline_through
from bozzetto_product.report import report_of
from bozzetto_product.solve.solver import solve_product


def arc(first, second, begin, end, count=61):
    at = np.linspace(begin, end, count)[:, None]
    return 50.0 * (np.cos(at) * first + np.sin(at) * second)


def ball(seed, farthest):
    """The twelve quarters of three great circles, both ends drawn on over the next quarter."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rows = []
    for k in range(3):
        for quarter in range(4):
            begin, end = rng.choice((0.0, 0.5, 1.0), 2) * farthest
            row = arc(
                axes[k],
                axes[(k + 1) % 3],
                quarter * np.pi / 2 - begin,
                (quarter + 1) * np.pi / 2 + end,
            )
            rows.append(row[:: rng.choice((-1, 1))])
    return rows


@pytest.mark.parametrize("seed", [411, 412, 413])
def test_a_ball_of_quarters_that_overlap_has_eight_surfaces_on_it(seed):
    rows = ball(seed, 0.1)
    curves = [{"name": f"c{k}", "points": row.tolist()} for k, row in enumerate(rows, 1)]
    state = product_of_network({"network": {"curves": curves}, "unit": "mm"})
    result = solve_product(state, Job(quality="final"))
    told = report_of(state, result, Job())
    assert told["closed"]
    assert len(told["patches"]) == 8
    assert max(one["g1_deg"] for one in told["patches"]) <= 0.05
    away = [np.abs(np.linalg.norm(one.mesh.vertices, axis=1) - 50.0) for one in result.filled]
    assert np.concatenate(away).max() < 1e-2


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("order", [1, -1])
def test_the_longer_curve_ends_where_the_other_begins(turned, order):
    x, y, _ = np.eye(3)
    longer, shorter = arc(x, y, -2.0, 0.1), arc(x, y, 0.0, 1.5)
    rows = [longer[::-1] if turned else longer, shorter][::order]
    made = without_overlaps([spline_through(row, 1e-4) for row in rows], 1e-3, 0.1)[::order]
    ends = made[0].control_points[[0, -1]]
    assert np.linalg.norm(ends - 50.0 * x, axis=1).min() < 1e-3
    np.testing.assert_array_equal(made[1].control_points[0], shorter[0])


def test_what_crosses_or_ends_beside_or_runs_back_stays():
    x, y, z = np.eye(3)
    kept = [
        [arc(x, y, -1.0, 0.1), arc(x, z, -0.2, 1.0)],  # cross
        [arc(x, y, -1.0, 0.1), arc(x, y, 0.0, 1.5) + 0.1 * z],  # side by side
        [arc(x, y, -1.0, 0.0), arc(x, y, 0.0, 1.0)],  # meet
        [arc(x, y, -1.0, 0.1), arc(x, y, 0.05, -1.2)],  # one over the other, not on from it
    ]
    for rows in kept:
        splines = [spline_through(row, 1e-4) for row in rows]
        made = without_overlaps(splines, 1e-3, 0.1)
        assert all(one is other for one, other in zip(made, splines, strict=True))
