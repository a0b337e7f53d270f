"""A simulated hand that draws products: curves on a rough shape, in several strokes and views.

It draws through cameras, as a person does: what it knows of a curve in space is where it is seen.
Every stroke is beside the course that was meant, begins and ends too early or too late, and may be
drawn backwards.
"""

from __future__ import annotations

import json
import re
import zlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import map_coordinates

from bozzetto.view import Camera, fit_points
from bozzetto.view.standard_views import look_along
from bozzetto_product.model.rough_shapes import RoughShape
from bozzetto_product.rough_shapes.shapes import rough_mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bozzetto.arrays import Array
    from bozzetto.geometry import Mesh

SHEET = (1400, 900)
FOV = 24.0
"""Opening angle of the views, degrees: a long lens."""

RATE, SPEED = 120.0, 700.0
"""Samples a second, and px a second."""

DRIFT, TREMOR = 0.8, 0.25
"""How far the hand is beside its course, slowly and from sample to sample, px (deviation)."""

MISS = 3.0
"""How far a stroke begins or ends before or behind its end, px (deviation)."""

TREMBLES = 0
"""Number of the hand: others tremble in other ways; 0 drew the gallery."""

BOARD = 2.0
"""Thickness of a drawing board, mm."""

CURVE_MISS = 7.0
"""Length that strokes are drawn too long at most, px."""


@dataclass
class Body:
    """A rough shape whose surface is known by two numbers: ring, and share of a turn."""

    shape: RoughShape | None
    grid: Array = field(init=False)

    def __post_init__(self) -> None:
        vertices = self.mesh.vertices.astype(float)
        self.grid = vertices[1:-1].reshape(-1, 64, 3)

    @property
    def mesh(self) -> Mesh:
        """Its surface."""
        assert self.shape is not None
        return rough_mesh(self.shape)

    def at(self, ring: Array | float, turn: Array | float) -> Array:
        """Places on the surface (n, 3), mm; turn 0 is the front (+x), 0.25 the left side (+y)."""
        rows, columns = np.broadcast_arrays(np.asarray(ring, float), np.asarray(turn, float))
        rows = np.clip(rows, 0.0, len(self.grid) - 1.0)
        wrapped = np.concatenate((self.grid[:, -4:], self.grid, self.grid[:, :5]), axis=1)
        where = np.stack((rows.ravel(), np.mod(columns.ravel(), 1.0) * 64.0 + 4.0))
        return np.stack(
            [map_coordinates(wrapped[..., k], where, order=1, mode="nearest") for k in range(3)],
            axis=1,
        )

    def outward(self, ring: float, turn: float) -> Array:
        """The unit normal (3,)."""
        d = 0.02
        across = self.at(ring, turn + d)[0] - self.at(ring, turn - d)[0]
        up = self.at(ring + d, turn)[0] - self.at(ring - d, turn)[0]
        normal = np.cross(across, up)
        return normal / np.linalg.norm(normal)

    @property
    def corners(self) -> Array:
        """Places (n, 3) that a view of it shows, mm."""
        return self.grid.reshape(-1, 3)


@dataclass
class Board:
    """A thin box, or a wedge, with a face to draw what is planar on."""

    shape: RoughShape

    @property
    def corners(self) -> Array:
        """Places (n, 3) that a view of it shows, mm."""
        return rough_mesh(self.shape).vertices.astype(float)


def board(axis: str, at: float, reach: tuple[float, float, float], middle: Array) -> Board:
    """A board across an axis, its face where it is seen first from behind that axis, mm.

    Boards across x and y are seen from the front and from the right; those across z from above.
    """
    size = np.array(reach, float)
    number = "xyz".index(axis)
    size[number] = BOARD
    centre = np.array(middle, float)
    centre[number] = at + (0.5 * BOARD if axis == "y" else -0.5 * BOARD)
    length, width, height = map(float, size)
    x, y, z = map(float, centre)
    return Board(
        RoughShape(kind="box", length=length, width=width, height=height, centre=(x, y, z))
    )


def fact_of(shape: RoughShape) -> dict[str, object]:
    """What a file says of a rough shape."""
    return {
        "kind": shape.kind,
        "length": shape.length,
        "width": shape.width,
        "height": shape.height,
        "centre": list(shape.centre),
    }


class Hand:
    """Draws, and remembers each stroke and each step."""

    def __init__(
        self, name: str, bodies: Sequence[Body | Board], *, settings: dict[str, Any] | None = None
    ) -> None:
        self.name = name
        self.bodies = bodies
        self.rng = np.random.default_rng(zlib.crc32(f"{name}{TREMBLES or ''}".encode()))
        self.strokes: list[dict[str, Any]] = []
        self.steps: list[dict[str, Any]] = []
        self.meant: dict[str, Array] = {}
        self.facts: dict[str, Any] = {}
        self.beside: dict[str, dict[str, Any]] = {}
        self.hidden: set[int] = set()
        self.corners = np.concatenate([body.corners for body in bodies])
        self.camera = self.view(-60.0, 25.0)
        if settings:
            self.steps.append({"set": settings})

    # -- views --

    def view(self, azimuth: float, elevation: float, *, near: float = 1.0) -> Camera:
        """From so many degrees round (0 is from the front, +x; -90 from the right) and above."""
        a, e = np.radians((azimuth, elevation))
        way = -np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
        square = elevation in (90.0, -90.0, 0.0) and azimuth % 90.0 == 0.0
        kind = "orthographic" if square else "perspective"
        camera = look_along(Camera(kind=kind, fov_y=FOV, viewport=SHEET), way)
        return fit_points(camera, self.corners, 0.08 / near)

    def closer(self, camera: Camera, place: Array, times: float = 3.0) -> Camera:
        """The same view, so many times as large about a place."""
        shift = np.asarray(place, float) - camera.target
        shift -= camera.axes[2] * (shift @ camera.axes[2])
        eye, target = (np.asarray(point) + shift for point in (camera.eye, camera.target))
        half = np.tan(np.radians(0.5 * camera.fov_y)) / times
        fov = float(np.degrees(2.0 * np.arctan(half)))
        return replace(
            camera, eye=tuple(eye), target=tuple(target), height=camera.height / times, fov_y=fov
        )

    # -- gestures --

    def draw(
        self, name: str, course: Array, camera: Camera, *, strokes: int = 2, **facts: Any
    ) -> None:
        """Draw a curve in some strokes, and call it something."""
        self._gesture("draw", course, camera, strokes)
        self.meant[name] = course
        self.steps.append({"rename": name})
        if facts:
            self.steps.append({"set": facts})

    def modify(self, name: str, course: Array, camera: Camera, *, strokes: int = 1) -> None:
        """Draw over a curve where it is to run, perhaps from another side."""
        self.steps.append({"select": name})
        self._gesture("modify", course, camera, strokes)
        self.meant[name] = course

    def round(self, course: Array, camera: Camera, tool: str = "detail", **facts: Any) -> None:
        """Draw a closed round in one stroke, and say what becomes of the area."""
        self._gesture(tool, course, camera, 1)
        self.steps.append({"set": facts})

    def only(self, *bodies: Body | Board) -> None:
        """Show these rough shapes, and hide the others; the view shows what is there."""
        for number, body in enumerate(self.bodies, 1):
            shown = any(body is one for one in bodies)
            if shown is not (number not in self.hidden):
                self.steps.append({"show": shown, "part": f"Rough shape {number}"})
                self.hidden ^= {number}
        self.steps.append({"select": ""})
        if bodies:
            self.corners = np.concatenate([body.corners for body in bodies])

    def command(self, name: str) -> None:
        """Run a command."""
        self.steps.append({"command": name})

    def step(self, **facts: Any) -> None:
        """Set what counts from here on."""
        self.steps += [{"select": ""}, {"set": facts}]

    def touch(self, tool: str, place: Array, camera: Camera) -> None:
        """Touch where a place in space is seen."""
        x, y = camera.project(place[None])[0][0]
        step = {"tool": tool, "tap": [round(float(x), 1), round(float(y), 1)]}
        self.steps.append(step | {"camera": _camera(camera)})

    def paint(self, place: Array, camera: Camera, **facts: Any) -> None:
        """Choose the surface that is seen at a place, and say what it is like."""
        self.touch("move", place, self.closer(camera, place))
        self.steps.append({"set": facts})

    def _gesture(self, tool: str, course: Array, camera: Camera, strokes: int) -> None:
        pixels = camera.project(course)[0]
        first = len(self.strokes)
        self._stroke(pixels, camera)
        for number in range(1, strokes):
            low, high = (0.0, 0.62) if number % 2 else (0.36, 1.0)
            along = np.linspace(low, high, 60) * (len(pixels) - 1)
            part = np.stack(
                [np.interp(along, np.arange(len(pixels)), pixels[:, k]) for k in (0, 1)], 1
            )
            self._stroke(part[::-1] if self.rng.random() < 0.4 else part, camera)
        numbers = list(range(first, len(self.strokes)))
        self.steps.append({"tool": tool, "strokes": numbers})

    def _stroke(self, pixels: Array, camera: Camera) -> None:
        """Add a stroke about along places on the sheet."""
        pixels = _longer(pixels, *np.clip(self.rng.normal(0.0, MISS, 2), -CURVE_MISS, CURVE_MISS))
        run = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(pixels, axis=0).T))))
        count = max(int(run[-1] / SPEED * RATE), 12)
        at = run[-1] * np.linspace(0.0, 1.0, count)
        path = np.stack([np.interp(at, run, pixels[:, k]) for k in (0, 1)], axis=1)
        slow = self.rng.normal(size=(max(int(run[-1] / 110.0), 2) + 3, 2))
        knots = np.linspace(0.0, run[-1], len(slow))
        path += DRIFT * CubicSpline(knots, slow)(at) + TREMOR * self.rng.normal(size=path.shape)
        firm = (
            0.35
            + 0.3 * np.sin(np.pi * np.linspace(0.04, 0.96, count))
            + 0.03 * self.rng.normal(size=count)
        )
        self.strokes.append(
            {
                "x": np.round(path[:, 0], 1).tolist(),
                "y": np.round(path[:, 1], 1).tolist(),
                "pressure": np.round(np.clip(firm, 0.05, 1.0), 2).tolist(),
                "t": np.round(at / SPEED, 3).tolist(),
                "camera": _camera(camera),
            }
        )

    # -- the file --

    def record(self) -> dict[str, Any]:
        """The ink file."""
        shapes = [fact_of(body.shape) for body in self.bodies if body.shape is not None]
        return {
            "format": "bozzetto-ink/1",
            "modeler": "product",
            "canvas": {"width": SHEET[0], "height": SHEET[1]},
            "camera": _camera(self.camera),
            **self.facts,
            **({"template": shapes} if shapes else {}),
            "strokes": self.strokes,
            "steps": self.steps,
        }

    def write(self, path: Path) -> Path:
        """Write the ink file, and those beside it that it names."""
        for name, record in self.beside.items():
            place = path.parent / name
            place.parent.mkdir(exist_ok=True)
            _write(record, place)
        _write(self.record(), path)
        return path


def _write(record: dict[str, Any], path: Path) -> None:
    """Write an ink file, one stroke and one step a line."""
    text = json.dumps(record, allow_nan=False)
    text = re.sub(r'(\{"x": )', r"\n\1", text)
    head, mark, steps = text.partition('"steps": [')
    path.write_text(f"{head}{mark}\n{_rows(steps)}\n", "utf-8")


def _rows(steps: str) -> str:
    return re.sub(
        r"\}, \{(?=\"(?:tool|rename|set|select|command|show|group|delete)\")", "},\n{", steps
    )


def _camera(camera: Camera) -> dict[str, Any]:
    lens = (
        {"fov_y": round(camera.fov_y, 4)}
        if camera.kind == "perspective"
        else {"height": round(camera.height, 4)}
    )
    place = {
        name: [round(float(v), 4) for v in getattr(camera, name)]
        for name in ("eye", "target", "up")
    }
    return {"kind": camera.kind, **place, **lens}


def _longer(pixels: Array, before: float, behind: float) -> Array:
    """The same course, so much longer (or shorter) at its ends, px."""
    for more in (behind, before):
        pixels = pixels[::-1]
        way = pixels[0] - pixels[1]
        way = way / max(float(np.hypot(*way)), 1e-9)
        if more > 0.0:
            pixels = np.vstack((pixels[0] + more * way, pixels))
        else:
            run = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(pixels, axis=0).T))))
            at = np.linspace(min(-more, 0.2 * run[-1]), run[-1], len(pixels))
            pixels = np.stack([np.interp(at, run, pixels[:, k]) for k in (0, 1)], axis=1)
    return pixels
