"""Curves cut at their joints: exactly, mirrored to the last bit, whatever is missing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.cutting import net_of
from bozzetto_product.network.half_edges import half_edge_images
from bozzetto_product.network.net import Net
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.sketched_network import PLANE, interpolated

MIRRORED = sorted(name for name, make in DRAWN.items() if make().mirror)

ARC = Spline.uniform([(0, 10, 0), (10, 12, 5), (20, 9, 9), (30, 14, 3), (40, 10, 0)])
RING = Spline.uniform([(5, 1, 0), (5, 0, 1), (5, -1, 0), (5, 0, -1)], closed=True)


def _pieces(net: Net) -> dict[tuple[str, int, bool], Spline]:
    return {(each.curve, each.piece, each.mirrored): each.spline for each in net.edges}


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_pieces_are_the_curve_and_end_in_the_numbers_of_their_nodes(name: str) -> None:
    curves, joints = DRAWN[name]().built()
    net = net_of(curves, joints, PLANE)
    wholes = {each.id: each.spline for each in curves}
    for edge in net.edges:
        if edge.start >= 0:
            points = edge.spline.control_points
            assert (points[0] == net.nodes[edge.start]).all()
            assert (points[-1] == net.nodes[edge.end]).all()
        if not edge.mirrored:
            whole, places = wholes[edge.curve], edge.spline.sampled(7)
            feet = whole.value(whole.foot_points(places))
            size = np.ptp(whole.control_points, axis=0).max()
            assert np.abs(feet - places).max() <= 1e-9 * size


@pytest.mark.parametrize("name", MIRRORED)
def test_both_sides_are_mirror_images_to_the_last_bit(name: str) -> None:
    net = DRAWN[name]().net()
    images = half_edge_images(net)
    for number, edge in enumerate(net.edges):
        assert edge.twin >= 0
        twin = net.edges[edge.twin]
        assert twin.twin == number
        back = images[2 * number] % 2
        points = twin.spline.control_points[:: -1 if back else 1]
        assert (points == edge.spline.control_points * [1, -1, 1]).all()
    for node, image in enumerate(net.images):
        assert (net.nodes[image] == net.nodes[node] * [1, -1, 1]).all()
    assert (images[images] == np.arange(len(images))).all()


def test_a_joint_in_the_plane_lies_in_it_exactly() -> None:
    near = Spline.uniform([(0, 1e-7, 0), (0, 1, 0), (0, 2, 1), (0, 3, 1)])
    joint = Joint("j", (Meeting("a", 0.0),), in_plane=True)
    net = net_of([Curve("a", spline=near, mirrored=True)], [joint], PLANE)
    assert [edge.start for edge in net.edges] == [0, 0]
    assert net.nodes[0, 1] == 0.0


def test_a_curve_across_the_plane_is_met_on_both_sides() -> None:
    over, _ = interpolated(
        np.array([(0, -30, 0), (0, -15, 20), (0, 0, 26), (0, 15, 20), (0, 30, 0)])
    )
    side = Spline.uniform([(0, 30, 0), (10, 40, 0), (20, 40, 0), (30, 50, 0)])
    foot = Spline(side.knots, side.control_points + over.value([0.7]) - side.value([0.0]))
    curves = [Curve("over", spline=over), Curve("side", spline=foot, mirrored=True)]
    net = net_of(curves, [Joint("j", (Meeting("side", 0.0), Meeting("over", 0.7)))], PLANE)
    assert [edge.curve for edge in net.edges] == ["over", "over", "over", "side", "side"]
    assert [edge.twin for edge in net.edges] == [2, 1, 0, 4, 3]
    assert (
        net.edges[2].spline.control_points == net.edges[0].spline.control_points[::-1] * [1, -1, 1]
    ).all()


def test_pieces_come_in_order_whatever_the_order_of_curves_and_joints() -> None:
    curves, joints = DRAWN["car"]().built()
    one = _pieces(net_of(curves, joints, PLANE))
    other = _pieces(net_of(curves[::-1], joints[::-1], PLANE))
    assert one.keys() == other.keys()
    for key, spline in one.items():
        assert np.allclose(spline.control_points, other[key].control_points, rtol=0, atol=1e-9)


def test_a_thousand_times_larger_is_the_same() -> None:
    curves, joints = DRAWN["mouse"]().built()
    large = [
        replace(each, spline=Spline(each.spline.knots, 1000 * each.spline.control_points))
        for each in curves
        if each.spline
    ]
    one, other = net_of(curves, joints, PLANE), net_of(large, joints, PLANE)
    assert one.joints == other.joints
    assert [(e.start, e.end, e.twin) for e in one.edges] == [
        (e.start, e.end, e.twin) for e in other.edges
    ]


def test_whatever_is_missing_is_left_out() -> None:
    still = Spline.uniform(np.ones((4, 3)))
    flat = Spline.uniform([(0, 0), (1, 0), (2, 1), (3, 0)])
    curves = [
        Curve("a", spline=ARC),
        Curve("none"),
        Curve("still", spline=still),
        Curve("flat", spline=flat),
        Curve("ring", spline=RING),
    ]
    joints = [
        Joint("gone", (Meeting("nobody", 0.5), Meeting("still", 0.0))),
        Joint("nan", (Meeting("a", math.nan),)),
        Joint("beyond", (Meeting("a", 7.0), Meeting("none", 0.2))),
        Joint("one", (Meeting("a", 0.5),)),
        Joint("same", (Meeting("a", 0.5), Meeting("a", 0.5))),
        Joint("empty", ()),
        Joint("seam", (Meeting("ring", 1.0),)),
    ]
    net = net_of(curves, joints, Plane((0, 0, 0), (0, 0, 0)))
    assert [(edge.curve, edge.piece) for edge in net.edges] == [("a", 0), ("a", 1), ("ring", 0)]
    assert net.edges[2].start == net.edges[2].end
    assert np.isfinite(net.nodes).all()
    assert net_of([], joints, PLANE).edges == ()


def test_a_closed_curve_is_cut_where_it_is_met_and_stays_whole_where_not() -> None:
    (whole,) = net_of([Curve("r", spline=RING)], [], PLANE).edges
    assert whole.spline.closed
    assert whole.start == -1
    joints = [Joint("p", (Meeting("r", 0.2),)), Joint("q", (Meeting("r", 0.6),))]
    net = net_of([Curve("r", spline=RING)], joints, Plane((0, 0, 9), (0, 0, 1)))
    assert [(edge.start, edge.end) for edge in net.edges] == [(0, 1), (1, 0)]
    assert sum(edge.spline.length for edge in net.edges) == pytest.approx(RING.length, rel=1e-9)


def test_curves_that_did_not_change_give_the_very_same_pieces() -> None:
    curves, joints = DRAWN["car"]().built()
    before = _pieces(net_of(curves, joints, PLANE))
    moved = replace(curves[0], spline=interpolated(np.array([(0, 9, 0), (5, 9, 1), (9, 8, 0)]))[0])
    after = _pieces(net_of([moved, *curves[1:]], joints, PLANE))
    touched = {
        each.curve
        for joint in joints
        for each in joint.meetings
        if any(other.curve == curves[0].id for other in joint.meetings)
    }
    others = [key for key in before if key[0] not in touched]
    assert others
    assert all(after[key] is before[key] for key in others)
