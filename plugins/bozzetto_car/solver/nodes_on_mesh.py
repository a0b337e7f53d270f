"""Nodes of a template by the points that are marked on a mesh.

Nodes that are not marked go where the marked ones make them most probable: the conditional mean of
the cars of `prior`. From there they go on the surface, if that is near.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh, closest_on_mesh
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.state import CarMesh
from bozzetto_car.template.model import MIRROR, Template

FEWEST: Final = 6
"""Number of marked points from which the body is shown."""

SET: Final = 0.1
"""Standard deviation of a mark, mm: marks are met."""

ANYWHERE: Final = 300.0
"""Standard deviation of where a car lies along and above the ground, mm."""

NEAR: Final = 120.0
"""Farthest way of a node that is not marked to the surface, mm: what is farther was never there."""

ROUNDS: Final = 20
"""Most steps between the surface and the plane of symmetry."""

SETTLED: Final = 1e-3
"""Length of such a step that is no step any more, mm."""


def nodes_on_mesh(template: Template, car: CarMesh) -> Array:
    """Return the nodes of a template by the marked points of a mesh, (n, 3) mm.

    Parameters
    ----------
    template : Template
        The template. Marks of nodes that it has not do not count.
    car : CarMesh
        The mesh; without a mark, the template as it stands.
    """
    marked = {point.node: point.place for point in car.points if point.node in template.node}
    if not marked:
        return np.array(template.positions)
    numbers = [template.node[name] for name in marked]
    rows = template.basis.reshape(len(template.names), 3, -1)[numbers].reshape(3 * len(marked), -1)
    prior = Prior(template, Cost.balanced())
    covariance = np.linalg.inv(prior.form(prior.variables))
    for axis in (0, 2):
        moved = np.zeros_like(template.positions)
        moved[:, axis] = ANYWHERE
        way = template.reduced(moved)
        covariance += np.outer(way, way)
    wanted = np.concatenate(list(marked.values())) - rows @ template.variables
    pulled = rows @ covariance
    change = pulled.T @ np.linalg.solve(pulled @ rows.T + SET**2 * np.eye(len(rows)), wanted)
    places = template.whole(template.variables + change)
    for number in range(len(template.names)):
        name = template.names[number]
        if name.endswith(".L") or name in marked or number in template.wheels:
            continue
        own = places[number]
        on = (
            in_the_middle(car.mesh, own)
            if number in template.centre
            else closest_on_mesh(car.mesh, own[None]).points(car.mesh)[0]
        )
        if np.linalg.norm(on - own) <= NEAR:
            places[number] = on
    for name, place in marked.items():
        places[template.node[name]] = place
    right, left = template.pairs.T
    places[left] = places[right] * MIRROR
    return np.asarray(places)


def in_the_middle(mesh: Mesh, place: Array) -> Array:
    """Return the place near another one where a mesh meets the plane of symmetry, (3,) mm.

    Projections on surface and plane take turns, which leads to where both meet.
    """
    there = place * [1.0, 0.0, 1.0]
    for _ in range(ROUNDS):
        on = closest_on_mesh(mesh, there[None]).points(mesh)[0] * [1.0, 0.0, 1.0]
        step = float(np.linalg.norm(on - there))
        there = on
        if step < SETTLED:
            break
    return np.asarray(there)
