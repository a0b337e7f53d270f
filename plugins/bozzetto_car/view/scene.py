"""The scene of a car: sketch, body, edges and nodes, marks, wheels, styling."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.geometry import Look
from bozzetto.plugin import remembered
from bozzetto.scene import Image, Layer, Lines, Scene, Shaded, in_look
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import is_shown
from bozzetto_car.parts.part_list import (
    DIVISIONS,
    added_lines,
    added_parts,
    seen_body,
    seen_parts,
    wheel_parts,
    whole_mesh,
)
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.styling.scene import chosen_styling, styling_items
from bozzetto_car.view.edge_items import (
    crease_labels,
    handle_layer,
    network_layer,
    network_lines,
    node_items,
    sources_of,
)
from bozzetto_car.view.joint_items import joint_layer
from bozzetto_car.view.mark_items import mark_layers
from bozzetto_car.view.mesh_items import mesh_layers
from bozzetto_car.view.stroke_items import stroke_layers
from bozzetto_car.view.surface_colors import certainty_colors, curvature_colors

DRAFT: Final = 0.3
"""Opacity of a body over its sketch."""

SHUT: Final = (74, 70, 66)
"""Colour of shut lines."""

SHUT_WIDTH: Final = 1.2
"""Width of shut lines, px."""

SKETCH_LAYERS: Final = ("sketch", "marks", "strokes")
"""Layers that make sense only in a view through a sketch's camera."""


REMEMBERED: Final = 16
"""Number of layers of surfaces that are remembered, so that a viewport can keep its copies."""


def scene_of(state: CarState, body: Body | None) -> Scene:
    """Return the scene of a solved car; only the sketch while its camera is not known."""
    if body is None:
        return Scene()
    layers = [Layer("sketch", tuple(_picture(state.sketch, body)), chosen=True)]
    if is_shown(state, body):
        layers += [*body_layers(state, body), joint_layer(state, body)]
    layers.append(Layer("styling", styling_items(state, body)))
    layers.append(Layer("chosen styling", chosen_styling(state, body), chosen=True))
    layers += stroke_layers(state, body)
    layers += mark_layers(state, body)
    layers += mesh_layers(state)
    return Scene(tuple(layer for layer in layers if layer.items))


def body_layers(state: CarState, body: Body, camera: Camera | None = None) -> list[Layer]:
    """Return the layers of surfaces, wheels, edges, nodes and handles; see `handle_layer`."""
    return [
        *look_layers(state, body),
        Layer("nodes", tuple(node_items(state, body))),
        handle_layer(state, body, camera),
    ]


def look_layers(state: CarState, body: Body) -> list[Layer]:
    """Return the layers of surfaces, wheels and edges, which look different over a drawing."""
    return [_body_layer(state, body), _wheel_layer(state, body), network_layer(state, body)]


def view_dependent_scene(state: CarState, body: Body, camera: Camera) -> Scene:
    """Return handles and angles of the visible side; without the sketch in other views."""
    layers = []
    if is_shown(state, body):
        layers.append(handle_layer(state, body, camera))
        if state.creases:
            layers.append(Layer("angles", tuple(crease_labels(body, camera))))
    sketch = state.sketch
    sketch_camera = None if sketch is None else body.sketch_cameras.get(sketch.id)
    if sketch_camera is not None and not sketch_camera.is_seen_through(camera):
        layers += [Layer(name) for name in SKETCH_LAYERS]
    return Scene(tuple(layers))


def _picture(sketch: Sketch | None, body: Body) -> Iterator[Image]:
    if sketch is None or sketch.picture is None or not sketch.visible or not sketch.opacity:
        return
    sketch_camera = body.sketch_cameras.get(sketch.id)
    if sketch_camera is not None:
        yield sketch_camera.image(sketch.picture, sketch.opacity)


@remembered(
    limit=REMEMBERED,
    key=lambda state, body: (
        (body, state.body, state.shading, state.complete, state.mirrors, state.network, state.tyre)
    ),
)
def _body_layer(state: CarState, body: Body) -> Layer:
    return Layer("body", tuple(_skin(state, body)))


def _skin(state: CarState, body: Body) -> Iterator[Shaded | Lines]:
    if not state.body:
        return
    if state.shading != "shaded":
        yield _whole_skin(state, body)
        return
    for mesh, look in seen_body(state, body):
        yield in_look(mesh, look)
    for mesh, look in seen_parts(added_parts(state, body)):
        yield in_look(mesh, _opaque(look))
    if state.complete and not state.network:
        lines = np.reshape([points for _, points in added_lines(state, body)], (-1, 4, 3))
        yield network_lines(lines, SHUT, SHUT_WIDTH, hidden="hide")


def _opaque(look: Look) -> Look:
    """Return a look that is not seen through: behind the panes of a complete car is a dark bed."""
    return look._replace(finish="gloss") if look.finish == "glass" else look


def _whole_skin(state: CarState, body: Body) -> Shaded:
    """Return the surfaces in a shading of their own, with nothing beside them."""
    mesh = whole_mesh(body)
    if state.shading == "curvature":
        mesh = replace(mesh, colors=curvature_colors(body.nets, DIVISIONS))
    elif state.shading == "certainty":
        mesh = replace(mesh, colors=certainty_colors(body.template, sources_of(body), DIVISIONS))
    return Shaded(
        mesh,
        opacity=DRAFT if state.shading == "draft" else 1.0,
        finish="zebra" if state.shading == "zebra" else "clay",
    )


@remembered(
    limit=REMEMBERED,
    key=lambda state, body: (
        (body, state.wheels, state.body, state.complete, state.shading, state.tyre)
    ),
)
def _wheel_layer(state: CarState, body: Body) -> Layer:
    """Return the layer of the wheels; empty over a drawing, which shows its own."""
    if state.shading == "draft":
        return Layer("wheels")
    seen = seen_parts(wheel_parts(state, body))
    return Layer("wheels", tuple(in_look(mesh, look) for mesh, look in seen))
