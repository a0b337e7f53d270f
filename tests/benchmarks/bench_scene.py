"""How long pictures and picking take: ``python -m tests.benchmarks.bench_scene``.

Every function returns the median time of one call in seconds. The scene is a bumpy ball of
so many triangles with 500 polylines of 64 points around it.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from time import perf_counter

import numpy as np

from bozzetto.geometry.bvh import tree_of
from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import LIGHT, Layer, Lines, Picture, Scene, Shaded
from bozzetto.scene.picking import cast_rays
from bozzetto.scene.renderer import render
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import fit, turn
from bozzetto.view.standard_views import standard_view
from bozzetto_app.canvas.viewport.software import coarseness
from bozzetto_car.body.build import body_of
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.state import CarState
from bozzetto_car.view.scene import scene_of as car_scene
from tests.benchmarks.timing import Row, processor_ms

SIZE = (1000, 700)
REPEATS = 9


def bumpy_ball(triangles: int) -> Mesh:
    count = round(np.sqrt(triangles / 2))
    u, v = np.meshgrid(
        np.linspace(0, np.pi, count + 1), np.linspace(0, 2 * np.pi, count + 1), indexing="ij"
    )
    r = 100 * (1 + 0.15 * np.sin(5 * v) * np.sin(u) ** 3)
    x, y, z = r * np.sin(u) * np.cos(v), 0.6 * r * np.sin(u) * np.sin(v), 0.8 * r * np.cos(u)
    a = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    b, c, d = a + 1, a + count + 1, a + count + 2
    faces = np.concatenate((np.stack((a, c, b), 1), np.stack((b, c, d), 1)))
    return Mesh(np.stack((x.ravel(), y.ravel(), z.ravel()), 1).astype(np.float32), faces)


def arcs(count: int = 500, points: int = 64) -> Lines:
    random = np.random.default_rng(1)
    begin, axis = (random.normal(size=(count, 1, 3)) for _ in range(2))
    begin /= np.linalg.norm(begin, axis=2, keepdims=True)
    axis /= np.linalg.norm(axis, axis=2, keepdims=True)
    side = np.cross(axis, begin)
    up = np.cross(axis, side)
    t = np.linspace(0, 1.2, points)[:, None]
    arc = begin + side * np.sin(t) + up * (1 - np.cos(t))
    arc *= 120 / np.linalg.norm(arc, axis=2, keepdims=True)
    return Lines(arc.reshape(-1, 3).astype(np.float32), starts=np.arange(count) * points)


def scene_of(triangles: int, *, lines: bool = True) -> Scene:
    items = (Shaded(bumpy_ball(triangles)), *((arcs(),) if lines else ()))
    return Scene((Layer("bench", items),))


def view_of(scene: Scene, size: tuple[int, int] = SIZE) -> Camera:
    return fit(standard_view(Camera(viewport=size), "three-quarter"), scene.bounds())


def median_time(call: Callable[[int], object], repeats: int = REPEATS) -> float:
    call(0)
    times = []
    for k in range(repeats):
        begun = perf_counter()
        call(k)
        times.append(perf_counter() - begun)
    return statistics.median(times)


def frame(triangles: int, *, antialias: bool, size: tuple[int, int] = SIZE) -> float:
    scene = scene_of(triangles)
    camera = view_of(scene, size)

    def draw(k: int) -> object:
        return render(scene, turn(camera, 7.0 * k, 0), LIGHT, size=size, antialias=antialias)

    return median_time(draw)


def painted(triangles: int) -> float:
    """The usual way without a z-buffer: QPainter's polygons, the farthest first.

    Faces that look away are left out; lines are laid over everything, hidden or not.
    """
    from PySide6.QtCore import QPointF
    from PySide6.QtGui import QColor, QImage, QPainter, QPolygonF
    from PySide6.QtWidgets import QApplication

    application = QApplication.instance() or QApplication([])
    scene = scene_of(triangles)
    camera = view_of(scene)
    shaded, lines = scene.layers[0].items
    ends = np.append(lines.starts, len(lines.points))

    def polygon(points: np.ndarray) -> QPolygonF:
        return QPolygonF([QPointF(x, y) for x, y in points.tolist()])

    def draw(k: int) -> object:
        view = turn(camera, 7.0 * k, 0)
        pixels, depth = view.project(shaded.mesh.vertices)
        faces = shaded.mesh.faces
        a, b, c = shaded.mesh.vertices[faces].transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
        light = np.clip(normal @ (np.asarray(view.eye) / np.linalg.norm(view.eye)), 0, 1)
        p, q, r = pixels[faces].transpose(1, 0, 2)
        towards = (q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0] < 0
        order = np.argsort(-depth[faces].mean(axis=1))
        order = order[towards[order]]
        grey = (60 + 180 * light).astype(int)
        image = QImage(*SIZE, QImage.Format.Format_RGB32)
        image.fill(QColor(*LIGHT.paper))
        painter = QPainter(image)
        for corners, value in zip(pixels[faces[order]], grey[order].tolist(), strict=True):
            color = QColor(value, value, value)
            painter.setPen(color)
            painter.setBrush(color)
            painter.drawPolygon(polygon(corners))
        painter.setPen(QColor(*LIGHT.ink))
        places, _ = view.project(lines.points)
        for start, end in pairwise(ends.tolist()):
            painter.drawPolyline(polygon(places[start:end]))
        painter.end()
        return application, image

    return median_time(draw, repeats=3)


def frame_10k() -> float:
    return frame(10_000, antialias=False)


def frame_100k() -> float:
    return frame(100_000, antialias=False)


def still_100k() -> float:
    return frame(100_000, antialias=True)


def frame_100k_full_hd() -> float:
    return frame(100_000, antialias=False, size=(1920, 1080))


def index_100k() -> float:
    meshes = [bumpy_ball(100_000) for _ in range(REPEATS)]
    return median_time(lambda k: tree_of(meshes[k]))


def rays_100k(count: int) -> float:
    scene = scene_of(100_000, lines=False)
    camera = view_of(scene)
    stroke = np.column_stack((np.linspace(300, 700, count), np.linspace(300, 400, count)))
    rays = camera.rays(stroke)
    return median_time(lambda _: cast_rays(scene, rays))


def sketch_rows() -> Iterator[Row]:
    """A sketch behind a car seen through its camera, and from beside it while the view turns."""
    size = (1200, 900)
    state = CarState(shading="draft")
    body = body_of(state)
    car = car_scene(state, body)
    camera = view_of(car, size).with_viewport(1600, 1000)
    scan = np.random.default_rng(0).integers(0, 256, (1000, 1600, 4), np.uint8)
    scan[..., 3] = 255
    stand = SketchCamera.behind(camera, (0.0, 0.0), body.network.positions)
    sketch = Scene((Layer("sketch", (stand.image(Picture.of(scan, "sketch"), 0.8),)),))
    through = camera.with_viewport(*size)
    turns = iter(np.linspace(0.0, 40.0, 400))
    for what, scene, budget in (
        ("a car body alone", car, "≤ 100 ms"),
        ("a sketch of 1600×1000", sketch, ""),
        ("a sketch of 1600×1000 under a car body", sketch + car, "≤ 120 ms"),
    ):

        def turned(scale: float, *, antialias: bool, scene: Scene = scene) -> float:
            def draw() -> object:
                view = turn(through, next(turns), 0)
                return render(scene, view, LIGHT, size=size, scale=scale, antialias=antialias)

            return processor_ms(draw)

        still = processor_ms(lambda scene=scene: render(scene, through, LIGHT, size=size))
        yield Row("scene", f"frame with {what}, 1200×900, camera at rest", still)
        sharp = turned(1.0, antialias=True)
        yield Row("scene", f"frame with {what}, 1200×900, turning, sharp", sharp)
        # As the software view finds its resolution: by a sharp frame, then by one in motion.
        first = coarseness(1e-3 * sharp)
        share = coarseness(1e-3 * turned(first, antialias=False) / first**2)
        shown = turned(share, antialias=False)
        name = f"frame with {what}, 1200×900, as shown while the view turns"
        yield Row("scene", name, shown, budget=budget)


def rows() -> list[Row]:
    """The table's rows about the viewport."""
    timed = (
        ("frame, 10k triangles and 500 polylines, 1000×700, turning", frame_10k, ""),
        ("frame, 100k triangles and 500 polylines, 1000×700, turning", frame_100k, "≤ 150 ms"),
        ("the same, anti-aliased", still_100k, ""),
        ("frame, 100k triangles and 500 polylines, 1920×1080, turning", frame_100k_full_hd, ""),
        ("tree for rays, 100k triangles", index_100k, ""),
        ("1 ray, 100k triangles", lambda: rays_100k(1), ""),
        ("500 rays, 100k triangles", lambda: rays_100k(500), ""),
    )
    made = [Row("scene", what, 1e3 * call(), budget=budget) for what, call, budget in timed]
    named = "QPainter's polygons, sorted by depth"
    made[1] = replace(made[1], alternative=named, other=1e3 * painted(100_000))
    return [*made, *sketch_rows()]


if __name__ == "__main__":
    for row in rows():
        print(f"{row.what:60} {row.measured:8.1f} ms   {row.budget}")
