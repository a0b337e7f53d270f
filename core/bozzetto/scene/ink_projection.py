"""Ink on surfaces: every sample goes to the front-most place under it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink.checked_points import places_on_sheet
from bozzetto.ink.curves.resample import arc_length, distinct, points_along
from bozzetto.ink.stroke import Stroke
from bozzetto.scene.display_list import Scene, Shaded
from bozzetto.scene.picking import Hits, cast_rays
from bozzetto.view.camera import Camera

STEP: Final = 1.0
"""Longest way between two samples, px: what is narrower than a pixel is not seen either."""

MOST_SAMPLES: Final = 20_000
"""Most samples before subdivision; a longer stroke has them farther apart."""

FINEST: Final = 1.0 / 32.0
"""Way, px, down to which the rims of surfaces and their creases are located."""

BROKEN: Final = 5.0
"""Run in depth over the way across the line of sight, by which the step between neighbours
must differ from what the slopes of their two faces allow, for the surface to be broken
there. At `FINEST` that is a sixth of a pixel. (A bound on the slope alone would break every
round surface before its rim, where it is seen edge-on.)"""

EDGE_ON: Final = 1e-6
"""Least sine of the angle at which a face is taken to be seen."""

CREASE: Final = 0.9
"""Cosine of the angle between two normals below which there may be an edge between them."""


class Gap(NamedTuple):
    """A part of the stroke that is not on one surface.

    Attributes
    ----------
    begin, end : float
        Sample numbers of the stroke with shares, as in `Laid.at`. They are nearly equal
        where the ink steps from one surface down to another one behind it.
    pixels : float
        Length on the sheet, px.
    """

    begin: float
    end: float
    pixels: float


@dataclass(frozen=True, eq=False)
class Laid:
    """Ink on surfaces.

    Attributes
    ----------
    points : (n, 3) float
        mm.
    normals : (n, 3) float
        Unit face normals turned towards the eye.
    owners : tuple of str
        Id of the model that each point lies on.
    items : tuple of Shaded
        The surface that each point lies on.
    faces : (n,) int
        The face of its mesh.
    at : (n,) float
        Where on the stroke: sample number with share, increasing. With it pressure and time
        can be read off the stroke's columns.
    pieces : tuple of slice
        Runs of points on one unbroken surface; no other neighbours belong together.
    gaps : tuple of Gap
        What lies before, between and after the pieces; nothing is bridged.
    """

    points: Array
    normals: Array
    owners: tuple[str, ...]
    items: tuple[Shaded, ...]
    faces: Index
    at: Array
    pieces: tuple[slice, ...]
    gaps: tuple[Gap, ...]


def project_stroke(stroke: Stroke, scene: Scene) -> Laid:
    """Project a stroke on whatever surface is seen under it.

    All samples of the stroke are kept; others are put between them, at most `STEP` apart,
    and down to `FINEST` where the surface ends, breaks, bends sharply or gives way to
    another.

    Parameters
    ----------
    stroke : Stroke
        Drawn through its own camera.
    scene : Scene
        See `picking.cast_rays` for what counts as a surface.

    Returns
    -------
    Laid
        Without points, and with one gap, where the stroke meets nothing.

    Raises
    ------
    UserError
        If the stroke leaves the sheet beyond all bounds.
    """
    ink = places_on_sheet(stroke.points, "stroke")
    kept = distinct(ink)
    path, number = ink[kept], kept.astype(float)
    along = arc_length(path)
    way = _stations(along)
    path_at = _Path(path, number, along)
    hits = cast_rays(scene, stroke.camera.rays(path_at.places(way)))
    while len(between := _to_subdivide(way, hits, stroke.camera)):
        middle = 0.5 * (way[between] + way[between + 1])
        more = cast_rays(scene, stroke.camera.rays(path_at.places(middle)))
        order = np.argsort(np.concatenate((way, middle)), kind="stable")
        way, hits = np.concatenate((way, middle))[order], _merged(hits, more, order)
    return _in_pieces(way, hits, path_at, stroke.camera)


@dataclass(frozen=True, eq=False)
class _Path:
    """The stroke's way over the sheet, by arc length (px)."""

    points: Array
    number: Array
    along: Array

    def places(self, way: Array) -> Array:
        return points_along(self.points, self.along, way)

    def numbers(self, way: Array) -> Array:
        return np.interp(way, self.along, self.number)


def _stations(along: Array) -> Array:
    """Return arc lengths of the stroke's own samples and of those between them."""
    step = max(STEP, float(along[-1]) / MOST_SAMPLES)
    spans = np.diff(along)
    parts = np.maximum(np.ceil(spans / step), 1.0).astype(np.intp)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(len(first)) - first) / np.repeat(parts, parts)
    inner = np.repeat(along[:-1], parts) + share * np.repeat(spans, parts)
    return np.append(inner, along[-1])


def _to_subdivide(way: Array, hits: Hits, camera: Camera) -> Index:
    """Return the samples after which something happens that is not yet located."""
    hit = hits.hit
    rim = hit[1:] != hit[:-1]
    both = hit[1:] & hit[:-1]
    item = np.array([id(item) for item in hits.items])
    change = both & (item[1:] != item[:-1])
    turn = np.einsum("nk,nk->n", hits.normals[1:], hits.normals[:-1])
    crease = both & (turn < CREASE)
    events = rim | change | crease | _breaks(hits, camera)
    return np.flatnonzero(events & (np.diff(way) > FINEST))


def _breaks(hits: Hits, camera: Camera) -> Flags:
    """Whether one surface cannot reach from a sample to the next.

    Where two flat faces meet between the samples, the step in depth lies between those on
    the planes of the two.
    """
    step = np.diff(hits.points, axis=0)
    if camera.kind == "orthographic":
        sight = np.broadcast_to(camera.axes[2], step.shape)
    else:
        sight = 0.5 * (hits.points[1:] + hits.points[:-1]) - camera.eye
        sight = sight / np.linalg.norm(sight, axis=1, keepdims=True)
    depth = np.einsum("nk,nk->n", step, sight)
    across = step - depth[:, None] * sight
    slack = BROKEN * np.linalg.norm(across, axis=1)
    on_planes = []
    for normal in (hits.normals[:-1], hits.normals[1:]):
        facing = np.minimum(np.einsum("nk,nk->n", normal, sight), -EDGE_ON)
        on_planes.append(-np.einsum("nk,nk->n", normal, across) / facing)
    low, high = np.minimum(*on_planes), np.maximum(*on_planes)
    return np.asarray((depth < low - slack) | (depth > high + slack))  # False beside a miss


def _merged(one: Hits, other: Hits, order: Index) -> Hits:
    """Return the hits of both, put in order."""
    owners, items = one.owners + other.owners, one.items + other.items
    numbers = order.tolist()
    return Hits(
        np.concatenate((one.points, other.points))[order],
        np.concatenate((one.normals, other.normals))[order],
        np.concatenate((one.distance, other.distance))[order],
        tuple(owners[k] for k in numbers),
        tuple(items[k] for k in numbers),
        np.concatenate((one.faces, other.faces))[order],
    )


def _in_pieces(way: Array, hits: Hits, path: _Path, camera: Camera) -> Laid:
    """Cut what was hit into runs on one surface, and tell what lies between them."""
    hit = hits.hit
    kept = np.flatnonzero(hit)
    item = np.array([id(item) for item in hits.items])
    apart = (item[1:] != item[:-1]) | _breaks(hits, camera)
    new = np.flatnonzero(np.append(True, (np.diff(kept) > 1) | apart[kept[1:] - 1])[: len(kept)])
    ends = [*new.tolist()[1:], len(kept)]
    pieces = tuple(slice(begin, end) for begin, end in zip(new.tolist(), ends, strict=False))
    on = way[kept]
    borders = [0.0, *(float(w) for piece in pieces for w in (on[piece][0], on[piece][-1]))]
    borders.append(float(way[-1]))
    numbers = path.numbers(np.array(borders))
    gaps = tuple(
        Gap(float(numbers[k]), float(numbers[k + 1]), borders[k + 1] - borders[k])
        for k in range(0, len(borders), 2)
        if borders[k + 1] > borders[k] or not pieces
    )
    return Laid(
        hits.points[kept],
        hits.normals[kept],
        tuple(hits.owners[k] for k in kept.tolist()),
        tuple(found for found in hits.items if found is not None),
        hits.faces[kept],
        path.numbers(on),
        pieces,
        gaps,
    )
