"""What is shown of a car: the sketch, the body, its edges and nodes, marks, wheels, styling."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.crease import SMOOTH
from bozzetto.geometry.patch import bernstein
from bozzetto.geometry.tessellation import shaded
from bozzetto.scene import Image, Item, Label, Layer, Lines, Paint, Points, Scene, Shaded
from bozzetto.view import Camera
from bozzetto_car.body import Body
from bozzetto_car.certainty import Source, certainty
from bozzetto_car.edges import joints
from bozzetto_car.finishes import SOURCE_COLORS, certainty_colors, curvature_colors
from bozzetto_car.showing_marks import mark_layers
from bozzetto_car.showing_styling import styling_items
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.wheel_shape import wheel_meshes

__all__ = ["SKETCH_LAYERS", "hanging_on_view", "network_lines", "scene_of", "sources_of"]

Array = NDArray[np.float64]

DIVISIONS: Final = 12
"""Steps along each side of a patch that is shown."""

ALONG: Final = 24
"""Pieces of an edge that is shown."""

EDGE_WIDTH: Final = 1.4
"""Of the lines of a template, px."""

DRAFT: Final = 0.3
"""Opacity of a body that is laid over its sketch."""

SKETCH_LAYERS: Final = ("sketch", "marks")
"""Layers that mean something only where one looks through a sketch's camera."""


def scene_of(state: CarState, body: Body | None) -> Scene:
    """The car as it is solved; the sketch in work alone while its camera is not known."""
    if body is None:
        return Scene()
    sketch = state.sketch
    layers = [Layer("sketch", tuple(_picture(sketch, body)))]
    if sketch is None or body.solved.joint is not None:
        layers += [
            Layer("body", tuple(_surfaces(state, body))),
            Layer("wheels", _wheels(state, body)),
            Layer("network", tuple(_edges(state, body))),
            Layer("nodes", tuple(_nodes(state, body))),
        ]
    layers.append(Layer("styling", styling_items(state, body)))
    layers += mark_layers(state, body)
    return Scene(tuple(layer for layer in layers if layer.items))


def hanging_on_view(state: CarState, body: Body, camera: Camera) -> Scene:
    """What of the scene is not to be seen in a view: the sketch where one looks past it."""
    sketch = state.sketch
    if sketch is None or sketch.id not in body.stands:
        return Scene()
    if body.stands[sketch.id].is_seen_through(camera):
        return Scene()
    return Scene(tuple(Layer(name) for name in SKETCH_LAYERS))


def sources_of(body: Body) -> tuple[Source, ...]:
    """Whether each node is seen in a sketch, mirrored, or guessed."""
    solved = body.solved
    if solved.joint is None:
        nothing: Source = "guessed"
        return (nothing,) * len(body.template.names)
    return certainty(body.template, solved.cost, solved.joint).sources


def _picture(sketch: Sketch | None, body: Body) -> Iterator[Image]:
    if sketch is None or sketch.picture is None or not sketch.visible or not sketch.opacity:
        return
    stand = body.stands.get(sketch.id)
    if stand is not None:
        yield stand.image(sketch.picture, sketch.opacity)


def _surfaces(state: CarState, body: Body) -> Iterator[Shaded]:
    if not state.body:
        return
    mesh = shaded(body.patchwork, DIVISIONS)
    if state.shading == "curvature":
        mesh = replace(mesh, colors=curvature_colors(body.nets, DIVISIONS))
    elif state.shading == "certainty":
        mesh = replace(mesh, colors=certainty_colors(body.template, sources_of(body), DIVISIONS))
    yield Shaded(
        mesh,
        opacity=DRAFT if state.shading == "draft" else 1.0,
        finish="zebra" if state.shading == "zebra" else "clay",
    )


def _wheels(state: CarState, body: Body) -> tuple[Shaded, ...]:
    if not state.wheels or not state.body:
        return ()
    opacity = DRAFT if state.shading == "draft" else 1.0
    return tuple(Shaded(m, opacity=opacity, pickable=False) for m in wheel_meshes(body.network))


# -- edges and nodes -------------------------------------------------------------------------------


def network_lines(control_points: Array, color: Paint, width: float, opacity: float = 1.0) -> Lines:
    """Cubic Bézier curves (m, 4, 3) as one item."""
    points = bernstein(np.linspace(0.0, 1.0, ALONG + 1)) @ control_points
    starts = np.arange(0, points.shape[0] * points.shape[1], points.shape[1])
    return Lines(
        points.reshape(-1, 3).astype(np.float32), starts, color=color, width=width, opacity=opacity
    )


def _edges(state: CarState, body: Body) -> Iterator[Item]:
    if not state.network:
        return
    yield network_lines(body.network.control_points, "ink", EDGE_WIDTH, 0.75)
    if state.creases:
        yield from _creases(body)


def _creases(body: Body) -> Iterator[Item]:
    """Edges that smooth lines cross but surfaces do not; the angle of every crease."""
    angles = body.creases
    sharp = np.flatnonzero(np.nan_to_num(angles) > SMOOTH)
    crossed = _crossed_smoothly(body)
    for color, edges in (
        ("warning", [e for e in sharp if e in crossed]),
        ("second", [e for e in sharp if e not in crossed]),
    ):
        if edges:
            yield network_lines(body.network.control_points[edges], color, 2.4)
    middles = bernstein([0.5]) @ body.network.control_points
    for edge in sharp:
        x, y, z = middles[edge, 0].tolist()
        yield Label((x, y, z), f"{angles[edge]:.1f}°", size=11.0)


def _crossed_smoothly(body: Body) -> set[int]:
    """Edges that smooth lines cross at both ends: their patches should meet without a crease."""
    template = body.template
    crossings: dict[int, set[int]] = {}
    for joint in joints(template):
        taken = {joint.before[0], joint.after[0]}
        for edge, ends in enumerate(template.edges.tolist()):
            if joint.node in ends and edge not in taken:
                crossings.setdefault(edge, set()).add(joint.node)
    return {edge for edge, nodes in crossings.items() if len(nodes) == 2}


def _nodes(state: CarState, body: Body) -> Iterable[Points]:
    if not state.network:
        return
    sources = sources_of(body)
    for source, color in SOURCE_COLORS.items():
        chosen = [node for node, found in enumerate(sources) if found == source]
        if chosen:
            yield _dots(body.network.positions[chosen], color)


def _dots(points: Array, color: Paint) -> Points:
    return Points(points.astype(np.float32), color=color, size=6.0)
