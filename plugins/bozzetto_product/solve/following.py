"""Curves that follow the surface of another model that they were drawn on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import DEGREE, Mesh, Spline, closest_on_mesh, mesh_points
from bozzetto_product.model.curves import Curve, LaidPlaces
from bozzetto_product.solve.canvas import Canvas

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
    faces = found.faces.astype(np.int32)
    return LaidPlaces(canvas.part.id, len(canvas.mesh.faces), faces, found.weights, there)


def followed_curves(curves: Sequence[Curve], canvases: Sequence[Canvas]) -> tuple[Curve, ...]:
    """Return curves where they are on the surfaces that they follow, as these are now.

    A curve is displaced by as much as the places on its surface. Where the surface has other
    triangles now, each place goes to the closest one. A curve of which the surface is gone stays.
    """
    meshes = {canvas.part.id: canvas.mesh for canvas in canvases if len(canvas.mesh.faces)}
    return tuple(_followed(curve, meshes) for curve in curves)


def _followed(curve: Curve, meshes: Mapping[str, Mesh]) -> Curve:
    laid, spline = curve.laid, curve.spline
    if laid is None or spline is None or laid.part not in meshes:
        return curve
    mesh = meshes[laid.part]
    if len(mesh.faces) == laid.count and int(laid.faces.max(initial=0)) < laid.count:
        now = mesh_points(mesh, laid.faces, laid.weights)
    else:
        now = closest_on_mesh(mesh, laid.points).points(mesh)
    moved = now - laid.points
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
