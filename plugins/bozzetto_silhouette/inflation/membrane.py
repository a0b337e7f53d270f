"""Membranes under pressure: inflation as a kind of surface, and the quick round shape.

A membrane held at the outline takes the shape u with -laplace(u) = pressure, and the height
is sqrt(u). On a strip of half width r the height is that of a tube where the pressure is 2,
on a disc that of a ball where it is 4; with one pressure for both, one of them is too high or
too low by a factor of sqrt(2). After Dvoroznak et al., "Monster Mash", 2020.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.outline.boundary_sampling import Rim
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.fem import Elements, factorised
from bozzetto_silhouette.outline.normalized import Frame

TUBE, BALL = 2.0, 4.0
"""Pressure under which a strip becomes a tube, and a disc a ball."""


@dataclass(frozen=True, eq=False)
class Membrane:
    """A plan whose membrane can be blown up again and again."""

    plan: Plan
    mass: Array
    factors: Any

    @classmethod
    def of(cls, plan: Plan) -> Membrane:
        """Make a membrane that is held at the plan's rim."""
        elements, rim = Elements.of(plan), len(plan.after)
        return cls(plan, elements.mass[rim:], factorised(elements.stiffness(first=rim)))

    def blown(self, pressure: Array | float) -> Array:
        """Solve for the shape u (n,), 0 on the rim, under a pressure at the inner points."""
        u = np.zeros(len(self.plan.points))
        u[len(self.plan.after) :] = self.factors.solve(self.mass * pressure)
        return np.maximum(u, 0.0)

    def round(self, depth: Array, radius: Array) -> Array:
        """Return squared heights that are round on tubes and on balls.

        Parameters
        ----------
        depth : (k,) float array
            Distance of the inner points from the rim.
        radius : (k,) float array
            Local radius at their feet on the rim.

        Notes
        -----
        Under the pressure 1 the membrane stands ``d (2 r - d) / 2`` high on a strip and half as
        high on a disc: the height tells how round the place is, and so which pressure it needs.
        """
        calm = self.blown(1.0)[len(self.plan.after) :]
        round_section = depth * np.maximum(2.0 * radius - depth, depth)
        pressure = np.clip(round_section / np.maximum(calm, 1e-300), TUBE, BALL)
        return self.blown(pressure)


@dataclass(frozen=True)
class MembraneHeights:
    """The membrane under one pressure, each body as high as its largest inscribed ball."""

    def squares(self, frame: Frame, rim: Rim, plan: Plan) -> Array:
        """Return the squared half thickness at a plan's points."""
        from scipy.spatial import cKDTree

        square = Membrane.of(plan).blown(1.0)
        body = _bodies(plan)
        highest, widest = np.zeros((2, body.max() + 1))
        np.maximum.at(highest, body, square)
        _, near = cKDTree(plan.points).query(frame.axis[:, :2])
        np.maximum.at(widest, body[near], frame.axis[:, 2])
        scaled: Array = square * (widest**2 / np.maximum(highest, 1e-300))[body]
        return scaled


def _bodies(plan: Plan) -> Faces:
    """Return for each point the number of the connected piece of the plan it is in, (n,)."""
    a, b, c = plan.triangles.T
    return connected_pieces(np.concatenate([a, b]), np.concatenate([b, c]), len(plan.points))[1]
