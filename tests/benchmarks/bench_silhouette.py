"""From the last sample of a stroke to the solid, and the same by way of a dense lattice.

The dense alternatives get the skeleton, the weights and the field for nothing: only filling
the lattice and marching cubes are timed. Their lattice is the box around the solid, 128
cells along its longest side, not a full cube.
"""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bozzetto_silhouette
from bozzetto.document.model import Model
from bozzetto.exchange.import_file import read_drawing
from bozzetto.ink import Drawing, Stroke
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Ink
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.scene import LIGHT
from bozzetto.scene.display_list import Scene
from bozzetto.scene.renderer import render
from bozzetto.view.navigation import fit
from bozzetto.workbench.workbench import Workbench
from bozzetto_silhouette.implicit.convolution_field import ConvolutionField, convolution_field
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.normalized import frame_of
from tests.benchmarks.timing import Row, in_turn, median_ms, processor_ms

MODELER = "bozzetto.silhouette"
SAMPLES = Path(bozzetto_silhouette.__file__).parent / "samples"
OUTLINES = Path(__file__).parents[1] / "data" / "silhouettes"
DRAWINGS = (
    SAMPLES / "horse.json", SAMPLES / "fish.json", SAMPLES / "key.json",
    OUTLINES / "horse_skimage.svg", OUTLINES / "hand-paper.svg", OUTLINES / "spider.svg",
    OUTLINES / "snowflake.svg",
)  # fmt: skip
"""Recorded ink, and outlines from thick to spindly."""

CELLS = 128
"""Cells of the dense lattices along the longest side."""

SLAB = 8
"""Layers of the lattice filled at a time; all at once would not fit into memory."""

FRAME = (1280, 800)
"""Pixels of the one frame that shows the solid."""

Lattice = NDArray[np.float32]

_NUDGES = itertools.count(1)


@dataclass(frozen=True)
class Line:
    """Everything between the pen and the sheet, for one drawing."""

    bench: Workbench
    drawing: Drawing

    @classmethod
    def of(cls, path: Path) -> Line:
        """The line for a file of ink or an SVG."""
        return cls(Workbench(Registry()), read_drawing(path))

    def run(self, quality: Any) -> tuple[Model, Any, Scene]:
        """Apply the pen's tool, solve and make the picture's list, remembering nothing.

        Results are remembered by what was drawn; a hair to the side is another drawing.
        """
        hair = 1e-3 * next(_NUDGES)
        strokes = [_nudged(stroke, hair) for stroke in self.drawing.strokes]
        context = Context(camera=self.drawing.camera)
        model = self.bench.create(MODELER, context)
        tool = self.bench.tools(MODELER)[0]
        model = self.bench.apply(model, tool, Ink(tuple(strokes), committed=True), context)
        result = self.bench.solve(model, Job(quality=quality))
        return model, result, self.bench.model_scene(model, result)

    def longest(self) -> Stroke:
        """The stroke with most samples."""
        return max(self.drawing.strokes, key=len)


def _nudged(stroke: Stroke, hair: float) -> Stroke:
    return Stroke(
        stroke.x + hair, stroke.y, stroke.camera, pressure=stroke.pressure, t=stroke.t,
        tool=stroke.tool,
    )  # fmt: skip


def box_of(solid: SilhouetteSolid) -> tuple[NDArray[np.float64], ...]:
    """Coordinates of a lattice around a solid, two cells wider on every side."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    cell = float((high - low).max()) / CELLS
    return tuple(
        np.arange(a - 2 * cell, b + 3 * cell, cell) for a, b in zip(low, high, strict=True)
    )


def extracted(values: Lattice) -> tuple[NDArray[Any], NDArray[Any]]:
    """Vertices and faces of the zero surface."""
    from skimage.measure import marching_cubes

    vertices, faces, _, _ = marching_cubes(values, 0.0, gradient_direction="ascent")
    return vertices, faces


def dense_field(field: ConvolutionField, axes: tuple[NDArray[np.float64], ...]) -> object:
    """The modeler's own field at every node of the lattice, and its surface."""
    x, y, z = axes
    values = np.empty((len(x), len(y), len(z)), np.float32)
    for first in range(0, len(x), SLAB):
        part = slice(first, first + SLAB)
        nodes = np.stack(np.meshgrid(x[part], y, z, indexing="ij"), axis=-1)
        flat = nodes.reshape(-1, 3)
        level = field.raw_level(flat[:, :2], flat[:, 2] ** 2, np.ones(len(flat)))
        values[part] = level.reshape(nodes.shape[:3])
    return extracted(values)


def dense_capsules(skeleton: Skeleton, axes: tuple[NDArray[np.float64], ...]) -> object:
    """The union of the skeleton's capsules as a distance at every node, and its surface.

    As libraries of distance functions do it: every primitive is a function of points (n, 3),
    and a union is the least of their values.
    """
    x, y, z = (axis.astype(np.float32) for axis in axes)
    nodes = np.insert(skeleton.nodes.astype(np.float32), 2, 0.0, axis=1)
    values = np.empty((len(x), len(y), len(z)), np.float32)
    for first in range(0, len(x), SLAB):
        part = slice(first, first + SLAB)
        points = np.stack(np.meshgrid(x[part], y, z, indexing="ij"), axis=-1).reshape(-1, 3)
        inside = np.full(len(points), -np.inf, np.float32)
        for one, other in zip(*nodes[skeleton.edges.T], strict=True):
            np.maximum(inside, _in_capsule(points, one, other), out=inside)
        values[part] = inside.reshape(-1, len(y), len(z))
    return extracted(values)


def _in_capsule(points: Lattice, one: Lattice, other: Lattice) -> Lattice:
    """How deep points lie in a capsule from ball to ball, each (x, y, z, radius)."""
    span = other[:3] - one[:3]
    offset = points - one[:3]
    along = np.clip(offset @ span / max(float(span @ span), 1e-12), 0.0, 1.0)
    away = offset - along[:, None] * span
    depth: Lattice = one[3] + along * (other[3] - one[3]) - np.sqrt((away * away).sum(axis=1))
    return depth


def rows(drawings: tuple[Path, ...] = DRAWINGS) -> Iterator[Row]:
    """Preview and final solid of every drawing; then the alternatives; then showing it."""
    lines = {path.stem: Line.of(path) for path in drawings}
    previews, finals = [], []
    for name, line in lines.items():
        preview, final = in_turn(
            lambda line=line: line.run("preview"), lambda line=line: line.run("final")
        )
        previews.append(preview)
        finals.append(final)
        yield Row("silhouette", f"stroke to shown solid, 64 cells: {name}", preview)
        yield Row("silhouette", f"stroke to final solid, 128 cells: {name}", final)
    count = f"median of {len(lines)} drawings"
    for what, quality, times, budget in (
        ("stroke to shown solid, 64 cells", "preview", previews, "≤ 60 ms"),
        ("stroke to final solid, 128 cells", "final", finals, "≤ 200 ms"),
    ):
        yield Row("silhouette", f"{what}: {count}", statistics.median(times), budget=budget)
        processor = [
            processor_ms(lambda line=line, q=quality: line.run(q), repeats=5)
            for line in lines.values()
        ]
        yield Row(
            "silhouette", "the same, processor time", statistics.median(processor), budget=budget
        )
    first = next(iter(lines.values()))
    yield from _against_lattices(first, drawings[0].stem)
    yield from _live(list(lines.values()), count)
    yield _shown(first, drawings[0].stem)


def _against_lattices(line: Line, name: str) -> Iterator[Row]:
    _, result, _ = line.run("final")
    (solid,) = result.solids.values()
    frame = frame_of(solid.outline)
    field = convolution_field(frame)
    axes = box_of(solid)
    x, y, z = axes
    inner = (
        (x - frame.origin[0]) / frame.scale,
        (y - frame.origin[1]) / frame.scale,
        z / frame.scale,
    )
    ours, dense, capsules = in_turn(
        lambda: line.run("final"),
        lambda: dense_field(field, inner),
        lambda: dense_capsules(solid.skeleton, axes),
        repeats=3,
    )
    size = "×".join(str(len(axis)) for axis in axes)
    for what, other in (
        ("the field on a dense lattice", dense),
        ("its capsules in a dense distance field", capsules),
    ):
        yield Row(
            "silhouette", f"stroke to final solid, 128 cells: {name}", ours, "ms", "≥ 5×",
            f"{what}, {size}, marching cubes", other,
        )  # fmt: skip


def _live(lines: list[Line], count: str) -> Iterator[Row]:
    """A live preview when nearly all of a stroke is drawn."""
    moves, processor = [], []
    for line in lines:
        tool = line.bench.tools(MODELER)[0]
        context = Context(camera=line.drawing.camera)
        empty = line.bench.create(MODELER, context)
        gesture = Ink((line.longest(),))

        def move(
            line: Line = line, empty: Model = empty, tool: Any = tool,
            gesture: Ink = gesture, context: Context = context,
        ) -> Scene:  # fmt: skip
            return line.bench.preview(empty, tool, gesture, context)

        moves.append(median_ms(move, repeats=15))
        processor.append(processor_ms(move, repeats=15))
    what = f"live preview, one move of the pen at the end of the stroke: {count}"
    yield Row("silhouette", what, statistics.median(moves), budget="≤ 10 ms")
    yield Row(
        "silhouette", "the same, processor time", statistics.median(processor), budget="≤ 10 ms"
    )
    yield Row("silhouette", "the slowest of them, processor time", max(processor))


def _shown(line: Line, name: str) -> Row:
    """One frame of the solid."""
    _, _, scene = line.run("preview")
    camera = fit(line.drawing.camera.with_viewport(*FRAME), scene.bounds())
    return Row(
        "silhouette", f"one software frame of the shown solid, {FRAME[0]}×{FRAME[1]}: {name}",
        median_ms(lambda: render(scene, camera, LIGHT, size=FRAME, antialias=False)),
    )  # fmt: skip
