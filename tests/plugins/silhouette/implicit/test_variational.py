"""Variational surfaces: the function against SciPy's, its constraints, and the solids."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from skimage.measure import label

from bozzetto.errors import UserError
from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.implicit.interpolation_constraints import (
    MOST_OUTLINE_POINTS,
    OUTLINE_POINTS,
    fitted,
)
from bozzetto_silhouette.implicit.variational import (
    SPACING,
    VariationalSurface,
    apart,
    interpolated,
)
from bozzetto_silhouette.inflation.manifold_check import as_manifold
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid, solidify
from bozzetto_silhouette.inflation.variational_relief import VariationalHeights
from bozzetto_silhouette.outline.normalized import frame_of
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings
from bozzetto_silhouette.solids.polygonize import extract
from tests.plugins.silhouette import outlines as o
from tests.plugins.silhouette.fairness import unfairness

Points = NDArray[np.float64]

NAMES = sorted(p.stem for p in o.COMMITTED.glob("*.svg"))
QUICK = ("heart", "key")
UNIT_BOX = np.array([[-1.0] * 3, [1.0] * 3])


def random_constraints(count: int, seed: int = 0) -> tuple[Points, Points]:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (count, 3))
    return points, rng.normal(size=count)


def on_a_ball(count: int = 120, offset: float = 0.05) -> tuple[Points, Points]:
    """Evenly spread over the unit sphere, each with a normal constraint outside."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * k
    rho = np.sqrt(1.0 - z * z)
    points = np.column_stack([rho * np.cos(angle), rho * np.sin(angle), z])
    values = np.repeat([0.0, -offset], count)
    return np.concatenate([points, (1.0 + offset) * points]), values


def varied(name: str, resolution: int = 64) -> SilhouetteSolid:
    return solidify(o.outline(name), resolution=resolution, height_model=VariationalHeights())


# -- the function --


@pytest.mark.parametrize("count", [5, 40, 400])
def test_same_function_as_scipy(count: int) -> None:
    points, values = random_constraints(count)
    surface = interpolated(points, values, UNIT_BOX)
    oracle = RBFInterpolator(points, values, kernel="cubic", degree=1)
    asked = np.random.default_rng(1).uniform(-2, 2, (700, 3))
    wanted = oracle(asked)
    assert surface.level(asked) == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())


def test_gradient_is_that_of_the_level() -> None:
    surface = interpolated(*random_constraints(80), UNIT_BOX)
    asked = np.random.default_rng(1).uniform(-1, 1, (300, 3))
    _, gradient = surface.level_and_slope(asked)
    for axis, step in enumerate(1e-5 * np.eye(3)):
        slope = (surface.level(asked + step) - surface.level(asked - step)) / 2e-5
        assert gradient[:, axis] == pytest.approx(slope, abs=1e-6)


def test_constraints_on_a_plane_have_a_solution() -> None:
    points, values = random_constraints(60)
    points[:, 2] = 0.3
    surface = interpolated(points, values, UNIT_BOX)
    assert surface.level(points) == pytest.approx(values, abs=1e-7)
    up = np.array([[0.0, 0, 0.7]])
    assert surface.level(points + up) == pytest.approx(surface.level(points - up), abs=1e-7)


def test_half_the_system_gives_the_whole_function() -> None:
    points, values = random_constraints(60)
    points[:30, 2] = 0.0
    points[:, 2] = np.abs(points[:, 2])
    image = points[30:] * (1.0, 1.0, -1.0)
    whole = interpolated(np.concatenate([points, image]), np.append(values, values[30:]), UNIT_BOX)
    half = interpolated(points, values, UNIT_BOX, mirrored=True)
    asked = np.random.default_rng(1).uniform(-1, 1, (300, 3))
    assert half.level(asked) == pytest.approx(whole.level(asked), abs=1e-9)
    assert half.level(asked) == pytest.approx(half.level(asked * (1, 1, -1)), abs=1e-10)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_moves_and_scales_with_its_constraints(scale: float) -> None:
    points, values = random_constraints(60)
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    shift = np.array([1e3, -2e3, 5e2]) * scale

    def moved(p: Points) -> Points:
        return np.asarray(scale * p @ turn.T + shift)

    box = np.stack([moved(points).min(0), moved(points).max(0)])
    surface = interpolated(points, values, UNIT_BOX)
    other = interpolated(moved(points), scale * values, box)
    asked = np.random.default_rng(1).uniform(-1, 1, (300, 3))
    assert other.level(moved(asked)) / scale == pytest.approx(surface.level(asked), abs=1e-7)


def test_near_duplicates_are_never_silent_garbage() -> None:
    points, values = random_constraints(100)
    for gap in (0.0, 1e-12, 1e-8, 1e-5):
        twice = np.concatenate([points, points[:1] + gap])
        contradiction = np.append(values, values[0] + 1.0)
        try:
            surface = interpolated(twice, contradiction, UNIT_BOX)
        except UserError:
            pass
        else:
            assert surface.level(twice) == pytest.approx(contradiction, abs=1e-5)
        keep = apart(twice, SPACING)
        assert keep.tolist() == list(range(100))
        surface = interpolated(twice[keep], contradiction[keep], UNIT_BOX)
        assert surface.level(points) == pytest.approx(values, abs=1e-9)


def test_points_apart_are_apart_and_cover_the_rest() -> None:
    points = np.random.default_rng(0).uniform(0, 1, (2000, 2))
    keep = points[apart(points, 0.03)]
    gap = np.hypot(*(keep[:, None] - keep[None]).transpose(2, 0, 1)) + 9.0 * np.eye(len(keep))
    assert gap.min() > 0.03
    assert np.hypot(*(points[:, None] - keep[None]).transpose(2, 0, 1)).min(axis=1).max() <= 0.06


# -- as a solid in space --


def test_a_ball_from_its_constraints() -> None:
    points, values = on_a_ball()
    surface = interpolated(points, values, UNIT_BOX)
    mesh = extract(surface, UNIT_BOX, 0.05)
    assert np.linalg.norm(mesh.vertices, axis=1) == pytest.approx(
        np.ones(len(mesh.vertices)), abs=2e-3
    )
    assert (mesh.normals * mesh.vertices).sum(axis=1).min() > 0.9995
    assert as_manifold(mesh.vertices, mesh.faces).genus() == 0


def test_a_torus_from_its_constraints() -> None:
    u, v = np.meshgrid(np.arange(20) * np.pi / 10, np.arange(9) * 2 * np.pi / 9, indexing="ij")
    a, b = u.ravel(), v.ravel() + u.ravel()
    ray = np.column_stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)])
    ring = np.column_stack([np.cos(a), np.sin(a), 0.0 * a])
    points = np.concatenate([ring + 0.35 * ray, ring + 0.4 * ray])
    box = np.array([[-1.4, -1.4, -0.4], [1.4, 1.4, 0.4]])
    surface = interpolated(points, np.repeat([0.0, -0.05], len(a)), box)
    mesh = extract(surface, box, 0.04)
    whole = as_manifold(mesh.vertices, mesh.faces)
    assert whole.genus() == 1
    assert whole.volume() == pytest.approx(2 * np.pi**2 * 0.35**2, rel=0.01)


def test_the_value_is_about_the_distance() -> None:
    surface = interpolated(*on_a_ball(), UNIT_BOX)
    rays = np.random.default_rng(0).normal(size=(200, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    for radius in (0.9, 0.95, 1.05, 1.1):
        found = surface.sample(radius * rays)
        assert found.value == pytest.approx(np.full(200, 1.0 - radius), rel=0.08)
        assert (-found.gradient * rays).sum(axis=1) == pytest.approx(np.ones(200), abs=0.02)
    inside = surface.value(rays * np.linspace(0, 0.9, 200)[:, None])
    assert inside.min() > 0.0
    assert inside.max() < 1.6
    for ray in rays[:20]:
        far = surface.value(ray * np.geomspace(1.02, 1e6, 200)[:, None])
        assert (np.diff(far) < 0.0).all()
        assert (far < 0.5 * (1.0 - np.geomspace(1.02, 1e6, 200)) + 1e-3).all()


# -- outlines --


def zero_line(outline: Outline, most: int, cells: int = 300) -> tuple[float, bool]:
    """IoU of the raw function's inside in z = 0 with the drawing; whether topologies agree."""
    frame = frame_of(outline)
    surface = fitted(frame, most).surface
    low, high = frame.inner.bounds
    count = np.ceil((high - low) * cells).astype(int) + 20
    axes = [a + (np.arange(n) - 9.5) / cells for a, n in zip(low, count, strict=True)]
    x, y = np.meshgrid(*axes, indexing="ij")
    level = surface.level(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    found = level.reshape(x.shape) > 0.0
    polygon = frame.inner.polygon()
    shapely.prepare(polygon)
    drawn = shapely.contains_xy(polygon, x, y)
    same = pieces(found) == pieces(drawn) and pieces(~found) == pieces(~drawn)
    return float((found & drawn).sum() / (found | drawn).sum()), same


def pieces(inside: NDArray[np.bool_]) -> int:
    """Connected regions of a raster; what a few pixels have split off is the raster's doing."""
    return int((np.bincount(label(inside, connectivity=2).ravel())[1:] >= 5).sum())


@pytest.mark.slow
@pytest.mark.parametrize(("most", "fair"), [(MOST_OUTLINE_POINTS, 1.0), (OUTLINE_POINTS, 0.8)])
def test_the_raw_zero_line_is_the_outline(most: int, fair: float) -> None:
    found = [zero_line(o.outline(name), most) for name in NAMES]
    iou = np.array([share for share, _ in found])
    assert np.median(iou) > 0.995
    assert (iou > 0.98).mean() >= fair
    assert iou.min() > 0.965
    assert np.mean([same for _, same in found]) >= 0.9


def test_the_constraints_are_met() -> None:
    fit = fitted(frame_of(o.outline("key")))
    held = fit.constraints
    assert np.abs(fit.surface.level(held.points) - held.values).max() < 1e-9
    above = held.points[held.points[:, 2] > 0.0]
    below = held.points[held.points[:, 2] < 0.0] * (1.0, 1.0, -1.0)
    assert np.array_equal(above, below)
    assert len(apart(held.points, SPACING)) == len(held.points)


@pytest.mark.parametrize(
    "name",
    [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in NAMES],
)
def test_gates(name: str) -> None:
    solid = varied(name, 96)
    found = measure(solid)
    assert found.topology_ok, found
    assert found.iou > 0.997
    assert found.hausdorff_share < 0.004
    assert 0.85 < found.thickness_ratio < 1.12
    assert found.asymmetry == 0.0
    assert np.isfinite(solid.normals).all()
    assert unfairness(solid, 500) < 0.04


def test_a_disc_becomes_a_ball_and_a_bar_a_tube() -> None:
    height_model = VariationalHeights()
    disc = outline_from_rings([o.circle(0, 0, 50, 300)])
    ball = solidify(disc, resolution=64, height_model=height_model)
    radius = np.sqrt((ball.vertices**2).sum(axis=1))
    assert radius == pytest.approx(np.full(len(radius), 50.0), rel=0.03)
    bar = np.array([[-80, -10], [80, -10], [80, 10], [-80, 10.0]])
    tube = solidify(outline_from_rings([bar]), resolution=64, height_model=height_model)
    middle = tube.vertices[np.abs(tube.vertices[:, 0]) < 40]
    assert np.hypot(middle[:, 1], middle[:, 2]) == pytest.approx(
        np.full(len(middle), 10.0), rel=0.05
    )


def test_a_ring_becomes_a_torus() -> None:
    rings = [o.circle(0, 0, 50, 200), o.circle(0, 0, 30, 160)]
    solid = solidify(outline_from_rings(rings), resolution=64, height_model=VariationalHeights())
    assert solid.soundness.genus == 1
    assert solid.soundness.volume == pytest.approx(2 * np.pi**2 * 40 * 10**2, rel=0.06)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_size_and_place_do_not_matter(scale: float) -> None:
    plain = varied("key", 40)
    moved = solidify(
        o.outline("key").transformed(scale, np.array([1e4, -3e4]) * scale),
        resolution=40,
        height_model=VariationalHeights(),
    )
    assert moved.soundness.ok
    assert moved.soundness.volume / scale**3 == pytest.approx(plain.soundness.volume, rel=1e-4)


@pytest.mark.slow
def test_how_it_was_drawn_hardly_matters() -> None:
    ring = o.svg_rings(o.COMMITTED / "hand-paper.svg")[0]
    c, s = np.cos(0.65), np.sin(0.65)
    drawings = {
        "another start": np.roll(ring, 17, axis=0),
        "the other way": ring[::-1],
        "mirrored": ring * (-1.0, 1.0),
        "turned": ring @ np.array([[c, s], [-s, c]]),
        "resampled": o.dense(ring, 0.5),
    }
    plain = varied("hand-paper").soundness.volume
    for how, drawn in drawings.items():
        solid = solidify(
            outline_from_rings([drawn]), resolution=64, height_model=VariationalHeights()
        )
        assert solid.soundness.ok, how
        assert solid.soundness.volume == pytest.approx(plain, rel=0.015), how


HOSTILE = {
    "triangle": [np.array([[0, 0], [100, 0], [50, 70.0]])],
    "needle": [np.array([[0, 0], [100, 0], [100, 0.4], [0, 0.4]])],
    "wedge": [np.array([[0, 0], [100, 0], [50, 4.0]])],
    "thin ring": [o.circle(0, 0, 50, 200), o.circle(0, 0, 49, 200)],
    "touching nearly": [o.circle(0, 0, 20, 90), o.circle(40.02, 0, 20, 90)],
    "far holes": [o.circle(0, 0, 50)] + [o.circle(x, 0, 1.5, 30) for x in range(-44, 45, 4)],
    "comb": [o.comb(14, 1.0, 1.0, 50.0)],
    "star": [
        np.column_stack([np.cos(a), np.sin(a)]) * r
        for a, r in [(np.arange(60) * np.pi / 30, np.tile([[10.0], [50.0]], (30, 1)))]
    ],
    "many vertices": [o.circle(0, 0, 50, 20_000)],
}


LONG = ("thin ring", "touching nearly", "far holes", "comb", "star")


@pytest.mark.parametrize(
    "rings",
    [
        pytest.param(rings, id=name, marks=[pytest.mark.slow] * (name in LONG))
        for name, rings in HOSTILE.items()
    ],
)
def test_hostile_outlines(rings: list[Points]) -> None:
    try:
        solid = solidify(
            outline_from_rings(rings), resolution=48, height_model=VariationalHeights()
        )
    except UserError:
        return
    assert solid.soundness.ok, solid.soundness
    assert np.isfinite(solid.vertices).all()
    assert np.isfinite(solid.normals).all()
    assert (solid.front[len(solid.plan.after) :] > 0.0).all()


def test_random_blobs() -> None:
    rng = np.random.default_rng(7)
    angle = np.linspace(0, 2 * np.pi, 150, endpoint=False)
    for _ in range(3):
        wave = sum(
            rng.normal(scale=0.5 / k) * np.cos(k * angle + rng.uniform(0, 6)) for k in range(1, 9)
        )
        radius = 30.0 * np.exp(np.clip(wave, -1.8, 1.8))
        ring = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        solid = solidify(
            outline_from_rings([ring]), resolution=40, height_model=VariationalHeights()
        )
        found = measure(solid)
        assert found.topology_ok
        assert found.thickness_ratio < 1.2


def test_a_surface_that_cannot_be_is_refused() -> None:
    points = np.zeros((4, 3))
    with pytest.raises(UserError, match="too close"):
        interpolated(points, np.array([0.0, 1.0, 2.0, 3.0]), UNIT_BOX)


def test_the_surface_is_an_implicit_solid() -> None:
    surface: VariationalSurface = fitted(frame_of(o.outline("heart"))).surface
    mesh = extract(surface, surface.bounds, 0.02)
    whole = as_manifold(mesh.vertices, mesh.faces)
    assert whole.genus() == 0
    assert len(whole.decompose()) == 1
    assert whole.volume() > 0.0
