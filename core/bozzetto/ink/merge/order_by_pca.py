"""Order by the first principal component: what Kara & Shimada do (section 13.2)."""

from __future__ import annotations

import numpy as np

from bozzetto.ink.merge.resample_all import Ordering, ResampledInk


def order_by_pca(ink: ResampledInk) -> Ordering:
    """Order the points along the direction of their greatest spread.

    Right for curves that are graphs over a straight line, wrong for hooks and loops.
    """
    offset = ink.points - np.average(ink.points, axis=0, weights=ink.weights)
    spread = (offset * ink.weights[:, None]).T @ offset
    along = offset @ np.linalg.eigh(spread)[1][:, -1]
    extent = float(np.ptp(along))
    return Ordering(np.arange(len(along)), (along - along.min()) / extent, closed=False)
