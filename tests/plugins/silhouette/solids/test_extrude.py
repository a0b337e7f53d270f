"""Straight through: volumes in closed form, exact distances, the outline as it was seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.inflation.manifold_check import as_manifold
from bozzetto_silhouette.model.sketch_plane import sheet_under
from bozzetto_silhouette.model.state import Cut, Part
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.extrude import straight_body

BOX = np.array([[-50.0, -60.0, -40.0], [50.0, 60.0, 40.0]])
VIEWS = ["front", "right", "top", "three-quarter"]
KINDS = ["orthographic", "perspective"]


def through(*strokes: Stroke, kind: type[Part] = Part, **options: object) -> Part:
    sheet = sheet_under(strokes[0], Context(camera=strokes[0].camera))
    plain = kind(id="n1", strokes=Strokes(strokes), sheet=sheet, surface="straight")
    return replace(plain, **options)


def solid(part: Part, around: np.ndarray | None = BOX, resolution: int = 48):
    body = straight_body(part, around, resolution)
    made = as_manifold(body.vertices, body.faces)
    assert made.status().name == "NoError"
    assert made.volume() > 0.0
    return made


def block():
    from manifold3d import Manifold

    return Manifold.cube((BOX[1] - BOX[0]).tolist(), True)


@pytest.mark.parametrize("view", VIEWS)
def test_a_parallel_view_takes_area_times_thickness(view: str) -> None:
    camera = standard_view(Camera("orthographic", height=200.0), view)
    part = through(Pen(camera).polygon((570, 420), (640, 430), (630, 470), (580, 480)))
    slab = solid(part, np.array([[-90.0] * 3, [90.0] * 3]))
    right, up, forward = camera.axes
    frame = np.column_stack([right, up, -forward, np.zeros(3)]).tolist()
    from manifold3d import Manifold

    plate = Manifold.cube([150.0, 150.0, 12.5], True).transform(np.array(frame).reshape(3, 4))
    taken = plate.volume() - (plate - slab).volume()
    assert taken == pytest.approx(outline_of(part).area * 12.5, rel=1e-9)


@pytest.mark.parametrize("view", VIEWS)
def test_a_perspective_view_takes_a_cone_from_the_eye(view: str) -> None:
    camera = standard_view(Camera("perspective"), view)
    part = through(Pen(camera).polygon((560, 420), (650, 430), (630, 480)))
    body = straight_body(part, BOX, 48)
    # Every point of the walls is seen on the drawn line, near and far.
    seen, depth = camera.project(body.vertices)
    drawn, _ = camera.project(part.sheet.to_world(np.concatenate(outline_of(part).rings)))
    from shapely import LinearRing, Polygon, distance, points

    rim = LinearRing(drawn)
    off = distance(points(seen), rim)
    far = np.isin(depth.round(6), [depth.min().round(6), depth.max().round(6)])
    assert off[~far].max() < 1e-6
    assert np.ptp(depth) > 80.0
    # A frustum's volume, from its two end faces.
    ends = [
        Polygon(drawn).area * (z / camera_focal(camera)) ** 2 for z in (depth.min(), depth.max())
    ]
    height = float(np.ptp(depth))
    expected = height * (ends[0] + ends[1] + np.sqrt(ends[0] * ends[1])) / 3.0
    assert solid(part).volume() == pytest.approx(expected, rel=1e-6)


def camera_focal(camera: Camera) -> float:
    return camera.viewport[1] / 2.0 / float(np.tan(np.radians(camera.fov_y) / 2.0))


@pytest.mark.parametrize("kind", KINDS)
def test_holes_stay(kind) -> None:
    camera = standard_view(Camera(kind), "right")
    pen = Pen(camera)
    part = through(pen.circle(600, 450, 200), pen.circle(540, 450, 40), pen.circle(660, 450, 40))
    assert solid(part).genus() == 2
    assert (block() ^ solid(part)).genus() == 2
    assert (block() - solid(pen_hole(pen))).genus() == 1


def pen_hole(pen: Pen) -> Part:
    return through(pen.circle(600, 450, 60))


def test_a_slab_of_its_own_is_as_thick_as_wide() -> None:
    part = through(Pen(Camera("orthographic", height=180.0)).circle(600, 450, 100), inflation=0.7)
    low, high = straight_body(part, None, 64).bounds
    assert (high - low) == pytest.approx([40.0, 0.7 * 40.0, 40.0], rel=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_distances_are_those_from_the_mesh(kind) -> None:
    camera = standard_view(Camera(kind), "three-quarter")
    part = through(Pen(camera).polygon((500, 350), (700, 380), (680, 560), (560, 540)))
    body = straight_body(part, BOX, 16)
    random = np.random.default_rng(5)
    low, high = body.bounds
    points = random.uniform(low - 20.0, high + 20.0, (150, 3))
    value, gradient, _ = body.implicit.sample(points)
    exact = _distances(points, body.vertices, body.faces)
    inside = value > 0
    assert np.abs(value[inside]) == pytest.approx(exact[inside], rel=2e-3, abs=1e-6)
    assert (np.abs(value[~inside]) <= exact[~inside] * 1.01 + 1e-9).all()
    assert (np.abs(value[~inside]) >= exact[~inside] * 0.5).all()
    step = 1e-5
    slopes = np.stack([
        (body.implicit.value(points + step * axis) - body.implicit.value(points - step * axis))
        / (2 * step)
        for axis in np.eye(3)
    ], axis=1)  # fmt: skip
    near = inside & (np.abs(slopes - gradient).max(axis=1) < 0.5)  # not where two walls are equal
    assert near.sum() > 0.98 * inside.sum()
    assert slopes[near] == pytest.approx(gradient[near], abs=1e-5)
    assert np.linalg.norm(gradient[inside], axis=1) == pytest.approx(1.0)


def _distances(points, vertices, faces):
    """Unsigned distances by brute force (Ericson, Real-Time Collision Detection, 5.1.5)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    best = np.full(len(points), np.inf)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for i, p in enumerate(points):
        height = ((p - a) * normal).sum(axis=1)
        foot = p - height[:, None] * normal
        inside = np.ones(len(a), bool)
        edge_gap = np.full(len(a), np.inf)
        for u, v in ((a, b), (b, c), (c, a)):
            inside &= (np.cross(v - u, foot - u) * normal).sum(axis=1) >= 0
            t = np.clip(((p - u) * (v - u)).sum(axis=1) / ((v - u) ** 2).sum(axis=1), 0, 1)
            edge_gap = np.minimum(edge_gap, np.linalg.norm(p - u - t[:, None] * (v - u), axis=1))
        best[i] = np.where(inside, np.abs(height), edge_gap).min()
    return best


def test_it_moves_as_its_part_moves() -> None:
    part = through(Pen(Camera()).circle(600, 450, 100))
    turn = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0), 1.3, (5.0, -7.0, 11.0))
    moved = straight_body(replace(part, pose=turn), None, 48)
    still = straight_body(part, None, 48)
    assert moved.vertices == pytest.approx(turn.points(still.vertices), abs=1e-9)
    assert moved.radius == pytest.approx(1.3 * still.radius)
    assert as_manifold(moved.vertices, moved.faces).volume() > 0.0


LINES = {
    "straight": [(100, 430), (1100, 470)],
    "wavy": np.column_stack([x := np.linspace(150, 1050, 80), 450 + 60 * np.sin(x / 40.0)]),
    "short": [(560, 440), (620, 470)],
    "notch": [(520, 100), (520, 470), (680, 470), (680, 100)],
    "closing notch": [(380, 250), (560, 520), (640, 520), (820, 250)],
    "steep": [(600, 800), (610, 100)],
    "hooked": [(100, 450), (1000, 450), (1020, 455), (1010, 470), (1000, 466)],
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", LINES)
def test_both_sides_of_a_cut_add_up(name: str, kind) -> None:
    camera = standard_view(Camera(kind), "three-quarter")
    stroke = Pen(camera, tremor=0.5 if name == "wavy" else 0.0).along(LINES[name])
    cut = through(stroke, kind=Cut, side="left")
    whole = block()
    left, right = (whole ^ solid(replace(cut, side=side)) for side in ("left", "right"))
    assert left.volume() + right.volume() == pytest.approx(whole.volume(), rel=1e-9)
    assert min(left.volume(), right.volume()) > 1e-3 * whole.volume()
    assert (left ^ right).volume() == pytest.approx(0.0, abs=1e-6 * whole.volume())


def test_left_is_left_of_the_line() -> None:
    camera = Camera("orthographic", height=180.0)
    upwards = through(Pen(camera).along([(600, 800), (600, 100)]), kind=Cut, side="left")
    box = (block() ^ solid(upwards)).bounding_box()
    assert box[0] == pytest.approx(-50.0)
    assert box[3] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(
    "line",
    [[(600, 450)], [(600, 450)] * 5, [(500, 400), (700, 500), (600, 600), (590, 300)]],
    ids=["dot", "dots", "crosses itself"],
)
def test_a_line_that_cuts_nothing_is_refused(line) -> None:
    stroke = Stroke(*np.array(line, float).T, Camera())
    with pytest.raises(UserError, match=r"Draw .*\."):
        straight_body(through(stroke, kind=Cut), BOX, 48)


def test_the_eye_inside_what_is_cut() -> None:
    camera = Camera("perspective", (0.0, -30.0, 0.0), (0.0, 0.0, 0.0))
    body = straight_body(through(Pen(camera).circle(600, 450, 200)), BOX, 48)
    assert as_manifold(body.vertices, body.faces).volume() > 0.0
    assert body.bounds[0, 1] > -30.0
    value, gradient, _ = body.implicit.sample(
        np.random.default_rng(1).uniform(-500, 500, (1000, 3))
    )
    assert np.isfinite(value).all()
    assert np.isfinite(gradient).all()
