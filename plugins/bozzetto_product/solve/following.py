"""Curves that follow the surface of another model that they were drawn on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import DEGREE, Mesh, MeshPlaces, Spline, closest_on_mesh, mesh_points
from bozzetto.scene import follow, topology_of
from bozzetto_product.model.curves import Curve, LaidPlaces
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.canvas import Canvas, Sources, canvases_of

STILL: Final = 1e-6
"""Displacement below which a surface has not moved, as share of the distance of the places from
the origin: its mesh is of single precision."""

PLACES: Final = 60
"""Places along a curve that follow: eight for each span of a curve of ten control points."""


def laid_on(spline: Spline, canvas: Canvas) -> LaidPlaces:
    """Return the places of a surface that a curve follows from now on: the closest ones."""
    points = spline.sampled(PLACES)
    found = closest_on_mesh(canvas.mesh, points)
    there = mesh_points(canvas.mesh, found.faces, found.weights)
    return _laid(canvas.part.id, canvas.mesh, found, there)


def _laid(part: str, mesh: Mesh, found: MeshPlaces, points: Array) -> LaidPlaces:
    """Return places that were found on a surface, with what tells it from others."""
    faces = found.faces.astype(np.int32)
    return LaidPlaces(part, len(mesh.faces), faces, found.weights, points, topology_of(mesh))


def followed_curves(curves: Sequence[Curve], canvases: Sequence[Canvas]) -> tuple[Curve, ...]:
    """Return curves where they are on the surfaces that they follow, as these are now.

    A curve is displaced by as much as the places on its surface. Where the surface has other
    triangles now, each place goes to the closest one. A curve of which the surface is gone stays.
    """
    meshes = _meshes(canvases)
    return tuple(_followed(curve, meshes) for curve in curves)


def where_it_stands(state: ProductState, sources: Sources) -> ProductState:
    """Return a product with its curves where they are on what it follows, as that is now.

    So a person sees it, and so a gesture means it: what is drawn, touched or rubbed out lies over
    the curves as they stand, not over those of the time before the other model changed.

    Parameters
    ----------
    state : ProductState
        As the recipe has it.
    sources : Sources
        What it follows.
    """
    if not sources or not any(curve.laid is not None for curve in state.of_kind(Curve)):
        return state
    meshes = _meshes(canvases_of(state, sources))
    nodes = tuple(
        _laid_anew(node, meshes) if isinstance(node, Curve) else node for node in state.nodes
    )
    same = all(after is before for after, before in zip(nodes, state.nodes, strict=True))
    return state if same else replace(state, nodes=nodes)


def _laid_anew(curve: Curve, meshes: Mapping[str, Mesh]) -> Curve:
    """Return a curve where it is now, with the places there that it follows from now on."""
    moved, laid = _followed(curve, meshes), curve.laid
    if laid is None or (mesh := meshes.get(laid.part)) is None:
        return curve
    if moved is curve and (_is_same(laid, mesh) or not laid.topology):
        return curve
    return replace(moved, laid=_places_now(laid, mesh))


def _meshes(canvases: Sequence[Canvas]) -> dict[str, Mesh]:
    return {canvas.part.id: canvas.mesh for canvas in canvases if len(canvas.mesh.faces)}


def _places_now(laid: LaidPlaces, mesh: Mesh) -> LaidPlaces:
    """Return places on a surface as it is now: with other triangles the closest ones."""
    if not laid.topology and _is_same(laid, mesh):
        return replace(laid, points=mesh_points(mesh, laid.faces, laid.weights))
    if _is_same(laid, mesh):
        return replace(laid, points=follow(laid.on_surface(), mesh, mesh).points)
    found = closest_on_mesh(mesh, laid.points)
    return _laid(laid.part, mesh, found, found.points(mesh))


def _is_same(laid: LaidPlaces, mesh: Mesh) -> bool:
    """Whether a surface has the triangles on which places lie, though a mirror turned them over."""
    if laid.topology:
        return laid.on_surface().fit(mesh)
    return len(mesh.faces) == laid.count and int(laid.faces.max(initial=0)) < laid.count


def _followed(curve: Curve, meshes: Mapping[str, Mesh]) -> Curve:
    laid, spline = curve.laid, curve.spline
    if laid is None or spline is None or laid.part not in meshes:
        return curve
    moved = _places_now(laid, meshes[laid.part]).points - laid.points
    if np.abs(moved).max(initial=0.0) <= STILL * np.abs(laid.points).max(initial=1.0):
        return curve
    return replace(curve, spline=_displaced(spline, moved))


def _displaced(spline: Spline, moved: Array) -> Spline:
    """Return the spline with the displacement added that fits best; its ends move exactly."""
    from scipy.interpolate import BSpline

    count = len(spline.control_points)
    at = np.linspace(*spline.range, len(moved))
    basis = BSpline.design_matrix(at, spline.knots, DEGREE).toarray()
    if spline.closed:
        free = count - DEGREE
        basis[:, :DEGREE] += basis[:, free:]
        found, *_ = np.linalg.lstsq(basis[:, :free], moved, rcond=None)
        found = np.vstack((found, found[:DEGREE]))
    else:
        rest = moved - np.outer(basis[:, 0], moved[0]) - np.outer(basis[:, -1], moved[-1])
        inner, *_ = np.linalg.lstsq(basis[:, 1:-1], rest, rcond=None)
        found = np.vstack((moved[:1], inner, moved[-1:]))
    return Spline(spline.knots, spline.control_points + found, spline.closed)
