"""Plane outlines that are bent inward get surfaces without folds."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.loops.orientation import orient_loops
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.plane_outlines import angled, waisted

SEEDS = range(9000, 9008)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("outline", [waisted, angled])
def test_outlines_bent_inward_do_not_fold(outline, seed: int) -> None:
    net, loop = outline(seed)
    fill = fill_net(net, [loop])[0]
    assert fill is not None
    assert not fill.folded
    heights = np.abs(fill.mesh.vertices[:, 2])
    assert heights.max() < 1e-6
    ring = np.concatenate([net.edges[edge].spline.sampled(65)[:-1, :2] for edge, _ in loop])
    x, y = ring.T
    area = 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    assert abs(fill.area / area - 1.0) < 2e-3


@pytest.mark.parametrize("name", ["guitar", "remote"])
def test_drawn_outlines_with_a_waist_do_not_fold(name: str) -> None:
    net = DRAWN[name]().net()
    loops = orient_loops(net, find_loops(net).loops).loops
    longest = sorted(loops, key=len)[-2:]
    assert not any(fill is None or fill.folded for fill in fill_net(net, longest))
