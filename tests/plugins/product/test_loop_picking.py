"""The loop that a touch means, and what is left open."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_product.loops.finding import find_loops
from bozzetto_product.loops.picking import loops_at
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.random_networks import cells
from tests.plugins.product.sketched_network import edge_set


@pytest.mark.parametrize("seed", [3001, 3002])
def test_a_touch_on_a_body_means_the_face_in_front(seed: int) -> None:
    sketch = cells(seed)
    net = sketch.net()
    found = find_loops(net)
    middle = net.nodes.mean(axis=0)
    for face in sketch.truth(net):
        centre = np.vstack([net.edges[edge].spline.sampled(9) for edge in face]).mean(axis=0)
        eye = middle + 20.0 * (centre - middle)
        at = loops_at(net, found, eye, centre - eye)
        assert edge_set(at[0]) == face
        assert len({edge_set(loop) for loop in at}) == len(at)


def test_the_next_touch_may_mean_another_loop() -> None:
    net = DRAWN["sheet"]().net()
    found = find_loops(net)
    at = loops_at(net, found, (3.0, 4.0, 500.0), (0.0, 0.0, -1.0))
    assert len(at) > 1
    assert edge_set(at[0]) in {edge_set(loop) for loop in found.loops}


@pytest.mark.parametrize(
    "ray", [((1e4, 0, 500), (0, 0, -1)), ((0, 0, 9), (0, 0, 0)), ((0, 0, np.nan), (0, 0, 1))]
)
def test_a_touch_beside_all_loops_means_none(
    ray: tuple[tuple[float, ...], tuple[float, ...]],
) -> None:
    net = DRAWN["sheet"]().net()
    assert loops_at(net, find_loops(net), *ray) == ()
