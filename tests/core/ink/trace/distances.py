"""How far traced lines lie from those that were drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bozzetto.ink.curves.resample import resample

Points = NDArray[np.float64]


def hausdorff(one: Points, other: Points) -> float:
    """Largest distance of either polyline from the other, by dense samples."""
    a, b = (resample(line, spacing=1.0) for line in (one, other))
    return float(max(cKDTree(a).query(b)[0].max(), cKDTree(b).query(a)[0].max()))
