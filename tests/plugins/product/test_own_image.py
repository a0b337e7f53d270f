"""A curve drawn across the symmetry plane, about alike on both sides, is its own mirror image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen, Shell
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.own_image import UNEVEN, as_own_image
from tests.plugins.product.pen_strokes import FRONT, draw_along
from tests.plugins.product.test_mirrored_changes import PLANE, arch

SEEDS = (7101, 7102, 7103, 7104)
ACROSS = Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def ring(seed: int, count: int = 9) -> Spline:
    """A closed curve that is its own image in `PLANE`, beginning anywhere on it."""
    random = np.random.default_rng(seed)
    angles = 2.0 * np.pi * np.arange(count) / count
    wave = 1.0 + 0.2 * np.cos(2.0 * angles) * random.uniform()
    points = np.column_stack((30.0 * wave * np.sin(angles), 20.0 * np.cos(angles), 5.0 * wave))
    return Spline.uniform(np.roll(points, 2, axis=0) + np.array([3.0, 0.0, 0.0]), closed=True)


def shaken(spline: Spline, size: float, seed: int) -> Spline:
    random = np.random.default_rng(seed)
    points = spline.control_points + random.normal(0.0, size, spline.control_points.shape)
    if spline.closed:
        points[-3:] = points[:3]
    return Spline(spline.knots, points, spline.closed)


def apart(one: Spline, other: Spline) -> float:
    places = one.sampled(200)
    return float(np.linalg.norm(other.value(other.foot_points(places)) - places, axis=1).max())


@pytest.mark.parametrize("make", [arch, ring])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_curve_that_is_its_own_image_stays_as_it_is(make, seed) -> None:
    whole = make(seed)
    made = as_own_image(whole, PLANE)
    assert made is not None
    assert apart(made, whole) < (1e-9 if make is arch else 0.2)  # of 60 mm: a ring is fitted anew


@pytest.mark.parametrize("make", [arch, ring])
@pytest.mark.parametrize("seed", SEEDS)
def test_what_a_hand_misses_is_shared_by_both_halves(make, seed) -> None:
    drawn = shaken(make(seed), 1.0, seed)
    reflection = Reflection(PLANE)
    made = as_own_image(drawn, PLANE)
    assert made is not None
    assert made.closed == drawn.closed
    assert reflection.keeps(made)
    assert apart(drawn, made) < UNEVEN * 80.0
    # Which side is which, and the direction of the stroke, do not count; nor does the size.
    image = as_own_image(reflection.spline(drawn), PLANE)
    assert image is not None
    assert apart(image, made) < 1e-6 * 80.0
    if not drawn.closed:
        back = as_own_image(drawn.reversed(), PLANE)
        assert back is not None
        assert apart(back, made) < 1e-9
    large = as_own_image(
        Spline(drawn.knots, 1000.0 * drawn.control_points, drawn.closed),
        Plane((3000.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    )
    assert large is not None
    assert np.allclose(large.control_points / 1000.0, made.control_points, atol=1e-6)


@pytest.mark.parametrize(
    "points",
    [
        [(-40, -30, 0), (-20, -15, 0), (20, 15, 0), (40, 30, 0)],  # askew
        [(-40, 10, 0), (-20, 25, 0), (20, 25, 0), (40, 10, 0)],  # beside the plane
        [(-60, -20, 0), (-30, 60, 0), (0, -60, 0), (30, 60, 0), (60, -60, 0)],  # there and back
        [(0, -10, 0), (0, 0, 0), (0, 30, 0), (0, 60, 0)],  # much more of it on one side
    ],
)
def test_what_is_meant_otherwise_is_left_alone(points) -> None:
    assert as_own_image(Spline.uniform(points), ACROSS) is None


@pytest.fixture
def shell(tmp_path: Path) -> Shell:
    made = Shell(Registry(), tmp_path)
    made.open("bozzetto.product")
    made.camera = FRONT
    made.run("add-box")
    made.set(mirror=True)
    return made


def across(seed: int) -> np.ndarray:
    """Places of a hand's stroke over the top of the box from side to side, mm."""
    random = np.random.default_rng(seed)
    along = np.linspace(-1.0, 1.0, 40)
    bow = random.uniform(5.0, 20.0)
    askew, tremor = random.uniform(-1.5, 1.5), np.sin(3.0 * along + random.uniform(0, 6.0))
    x = -40.0 + bow * (1.0 - along**2) + askew * along + 0.3 * tremor
    return np.column_stack((x, 30.0 * along, np.full(40, 60.0)))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_stroke_from_side_to_side_is_one_symmetric_curve(shell: Shell, seed: int) -> None:
    draw_along(shell, Pen(), across(seed))
    (curve,) = shell.state.of_kind(Curve)
    assert not curve.mirrored
    assert curve.spline is not None
    assert Reflection(shell.state.symmetry).keeps(curve.spline)
    assert len(shell.shapes().curves) == 1
    there = curve.spline.value(curve.spline.foot_points(across(seed)))
    assert np.linalg.norm(there - across(seed), axis=1).max() < 2.5


@pytest.mark.parametrize("seed", SEEDS)
def test_it_closes_an_area_with_a_pair_of_curves(shell: Shell, seed: int) -> None:
    """The stroke and its image lay side by side, and left a sliver between them."""
    places = across(seed)
    begin, end = places[0], places[-1]
    side = np.linspace(begin, (begin[0] + 70.0, -30.0, 60.0), 30)
    draw_along(shell, Pen(), side)
    front = np.linspace(side[-1], (side[-1][0], 30.0, 60.0), 30)
    draw_along(shell, Pen(), front)
    draw_along(shell, Pen(), np.vstack((places[:-1], end)))
    curves = shell.state.of_kind(Curve)
    assert [curve.mirrored for curve in curves] == [True, False, False]
    (patch,) = shell.state.of_kind(Patch)
    (surface,) = shell.shapes().surfaces
    low, high = surface.mesh.bounds
    assert low[1] == pytest.approx(-high[1], abs=1e-9)
    assert patch.id


@pytest.mark.parametrize("seed", SEEDS)
def test_a_ring_about_the_plane_is_one_symmetric_curve_with_one_surface(
    shell: Shell, seed: int
) -> None:
    random = np.random.default_rng(seed)
    angles = np.linspace(0.0, 2.0 * np.pi, 80) + random.uniform(0.0, 6.0)
    size = 1.0 + 0.03 * np.sin(angles + random.uniform(0.0, 6.0))
    places = np.column_stack(
        (30.0 * size * np.cos(angles), 20.0 * size * np.sin(angles), np.full(80, 60.0))
    )
    draw_along(shell, Pen(), places)
    (curve,) = shell.state.of_kind(Curve)
    assert curve.spline is not None
    assert curve.spline.closed
    assert not curve.mirrored
    assert Reflection(shell.state.symmetry).keeps(curve.spline)
    assert len(shell.state.of_kind(Patch)) == 1
    there = curve.spline.value(curve.spline.foot_points(places))
    assert np.linalg.norm(there - places, axis=1).max() < 3.0
