"""Marking a mesh with the pen: what is asked for, touches, drags and the eraser."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import NextStep
from bozzetto.view import Camera, triple
from bozzetto_car.marking.points_on_mesh import (
    nodes_to_mark,
    on_its_wheels,
    right_name,
    touched_place,
    with_point,
    without_points,
)
from bozzetto_car.solver.nodes_on_mesh import FEWEST
from bozzetto_car.solver.pipeline import solve_car, template_of
from bozzetto_car.state import CarMesh, CarState

ALL_MARKED: Final = (
    "All points are marked. Keep the car as a template in the panel Car, or drag a point to move "
    "it."
)


def mesh_in_work(state: CarState) -> CarMesh:
    """Return the mesh that is marked.

    Raises
    ------
    UserError
        If there is none, or it is hidden.
    """
    if state.mesh is None:
        raise UserError("There is no mesh to mark. Show it first.")
    return state.mesh


def asked_on_mesh(state: CarState) -> str | None:
    """Return the node to mark next; None where all are marked.

    It is the one that was chosen, or the next in the template's order.
    """
    car, template = mesh_in_work(state), template_of(state)
    if state.asked in template.node:
        return right_name(template, state.asked)
    rest = (node for node in nodes_to_mark(template) if car.point_of(node) is None)
    return next(rest, None)


def next_point(state: CarState) -> NextStep:
    """Return which point of the mesh to touch, in the template's words, and where it is expected.

    It is expected where the points before have brought the template.
    """
    car, template, node = mesh_in_work(state), template_of(state), asked_on_mesh(state)
    if node is None:
        return NextStep(ALL_MARKED)
    prompt = template.prompts.get(node, node)
    missing = FEWEST - len(car.points)
    more = f" The body is shown with {missing} more." if missing > 0 else ""
    place = None
    if missing <= 0:
        place = triple(solve_car(state).positions[template.node[node]])
    side = ", on either side" if node.endswith(".R") else ""
    if template.node[node] in template.wheels:
        side = ", seen from the side"
    return NextStep(f"Touch on the mesh: {prompt}{side}.{more}", place)


def marked_on_mesh(state: CarState, node: str | None, camera: Camera, at: Array) -> CarState:
    """Return the state with a node marked where the mesh is touched.

    Parameters
    ----------
    state : CarState
        The car.
    node : str or None
        None where none is left.
    camera : Camera
        The view.
    at : (2,) float
        Where it is touched, px of the view.

    Raises
    ------
    UserError
        If there is no surface there, or nothing to mark.
    """
    if node is None:
        raise UserError(ALL_MARKED)
    car, template = mesh_in_work(state), template_of(state)
    place = touched_place(car, template, node, camera, np.asarray(at, float))
    made = on_its_wheels(with_point(car, template, node, place), template)
    return replace(state.with_node(made), asked="")


def erased_on_mesh(state: CarState, strokes: Iterable[Stroke], reach: float) -> CarState:
    """Return the state without the points that an eraser ran over.

    Raises
    ------
    UserError
        If there is none under it.
    """
    car = mesh_in_work(state)
    own = [(p.node, place) for p in car.points for _, place in p.on_both_sides()]
    places = np.array([place for _, place in own]).reshape(-1, 3)
    met: set[str] = set()
    for stroke in strokes:
        seen = stroke.camera.project(places)[0]
        near = np.linalg.norm(seen[:, None] - stroke.points, axis=2).min(axis=1) <= reach
        met |= {own[number][0] for number in np.flatnonzero(near).tolist()}
    if not met:
        raise UserError("There is no point under the eraser. Rub over a point to take it away.")
    return state.with_node(without_points(car, met))
