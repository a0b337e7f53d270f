"""Loops that nobody would draw on purpose are filled with numbers, or refused with a sentence."""

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.network.net import Edge, Net


def net_of_chains(chains):
    nodes = np.array([chain[0] for chain in chains], float)
    count = len(chains)
    edges = []
    for k, chain in enumerate(chains):
        points = np.array(chain, float)
        points[-1] = nodes[(k + 1) % count]
        edges.append(Edge(Spline.uniform(points), k, (k + 1) % count, f"c{k}"))
    return Net(nodes, tuple(edges)), [tuple((k, True) for k in range(count))]


def line(a, b, count=7):
    return np.linspace(a, b, count)


HOSTILE = {
    "one point": [np.zeros((7, 3))] * 4,
    "on one line": [
        line((0, 0, 0), (1, 0, 0)),
        line((1, 0, 0), (2, 0, 0)),
        line((2, 0, 0), (0, 0, 0)),
    ],
    "there and back": [line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (0, 0, 0))],
    "an edge of no length": [
        line((0, 0, 0), (1, 0, 0)),
        line((1, 0, 0), (1, 0, 0)),
        line((1, 0, 0), (1, 1, 0)),
        line((1, 1, 0), (0, 0, 0)),
    ],
    "an edge that hardly has a length": [
        line((0, 0, 0), (1, 0, 0)),
        line((1, 0, 0), (1, 1e-12, 0)),
        line((1, 1e-12, 0), (1, 1, 0)),
        line((1, 1, 0), (0, 0, 0)),
    ],
    "a bow tie": [
        line((0, 0, 0), (1, 1, 0)),
        line((1, 1, 0), (1, 0, 0)),
        line((1, 0, 0), (0, 1, 0)),
        line((0, 1, 0), (0, 0, 0)),
    ],
    "a needle": [
        line((0, 0, 0), (1000, 0, 0)),
        line((1000, 0, 0), (1000, 1e-3, 0)),
        line((1000, 1e-3, 0), (0, 0, 0)),
    ],
    "doubled points": [
        np.repeat([(0, 0, 0), (1, 0, 0.1)], 4, axis=0),
        np.repeat([(1, 0, 0.1), (0, 1, 0)], 4, axis=0),
        np.repeat([(0, 1, 0), (0, 0, 0)], 4, axis=0),
    ],
    "a spike": [
        [(0, 0, 0), (5, 0, 0), (5, 0, 0), (0, 0.1, 0), (1, 0, 0)],
        line((1, 0, 0), (1, 1, 1)),
        line((1, 1, 1), (0, 0, 0)),
    ],
    "a closed stroke through itself": [
        [(np.cos(t), np.sin(2 * t), 0.1 * t) for t in np.linspace(0, 2 * np.pi, 12)]
    ],
}


@pytest.mark.parametrize("name", list(HOSTILE))
def test_a_hostile_loop_gives_numbers_or_nothing(name):
    net, loops = net_of_chains(HOSTILE[name])
    (fill,) = fill_net(net, loops)
    if fill is None:
        return
    fill.mesh, fill.folded, fill.area, fill.quality_p5, fill.g1_degrees  # noqa: B018
    for patch in fill.patches:
        assert np.isfinite(patch.control_points).all()
    assert np.isfinite(fill.mesh.vertices).all()
    assert fill.deviation < 1e-9 * 1000


def test_far_from_the_origin_the_sides_stay_exact():
    net, loops = net_of_chains(
        [
            line((1e6, 0, 0), (1e6 + 1, 0, 0)),
            line((1e6 + 1, 0, 0), (1e6 + 1, 1, 0.2)),
            line((1e6 + 1, 1, 0.2), (1e6, 0, 0)),
        ]
    )
    (fill,) = fill_net(net, loops)
    assert fill.deviation < 1e-8
    assert not fill.folded


def test_a_loop_of_one_point_has_no_surface_and_takes_none_from_another():
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0.2)]
    good, _ = net_of_chains([line(corners[k], corners[(k + 1) % 3]) for k in range(3)])
    point, _ = net_of_chains(HOSTILE["one point"])
    shifted = [replace(e, start=e.start + 3, end=e.end + 3) for e in point.edges]
    both = Net(np.vstack((good.nodes, point.nodes)), (*good.edges, *shifted))
    loops = [tuple((k, True) for k in range(3)), tuple((k, True) for k in range(3, 7))]
    fill, nothing = fill_net(both, loops)
    assert nothing is None
    assert fill is not None
    assert fill.area == pytest.approx(
        0.5 * np.linalg.norm(np.cross(corners[1], corners[2])), rel=1e-6
    )
