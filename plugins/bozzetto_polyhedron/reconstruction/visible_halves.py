"""Symmetric solids: what is visible with its image by a half turn, or in a mirror.

Both hold in the picture of a parallel view as they do in space. Lengths are shares of the diagonal.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.mirror_images import mirror_images
from bozzetto_polyhedron.reconstruction.missing_lines import Whole
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.visible_regions import Junctions


def turned_wholes(drawing: Drawing, junctions: Junctions, reach: float) -> list[Whole]:
    """Return what was drawn with its image by a half turn, about middles of pairs of corners."""
    points, lines, _ = _without_stems(drawing, junctions)
    first, second = np.triu_indices(len(points), 1)
    middles = (points[first] + points[second]) / 2.0
    turned = (
        _with_images(points, lines, 2.0 * middle - points, reach)
        for middle in middles[_most_common(middles, reach)]
    )
    return [whole for whole in turned if whole is not None]


def mirrored_wholes(drawing: Drawing, junctions: Junctions, reach: float) -> list[Whole]:
    """Return what was drawn with its mirror image, across the lines of each class."""
    points, lines, kept = _without_stems(drawing, junctions)
    labels = parallel_classes(drawing).labels[kept]
    mirrored = (
        _with_images(points, lines, images, reach, across=True)
        for images in mirror_images(points, lines, labels, reach)
    )
    return [whole for whole in mirrored if whole is not None]


def _without_stems(drawing: Drawing, junctions: Junctions) -> tuple[Array, Index, Flags]:
    """Return corners and lines between them without those that go behind, and which lines stay."""
    kept = np.asarray(~junctions.is_stem[drawing.lines].any(1))
    corners, numbers = np.unique(drawing.lines[kept], return_inverse=True)
    return drawing.points[corners], numbers.reshape(-1, 2).astype(np.intp), kept


def _with_images(
    points: Array, lines: Index, images: Array, reach: float, *, across: bool = False
) -> Whole | None:
    """Return corners and lines with their images; None where a corner has too few lines.

    Lines `across` join corners to their images where both have one line too few.
    """
    if not len(points):
        return None
    away = np.linalg.norm(images[:, None] - points, axis=2)
    nearest = away.argmin(1)
    own = away[np.arange(len(points)), nearest] < reach
    fresh = np.cumsum(~own) - 1 + len(points)
    numbers = np.where(own, nearest, fresh)
    pairs = np.sort(np.concatenate((lines, numbers[lines])), axis=1)
    pairs = np.unique(pairs, axis=0)
    corners = np.concatenate((points, images[~own]))
    degrees = np.bincount(pairs.ravel(), minlength=len(corners))
    if across:
        joins = np.sort(np.column_stack((np.arange(len(points)), numbers)), axis=1)
        joins = joins[(joins[:, 0] != joins[:, 1]) & (degrees[joins] == 2).all(axis=1)]
        pairs = np.unique(np.concatenate((pairs, joins)), axis=0)
        degrees = np.bincount(pairs.ravel(), minlength=len(corners))
    return Whole(corners, pairs) if (degrees >= 3).all() else None


def _most_common(places: Array, reach: float, most: int = 6) -> Index:
    """Return places with the most others close by, each far from those before."""
    close = np.linalg.norm(places[:, None] - places, axis=2) < reach
    order = np.argsort(-close.sum(1), kind="stable")
    taken: list[int] = []
    for number in order.tolist():
        if not any(close[number, other] for other in taken):
            taken.append(number)
        if len(taken) == most:
            break
    return np.array(taken, np.intp)
