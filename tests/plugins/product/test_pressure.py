"""Pressure by volume: films against spherical caps, plates against their tangent planes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.network.net import Edge, Net
from bozzetto_product.shaping.pressure import inflated, volume_of_pressure

QUARTER = 0.5522847498
"""Handle of a cubic that is a quarter of a circle."""

ONE_SPAN = np.repeat((0.0, 1.0), 4)


def disc(radius: float = 1.0, turn: np.ndarray | None = None) -> Fill:
    """A flat disc within four quarter circles that are creases."""
    corners = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], float)
    frame = np.eye(3) if turn is None else turn
    places = radius * corners @ frame.T
    edges = []
    for k in range(4):
        start, end = corners[k], corners[(k + 1) % 4]
        inner = [start + QUARTER * end, end + QUARTER * start]
        net = radius * np.array([start, *inner, end]) @ frame.T
        net[[0, -1]] = places[k], places[(k + 1) % 4]
        edges.append(Edge(Spline(ONE_SPAN, net), k, (k + 1) % 4, f"c{k}", crease=1.0))
    made = Net(places, tuple(edges), (("", False),) * 4)
    (fill,) = fill_net(made, [tuple((k, True) for k in range(4))])
    return fill


def middle_of_a_sheet(height=lambda x, y: 0.1 * (x * x - 0.6 * y * y)) -> Fill:
    """The middle of three by three surfaces that meet smoothly."""
    at = np.array([0.0, 1.0, 2.2, 3.0])
    nodes = np.array([(x, y, height(x, y)) for x in at for y in at])
    edges = []
    for i, j in np.ndindex(4, 4):
        for di, dj in ((1, 0), (0, 1)):
            if i + di < 4 and j + dj < 4:
                a, b = 4 * i + j, 4 * (i + di) + j + dj
                share = np.linspace(0, 1, 4)[:, None]
                flat = nodes[a] + share * (nodes[b] - nodes[a])
                line = np.column_stack((flat[:, :2], [height(*place[:2]) for place in flat]))
                edges.append(Edge(_through(line), a, b, f"c{len(edges)}", crease=0.0))
    numbers = {(edge.start, edge.end): k for k, edge in enumerate(edges)}

    def loop(i: int, j: int):
        a, b, c, d = 4 * i + j, 4 * i + 4 + j, 4 * i + 5 + j, 4 * i + 1 + j
        return (
            (numbers[a, b], True), (numbers[b, c], True),
            (numbers[d, c], False), (numbers[a, d], False),
        )  # fmt: skip

    net = Net(nodes, tuple(edges), (("", False),) * 16)
    fills = fill_net(net, [loop(i, j) for i in range(3) for j in range(3)])
    return fills[4]


def _through(points: np.ndarray) -> Spline:
    """The cubic through four points at even parameters."""
    t = np.linspace(0, 1, 4)[:, None]
    rows = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    net = np.linalg.solve(rows, points)
    net[[0, -1]] = points[[0, -1]]
    return Spline(ONE_SPAN, net)


def places(fill: Fill, count: int = 33) -> np.ndarray:
    u, v = (x.ravel() for x in np.meshgrid(*[np.linspace(0, 1, count)] * 2, indexing="ij"))
    return np.concatenate([patch.value(u, v) for patch in fill.patches])


def volume_between(one: Fill, other: Fill, count: int = 129) -> float:
    """By triangles on a fine grid, which is another way than the one under test."""
    found = []
    for fill in (one, other):
        total = 0.0
        u, v = (x.ravel() for x in np.meshgrid(*[np.linspace(0, 1, count)] * 2, indexing="ij"))
        for patch in fill.patches:
            grid = patch.value(u, v).reshape(count, count, 3)
            a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
            total += (np.cross(a, b) * c).sum() / 6 + (np.cross(a, c) * d).sum() / 6
        found.append(total)
    return found[1] - found[0]


@pytest.mark.parametrize("share", [1 / 3, 1.0, 1.4, -0.6])
def test_a_disc_becomes_the_cap_of_its_volume_through_the_hemisphere(share: float) -> None:
    radius = 40.0
    height = share * radius
    volume = np.pi * height * (3 * radius**2 + height**2) / 6
    found = inflated(disc(radius), volume)
    assert not found.limited
    assert found.volume == pytest.approx(volume)
    points = places(found.fill)
    tops = points[:, 2].min(), points[:, 2].max()
    assert tops[share > 0] == pytest.approx(height, rel=1e-3)
    ball = (radius**2 + height**2) / 2 / abs(height)
    middle = (0, 0, height - np.sign(height) * ball)
    np.testing.assert_allclose(np.linalg.norm(points - middle, axis=1), ball, rtol=2e-3)


def test_the_volume_is_kept_to_the_last_digits_and_so_is_the_boundary() -> None:
    start = middle_of_a_sheet()
    wanted = volume_of_pressure(start.area, 0.1)
    found = inflated(start, wanted)
    assert not found.limited
    assert volume_between(start, found.fill) == pytest.approx(wanted, rel=2e-3)
    again = inflated(found.fill, 0.0)
    assert again.fill is found.fill
    for one, two in zip(start.patches, found.fill.patches, strict=True):
        np.testing.assert_array_equal(one.control_points[0], two.control_points[0])
        np.testing.assert_array_equal(one.control_points[:, 0], two.control_points[:, 0])


@pytest.mark.parametrize("pressure", [0.05, -0.05, 0.15])
def test_smooth_edges_stay_smooth(pressure: float) -> None:
    start = middle_of_a_sheet()
    found = inflated(start, volume_of_pressure(start.area, pressure)).fill
    assert max(found.g1_degrees) <= max(start.g1_degrees) + 0.1


def test_too_much_pressure_stops_where_the_surface_would_come_off() -> None:
    start = middle_of_a_sheet()
    asked = volume_of_pressure(start.area, 2.0)
    found = inflated(start, asked)
    assert found.limited
    assert 0.0 < found.volume < asked
    assert max(found.fill.g1_degrees) <= max(start.g1_degrees) + 1.0
    assert volume_between(start, found.fill) == pytest.approx(found.volume, rel=5e-3)


@pytest.mark.parametrize("make", [disc, lambda: middle_of_a_sheet(lambda x, y: 0.0 * x)])
def test_out_and_in_are_mirror_images_on_a_plane(make) -> None:
    start = make()
    volume = volume_of_pressure(start.area, 0.2)
    out, back = (places(inflated(start, sense * volume).fill) for sense in (1, -1))
    np.testing.assert_allclose(out * (1, 1, -1), back, atol=1e-9 * start.size)


def test_more_pressure_is_more_volume_everywhere() -> None:
    start = disc()
    tops = [
        places(inflated(start, volume_of_pressure(start.area, p)).fill)[:, 2].max()
        for p in (0.1, 0.3, 0.6, 1.0)
    ]
    assert (np.diff(tops) > 0.05).all()


def test_a_thousand_times_larger_and_turned_is_the_same() -> None:
    turn = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
    volume = volume_of_pressure(disc().area, 0.7)
    small = places(inflated(disc(), volume).fill)
    large = places(inflated(disc(1000.0, turn), 1e9 * volume).fill)
    middle, radius = ball_through(small)
    away = np.linalg.norm(large - 1000.0 * turn @ middle, axis=1)
    np.testing.assert_allclose(away, 1000.0 * radius, rtol=1e-3)


def ball_through(points: np.ndarray) -> tuple[np.ndarray, float]:
    rows = np.column_stack((2 * points, np.ones(len(points))))
    found = np.linalg.lstsq(rows, (points**2).sum(axis=1), rcond=None)[0]
    return found[:3], float(np.sqrt(found[3] + found[:3] @ found[:3]))


def test_twice_the_same_whatever_was_asked_between() -> None:
    start = middle_of_a_sheet()
    volume = volume_of_pressure(start.area, 0.12)
    once = inflated(start, volume).fill
    inflated(start, -volume)
    inflated(start, 0.3 * volume)
    again = inflated(replace(start), volume).fill
    for one, two in zip(once.patches, again.patches, strict=True):
        np.testing.assert_array_equal(one.control_points, two.control_points)
