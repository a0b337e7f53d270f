"""How long oversketching, lifting and laying take, as processor time.

Run by ``python -m tests.benchmarks snake``.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bozzetto.geometry.curve_flattening import flattened
from bozzetto.ink.curves.nearest import nearest_curve
from bozzetto.ink.oversketch.lift import lift_curve
from bozzetto.ink.oversketch.snake import oversketch_curve
from bozzetto.ink.stroke import Stroke
from bozzetto.scene import project_stroke
from bozzetto.view.camera import Camera
from tests.benchmarks.bench_scene import scene_of, view_of
from tests.benchmarks.timing import Row, processor_ms

NODES = 200
SAMPLES = 500


def wave(count: int, height: float) -> np.ndarray:
    """A gentle S, 600 px wide."""
    t = np.linspace(0, 1, count)
    return np.column_stack((600 * t, 80 * np.sin(np.pi * t) + height * np.sin(2 * np.pi * t)))


def shaky(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Strokes of an unsteady hand, about 2 px off."""
    from scipy.ndimage import gaussian_filter1d

    random = np.random.default_rng(1)
    path = wave(SAMPLES, 40.0)
    tremor = gaussian_filter1d(random.normal(size=(count, SAMPLES, 2)), 15.0, axis=1)
    tremor *= 2.0 / tremor.std()
    return [(path + one, random.uniform(0.2, 0.9, SAMPLES)) for one in tremor]


def rows() -> Iterator[Row]:
    curve = wave(NODES, 0.0)
    for count, budget in ((1, "≤ 60 ms"), (3, "≤ 60 ms"), (8, "≤ 60 ms")):
        ink = shaky(count)
        took = processor_ms(lambda ink=ink: oversketch_curve(curve, ink))
        yield Row("snake", f"{NODES} nodes modified by {count} strokes", took, budget=budget)
    again = [(wave(SAMPLES, 0.0), np.full(SAMPLES, 0.5))]
    yield Row(
        "snake",
        "the same, a stroke drawn again",
        processor_ms(lambda: oversketch_curve(curve, again)),
    )
    many = [curve - (0, 3.0 * k) for k in range(100)]
    took = processor_ms(lambda: nearest_curve(many, wave(SAMPLES, 9.0)))
    yield Row("snake", f"nearest of 100 curves of {NODES} nodes", took)
    camera = Camera(eye=(300, -700, 260))
    space = np.random.default_rng(2).uniform(-90, 90, (NODES, 3))
    pixels = camera.project(space)[0] + 5.0
    took = processor_ms(lambda: lift_curve(space, camera, pixels))
    yield Row("snake", f"{NODES} nodes lifted", took)
    pieces = np.random.default_rng(3).uniform(-90, 90, (20, 4, 3))
    took = processor_ms(lambda: flattened(pieces, 0.25 / camera.pixels_per_mm))
    yield Row("snake", "20 Bezier pieces as a polyline, 0.25 px", took)
    scene = scene_of(100_000, lines=False)
    view = view_of(scene)
    width, height = view.viewport
    t = np.linspace(0, 1, SAMPLES)
    stroke = Stroke(width * (0.1 + 0.8 * t), height * (0.5 + 0.2 * np.sin(7 * t)), view)
    took = processor_ms(lambda: project_stroke(stroke, scene))
    yield Row("snake", f"{SAMPLES} samples laid on 100k triangles", took)


if __name__ == "__main__":
    for row in rows():
        print(f"{row.what:50} {row.measured:8.2f} ms   {row.budget}")
