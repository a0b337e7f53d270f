"""Rails that bend over an edge: the surface between them follows them, and stays smooth."""

import numpy as np
import pytest

from bozzetto.geometry import Curve, Spline
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.fill.quintic import insertion
from bozzetto_product.fill.thin_strips import left_in_middle
from bozzetto_product.hand_over.point_fit import spline_through
from tests.plugins.product.known_surfaces import net_of_splines

RAIL = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 40.0), (60.0, 0.0, 40.0)])


def bent(radius, count=20):
    """Points of an L over an edge, with a fillet."""
    corner, turn = RAIL[1] + (radius, 0.0, -radius), np.linspace(0.0, 0.5 * np.pi, count)[:, None]
    arc = corner + radius * (np.sin(turn) * (0.0, 0.0, 1.0) - np.cos(turn) * (1.0, 0.0, 0.0))
    steps = np.linspace(0.0, 1.0, count)[:, None]
    return np.vstack(
        (
            (RAIL[0] + steps * (arc[0] - RAIL[0]))[:-1],
            arc,
            (arc[-1] + steps * (RAIL[2] - arc[-1]))[1:],
        )
    )


def straight(one, two):
    return Spline.uniform(np.linspace(one, two, 4))


def between(rail, other, exactly=1e-4):
    """The surface between two rails, with straight edges at their ends."""
    size = np.linalg.norm(np.ptp(rail, axis=0))
    one, two = (spline_through(row, exactly * size, 0.1 * exactly * size) for row in (rail, other))
    edges = [
        one,
        straight(rail[-1], other[-1]),
        two.reversed(),
        straight(other[0], rail[0]),
    ]
    net, loop = net_of_splines(edges)
    (fill,) = fill_net(net, [loop])
    return fill


def off(fill, rail):
    """Largest distance of a surface from its rail, seen along the sweep, as share of its size."""
    places = fill.mesh.vertices[:, [0, 2]].astype(float)
    start, way = rail[:-1, [0, 2]], np.diff(rail[:, [0, 2]], axis=0)
    share = ((places[:, None] - start) * way).sum(axis=2) / (way**2).sum(axis=1)
    feet = start + np.clip(share, 0.0, 1.0)[..., None] * way
    return np.linalg.norm(places[:, None] - feet, axis=2).min(axis=1).max() / fill.size


def over_spokes(fill):
    """Largest angle of patches where they meet inside, degrees, and distance."""
    at, end = np.linspace(0.0, 1.0, 101), np.ones(101)
    angles, gaps = [], []
    for number, one in enumerate(fill.patches):
        two = fill.patches[(number + 1) % len(fill.patches)]
        across = np.cross(one.normals(end, at), two.normals(at, end))
        angles.append(np.degrees(np.linalg.norm(across, axis=1).max()))
        gaps.append(np.linalg.norm(one.value(end, at) - two.value(at, end), axis=1).max())
    return max(angles), max(gaps)


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize("radius", [1.0, 2.0, 4.0, 8.0])
def test_a_surface_between_rails_is_swept(radius, scale):
    """It sagged by 1.5 to 3 % of its size between them."""
    rail = scale * bent(radius)
    fill = between(rail, rail + scale * np.array((0.0, 20.0, 0.0)))
    assert not fill.folded
    assert off(fill, rail) < 0.01
    angle, gap = over_spokes(fill)
    assert angle < 0.01
    assert gap < 1e-12 * fill.size
    assert fill.deviation < 1e-12 * fill.size


@pytest.mark.parametrize("exactly", [1e-4, 1e-6])
def test_over_a_sharp_edge_it_does_not_count_as_folded(exactly):
    """Its normals turn by a right angle from one place of a grid to the next."""
    rail = np.vstack((np.linspace(RAIL[0], RAIL[1], 25), np.linspace(RAIL[1], RAIL[2], 25)[1:]))
    fill = between(rail, rail + np.array((0.0, 20.0, 0.0)), exactly)
    assert not fill.folded
    assert off(fill, rail) < 0.01


def test_rails_that_open_and_bend_at_other_places_are_smooth_inside():
    rail = bent(5.0)
    other = rail * (0.8, 1.0, 1.15) + (3.0, 30.0, 0.0) + 0.1 * rail[:, [2]] * (0.0, 1.0, 0.0)
    fill = between(rail, other)
    angle, gap = over_spokes(fill)
    assert not fill.folded
    assert angle < 0.05
    assert gap < 1e-12 * fill.size


def test_a_mirror_image_has_the_mirrored_surface():
    rail = bent(4.0)
    other = rail * (0.9, 1.0, 1.1) + (0.0, 24.0, 0.0)
    fill, image = between(rail, other), between(rail * (1.0, -1.0, 1.0), other * (1.0, -1.0, 1.0))
    at = np.linspace(0.0, 1.0, 9)
    for one, two in zip(fill.patches, image.patches, strict=True):
        assert np.allclose(
            one.value(at, at), two.value(at, at) * (1.0, -1.0, 1.0), atol=1e-7 * fill.size
        )


def test_a_bend_of_one_rail_only_fades():
    """A straight rail opposite has nothing in common with it: nothing is carried."""
    rail = bent(6.0)
    other = np.linspace(rail[0], rail[-1], 30) + np.array((0.0, 40.0, 0.0))
    fill = between(rail, other)
    assert {len(patch.knots_u) for patch in fill.patches} | {
        len(patch.knots_v) for patch in fill.patches
    } >= {12}
    assert over_spokes(fill)[0] < 1e-3


def test_more_knots_change_no_curve_however_short_a_span_is():
    random = np.random.default_rng(5)
    for short in (0.3, 1e-4, 1e-9):
        knots = np.concatenate((np.zeros(6), [short, 0.5, 0.5], np.ones(6)))
        finer = np.sort(np.concatenate((knots, random.random(3), [0.5, 0.9, 0.9])))
        points = random.normal(size=(9, 3))
        more, at = insertion(knots, finer) @ points, np.linspace(0.0, 1.0, 99)
        assert (more[[0, -1]] == points[[0, -1]]).all()
        one, other = (Curve(5, *each).value(at) for each in ((knots, points), (finer, more)))
        assert np.abs(one - other).max() < 1e-13


def wavy(length, waves, height, phase):
    """Points of a straight rail with waves along it."""
    at = np.linspace(0.0, 1.0, 61)
    bend = height * np.sin(2.0 * np.pi * waves * at + phase) * np.sin(np.pi * at) ** 2
    return np.column_stack((length * at, bend, np.zeros(61)))


@pytest.mark.parametrize("seed", range(6))
def test_a_long_wall_follows_both_of_its_rails(seed):
    """Where rails tremble each in its own way it had dents of their size between them."""
    random = np.random.default_rng(7000 + seed)
    rail = wavy(300.0, random.uniform(4.0, 7.0), 1.0, random.uniform(0.0, 6.0))
    other = wavy(300.0, random.uniform(4.0, 7.0), 1.0, random.uniform(0.0, 6.0))
    fill = between(rail, other + np.array((0.0, 0.0, 12.0)))
    places = fill.mesh.vertices.astype(float)
    share = places[:, 2] / 12.0
    low, high = (np.interp(places[:, 0], row[:, 0], row[:, 1]) for row in (rail, other))
    ruled = (1.0 - share) * low + share * high
    assert np.abs(places[:, 1] - ruled).max() < 0.35
    angle, gap = over_spokes(fill)
    assert angle < 0.05
    assert gap < 1e-12 * fill.size


@pytest.mark.parametrize("width", [0.0, 1e-9, 0.1, 1.0, 3.0, 10.0, 1e3, 1e9])
def test_what_is_left_of_waves_in_the_middle_of_a_strip(width):
    """All between sides that touch, less the wider it is, and that of the closed form."""

    class Half:
        def __init__(self, off):
            self.knots, self.off = np.array([0.0] * 6 + [0.5] + [1.0] * 6), off

        def value(self, at, order=0):
            return (
                np.outer(at, (9.0, 0.0, 0.0)) + self.off
                if order == 0
                else np.tile((9.0, 0.0, 0.0), (len(at), 1))
            )

    rest = np.random.default_rng(1).normal(size=(7, 3))
    found, wider = (
        left_in_middle((Half(np.zeros(3)), Half(np.array((0.0, each, 0.0)))), (rest, rest))
        for each in (width, 1.5 * width)
    )
    assert 0.0 <= wider <= found <= 1.0
    assert (found == 1.0) or width > 0.0
    assert found < 0.01 or width < 20.0
