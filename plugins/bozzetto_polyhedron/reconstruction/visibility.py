"""Which lines faces hide, and whether they are the ones that were drawn lightly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.line_samples import SAMPLES, SHARES
from bozzetto_polyhedron.reconstruction.regularity import area_vector

CLEARANCE: Final = 0.01
"""Depth, diagonals, by which a face must be nearer to hide a place."""

WRONG_MARKS: Final = 0.1
"""Share of lines that a person marks wrongly."""

CONTRAST: Final = 0.3
"""Difference of the darkest from the lightest lines below which no line is marked."""


def is_marked(drawing: Drawing) -> bool:
    """Whether hidden lines were drawn otherwise than visible ones."""
    return bool(np.ptp(drawing.light) > CONTRAST) if len(drawing.light) else False


def agreement(
    drawing: Drawing, depths: Array, faces: Sequence[Rings], lines: Flags | None = None
) -> tuple[float, float]:
    """Return the log-likelihood of the marks for a reading, and for its mirrored one.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    depths : (n,) array
        Away from the eye, diagonals; negative ones are those of the mirrored reading.
    faces : sequence of Rings
        Rings of corners, in any sense.
    lines : (m,) bool, optional
        Lines whose marks count; all without.
    """
    found = []
    for hidden in hidden_shares(drawing, depths, faces):
        likely = WRONG_MARKS + (1.0 - 2.0 * WRONG_MARKS) * hidden
        each = drawing.light * np.log(likely) + (1.0 - drawing.light) * np.log1p(-likely)
        found.append(float(each.sum() if lines is None else each[lines].sum()))
    return found[0], found[1]


def hidden_shares(drawing: Drawing, depths: Array, faces: Sequence[Rings]) -> tuple[Array, Array]:
    """Return the share of each line that faces hide, seen from the eye and from the far side.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    depths : (n,) array
        Away from the eye, diagonals.
    faces : sequence of Rings
        Rings of corners, in any sense.
    """
    space = np.column_stack((drawing.points, depths))
    start, end = (space[drawing.lines[:, k]][:, None] for k in (0, 1))
    places = (start + SHARES[:, None] * (end - start)).reshape(-1, 3)
    before = np.zeros(len(places), bool)
    behind = before.copy()
    for face in faces:
        normal = area_vector(space[list(face[0])])
        if abs(normal[2]) < 1e-6:
            continue
        under = np.flatnonzero(drawing.covered.samples(face))
        if not len(under):
            continue
        middle = space[list(face[0])].mean(0)
        level = middle[2] - (places[under, :2] - middle[:2]) @ normal[:2] / normal[2]
        before[under] |= level < places[under, 2] - CLEARANCE
        behind[under] |= level > places[under, 2] + CLEARANCE
    return (
        before.reshape(-1, SAMPLES).mean(1),
        behind.reshape(-1, SAMPLES).mean(1),
    )
