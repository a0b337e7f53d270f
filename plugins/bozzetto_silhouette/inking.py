"""Pen strokes to closed rings. (First version: closed strokes only.)"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["rings_from_strokes"]


def rings_from_strokes(
    strokes: Sequence[ArrayLike], *, tolerance: float | None = None
) -> list[NDArray[np.float64]]:
    """Each stroke taken as a closed ring."""
    return [np.asarray(s, dtype=np.float64) for s in strokes]
