"""What weak creases miss of the angle that they should have between their ends.

The angles in the ends of a crease follow from lines (`crease_sides`). Between them it follows from
the patches, too: over an edge of 12° and 17° in its ends patches of least variation may meet at 1°,
or be hollow. A crease should have `SHARE` of what it would have if the angle ran straight from one
end to the other, but need not have more than `LEAST`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.geometry.patches import bernstein
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import KNOWN

SHARE: Final = 0.75
"""Share of the angle that runs straight from one end of a crease to the other."""

LEAST: Final = np.radians(6.0)
"""Angle that is enough between the ends, radians."""

PLACES: Final = np.linspace(0.0, 1.0, 7)
"""Places along a crease in which its angle is looked at."""

_VALUES: Final = bernstein(PLACES)
_SLOPES: Final = bernstein(PLACES, 1)
_INNER: Final = 3.0 * _VALUES[:, 1:3]
_SENSES: Final = np.array([1.0, -1.0])[:, None, None, None]
"""A patch to the left of a crease has its normal along × beside, one to the right the opposite."""

TINY: Final = float(np.finfo(float).tiny)

ROWS: Final = tuple(
    tuple(tuple(4 * i + j for i, j in places) for places in rows)
    for rows in (
        [[(k, row) for k in range(4)] for row in (0, 1)],
        [[(3 - row, k) for k in range(4)] for row in (0, 1)],
        [[(3 - k, 3 - row) for k in range(4)] for row in (0, 1)],
        [[(row, 3 - k) for k in range(4)] for row in (0, 1)],
    )
)
"""Numbers of the control points along each side of a net, in its sense, and in the next row."""

CORNER: Final = {5: 0, 9: 1, 10: 2, 6: 3}
"""The corner of each inner control point, by its number in a net."""


@dataclass(frozen=True, eq=False)
class Creases:
    """The creases between patches of the right half.

    Attributes
    ----------
    patches : (2, c) int
        The patch to the left of each crease as it runs, and that to the right.
    lines, rows : (2, c, 4) int
        Numbers of their control points along the crease, and of those in the next row.
    corners : (2, c, 2) int
        Numbers of the inner control points in these rows among those of their patches.
    """

    patches: Index
    lines: Index
    rows: Index
    corners: Index

    def missing(self, nets: Array, ways: Array) -> tuple[Array, Array]:
        """Return what is missing of the angles, times the width of the patches, and its slope.

        Parameters
        ----------
        nets : (k, 16, 3) float
            Control points, mm.
        ways : (k, 4, n, 3) float
            How each inner control point moves with each unknown.

        Returns
        -------
        short : (c p,) float
            mm, each by the root of the number of places. 0 where nothing is missing.
        slopes : (c p, n) float
            How it changes.
        """
        lines = nets[self.patches[0][:, None], self.lines[0]]
        along = _SLOPES @ lines
        along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), TINY)
        legs = 3.0 * (nets[self.patches[..., None], self.rows] - lines)
        beside = _VALUES @ legs
        beside = beside - (beside * along).sum(axis=-1, keepdims=True) * along
        widths = np.maximum(np.linalg.norm(beside, axis=-1), TINY)
        normals = cross_product(along, beside) * _SENSES / widths[..., None]
        sine = (cross_product(normals[0], normals[1]) * along).sum(axis=-1)
        angles = np.arctan2(sine, (normals[0] * normals[1]).sum(axis=-1))
        straight = angles[:, :1] * (1.0 - PLACES) + angles[:, -1:] * PLACES
        signs = np.sign(straight)
        short = np.maximum(np.minimum(SHARE * np.abs(straight), LEAST) - signs * angles, 0.0)
        scale = 2.0 / (1.0 / widths).mean(axis=2).sum(axis=0)[:, None] / np.sqrt(len(PLACES))
        turning = (signs * (short > 0.0) * scale / widths)[..., None] * normals
        inner = ways[self.patches[..., None], self.corners]
        each = turning[:, :, None] @ inner.swapaxes(-1, -2)
        by_inner = (_INNER.T[:, :, None] * each).sum(axis=(0, 2))
        return (short * scale).ravel(), by_inner.reshape(short.size, ways.shape[2])


@lru_cache(maxsize=KNOWN)
def creases_between(template: Template, patches: tuple[int, ...]) -> Creases:
    """Return the creases between some patches of a template, whose order gives their numbers."""
    number = {patch: own for own, patch in enumerate(patches)}
    sides = {side: divmod(at, 4) for at, side in enumerate(template.sides.ravel().tolist())}
    found = [
        (sides[edge], sides[~edge])
        for edge in sorted(template.creases)
        if {sides[edge][0], sides[~edge][0]} <= number.keys()
    ]
    lines, rows = [], []
    for (_, left), (_, right) in found:
        both = ROWS[left], tuple(row[::-1] for row in ROWS[right])
        lines.append([line for line, _ in both])
        rows.append([row for _, row in both])
    shape = (len(found), 2, 4)
    beside = np.array(rows, np.intp).reshape(shape)
    corners = [[[CORNER[at] for at in row[1:3]] for row in pair] for pair in beside.tolist()]
    return Creases(
        np.array([[number[one], number[two]] for (one, _), (two, _) in found], np.intp)
        .reshape(-1, 2)
        .T,
        np.array(lines, np.intp).reshape(shape).swapaxes(0, 1),
        beside.swapaxes(0, 1),
        np.array(corners, np.intp).reshape(-1, 2, 2).swapaxes(0, 1),
    )
