"""Curves that cross themselves, or end on themselves, are cut there: an 8, a 6, a clover."""

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.point_fit import closed_spline_through, spline_through
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.own_crossings import own_crossings
from bozzetto_product.operations.trim import trim
from bozzetto_product.report import report_of
from bozzetto_product.solve.solver import net_of_state, solve_product

ROUND = np.linspace(0.0, 2 * np.pi, 121)


def eight(start=0.3, size=60.0):
    at = ROUND + start
    return np.column_stack((size * np.cos(at), size / 2 * np.sin(2 * at), 0.0 * at))


def teardrop(begin, end, count=81):
    """A curve that crosses itself at the origin, at t = −1 and 1."""
    t = np.linspace(begin, end, count)
    return np.column_stack((40.0 * (t * t - 1), 30.0 * t * (t * t - 1), 0.0 * t))


def clover(count=241):
    t = np.linspace(0.2, 0.2 + 2 * np.pi, count)
    reach, beside = 30.0 + 22.0 * np.cos(4 * t), 8.0 * np.sin(4 * t)
    return np.column_stack(
        (reach * np.cos(t) - beside * np.sin(t), reach * np.sin(t) + beside * np.cos(t), 0.0 * t)
    )


def turned(points, seed):
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return points @ axes.T + rng.normal(0.0, 100.0, 3)


def reported(*rows):
    curves = [{"name": f"c{k}", "points": row.tolist()} for k, row in enumerate(rows, 1)]
    state = product_of_network({"network": {"curves": curves}, "unit": "mm"})
    result = solve_product(state, Job(quality="final"))
    return report_of(state, result, Job()), state


@pytest.mark.parametrize("seed", [71, 72, 73])
def test_an_eight_is_two_surfaces_however_it_lies(seed):
    told, _ = reported(turned(eight(start=0.1 * seed), seed))
    assert sorted(told["loops"]) == [["c1/1"], ["c1/2"]]
    lobes = 2 * 60.0**2 / 3  # ½ ∮ (x dy − y dx) round one of (a cos t, ½ a sin 2t)
    assert told["joints"] == 1
    assert sum(one["area_mm2"] for one in told["patches"]) == pytest.approx(2 * lobes, rel=2e-2)


def test_an_eight_on_a_sphere_has_two_surfaces_on_it():
    flat = eight(size=1.0)
    points = np.column_stack((flat[:, 0], flat[:, 1], np.full(len(flat), 1.2)))
    points *= 50.0 / np.linalg.norm(points, axis=1, keepdims=True)
    told, state = reported(points)
    assert len(told["patches"]) == 2
    result = solve_product(state, Job(quality="final"))
    for one in result.filled:
        away = np.abs(np.linalg.norm(one.mesh.vertices, axis=1) - 50.0)
        assert away.max() < 5e-3


def test_a_curve_may_begin_on_itself():
    told, state = reported(teardrop(-1.0, 1.8))
    assert told["loops"] == [["c1/1"]]
    (joint,) = state.joints
    assert {meet.at == 0.0 for meet in joint.meetings} == {True, False}
    # ∮ x dy round the loop of x = 40 (t² − 1), y = 30 t (t² − 1)
    assert told["patches"][0]["area_mm2"] == pytest.approx(1200 * 8 / 15, rel=2e-2)


def test_a_symmetric_clover_has_no_pieces_without_length():
    _, state = reported(clover())
    net = net_of_state(state)
    lengths = [
        np.linalg.norm(np.diff(edge.spline.sampled(33), axis=0), axis=1).sum() for edge in net.edges
    ]
    assert len(net.edges) == 8
    assert min(lengths) > 1.0


def test_an_eight_drawn_beside_itself_is_joined_by_trim():
    points = eight()
    points[:, 2] = 0.4 * np.sin(ROUND + 0.3)  # both passages are 0.8 mm apart
    spline = closed_spline_through(points[:-1], 1e-3)
    state = trim(ProductState(nodes=(Curve("n1", "c1", spline=spline),)), gap=2.0).state
    (joint,) = state.joints
    assert [meet.curve for meet in joint.meetings] == ["n1", "n1"]
    (own,) = [node.spline for node in state.nodes]
    begin, end = own.range
    one, other = own.value([begin + meet.at * (end - begin) for meet in joint.meetings])
    np.testing.assert_allclose(one, other, atol=1e-9)
    net = net_of_state(state)
    assert [(edge.start, edge.end) for edge in net.edges] == [(0, 0), (0, 0)]


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_crossings_scale(scale):
    spline = spline_through(scale * teardrop(-1.6, 1.6), scale * 1e-3)
    ((first, second, place),) = own_crossings(spline, scale * 1e-2)
    begin, end = spline.range
    np.testing.assert_allclose(
        spline.value([begin + s * (end - begin) for s in (first, second)]),
        [place, place],
        atol=scale * 1e-2,
    )
    assert np.linalg.norm(place) < scale * 1e-2


@pytest.mark.parametrize(
    "points",
    [
        np.column_stack((30 * np.cos(ROUND), 30 * np.sin(ROUND), 0 * ROUND))[:-1],
        np.column_stack((30 * np.cos(3 * ROUND), 30 * np.sin(3 * ROUND), 12 * ROUND)),
        np.column_stack((ROUND, np.sin(9 * ROUND), 0 * ROUND)),
    ],
    ids=["most of a circle", "screw", "waves"],
)
def test_what_does_not_meet_itself_has_no_crossing(points):
    assert own_crossings(spline_through(points, 1e-4), 0.5) == []


def test_a_straight_curve_has_none():
    straight = Spline.uniform(np.linspace((0, 0, 0), (9, 9, 9), 4).astype(float))
    assert own_crossings(straight, 1.0) == []
