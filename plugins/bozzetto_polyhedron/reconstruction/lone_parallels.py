"""Lines that look parallel to others in this view, and to none in a face that they bound.

The slanted lines of a pyramid have no parallel. Seen from somewhere, one of them runs like another
line of the drawing all the same; its slope, and with it the height, is then the one of that line.
Whether it is parallel in space, the drawing does not tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Flags
from bozzetto_polyhedron.reconstruction.affine_depth import affine_depth
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.lifting import Lifting
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses

SAME_DEPTHS: Final = 0.02
"""Change of affine depths, of unit length, below which lone parallels tell nothing."""

INDEPENDENT: Final = 0.15
"""Singular value above which directions are three."""


def without_lone_parallels(
    drawing: Drawing, classes: ParallelClasses, liftings: Sequence[Lifting]
) -> tuple[ParallelClasses, list[Lifting]] | None:
    """Return classes in which lone parallels stand alone, and what is drawn as these have it.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    liftings : sequence of Lifting
        The body, then its loose parts.

    Returns
    -------
    classes : ParallelClasses
    liftings : list of Lifting
        With the same faces. None in place of both where no depth hangs on such lines.
    """
    alone = borne_out(drawing, classes, [face for each in liftings for face in each.faces])
    lone = _lone(classes, alone)
    if not lone.any():
        return None
    freed = [
        replace(each, depth=affine_depth(drawing, alone, each.corners, each.faces))
        for each in liftings
    ]
    own = [lone & np.isin(drawing.lines[:, 0], each.corners) for each in liftings]
    hang = own[0].any() and _other_depths(drawing, liftings[0], freed[0])
    for flags, part in zip(own[1:], freed[1:], strict=True):
        hang = hang or (flags.any() and not _three_directions(drawing, alone, part))
    return (alone, freed) if hang else None


def borne_out(
    drawing: Drawing, classes: ParallelClasses, faces: Sequence[Rings]
) -> ParallelClasses:
    """Return classes in which a line without a parallel in a face that it bounds stands alone.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    faces : sequence of Rings
        All that are known.
    """
    number = {(int(a), int(b)): place for place, (a, b) in enumerate(drawing.lines)}
    borne = np.bincount(classes.labels)[classes.labels] < 2
    for face in faces:
        sides = [
            number[min(a, b), max(a, b)]
            for ring in face
            for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
        ]
        labels = classes.labels[sides]
        borne[sides] |= np.bincount(labels)[labels] > 1
    lone = np.flatnonzero(~borne)
    labels = classes.labels.copy()
    labels[lone] = len(classes.directions) + np.arange(len(lone))
    directions = drawing.spans[lone] / np.maximum(drawing.lengths[lone, None], 1e-12)
    present, labels = np.unique(labels, return_inverse=True)
    return ParallelClasses(labels, np.vstack((classes.directions, directions))[present])


def _lone(classes: ParallelClasses, alone: ParallelClasses) -> Flags:
    """Return which lines stand alone in the second classes only."""
    before = np.bincount(classes.labels)[classes.labels]
    return np.asarray((before > 1) & (np.bincount(alone.labels)[alone.labels] == 1))


def _other_depths(drawing: Drawing, body: Lifting, freed: Lifting) -> bool:
    """Whether depths of a body are open, or others, once lone parallels stand alone."""
    if freed.depth.basis.shape[1] > body.depth.basis.shape[1]:
        return True
    corners = list(body.corners)
    rows = np.column_stack(
        (np.ones(len(corners)), drawing.points[corners], freed.depth.basis[corners])
    )
    depths = body.depth.depths[corners]
    off = depths - rows @ np.linalg.lstsq(rows, depths, rcond=None)[0]
    return float(np.linalg.norm(off)) > SAME_DEPTHS


def _three_directions(drawing: Drawing, classes: ParallelClasses, part: Lifting) -> bool:
    """Whether a part has parallel lines in three independent directions, as prisms have."""
    corners = list(part.corners)
    depths = part.depth.depths
    scale = drawing.points[corners].std(0).mean() / max(1e-9, float(depths[corners].std()))
    lines = np.isin(drawing.lines[:, 0], corners)
    labels, ends = classes.labels[lines], drawing.lines[lines]
    rises = scale * (depths[ends[:, 1]] - depths[ends[:, 0]])
    ways = np.column_stack((drawing.spans[lines], rises))
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    means = []
    for label in np.flatnonzero(np.bincount(labels) > 1):
        own = ways[labels == label]
        means.append((own * np.sign(own @ own[0])[:, None]).mean(0))
    values = np.linalg.svd(np.array(means).reshape(-1, 3), compute_uv=False)
    return len(values) == 3 and float(values[2]) > INDEPENDENT
