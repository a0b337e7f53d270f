"""Crossings of rings with themselves and each other; those of an unsteady hand are mended."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.ink import self_crossings, signed_area

SMALL_LOOP = 6e-3
"""A loop whose area is below this share of the whole, and that is short, is cut off."""
SHORT_LOOP = 0.06
"""Longest loop that is cut off, as a share of the ring's length."""

THIN_OVERLAP = 0.012
"""Walls that overlap by less than this (share of the size) are pushed apart: the hand
trembled in a thin place."""


FLAT = 1e-5
"""A ring thinner than this (standard deviation, share of the size) is a straight line."""

MOST_CROSSINGS = 100
"""A ring that crosses itself more often is a scribble and is not mended: a trembling hand
comes to a few dozen crossings, and mending takes a look at every loop in turn."""

SHOWN = 8
"""Most crossings that are pointed out."""


def _crossings(ring: Array) -> tuple[Index, Index, Array]:
    """Find pairs of edges of a closed ring that cross, first < second, and the places (k, 2).

    Edge i runs from vertex i to the next.
    """
    found = self_crossings(ring, closed=True)
    last = len(ring) - 1
    first, second = (np.minimum(np.floor(at), last) for at in (found.first, found.second))
    return first.astype(np.intp), second.astype(np.intp), found.places


def rings_that_cross(rings: list[Array]) -> Array:
    """Return the places where different rings cross, (k, 2)."""
    import shapely

    lines = [shapely.LinearRing(r) for r in rings]
    found = [np.zeros((0, 2))]
    for i, one in enumerate(lines):
        for other in lines[i + 1 :]:
            if one.intersects(other):
                found.append(shapely.get_coordinates(one.intersection(other)))
    return np.concatenate(found)


def _length(line: Array) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def _area(ring: Array) -> float:
    return abs(signed_area(ring))


def untangled(ring: Array) -> tuple[Array | None, Array]:
    """Cut off small loops and push apart walls that only touch; report real crossings.

    Parameters
    ----------
    ring : (n, 2) float array
        Longest side of the drawing about 1.

    Returns
    -------
    ring : (m, 2) float array or None
        Simple, or None when it encloses nothing.
    places : (k, 2) float array
        Crossings that cannot be mended; empty when the ring is simple.
    """
    if np.linalg.svd(ring - ring.mean(axis=0), compute_uv=False)[1] < FLAT * np.sqrt(len(ring)):
        return None, np.zeros((0, 2))
    for _ in range(40):
        first, second, places = _crossings(ring)
        if not len(first):
            break
        if len(first) > MOST_CROSSINGS:
            return ring, _some(places)
        loops = [
            np.vstack([p, ring[i + 1 : j + 1]])
            for i, j, p in zip(first, second, places, strict=True)
        ]
        whole, total = _area(ring), _length(ring)
        best, best_area = -1, np.inf
        cut_inner = True
        for k, loop in enumerate(loops):
            for inner in (True, False):
                part = (
                    loop
                    if inner
                    else np.vstack([places[k], ring[second[k] + 1 :], ring[: first[k] + 1]])
                )
                area, length = _area(part), _length(np.vstack([part, part[:1]]))
                small = area < SMALL_LOOP * max(whole, 1e-12) and length < SHORT_LOOP * total
                if small and area < best_area:
                    best, best_area, cut_inner = k, area, inner
        if best >= 0:
            i, j, p = first[best], second[best], places[best]
            if cut_inner:
                ring = np.vstack([ring[: i + 1], p, ring[j + 1 :]])
            else:
                ring = loops[best]
            continue
        apart = _pushed_apart(ring, first, second)
        if apart is None:
            return ring, _some(places)
        ring = apart
    else:
        return ring, _some(_crossings(ring)[2])
    # A line drawn to and fro encloses nothing worth the name.
    if len(ring) < 3 or _area(ring) < 1e-5:
        return None, np.zeros((0, 2))
    return _repaired(ring)


def _some(places: Array) -> Array:
    return places[:: -(-len(places) // SHOWN) or 1]


def _repaired(ring: Array) -> tuple[Array | None, Array]:
    """Catch what is left: edges that fold back on their neighbours, or touch."""
    import shapely

    if shapely.LinearRing(ring).is_simple:
        return ring, np.zeros((0, 2))
    polygon = shapely.Polygon(ring)
    pieces = shapely.get_parts(shapely.make_valid(polygon))
    pieces = [p for p in pieces if p.geom_type == "Polygon"]
    pieces.sort(key=lambda p: -float(p.area))
    if not pieces or sum(p.area for p in pieces[1:]) > SMALL_LOOP * pieces[0].area:
        where = shapely.get_coordinates(shapely.node(shapely.LinearRing(ring)).boundary)
        return ring, _some(where) if len(where) else ring[:1]
    # A hair inward and out again separates what only touches.
    hair = 1e-4
    body = max(shapely.get_parts(pieces[0].buffer(-hair).buffer(hair)), key=lambda p: p.area)
    coordinates = shapely.get_coordinates(shapely.Polygon(body.exterior).exterior)[:-1]
    return coordinates, np.zeros((0, 2))


def _pushed_apart(ring: Array, first: Index, second: Index) -> Array | None:
    """Separate two walls that overlap thinly between two crossings, or None.

    Crossings come in pairs: one wall wanders over the other and back. Between them, both
    stretches are laid on either side of their middle line.
    """
    n = len(ring)
    order = np.argsort(first)
    first, second = first[order], second[order]
    result = ring.copy()
    done = False
    k = 0
    while k + 1 < len(first):
        i0, i1, j1, j0 = first[k], first[k + 1], second[k + 1], second[k]
        one = np.arange(i0, i1 + 2)
        two = np.arange(min(j0, j1), max(j0, j1) + 2) % n
        if len(one) < n // 3 and len(two) < n // 3 and not np.intersect1d(one, two).size:
            a, b = ring[one], ring[two]
            gap = np.hypot(a[:, 0][:, None] - b[:, 0], a[:, 1][:, None] - b[:, 1])
            if gap.min(axis=1)[1:-1].max(initial=0.0) < THIN_OVERLAP and (
                gap.min(axis=0)[1:-1].max(initial=0.0) < THIN_OVERLAP
            ):
                _lay_apart(result, ring, one, two)
                done = True
        k += 2
    return result if done else None


def _lay_apart(result: Array, ring: Array, one: Index, two: Index) -> None:
    """Move two stretches onto either side of their middle line, in place."""
    import shapely

    n = len(ring)
    pad = 2
    margin = 0.5 * THIN_OVERLAP
    lines = []
    for stretch in (one, two):
        wide = np.arange(stretch[0] - pad, stretch[0] + len(stretch) + pad) % n
        lines.append(wide)
    for wide, other in ((lines[0], lines[1]), (lines[1], lines[0])):
        curve = shapely.LineString(ring[other])
        p = ring[wide]
        q = shapely.get_coordinates(
            shapely.line_interpolate_point(
                curve, shapely.line_locate_point(curve, shapely.points(p))
            )
        )
        # The side this wall came from: before the first crossing it was clear of the other.
        outside = p[[0, -1]] - q[[0, -1]]
        outward = outside.sum(axis=0)
        norm = float(np.hypot(*outward))
        if norm < 1e-12:
            continue
        side = outward / norm
        moved = 0.5 * (p + q) + margin * side
        fade = np.ones(len(wide))
        fade[[0, -1]] = 0.5
        result[wide] = p + fade[:, None] * (moved - p)
