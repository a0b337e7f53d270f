"""Loops named by curves and joints, and found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_product.loops.boundaries import boundary_of, loop_of, mirrored_boundary
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.network.cutting import net_of
from bozzetto_product.network.net import Net
from bozzetto_product.network.outlines import outlines_of
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.sketched_network import PLANE, edge_set


def _points(net: Net, loop: tuple[tuple[int, bool], ...]) -> np.ndarray:
    for outline in outlines_of(net, loop):
        ends = [net.edges[edge].spline.control_points[:: 1 if on else -1] for edge, on in outline]
        for first, second in zip(ends, ends[1:] + ends[:1], strict=True):
            assert len(outline) == 1 or (first[-1] == second[0]).all()
    return np.vstack([net.edges[edge].spline.sampled(9)[:: 1 if on else -1] for edge, on in loop])


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_a_loop_comes_back_from_its_boundary(name: str) -> None:
    net = DRAWN[name]().net()
    for loop in find_loops(net).loops:
        back = loop_of(net, boundary_of(net, loop))
        assert back is not None
        assert set(back) == set(loop)
        _points(net, back)


@pytest.mark.parametrize("name", ["mouse", "car", "remote", "sandal"])
def test_joints_that_are_added_within_a_run_change_nothing(name: str) -> None:
    curves, joints = DRAWN[name]().built()
    net = net_of(curves, joints, PLANE)
    random = np.random.default_rng(5)
    added = [
        Joint(
            f"new{k}", (Meeting(str(random.choice([c.id for c in curves])), random.uniform(0, 1)),)
        )
        for k in range(20)
    ]
    later = net_of(curves, [*joints, *added], PLANE)
    assert len(later.edges) > len(net.edges)
    for loop in find_loops(net).loops:
        boundary = boundary_of(net, loop)
        back = loop_of(later, boundary)
        assert back is not None
        before, after = _points(net, loop), _points(later, back)
        assert np.linalg.norm(before[:, None] - after, axis=2).min(axis=0).max() < 0.2 * np.ptp(
            before
        )
        assert boundary_of(later, back) == boundary or len(boundary) == 1


@pytest.mark.parametrize("name", ["mouse", "helmet", "chair", "remote"])
def test_the_mirror_image_of_a_boundary_is_that_of_its_loop(name: str) -> None:
    net = DRAWN[name]().net()
    for loop in find_loops(net).loops:
        image = loop_of(net, mirrored_boundary(boundary_of(net, loop)))
        assert image is not None
        assert edge_set(image) == {net.edges[edge].twin for edge, _ in loop}
        own, other = _points(net, loop), _points(net, image)
        assert np.allclose(sorted(own.tolist()), sorted((other * [1, -1, 1]).tolist()))


def test_a_loop_is_gone_with_a_curve_or_a_joint() -> None:
    curves, joints = DRAWN["car"]().built()
    net = net_of(curves, joints, PLANE)
    for loop in find_loops(net).loops[:6]:
        boundary = boundary_of(net, loop)
        for run in boundary:
            left = [each for each in curves if each.id != run.curve]
            assert loop_of(net_of(left, joints, PLANE), boundary) is None
        fewer = [each for each in joints if each.id != boundary[0].start]
        assert loop_of(net_of(curves, fewer, PLANE), boundary) is None
        assert (
            loop_of(net, (*boundary, replace(boundary[0], forward=not boundary[0].forward))) is None
        )
    assert loop_of(net, ()) is None
