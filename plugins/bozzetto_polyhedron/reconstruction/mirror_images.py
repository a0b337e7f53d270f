"""Where the corners of a symmetric solid have their mirror images in a picture of visible lines.

A plane of symmetry is not seen, but lines across it are: both ends of such a line are images of
one another, and in a parallel view all ways from a corner to its image run along one direction k.
A line of a class (parallel in space) that is L long in the picture, along d, has the image
L (d + s k) with one s for all lines of its class; s = 0 where they run along the plane. What lines
tell is carried from corner to corner. Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bozzetto.arrays import Array, Index


def mirror_images(points: Array, lines: Index, labels: Index, reach: float) -> Iterator[Array]:
    """Yield the images (n, 2) of all corners, once for each direction that may lead to them.

    Parameters
    ----------
    points : (n, 2) float
        Corners.
    lines : (m, 2) intp
        Between them; every corner has one at least.
    labels : (m,) intp
        Class of each line.
    reach : float
        Distance within which places are one.
    """
    for across in np.unique(labels).tolist():
        pairs = lines[labels == across]
        if len(np.unique(pairs)) < pairs.size:
            continue  # a row of lines: no pair of corners is told
        images = {int(a): points[b] for pair in pairs for a, b in (pair, pair[::-1])}
        spans = points[pairs[:, 1]] - points[pairs[:, 0]]
        spans *= np.where(spans @ spans[0] < 0.0, -1.0, 1.0)[:, None]
        way = spans.sum(axis=0) / np.linalg.norm(spans.sum(axis=0))
        rest = labels != across
        _find_fixed(points, lines[rest], images, reach)
        slopes = _slopes(points, lines[rest], labels[rest], images, way)
        _carry(points, lines[rest], labels[rest], images, slopes, way)
        if len(images) == len(points):
            yield np.array([images[k] for k in range(len(points))])


def _find_fixed(points: Array, lines: Index, images: dict[int, Array], reach: float) -> None:
    """Add corners that are their own images: a line leads to a corner, and one to its image."""
    told = dict(images)
    for corner in range(len(points)):
        if corner in told:
            continue
        ends = [
            two if one == corner else one for one, two in lines.tolist() if corner in (one, two)
        ]
        wanted = [told[end] for end in ends if end in told]
        if any(np.linalg.norm(points[ends] - place, axis=1).min() < reach for place in wanted):
            images[corner] = points[corner]


def _slopes(
    points: Array, lines: Index, labels: Index, images: dict[int, Array], way: Array
) -> dict[int, float]:
    """Return s of each class of which a line has both ends told."""
    found: dict[int, list[float]] = {}
    for (one, two), label in zip(lines.tolist(), labels.tolist(), strict=True):
        if one in images and two in images:
            span = points[two] - points[one]
            off = images[two] - images[one] - span
            found.setdefault(label, []).append(float(off @ way) / _signed(span))
    return {label: float(np.median(values)) for label, values in found.items()}


def _carry(
    points: Array,
    lines: Index,
    labels: Index,
    images: dict[int, Array],
    slopes: dict[int, float],
    way: Array,
) -> None:
    """Add images along lines until no line leads on.

    Lines of a known slope lead first, and those from a corner that is its own image last: without a
    slope they would make a corner in the plane of what is beside it.
    """
    leads = True
    while leads:
        open_ends = []
        for number, (one, two) in enumerate(lines.tolist()):
            if (one in images) != (two in images):
                here = one if one in images else two
                open_ends.append((_rank(points, images, slopes, here, labels[number]), number))
        leads = bool(open_ends)
        if leads:
            _, number = min(open_ends)
            one, two = lines[number].tolist()
            here, there = (one, two) if one in images else (two, one)
            span = points[there] - points[here]
            slope = slopes.get(int(labels[number]), 0.0)
            images[there] = images[here] + span + slope * _signed(span) * way


def _rank(
    points: Array, images: dict[int, Array], slopes: dict[int, float], corner: int, label: int
) -> int:
    """Return how late a line from a corner leads: 0, 1 or 2."""
    if int(label) in slopes:
        return 0
    return 2 if np.array_equal(points[corner], images[corner]) else 1


def _signed(span: Array) -> float:
    """Return a length with the sign of the first coordinate that counts: up, or else right."""
    x, y = span.tolist()
    return float(np.hypot(x, y)) * (1.0 if (y, x) > (0.0, 0.0) else -1.0)
