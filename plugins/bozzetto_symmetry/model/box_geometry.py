"""The box and the centre plane as points and edges in space."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane

FLUSH: Final = 1e-9
"""Share of the box's diagonal within which a corner lies on the plane."""

SQUARE: Final = ((-1, -1), (1, -1), (1, 1), (-1, 1))
"""Signs of the corners of a square, in order around it."""


def box_corners(state: SymmetryState) -> Array:
    """Return the corners of the box in the model's frame, (8, 3) mm; the last axis runs first."""
    half = 0.5 * np.asarray(state.size)
    return np.asarray(state.centre + half * np.array(list(product((-1.0, 1.0), repeat=3))))


def box_edges(state: SymmetryState) -> Array:
    """Return the edges of the box, (12, 2, 3) mm: four along x, four along y, four along z."""
    corners = box_corners(state)
    pairs = [(k, k | bit) for bit in (4, 2, 1) for k in range(8) if not k & bit]
    return np.asarray(corners[pairs])


def plane_foot(state: SymmetryState, plane: CentrePlane | None = None) -> Array:
    """Return the place of the centre plane that is nearest to the middle of the box, (3,) mm.

    `plane` may be another one, in the frame of the model; so with the functions below.
    """
    plane = state.plane if plane is None else plane
    normal, centre = np.asarray(plane.normal), np.asarray(state.centre)
    return np.asarray(centre - normal * float((centre - plane.point) @ normal))


def plane_section(state: SymmetryState, plane: CentrePlane | None = None) -> Array:
    """Return the corners of the centre plane's section with the box, in order, (n, 3) mm.

    There are none where the plane passes the box by, or only touches it.
    """
    plane = state.plane if plane is None else plane
    corners, normal = box_corners(state), np.asarray(plane.normal)
    across, up = plane.placement.directions(AXES[[0, 2]])
    height = (corners - plane.point) @ normal
    slack = FLUSH * state.diagonal
    edges = box_edges(state)
    low, high = ((edges[:, end] - plane.point) @ normal for end in (0, 1))
    cut = (np.minimum(low, high) < -slack) & (np.maximum(low, high) > slack)
    share = low[cut] / (low[cut] - high[cut])
    met = edges[cut, 0] + share[:, None] * (edges[cut, 1] - edges[cut, 0])
    points = np.concatenate((corners[np.abs(height) <= slack], met))
    if len(points) < 3:
        return np.zeros((0, 3))
    offset = points - points.mean(axis=0)
    return np.asarray(points[np.argsort(np.arctan2(offset @ up, offset @ across))])


def plane_outline(state: SymmetryState, plane: CentrePlane | None = None) -> Array:
    """Return the corners of the shown part of the centre plane, in order, (n, 3) mm.

    Its section with the box; a square of the box's size where it passes the box by.
    """
    plane = state.plane if plane is None else plane
    section = plane_section(state, plane)
    if len(section):
        return section
    across, up = plane.placement.directions(AXES[[0, 2]])
    foot, half = plane_foot(state, plane), 0.5 * state.diagonal
    return np.array([foot + half * (i * across + j * up) for i, j in SQUARE])
