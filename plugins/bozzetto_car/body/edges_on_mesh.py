"""Edges between nodes on a mesh: bent until they lie on its surface.

Edges keep their ends, and places along them come as near to the surface as a cubic can; chains keep
one direction at each joint. They pass over openings, such as the windows and arches of a real car.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import Mesh, MeshPlaces, closest_on_mesh
from bozzetto.geometry.patches import bernstein
from bozzetto_car.body.chain_smoothing import smooth_chains
from bozzetto_car.body.fair_lines import fair_network, opened
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import HANDLE, Network, with_tangents

ALONG: Final = np.linspace(0.0, 1.0, 13)[1:-1]
"""Places along an edge that are brought to the surface."""

REACH: Final = 0.25
"""Farthest way of such a place to the surface, in chords of its edge."""

TO_BORDER: Final = 0.05
"""The same where the surface ends: windows and wheel arches are openings, and no edge goes along
their border because it is the nearest surface. That of the sill is nearer."""

STIFF: Final = 0.15
"""Weight of a change of a handle, relative to that of the places."""

WIDEST: Final = 174.0
"""Largest angle of two edges at a corner of a patch, degrees: hardly less than a template may have,
for whoever marks a mesh wants its lines."""

WELDED: Final = 0.1
"""Distance within which corners of a mesh are one, mm."""

ON_SIDE: Final = 1e-6
"""Weight of the corner opposite below which a place lies on a side of its face."""

ROUNDS: Final = 4
"""How often edges are bent and chains are smoothed."""


def network_on_mesh(template: Template, places: Array, mesh: Mesh) -> Network:
    """Return fair edges between nodes, bent until they lie on a mesh as far as cubics can.

    Parameters
    ----------
    template : Template
        The template.
    places : (n, 3) float
        Nodes, mm.
    mesh : Mesh
        The mesh.
    """
    network = fair_network(template, places)
    weights = bernstein(ALONG)
    inner = weights[:, 1:3]
    # Least squares of both handles, with a small price on what no place along the edge asks for.
    solver = np.linalg.solve(inner.T @ inner + STIFF * np.eye(2), inner.T)
    right = [edge for edge in range(len(template.edges)) if not _is_left(template, edge)]
    border = _border(mesh)
    for _ in range(ROUNDS):
        points = network.control_points[right]
        along = weights @ points
        found = closest_on_mesh(mesh, along.reshape(-1, 3))
        off = found.points(mesh).reshape(along.shape) - along
        chords = np.linalg.norm(points[:, 3] - points[:, 0], axis=1)
        ends_there = _on_border(border, found).reshape(along.shape[:2])
        reach = np.where(ends_there, TO_BORDER, REACH)
        near = np.linalg.norm(off, axis=2) <= reach * chords[:, None]
        handles = solver @ np.where(near[..., None], off, 0.0)
        changed = {}
        for edge, (first, second) in zip(right, handles, strict=True):
            tangents = network.tangents[edge]
            changed[edge, 0] = tangents[0] + first / HANDLE
            changed[edge, 1] = tangents[1] - second / HANDLE
        network = smooth_chains(with_tangents(network, changed))
    return opened(network, WIDEST, 360.0 - WIDEST)


def _border(mesh: Mesh) -> Flags:
    """Which sides of faces lead along a border of a mesh, (m, 3); each opposite a corner."""
    _, same = np.unique(np.round(mesh.vertices / WELDED), axis=0, return_inverse=True)
    corners = same.reshape(-1)[mesh.faces]
    sides = np.sort(np.stack((corners[:, [1, 2, 0]], corners[:, [2, 0, 1]]), axis=2), axis=2)
    _, kind, count = np.unique(
        sides.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True
    )
    return np.asarray(count[kind.reshape(-1)].reshape(-1, 3) == 1)


def _on_border(border: Flags, found: MeshPlaces) -> Flags:
    """Which places lie on a border, (n,): the surface ends there, and leads on under none."""
    return np.asarray((border[found.faces] & (found.weights < ON_SIDE)).any(axis=1))


def _is_left(template: Template, edge: int) -> bool:
    return any(template.names[node].endswith(".L") for node in template.edges[edge])
