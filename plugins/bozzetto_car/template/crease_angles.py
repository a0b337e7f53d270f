"""What creases miss of the angles in their ends while lines turn.

Lines that turn so that patches bend one way (`body.turned_lines`) turn creases, too. Here the angle
over each end of a crease is told from the control points of both patches beside it, with how it
changes with them, so that it keeps the sign and the least size that `crease_sides` wants.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto_car.template.crease_sides import crease_ends, wanted_angles
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import HANDLE, KNOWN
from bozzetto_car.template.weak_creases import ROWS

SENSES: Final = np.array([1.0, -1.0])[:, None]
"""A patch to the left of a crease has its normal along × beside, one to the right the opposite."""

SLIGHT: Final = 20.0
"""What is missing, mm, at which it counts for half as much as by its size alone. So that lines do
not leap while nodes move, what has just come to be missing counts for nothing."""

TINY: Final = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class EndAngles:
    """The angles over the ends of creases between some patches, by the patches' control points.

    Attributes
    ----------
    along : (c, 3) int
        Of each crease's tangent: a patch, and the control points of the net at its tip and foot.
    beside : (c, 2, 3) int
        The same of the edge to the left of the crease and of that to its right.
    leaving : (c, 2, 1) float
        1 where such a tangent leaves the node, -1 where it leads to it.
    signs, least : (c,) float
        The sign that the angle should have, and its least size, radians.
    """

    along: Index
    beside: Index
    leaving: Array
    signs: Array
    least: Array

    def missing(self, nets: Array, ways: Array) -> tuple[Array, Array]:
        """Return what is missing of the angles, times the lengths of the edges beside.

        Parameters
        ----------
        nets : (k, 16, 3) float
            Control points, mm.
        ways : (k, 16, n, 3) float
            How each of them moves with each unknown.

        Returns
        -------
        short : (c,) float
            mm. 0 where nothing is missing.
        slopes : (c, n) float
            How it changes; lengths count as fixed.
        """
        along, own = _tangents(nets, self.along), _tangents(ways, self.along)
        sizes = np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), TINY)
        along = along / sizes
        beside = self.leaving * _tangents(nets, self.beside)
        ahead = (beside * along[:, None]).sum(axis=-1, keepdims=True)
        across = beside - ahead * along[:, None]
        widths = np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), TINY)
        normals = cross_product(along[:, None], across) * SENSES / widths
        sine = (cross_product(normals[:, 0], normals[:, 1]) * along).sum(axis=-1)
        angles = np.arctan2(sine, (normals[:, 0] * normals[:, 1]).sum(axis=-1))
        short = np.maximum(self.least - self.signs * angles, 0.0)
        # A crease that turns takes along what lies ahead of an edge beside it.
        turning = self.leaving[..., None] * _tangents(ways, self.beside)
        turning = turning - (ahead / sizes[:, None])[..., None] * own[:, None]
        slopes = (turning @ (normals / widths)[..., None])[..., 0].sum(axis=1)
        scale = 2.0 / (1.0 / widths[..., 0]).sum(axis=1)
        short = short * scale
        gently = np.sqrt(short / (short + SLIGHT))
        return short * gently, (self.signs * gently * scale)[:, None] * slopes


def _tangents(points: Array, places: Index) -> Array:
    """Return tangents by the control points of nets, or how they change by how these do."""
    patch, tip, foot = np.moveaxis(places, -1, 0)
    return np.asarray((points[patch, tip] - points[patch, foot]) / HANDLE)


@lru_cache(maxsize=KNOWN)
def end_angles_between(template: Template, patches: tuple[int, ...]) -> EndAngles:
    """Return the ends of creases between some patches, whose order gives their numbers."""
    places: dict[tuple[int, int], tuple[int, int, int]] = {}
    for number, patch in enumerate(patches):
        for side, signed in enumerate(template.sides[patch].tolist()):
            line = ROWS[side][0] if signed >= 0 else ROWS[side][0][::-1]
            edge = max(signed, ~signed)
            places[edge, 0] = number, line[1], line[0]
            places[edge, 1] = number, line[3], line[2]
    ends = crease_ends(template)
    signs, least = wanted_angles(template)
    creases = [(edge, end) for edge, end in ends.creases.tolist()]
    beside = [[(edge, end) for edge, end in pair] for pair in ends.beside.tolist()]
    kept = [
        at for at, (own, pair) in enumerate(zip(creases, beside, strict=True))
        if {own, *pair} <= places.keys()
    ]  # fmt: skip
    return EndAngles(
        np.array([places[creases[at]] for at in kept], np.intp).reshape(-1, 3),
        np.array([[places[end] for end in beside[at]] for at in kept], np.intp).reshape(-1, 2, 3),
        ends.leaving[kept],
        signs[kept],
        least[kept],
    )
