"""Factors on the height and the depth of a solid: what the silhouette does not say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.frame import Frame
from bozzetto_silhouette.plan import Plan

__all__ = ["Thickness", "Uniform"]

Points = NDArray[np.float64]


class Thickness(Protocol):
    """How much deeper or flatter than round a solid is, from place to place.

    The outline stays whatever the factors are: they multiply heights that are 0 there.
    """

    def factors(self, frame: Frame, plan: Plan) -> tuple[Points, Points]:
        """Factors on the heights towards the person and away, at a plan's points, (n,) each.

        Positive and finite. The same array twice where front and back are alike.
        """
        ...


@dataclass(frozen=True)
class Uniform:
    """The same factor everywhere."""

    inflation: float = 1.0

    def factors(self, frame: Frame, plan: Plan) -> tuple[Points, Points]:
        """The factor at every point, the same for front and back."""
        same = np.full(len(plan.points), self.inflation)
        return same, same
