"""Factors on the height and the depth of a solid: what the silhouette does not say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.normalized import Frame


class Thickness(Protocol):
    """Factors by which a solid is deeper or flatter than round, from place to place.

    The outline stays whatever the factors are: they multiply heights that are 0 there.
    """

    def factors(self, frame: Frame, plan: Plan, front: Array, back: Array) -> tuple[Array, Array]:
        """Return factors on the heights towards the person and away, at a plan's points, (n,) each.

        Positive and finite. The same array twice where front and back are alike.

        Parameters
        ----------
        frame : Frame
            The outline and its scale.
        plan : Plan
            In the frame of the sums.
        front, back : (n,) float array
            The squared heights that will be multiplied.
        """
        ...


@dataclass(frozen=True)
class Uniform:
    """The same factor everywhere."""

    inflation: float = 1.0

    def factors(self, frame: Frame, plan: Plan, front: Array, back: Array) -> tuple[Array, Array]:
        """Return the factor at every point, the same for front and back."""
        same = np.full(len(plan.points), self.inflation)
        return same, same


@dataclass(frozen=True)
class InTurn:
    """One after the other; each sees the heights that those before it left."""

    steps: tuple[Thickness, ...]

    def factors(self, frame: Frame, plan: Plan, front: Array, back: Array) -> tuple[Array, Array]:
        """Return the products of the factors of all steps."""
        up = down = np.ones(len(plan.points))
        for step in self.steps:
            so_far = front * up**2
            other = so_far if back is front and up is down else back * down**2
            higher, deeper = step.factors(frame, plan, so_far, other)
            alike = up is down and higher is deeper
            up = up * higher
            down = up if alike else down * deeper
        return up, down
