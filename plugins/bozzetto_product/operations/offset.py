"""Curves beside a curve, along a surface."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Spline, closest_on_mesh
from bozzetto.ink import spline_weights
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import curve_of, spline_of
from bozzetto_product.projection.spline_basis import with_controls

LOOKS: Final = 129
"""Places that walk over the surface."""

STEPS: Final = 24
"""Steps in which they walk: each along the tangent plane, and then back to the surface."""


def offset_curve(
    state: ProductState, curve_id: str, distance: float, mesh: Mesh
) -> tuple[ProductState, str]:
    """Add a curve at a distance from another one, measured along a surface.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    curve_id : str
        Id of the curve.
    distance : float
        mm; to the left of the curve, seen from outside; negative to the right.
    mesh : Mesh
        The surface, in the frame of the model.

    Returns
    -------
    state : ProductState
        With the new curve, which is chosen.
    name : str
        Its id.

    Raises
    ------
    UserError
        If the distance is 0 or not finite, or the surface is empty.
    """
    curve, spline = curve_of(state, curve_id), spline_of(state, curve_id)
    if not np.isfinite(distance) or distance == 0.0 or not len(mesh.faces):
        raise UserError("An offset needs a surface, and a distance other than 0.")
    made = offset_spline(spline, distance, mesh)
    name = state.unused_id()
    fresh = replace(
        curve,
        id=name,
        name=state.unused_name("Curve"),
        spline=made,
        plane=None,
        laid=None,
        told=(),
    )
    return state.with_node(fresh), name


def offset_spline(spline: Spline, distance: float, mesh: Mesh) -> Spline:
    """Return the curve beside another one along a surface; see `offset_curve`."""
    at = np.linspace(*spline.range, LOOKS)
    start = spline.value(at)
    points = start + 0.0
    normals = _normals(mesh, points)
    tangents = _unit(spline.derivative(at))
    ways = _unit(cross_product(normals, tangents))
    for _ in range(STEPS):
        stepped = points + distance / STEPS * ways
        found = closest_on_mesh(mesh, stepped)
        points = found.points(mesh)
        new = _smooth_normals(mesh, found.faces, found.weights)
        # Straight ahead: the direction goes along with the tangent plane.
        ways = _unit(ways - np.einsum("nk,nk->n", ways, new)[:, None] * new)
    controls = np.asarray(np.linalg.lstsq(spline_weights(spline, at), points, rcond=1e-9)[0], float)
    return with_controls(spline, controls)


def _normals(mesh: Mesh, points: Array) -> Array:
    found = closest_on_mesh(mesh, points)
    return _smooth_normals(mesh, found.faces, found.weights)


def _smooth_normals(mesh: Mesh, faces: Index, weights: Array) -> Array:
    """Return normals that turn steadily from face to face, (n, 3)."""
    corners = mesh.vertex_normals()[mesh.faces[faces]].astype(float)
    return _unit(np.einsum("nc,nck->nk", weights, corners))


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))
