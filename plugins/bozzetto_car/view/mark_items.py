"""Marks on the sketch as scene items: handles, residuals, and what is asked for next.

All items lie on the plane of the picture. While a mark is dragged, the camera changes with it, but
the view on the sheet does not; so the new car is shown where the picture would show it, which is
correct from any view through the picture.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import bernstein
from bozzetto.scene import Handle, Item, Label, Layer, Lines, Points, Scene
from bozzetto.view import triple
from bozzetto.view.calibration import direct_linear_transform
from bozzetto_car.body.body import Body
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.camera.visibility import facing
from bozzetto_car.marking.next_mark import Asked, asked_of, in_work, node_title
from bozzetto_car.solver.initial_cameras import Placed, counted_marks
from bozzetto_car.state import CarState, Mark
from bozzetto_car.view.edge_items import ON_PAPER

MARK_TOOL: Final = "mark"

MARK: Final = "mark "
"""Prefix of the ids of marks' handles; the name of the node follows."""

SHOWN_FROM: Final = 1.0
"""Distance of a mark from its node, px, from which a line between them is drawn."""

ROUND: Final = 48
"""Corners of an ellipse."""

LEAST_RING: Final = 6.0
"""Least half axis of the ring around an expected place, px: a smaller one hides in the dot."""

ALONG: Final = 16
"""Pieces of the polyline that shows an edge while a mark moves."""

CROSS: Final = 0.006
"""Half the width of a cross, in diagonals of the picture."""

HIDDEN_MEANWHILE: Final = ("body", "wheels", "nodes", "network", "handles", "angles", "styling",
                           "strokes")  # fmt: skip
"""Layers that show the car as it was before a mark moved."""


def mark_layers(state: CarState, body: Body) -> tuple[Layer, ...]:
    """Return the layer with the marks of the sketch in work and the place of the next one."""
    placed = in_work(state, body.solved)
    if placed is None:
        return ()
    sketch_camera = body.sketch_cameras[placed.sketch.id]
    items = [*_marks(placed, body, sketch_camera, sketch_camera)]
    if state.direct:
        items += [*_direct(placed, body, sketch_camera)]
    asked = asked_of(state, body.solved)
    if asked is not None:
        items += [*_expected(asked, placed, body, sketch_camera)]
    return (Layer("marks", tuple(items), tool=MARK_TOOL),)


def mark_preview(before: Body, after: Body, state: CarState, moved: Mark) -> Scene:
    """Return the car with a moved mark, shown on the picture as it is seen now.

    Parameters
    ----------
    before : Body
        The car that the view on the sheet belongs to.
    after : Body
        The car with the mark.
    state : CarState
        The state with the mark.
    moved : Mark
        The mark under the pen.
    """
    placed = in_work(state, after.solved)
    if placed is None:
        return Scene()
    on, now = before.sketch_cameras[placed.sketch.id], after.sketch_cameras[placed.sketch.id]
    items = [*_marks(placed, after, now, on, moved.node)]
    if not placed.is_known:
        return Scene((Layer("marks", tuple(items), tool=MARK_TOOL),))
    gone = tuple(Layer(name) for name in HIDDEN_MEANWHILE)
    shape = Layer("car", tuple(_network(after, now, on)))
    return Scene((*gone, shape, Layer("marks", tuple(items), tool=MARK_TOOL)))


def _network(body: Body, now: SketchCamera, on: SketchCamera) -> Iterator[Lines]:
    """Yield the edges where the picture would show them, faint on the side that is not seen."""
    curves = bernstein(np.linspace(0.0, 1.0, ALONG + 1)) @ body.network.control_points
    seen = now.pixels(curves.reshape(-1, 3)).reshape(*curves.shape[:2], 2)
    there = np.isfinite(seen).all(axis=(1, 2))
    near = facing(body.template, body.network.positions, now.camera)
    front = near[body.template.edges].all(axis=1)
    for side, opacity in ((front, 0.8), (~front, 0.25)):
        pixels = seen[there & side]
        if len(pixels):
            starts = np.arange(0, pixels.shape[0] * pixels.shape[1], pixels.shape[1])
            places = on.lifted(pixels.reshape(-1, 2)).astype(np.float32)
            yield Lines(places, starts, color=ON_PAPER, width=1.4, opacity=opacity, hidden="show")


def _marks(
    placed: Placed, body: Body, seen_from: SketchCamera, on: SketchCamera, moved: str = ""
) -> Iterator[Item]:
    """Yield the marks on one sketch camera, with the places of their nodes through another."""
    template, sketch = body.template, placed.sketch
    marks = sketch.marks
    if not marks:
        return
    places = on.lifted([(mark.u, mark.v) for mark in marks])
    off = _missed(placed, body, seen_from)
    others = placed.left_out or {}
    apart: list[tuple[Array, Array]] = []
    for mark, place in zip(marks, places, strict=True):
        at = triple(place)
        wrong = mark.node in placed.disagreeing
        unknown = mark.node not in template.node
        title = node_title(mark.node, sketch, template)
        node, missed = off.get(mark.node, (None, 0.0))
        tip = title if node is None else f"{title}: {missed:.1f} px off"
        color = "ghost" if unknown else "warning" if wrong else "accent"
        yield Handle(f"{MARK}{mark.node}", at, color=color, tip=tip)
        if wrong:
            expected = others.get(mark.node, missed)
            yield Label(at, f"{title}: this mark disagrees by {expected:.0f} px", color="warning")
        elif mark.node == moved:
            yield Label(at, tip)
        if node is not None and missed > SHOWN_FROM:
            apart.append((place, node))
    if apart:
        from_marks, nodes = (np.stack(column) for column in zip(*apart, strict=True))
        pairs = np.stack((from_marks, on.lifted(nodes)), axis=1)
        points = pairs.reshape(-1, 3).astype(np.float32)
        starts = np.arange(0, len(points), 2, dtype=np.int32)
        yield Lines(points, starts, color="second", width=1.2, hidden="show")


def _missed(
    placed: Placed, body: Body, sketch_camera: SketchCamera
) -> dict[str, tuple[Array, float]]:
    """Return, by marked node, where it is seen, and how far that is from its mark, px."""
    if not placed.is_known:
        return {}
    template = body.template
    marks = [mark for mark in placed.sketch.marks if mark.node in template.node]
    nodes = [template.node[mark.node] for mark in marks]
    seen = sketch_camera.pixels(body.network.positions[nodes])
    offsets = {}
    for mark, place in zip(marks, seen, strict=True):
        if np.isfinite(place).all():
            offsets[mark.node] = place, float(np.hypot(*(place - (mark.u, mark.v))))
    return offsets


def _expected(
    asked: Asked, placed: Placed, body: Body, sketch_camera: SketchCamera
) -> Iterator[Item]:
    """Yield a ring where the next mark is expected, and the region in which it lies."""
    if asked.place is None or asked.ellipse is None:
        return
    color = "ghost" if asked.hidden else "second"
    at = sketch_camera.lifted(asked.place[None])
    yield Points(at.astype(np.float32), color=color, size=7.0, hidden="show")
    title = node_title(asked.node, placed.sketch, body.template)
    text = f"{title}: not seen from here" if asked.hidden else title
    yield Label(triple(at), text, color=color)
    axes = asked.ellipse
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    if lengths.min() < LEAST_RING:
        along = axes[0] / lengths[0] if lengths[0] > 0.0 else np.array([1.0, 0.0])
        square = np.array([along, (-along[1], along[0])])
        axes = square * np.maximum(lengths, LEAST_RING)
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND + 1)
    ring = asked.place + np.stack((np.cos(turn), np.sin(turn)), axis=1) @ axes
    yield Lines(
        sketch_camera.lifted(ring).astype(np.float32),
        color=color,
        width=1.4,
        opacity=0.8,
        hidden="show",
    )


def _direct(placed: Placed, body: Body, sketch_camera: SketchCamera) -> Iterator[Lines]:
    """Yield crosses where the direct linear transform sees the marked nodes of the template."""
    nodes, marks = counted_marks(placed, body.template)
    points = body.template.positions[nodes]
    try:
        seen = direct_linear_transform(points, marks).project(points)
    except UserError:
        return  # too few marks, or in one plane: the report says so
    seen = seen[np.isfinite(seen).all(axis=1)]
    if len(seen):
        size = CROSS * float(np.hypot(*sketch_camera.camera.viewport))
        strokes = np.array([[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]])
        corners = (seen[:, None] + size * strokes).reshape(-1, 2)
        starts = np.arange(0, len(corners), 2, dtype=np.int32)
        yield Lines(
            sketch_camera.lifted(corners).astype(np.float32), starts, color="ghost", hidden="show"
        )
