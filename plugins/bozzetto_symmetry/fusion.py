"""What several views say about one curve, in one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Estimate", "fused"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Estimate:
    """What one view says about a curve.

    Parameters
    ----------
    points : (k, 3) float
        In order along the curve, mm.
    covariances : (k, 3, 3) float
        mm².
    """

    points: Array
    covariances: Array


def fused(estimates: Sequence[Estimate], *, closed: bool = False) -> Estimate:
    """Combine estimates of the same curve."""
    return min(estimates, key=lambda e: float(np.median(np.trace(e.covariances, axis1=1, axis2=2))))
