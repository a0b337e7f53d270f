"""Cars with a marked sketch, as a person has them who begins to work on the body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.ink import Stroke
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.camera.visibility import facing
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.network import edge_called, junctions
from tests.plugins.car.sketched import FRONT_QUARTER, PICTURE, View, looking, styled
from tests.plugins.car.traced_car import drawn

Array = NDArray[np.float64]


def marked(seed: int = 0, name: str = "sedan", view: View = FRONT_QUARTER) -> CarState:
    """A car that is styled, and one sketch of it with all marks that it shows, 1 px unsteady."""
    template = bundled(name)
    car, rng = styled(template, seed), np.random.default_rng(seed)
    camera = looking(car, view, rng)
    seen = camera.project(car)[0] + rng.normal(0.0, 1.0, (len(car), 2))
    marks = tuple(
        Mark(template.names[node], *seen[node].tolist())
        for node in np.flatnonzero(facing(template, car, camera))
    )
    sketch = Sketch(id="1", name="Sketch", width=PICTURE[0], height=PICTURE[1], marks=marks)
    return CarState(nodes=(sketch,), selected="1", template=name)  # type: ignore[arg-type]


def with_mark_moved(state: CarState, node: str, by: tuple[float, float]) -> CarState:
    """One mark elsewhere."""
    sketch = state.sketches[0]
    marks = tuple(
        Mark(m.node, m.u + by[0], m.v + by[1]) if m.node == node else m for m in sketch.marks
    )
    return state.with_node(replace(sketch, marks=marks))


def another(body: Body, name: str, seed: int, share: float = 0.06) -> Array:
    """Bézier points (4, 3) of an edge with other tangents, by a share of its chord.

    They are such as a symmetric car can have.
    """
    edge = edge_called(body.template, name)
    own = body.network.control_points[edge].copy()
    chord = np.linalg.norm(own[3] - own[0])
    change = np.random.default_rng(seed).normal(0.0, share * chord, (2, 3))
    own[1:3] += np.where(body.network.free_axes[edge], change, 0.0)
    return own


def pen(camera: Camera, control_points: Array, **kind: str) -> Stroke:
    """A stroke along the picture of a cubic."""
    pixels = drawn(camera, control_points)
    return Stroke(pixels[:, 0], pixels[:, 1], camera, **kind)  # type: ignore[arg-type]


def apart(camera: Camera, one: Array, other: Array) -> float:
    """Largest distance of the pictures of two cubics, either way, px."""
    a, b = drawn(camera, one, 300), drawn(camera, other, 300)
    return float(max(distances_to_polyline(a, b).max(), distances_to_polyline(b, a).max()))


def locked_creases(body: Body) -> Array:
    """Degrees along the edges that smooth lines cross at both ends."""
    template = body.template
    crossed: dict[int, set[int]] = {}
    for joint in junctions(template):
        for edge in np.flatnonzero((template.edges == joint.node).any(axis=1)).tolist():
            if edge not in (joint.before[0], joint.after[0]):
                crossed.setdefault(edge, set()).add(joint.node)
    edges = [edge for edge, nodes in crossed.items() if len(nodes) == 2]
    angles = body.creases[edges]
    return np.asarray(angles[np.isfinite(angles)])
