"""Cautions that a person is told about an answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses

NEAR_AXES: Final = 6.0
"""Angle on the sheet, degrees, below which two directions are hard to tell apart."""

FAR_IN_SPACE: Final = 25.0
"""Angle in space, degrees, above which two directions are certainly two."""

EDGE_ON: Final = 0.015
"""Width of a face on the sheet, diagonals, below which it is seen edge-on."""

TOO_CLOSE = (
    "Two directions of edges lie nearly on one another in this view. Draw it from another side."
)
SEEN_EDGE_ON = "A face is seen nearly edge-on. Draw the solid from another side."
SHORT = "Some edges are hardly longer than the hand is unsteady. Draw larger, or those edges again."
SIDE = (
    "Hidden edges are not marked, so it is taken as seen from above; the mirrored one is offered."
)
LOOSE = (
    "A part of the drawing hangs in no face. Join it with a line, or draw it inside a face; for "
    "another body choose “Begin a new body” before you draw it."
)
BY_LOOKS = (
    "A slanted edge looks parallel to others, which may be chance in this view. Both answers are "
    "offered: with its slope taken from them, and left open. Draw it from another side to be sure."
)
PERSPECTIVE = "The lines meet in the distance, so the drawing is taken as one in perspective."


def cautions(
    drawing: Drawing, classes: ParallelClasses, depths: Array, faces: Sequence[Rings]
) -> tuple[str, ...]:
    """Return what makes a reading doubtful: directions or faces that the view does not show well.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    depths : (n,) array
        Away from the eye, diagonals.
    faces : sequence of Rings
        Rings of corners, in any sense.
    """
    found = []
    if _axes_near(drawing, classes, depths):
        found.append(TOO_CLOSE)
    if any(_width(drawing.points[list(face[0])]) < EDGE_ON for face in faces):
        found.append(SEEN_EDGE_ON)
    if len(drawing.lines) and drawing.lengths.min() < 2.0 * drawing.noise:
        found.append(SHORT)
    return tuple(found)


def _axes_near(drawing: Drawing, classes: ParallelClasses, depths: Array) -> bool:
    """Whether lines of clearly different directions in space run alike on the sheet."""
    if len(drawing.lines) < 2:
        return False
    rise = depths[drawing.lines[:, 1]] - depths[drawing.lines[:, 0]]
    space = np.column_stack((drawing.spans, rise))
    space /= np.maximum(np.linalg.norm(space, axis=1, keepdims=True), 1e-12)
    flat = drawing.spans / drawing.lengths[:, None]
    steady = drawing.lengths > 6.0 * drawing.noise
    common = np.bincount(classes.labels)[classes.labels] > 1
    chosen = np.flatnonzero(steady & common)
    on_sheet = np.degrees(np.arccos(np.clip(np.abs(flat[chosen] @ flat[chosen].T), 0.0, 1.0)))
    in_space = np.degrees(np.arccos(np.clip(np.abs(space[chosen] @ space[chosen].T), 0.0, 1.0)))
    apart = (on_sheet < NEAR_AXES) & (in_space > FAR_IN_SPACE)
    return bool(apart.any())


def _width(ring: Array) -> float:
    """Return the least width of a polygon on the sheet, from the spread across its main axis."""
    values = np.linalg.svd(ring - ring.mean(0), compute_uv=False)
    return float(2.0 * values[-1] / np.sqrt(len(ring)))
