"""Creases and the lock of tangent ratios: closed forms, brute force and laws."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.crease import SMOOTH, crease_angles, locked
from bozzetto.geometry.patches.patch import grid
from tests.core.geometry.body_kit import body, mirror_images, network, smooth_rows


def roof(angle):
    """Two flat patches that meet at an angle along edge 0, (edges, sides)."""
    rise = np.tan(np.radians(angle / 2))
    corners = {"a": (0, 0, 0), "b": (0, 10, 0), "c": (8, 0, -8 * rise), "d": (8, 10, -8 * rise),
               "e": (-8, 0, -8 * rise), "f": (-8, 10, -8 * rise)}  # fmt: skip
    edges = []
    for p, q in ("ab", "ac", "cd", "db", "be", "fe", "af"):
        swap = {"e": "f", "f": "e"}
        p, q = (np.array(corners[swap.get(k, k)], float) for k in (p, q))
        edges.append([p, p + (q - p) / 3, q + (p - q) / 3, q])
    return np.array(edges), np.array([[1, 2, 3, ~0], [0, 4, ~5, ~6]])


@pytest.mark.parametrize("angle", [0.0, 0.05, 1.0, 30.0, 90.0, 170.0])
def test_the_crease_of_two_planes(angle):
    edges, sides = roof(angle)
    found = crease_angles(coons_nets(edges, sides), sides, len(edges))
    assert found[0] == pytest.approx(angle, abs=1e-9)
    assert np.isnan(found[1:]).all()


def test_edges_of_no_patch_have_no_crease():
    edges, sides = roof(10)
    assert np.isnan(crease_angles(coons_nets(edges, sides), sides, 9)[7:]).all()


def test_creases_of_a_body_by_brute_force():
    """Normals of both patches by differences, matched by their places."""
    edges, sides, _, _ = body(4, 0.8)
    nets = coons_nets(edges, sides)
    found = crease_angles(nets, sides, len(edges))
    assert np.isnan(found).sum() == 12
    at, h = np.linspace(0, 1, 33), 1e-6
    seen = {}
    for patch, row in enumerate(sides.tolist()):
        for place, edge in enumerate(row):
            u, v = [(at, 0), (1, at), (1 - at, 1), (0, 1 - at)][place]
            u, v = np.broadcast_arrays(u, v)
            u, v = np.clip(u, 1e-4, 1 - 1e-4), np.clip(v, 1e-4, 1 - 1e-4)

            def point(a, b, net=nets[patch]):
                return np.array(
                    [grid(net[None], [x], [y])[0, 0, 0] for x, y in zip(a, b, strict=True)]
                )

            n = np.cross(point(u + h, v) - point(u - h, v), point(u, v + h) - point(u, v - h))
            n /= np.linalg.norm(n, axis=1, keepdims=True)
            seen.setdefault(edge if edge >= 0 else ~edge, []).append(n if edge >= 0 else n[::-1])
    for edge, both in seen.items():
        if len(both) == 2:
            inner = slice(3, -3)  # beside degenerate corners the normal turns quickly
            angle = np.degrees(np.arccos(np.clip((both[0] * both[1]).sum(1), -1, 1)))[inner]
            assert angle.max() <= found[edge] + 0.1


def crossed_edges():
    """Numbers of the edges that smooth lines cross in both ends, from one patch to the other."""
    ends, sides, _ = network()
    corner = {number: pair for pair, number in ends.items()}
    joined = {(b, frozenset((a, c))) for row in smooth_rows()
              for a, b, c in zip(row, row[1:], row[2:], strict=False)}  # fmt: skip
    beside = {}
    for row in sides.tolist():
        quad = [corner[s][0] if s >= 0 else corner[~s][1] for s in row]
        for k in range(4):
            beside[quad[k], quad[(k + 1) % 4]] = quad[k - 1], quad[(k + 2) % 4]
    found = []
    for number, (a, b) in corner.items():
        if (a, b) in beside and (b, a) in beside:
            (a1, b1), (b2, a2) = beside[a, b], beside[b, a]
            if {(a, frozenset((a1, a2))), (b, frozenset((b1, b2)))} <= joined:
                found.append(number)
    return found


def test_smooth_lines_alone_do_not_make_smooth_surfaces_but_the_lock_does():
    smooth = crossed_edges()
    assert len(smooth) == 22
    worst = 0.0
    for seed in range(10):
        edges, sides, _, joints = body(seed, 2.0)
        before = crease_angles(coons_nets(edges, sides), sides, len(edges))[smooth]
        worst = max(worst, before.max())
        made = locked(edges, sides, joints)
        after = crease_angles(coons_nets(made, sides), sides, len(edges))[smooth]
        assert after.max() <= 1e-4
    assert worst > 10 * SMOOTH


def strip(ratios):
    """Patches on both sides of a line of edges along y, crossed by straight lines in x."""
    count = len(ratios)
    edges, sides, joints = [], [], []
    for k, ratio in enumerate(ratios):
        p = np.array([0.0, 10.0 * k, 0.0])
        lift = np.array([3.0, 0.0, 1.0 + 0.5 * k])  # the line's tangent at the node
        far = p + np.array([[10, 0, -2.0 - k], [-10, 0, -4.0]])
        edges.append([p, p + ratio * lift, far[0] - [3, 0, 0], far[0]])
        edges.append([p, p - lift, far[1] + [3, 0, 0], far[1]])
        joints.append((2 * k + 1, 2 * k))

    def line(a, b):
        d = b - a
        edges.append([a, a + d / 3, b - d / 3, b])
        return len(edges) - 1

    ends = [[np.array(e[0]), np.array(e[3])] for e in edges]
    for k in range(count - 1):
        r, w = 2 * k, 2 * k + 1
        middle = line(ends[r][0], ends[r + 2][0])
        right, left = line(ends[r][1], ends[r + 2][1]), line(ends[w][1], ends[w + 2][1])
        sides.append([r, right, ~(r + 2), ~middle])
        sides.append([~w, middle, w + 2, ~left])
    return np.array(edges), np.array(sides), tuple(joints)


def test_equal_ratios_need_no_lock_and_unequal_ones_crease():
    edges, sides, joints = strip([2.0, 2.0])
    middle = 4
    assert crease_angles(coons_nets(edges, sides), sides, len(edges))[middle] <= 1e-5
    np.testing.assert_array_equal(locked(edges, sides, joints), edges)
    edges, sides, joints = strip([0.5, 2.0])
    assert crease_angles(coons_nets(edges, sides), sides, len(edges))[middle] > 1.0


def test_a_row_gets_the_geometric_mean_of_its_ratios_and_joints_keep_their_product():
    ratios = [0.5, 2.0, 3.0, 1.0]
    edges, sides, joints = strip(ratios)
    made = locked(edges, sides, joints)

    def lengths(e):
        d = np.linalg.norm(e[:8, 1] - e[:8, 0], axis=1)
        return d[::2], d[1::2]

    right, left = lengths(made)
    np.testing.assert_allclose(right / left, np.prod(ratios) ** 0.25, rtol=1e-12)
    before = lengths(edges)
    np.testing.assert_allclose(right * left, before[0] * before[1], rtol=1e-12)
    np.testing.assert_array_equal(made[:, [0, 3]], edges[:, [0, 3]])
    one, other = made[:8, 1] - made[:8, 0], edges[:8, 1] - edges[:8, 0]
    np.testing.assert_allclose(np.cross(one, other), 0, atol=1e-12)
    np.testing.assert_array_equal(made[8:], edges[8:])

    # No other common ratio changes the logarithms less.
    def cost(k):
        return sum((np.log(k) - np.log(r)) ** 2 for r in ratios)

    best = np.prod(ratios) ** 0.25
    assert cost(best) < min(cost(best * 1.01), cost(best / 1.01))


def test_the_order_of_joints_and_of_their_ends_does_not_matter():
    edges, sides, joints = strip([0.5, 2.0, 3.0])
    expected = locked(edges, sides, joints)
    turned = tuple((b, a) for a, b in reversed(joints))
    np.testing.assert_array_equal(locked(edges, sides, turned), expected)
    mixed = (joints[0], joints[1][::-1], joints[2])
    np.testing.assert_array_equal(locked(edges, sides, mixed), expected)


def test_a_symmetric_network_stays_so_bit_for_bit():
    images = mirror_images()
    for seed in range(10):
        edges, sides, _, joints = body(seed, 2.0, symmetric=True)
        for curves in (edges, locked(edges, sides, joints)):
            for number, image in images.items():
                curve = curves[image] if image >= 0 else curves[~image][::-1]
                np.testing.assert_array_equal(curves[number], curve * [1, -1, 1])


def test_a_locked_network_is_locked():
    edges, sides, _, joints = body(1, 2.0)
    made = locked(edges, sides, joints)
    assert np.abs(made - edges).max() > 1
    np.testing.assert_allclose(locked(made, sides, joints), made, atol=1e-9)


def test_tangents_of_no_length_stay_and_nothing_is_not_a_number():
    edges, sides, joints = strip([0.5, 2.0])
    edges[0, 1] = edges[0, 0]
    made = locked(edges, sides, joints)
    assert np.isfinite(made).all()
    np.testing.assert_array_equal(made[0], edges[0])


def test_the_firmer_an_edge_is_the_less_it_gives_way():
    edges, sides, joints = strip([0.5, 2.0, 3.0])
    plain = locked(edges, sides, joints)
    even = locked(edges, sides, joints, np.full(len(edges), 7.0))
    np.testing.assert_allclose(even, plain, rtol=1e-12)
    held = {max(end, ~end) for end in joints[0]}
    firm = np.ones(len(edges))
    firm[list(held)] = 1e6
    made = locked(edges, sides, joints, firm)
    np.testing.assert_allclose(made[list(held)], edges[list(held)], atol=1e-3)
    # Whatever is firm, surfaces are smooth: the ratio in all joints is one.
    lengths = np.linalg.norm(made[:, [1, 2]] - made[:, [0, 3]], axis=2)
    ratios = [
        np.divide(*(lengths[end, 0] if end >= 0 else lengths[~end, 1] for end in joint))
        for joint in joints
    ]
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-9)


def test_of_all_ratios_the_one_is_taken_that_costs_least():
    """Against a search over the common ratio, each joint giving way as it costs least."""
    from scipy.optimize import minimize_scalar

    edges, sides, joints = strip([0.4, 1.5, 2.5])
    firm = np.random.default_rng(4).uniform(0.5, 20.0, len(edges))

    def lengths(curves):
        return np.linalg.norm(curves[:, [1, 2]] - curves[:, [0, 3]], axis=2)

    def length(of, end):
        return of[end, 0] if end >= 0 else of[~end, 1]

    def price(logarithm):
        total = 0.0
        for one, other in joints:
            a, b = firm[max(one, ~one)], firm[max(other, ~other)]
            now = np.log(length(lengths(edges), other) / length(lengths(edges), one))
            total += a * b / (a + b) * (logarithm - now) ** 2
        return total

    made = lengths(locked(edges, sides, joints, firm))
    one, other = joints[0]
    found = np.log(length(made, other) / length(made, one))
    assert abs(found - minimize_scalar(price).x) < 1e-6
