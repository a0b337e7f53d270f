"""The solid: gates on outlines, laws, and the field behind it."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import Cancelled
from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights
from bozzetto_silhouette.inflation.live_preview import inflate
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid, solidify
from bozzetto_silhouette.inflation.thickness import Uniform
from bozzetto_silhouette.outline.outline import outline_from_rings, outline_from_strokes
from tests.plugins.silhouette import outlines as o
from tests.plugins.silhouette.fairness import front

NAMES = sorted(p.stem for p in o.COMMITTED.glob("*.svg"))


@pytest.fixture(scope="module")
def key() -> SilhouetteSolid:
    return solidify(o.outline("key"), resolution=64)


@pytest.mark.parametrize("name", NAMES)
def test_gates(name: str) -> None:
    solid = solidify(o.outline(name))
    found = measure(solid)
    assert found.topology_ok, found
    assert found.iou > 0.997
    assert found.hausdorff_share < 0.004
    assert 0.85 < found.thickness_ratio < 1.12
    assert found.asymmetry == 0.0
    assert np.isfinite(solid.vertices).all()
    assert np.linalg.norm(solid.normals, axis=1) == pytest.approx(np.ones(len(solid.normals)))


def test_gates_hold_for_the_preview_resolution() -> None:
    for name in ("spiral", "horse_skimage", "dice-five"):
        found = measure(solidify(o.outline(name), resolution=64))
        assert found.topology_ok
        assert found.iou > 0.994


@pytest.mark.parametrize(
    "rings",
    [
        [o.spiral(5, 2.0, 2.0)],
        [o.comb(12, 2.0, 2.0, 50.0)],
        [o.circle(0, 0, 50, 200), o.circle(0, 0, 48, 200)],
        [o.circle(0, 0, 50, 200), o.circle(31, 0, 18, 100)],
        [o.circle(0, 0, 50)] + [o.circle(x, y, 4, 40) for x in (-20, 0, 20) for y in (-20, 0, 20)],
        [o.circle(0, 0, 20), o.circle(60, 0, 20), o.circle(60, 0, 8)],
        [np.array([[0, 0], [100, 0], [100, 2], [0, 2.0]])],
        [np.array([[0, 0], [100, 0], [50, 10.0]])],
        [np.array([[0, 0], [100, 0], [100, 100], [0, 100.0]])],
    ],
    ids=["spiral", "comb", "annulus", "eccentric", "holes", "two bodies", "bar", "wedge", "square"],
)
def test_thin_walls_gaps_and_holes(rings) -> None:
    found = measure(solidify(outline_from_rings(rings)))
    assert found.topology_ok, found
    assert found.iou > 0.995
    assert 0.85 < found.thickness_ratio < 1.12


def test_near_touching_limbs_stay_apart() -> None:
    # Two fingers with a gap of 0.2 % of the size between them.
    fork = np.array(
        [
            [0, 0],
            [41.2, 0],
            [41.2, 100],
            [20.7, 100],
            [20.7, 20],
            [20.5, 20],
            [20.5, 100],
            [0, 100.0],
        ]
    )
    found = measure(solidify(outline_from_rings([fork])))
    assert found.topology_ok
    assert found.iou > 0.995


def test_a_disc_becomes_a_ball_and_a_bar_a_tube() -> None:
    ball = solidify(outline_from_rings([o.circle(0, 0, 50, 300)]))
    radius = np.sqrt((ball.vertices**2).sum(axis=1))
    assert radius == pytest.approx(np.full(len(radius), 50.0), rel=0.02)
    assert ball.soundness.volume == pytest.approx(4 / 3 * np.pi * 50**3, rel=0.03)
    bar = np.array([[-80, -10], [80, -10], [80, 10], [-80, 10.0]])
    tube = solidify(outline_from_rings([bar]))
    middle = tube.vertices[np.abs(tube.vertices[:, 0]) < 40]
    assert np.hypot(middle[:, 1], middle[:, 2]) == pytest.approx(
        np.full(len(middle), 10.0), rel=0.03
    )


def test_the_rim_is_round(key: SilhouetteSolid) -> None:
    rim = key.vertices[:, 2] == 0.0
    assert np.abs(key.normals[rim, 2]).max() < 1e-6
    # No edge of the mesh is sharp, apart from drawn corners.
    corner = key.vertices[key.faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    edges = np.sort(key.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort(edges.T)
    face = np.repeat(np.arange(len(key.faces)), 3)[order].reshape(-1, 2)
    assert (edges[order][::2] == edges[order][1::2]).all()
    cosine = (normal[face[:, 0]] * normal[face[:, 1]]).sum(axis=1)
    assert np.quantile(cosine, 0.01) > np.cos(np.deg2rad(35))


def test_symmetric_in_depth(key: SilhouetteSolid) -> None:
    front = key.vertices[key.vertices[:, 2] > 0]
    back = key.vertices[key.vertices[:, 2] < 0]
    assert np.array_equal(front * [1, 1, -1], back)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_volume_scales_with_the_cube(key: SilhouetteSolid, scale: float) -> None:
    rings = [r * scale for r in o.outline("key").rings]
    other = solidify(outline_from_rings(rings), resolution=64)
    assert other.soundness.ok
    assert other.soundness.volume == pytest.approx(key.soundness.volume * scale**3, rel=1e-2)


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r @ np.array([[0.8, -0.6], [0.6, 0.8]]),
        lambda r: r * [-1, 1],
        lambda r: r[::-1],
        lambda r: np.roll(r, 50, axis=0),
        lambda r: o.dense(r, 0.4),
        lambda r: r + 1e4,
    ],
    ids=["rotated", "mirrored", "reversed", "other start", "resampled", "far away"],
)
def test_the_solid_is_the_same_however_drawn(key: SilhouetteSolid, change) -> None:
    rings = [change(r) for r in o.svg_rings(o.COMMITTED / "key.svg")]
    other = solidify(outline_from_strokes(rings), resolution=64)
    assert other.soundness.ok
    assert other.soundness.volume == pytest.approx(key.soundness.volume, rel=1e-2)


def test_sparse_and_dense_sampling_agree() -> None:
    angle = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    blob = (40 + 12 * np.cos(3 * angle) + 5 * np.sin(5 * angle))[:, None] * np.column_stack(
        [np.cos(angle), np.sin(angle)]
    )
    few, many = (solidify(outline_from_strokes([blob[::k]]), resolution=64) for k in (20, 6))
    assert measure(few, many.outline).iou > 0.99
    assert few.soundness.volume == pytest.approx(many.soundness.volume, rel=0.02)


def test_parameters(key: SilhouetteSolid) -> None:
    flat = solidify(o.outline("key"), resolution=64, thickness=Uniform(0.4))
    assert flat.soundness.volume == pytest.approx(0.4 * key.soundness.volume, rel=1e-6)
    assert np.array_equal(flat.vertices[:, :2], key.vertices[:, :2])
    for softness in (1.25, 2.0):
        found = measure(
            solidify(o.outline("key"), resolution=64, height_model=ConvolutionHeights(softness))
        )
        assert found.topology_ok
        assert 0.8 < found.thickness_ratio < 1.15
    fine = solidify(o.outline("key"), resolution=96)
    assert len(fine.vertices) > 1.5 * len(key.vertices)


def test_cancelling() -> None:
    steps = []

    def stop(fraction: float, step: str) -> None:
        steps.append((fraction, step))
        if fraction > 0.3:
            raise Cancelled

    with pytest.raises(Cancelled):
        solidify(o.outline("heart"), resolution=48, checkpoint=stop)
    assert [s for _, s in steps] == ["skeleton", "plan", "surface"]


def test_preview_shows_something_early_and_never_raises() -> None:
    ring = o.svg_rings(o.COMMITTED / "hand-paper.svg")[0]
    for count in (30, 200, len(ring)):
        shown = inflate(ring[:count])
        assert shown is not None
        assert shown.vertices[:, 2].max() > 0
        assert shown.faces.max() < len(shown.vertices)
    random = np.random.default_rng(4)
    for _ in range(40):
        inflate(random.normal(size=(int(random.integers(0, 70)), 2)).cumsum(axis=0))
    for nothing in (
        [],
        [[0, 0]],
        [[1, 1]] * 5,
        [[0, 0], [1, 1], [2, 2]],
        [[np.nan, 0], [1, 2], [3, 1]],
    ):
        assert inflate(nothing) is None


@pytest.mark.slow
def test_gates_on_the_whole_set() -> None:
    if not o.SHARED.is_dir():
        pytest.skip("the large set of outlines is not here")
    found = [measure(solidify(outline_from_rings(o.svg_rings(p)))) for p in o.SHARED.glob("*.svg")]
    assert np.mean([f.topology_ok for f in found]) >= 0.95
    assert np.median([f.iou for f in found]) >= 0.998
    assert min(f.iou for f in found) >= 0.99
    assert np.median([f.hausdorff_share for f in found]) <= 0.002
    assert all(0.85 <= f.thickness_ratio <= 1.12 for f in found)


@pytest.mark.slow
def test_gates_on_all_ink() -> None:
    if not o.SHARED.is_dir():
        pytest.skip("the large set of outlines is not here")
    found = []
    for path in (o.SHARED / "ink").glob("*.json"):
        strokes, *_ = o.ink(path)
        drawn = o.in_outline_units(outline_from_strokes(strokes), path)
        exact = outline_from_rings(o.svg_rings(path.with_suffix(".svg")))
        found.append(measure(solidify(drawn), exact))
    assert np.mean([f.topology_ok for f in found]) >= 0.9
    assert np.median([f.iou for f in found]) >= 0.98
    assert min(f.iou for f in found) >= 0.96


@pytest.mark.parametrize("count", [9, 10, 11, 12, 13])
def test_a_blunt_corner_is_as_thick_as_a_rounded_one(count: int) -> None:
    """Into some corners the skeleton has a branch and into others none: no dent is seen there."""
    import shapely

    angle = 2.0 * np.pi * (np.arange(count) + 0.03 * count) / count
    outward = np.column_stack([np.cos(angle), np.sin(angle)])
    ring, hole = 60.0 * outward, o.circle(8.0, 0.0, 10.0, 40)
    rounded = shapely.Polygon(ring).buffer(-15.0).buffer(15.0, quad_segs=32)
    round_ring = np.asarray(rounded.exterior.coords)[:-1]
    drawn, calm = (
        solidify(outline_from_rings([one, hole]), resolution=64) for one in (ring, round_ring)
    )
    places = ring[:, None] - np.linspace(3.0, 15.0, 7)[:, None] * outward[:, None]
    ratio = front(drawn)(places)[..., 0] / front(calm)(places)[..., 0]
    assert ratio.min() > 0.93
    assert ratio.max() < 1.1
