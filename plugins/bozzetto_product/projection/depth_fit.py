"""A curve in space that is seen as a curve on the sheet, at the depth of a surface.

Its image is held and its depth is fitted with the curve's own control points: where the ink is
on the surface by how squarely that is seen, beside the surface hardly at all, and with as
little bending as that allows. The depth of a round body falls steeply towards its silhouette, and
a curve that ran off it as steeply would bend back sharply; weights of cubed cosines avoid that.
Bending costs the more, the more of the ink is beside the surface: where all of it is on the
surface, the depth is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, cross_product
from bozzetto.geometry import Spline
from bozzetto.ink import spline_weights
from bozzetto.scene import Hits, Scene, cast_rays, depth_breaks, unbroken_runs
from bozzetto.view import Camera, Rays
from bozzetto_product.model.planes import Plane
from bozzetto_product.projection.planes import heights, in_plane, plane_of
from bozzetto_product.projection.spline_basis import free_controls, with_controls
from bozzetto_product.projection.views import seen_at

SAMPLES: Final = 241
"""Places along the curve at which the surface is asked for."""

BESIDE: Final = 1e-3
"""Weight of the last depth where the ink is beside the surface."""

STEEPNESS: Final = 3.0
"""Power of the cosine of incidence that is the weight of a depth on the surface."""

BENDING: Final = 1e-4
"""Weight of the squared second derivative of the depth by the parameter (0 … 1), of ink that is
wholly beside the surface; less by the share of the ink that is on it."""

LEAST_BENDING: Final = 1e-3
"""Share of `BENDING` that is left where all of the ink is on the surface: it holds control points
that the depth does not."""

IMAGE: Final = 1e4
"""Weight of a mm across the sight against a mm of depth: the image is held."""

HELD: Final = (1e6, 1e4, 1e2, 1.0)
"""Weights of a mm from a surface that is seen squarely, tried in this order where all of the ink
is on it: a curve that is drawn on a flat face lies in it, as far as its few control points then
show the ink. Ink that runs off has the last weight, for a round body falls away from it."""

ALLOWED: Final = 1.0
"""Distance of the image from the ink, px, at which no smaller weight is tried."""

ROUNDS: Final = 8
"""Rounds in which the places of the ink on the curve are sought anew. A view in perspective
moves them along the curve."""

STEP: Final = 0.02
"""Longest step of a place along the curve in one round, as a share of the range."""

ENDS: Final = 1e4
"""Weight of the depths of both ends, by the fourth power of the cosine of incidence: a curve that
is rounded over an edge of a surface begins and ends where others are met that end there."""

FLAT: Final = 1e-6
"""Distance of places from one plane, as share of their extent, at which a surface is flat there."""

FLAT_SINE: Final = 1e-5
"""Largest part of a normal across the first one there."""

NEAR_FLAT: Final = 1e-4
"""Distance of a curve from a flat surface, as share of its extent, that is not seen."""

STEEPEST: Final = 4.0
"""Change of depth per length across the sight from which two stretches are not one surface."""


@dataclass(frozen=True, eq=False)
class Sight:
    """Depths that are seen along a curve on the sheet.

    Attributes
    ----------
    rays : Rays
        Through places at equal steps of the parameter.
    hits : Hits
        What they meet.
    on : (n,) bool
        Rays whose hit counts: those on the surface that most of the ink is on.
    apart : bool
        Some of the ink is over another surface, far before or behind it.
    """

    rays: Rays
    hits: Hits
    on: Flags
    apart: bool


def look_along(spline: Spline, camera: Camera, scene: Scene) -> Sight:
    """Cast rays through a curve on the sheet, and choose the surface that it is drawn on.

    Parameters
    ----------
    spline : Spline
        On the sheet, px.
    camera : Camera
        Of the view.
    scene : Scene
        What is visible.

    Returns
    -------
    Sight
    """
    rays = camera.rays(spline.sampled(SAMPLES))
    hits = cast_rays(scene, rays)
    broken = depth_breaks(hits.points, hits.normals, rays.directions)
    runs = unbroken_runs(hits.hit, broken)
    on = np.zeros(SAMPLES, bool)
    if not runs:
        return Sight(rays, hits, on, False)
    first = max(range(len(runs)), key=lambda k: len(runs[k]))
    on[runs[first]] = True
    for order in (range(first + 1, len(runs)), range(first - 1, -1, -1)):
        edge = runs[first]
        for number in order:
            run = runs[number]
            here, there = (edge[-1], run[0]) if number > first else (edge[0], run[-1])
            if _leads_to(hits.points[there] - hits.points[here], rays.directions[here]):
                on[run] = True
                edge = run
    return Sight(rays, hits, on, bool((hits.hit & ~on).any()))


def _leads_to(way: Array, sight: Array) -> bool:
    """Whether a surface could lead over a gap."""
    depth = float(way @ sight)
    return abs(depth) <= STEEPEST * float(np.linalg.norm(way - depth * sight))


def at_depth(sheet: Spline, camera: Camera, sight: Sight) -> Spline:
    """Return the curve in space that is seen where the ink is, at the depth of the surface.

    Parameters
    ----------
    sheet : Spline
        On the sheet, px.
    camera : Camera
        Of the view.
    sight : Sight
        At least one of its hits counts.

    Returns
    -------
    Spline
        mm, over the knots of the curve on the sheet.
    """
    origins, directions = sight.rays
    at = np.linspace(*sheet.range, SAMPLES)
    goals, axes, weight = _depths(sight, sheet.closed)
    price = BENDING * max(float((~sight.on).mean()), LEAST_BENDING)
    across = _across(directions)
    drawn = sheet.value(at)
    for held in HELD if sight.on.all() else HELD[-1:]:
        say = np.where(sight.on, held, 1.0) * weight
        curve = with_controls(sheet, np.zeros((spline_weights(sheet, at[:1]).shape[1], 3)))
        places = at
        for step in range(ROUNDS):
            curve = _solved(curve, places, goals, directions, across, axes, say, price)
            if step + 1 < ROUNDS:
                places = _sought(curve, places, origins, across)
        seen = seen_at(camera, curve.value(places))
        if np.linalg.norm(seen - drawn, axis=1).max() <= ALLOWED:
            break
    face = _face_under(sight)
    if face is None:
        return curve
    points = free_controls(curve)
    seen_on = NEAR_FLAT * float(np.linalg.norm(np.ptp(points, axis=0)))
    if float(np.abs(heights(points, face)).max()) > seen_on:
        return curve
    return with_controls(curve, in_plane(points, face))


def _face_under(sight: Sight) -> Plane | None:
    """Return the plane of a surface on which all of the ink is; None where it is not flat there."""
    if not sight.on.all():
        return None
    points, normals = sight.hits.points, sight.hits.normals
    if float(np.linalg.norm(cross_product(normals, normals[0]), axis=1).max()) > FLAT_SINE:
        return None
    face = plane_of(points.mean(axis=0), normals[0])
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    return face if float(np.abs(heights(points, face)).max()) <= FLAT * extent else None


def _depths(sight: Sight, closed: bool) -> tuple[Array, Array, Array]:
    """Return a place on each ray, the axis along which a curve may not leave it, and its weight.

    On the surface the axis is its normal; beside it the sight, and the place has the last depth.
    """
    origins, directions = sight.rays
    known = np.flatnonzero(sight.on)
    number = np.arange(SAMPLES)
    apart = np.abs(number[:, None] - known)
    if closed:
        apart = np.minimum(apart, SAMPLES - 1 - apart)
    nearest = known[np.argmin(apart, axis=1)]
    hit = np.where(sight.on[:, None], sight.hits.points, 0.0)
    along = np.einsum("nk,nk->n", hit - origins, directions)
    normals = np.where(sight.on[:, None], sight.hits.normals, 0.0)
    cosine = np.einsum("nk,nk->n", normals, directions)
    goals = origins + along[nearest][:, None] * directions
    axes = np.where(sight.on[:, None], normals, directions)
    weight = np.where(sight.on, np.abs(cosine) ** (STEEPNESS - 2.0), BESIDE)
    if not closed:
        weight[[0, -1]] *= 1.0 + ENDS * cosine[[0, -1]] ** 4
    return goals, axes, weight


def _across(directions: Array) -> Array:
    """Return two unit vectors across each ray, (n, 2, 3)."""
    least = np.eye(3)[np.argmin(np.abs(directions), axis=1)]
    first = cross_product(directions, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack((first, cross_product(directions, first)), axis=1)


def _sought(curve: Spline, places: Array, origins: Array, across: Array) -> Array:
    """Return where the curve passes the rays, by one step of Newton's method each."""
    away = np.einsum("nak,nk->na", across, curve.value(places) - origins)
    slope = np.einsum("nak,nk->na", across, curve.derivative(places))
    speed = (slope**2).sum(axis=1)
    begin, end = curve.range
    reach = STEP * (end - begin)
    step = np.divide(-(away * slope).sum(axis=1), speed, out=np.zeros(len(places)), where=speed > 0)
    moved = places + np.clip(step, -reach, reach)
    if not curve.closed:
        moved = np.maximum.accumulate(np.clip(moved, begin, end))
        moved[[0, -1]] = begin, end
    return np.asarray(moved)


def _solved(
    curve: Spline,
    places: Array,
    goals: Array,
    directions: Array,
    across: Array,
    axes: Array,
    weight: Array,
    price: float,
) -> Spline:
    """Solve for the control points: image, distance from the surface, and bending of the depth."""
    rows, bending = spline_weights(curve, places), spline_weights(curve, places, 2)
    count = rows.shape[1]
    span = curve.range[1] - curve.range[0]
    held = np.full(len(rows), IMAGE)
    pieces = ((across[:, 0], held), (across[:, 1], held), (axes, weight))
    system = [
        np.sqrt(say)[:, None] * (rows[:, :, None] * axis[:, None]).reshape(len(rows), -1)
        for axis, say in pieces
    ]
    system.append(
        np.sqrt(price)
        * span**2
        * (bending[:, :, None] * directions[:, None]).reshape(len(rows), -1)
    )
    goal = [np.sqrt(say) * np.einsum("nk,nk->n", axis, goals) for axis, say in pieces]
    goal.append(np.zeros(len(rows)))
    found = np.linalg.lstsq(np.vstack(system), np.concatenate(goal), rcond=None)[0]
    return with_controls(curve, found.reshape(count, 3))
