"""Checks of the result of a set operation, before anybody builds on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.model.state import Operation

if TYPE_CHECKING:
    from manifold3d import Manifold

EXACT = 1e-6
"""Volume by which a result of exact operations may miss its bounds, as a share of the larger
operand's: their meshes are rounded, not resampled."""

RESAMPLED = 0.3
"""The same of a surface that was made anew, and swells where it is blended."""

PROBES = 24
"""Places along the longest side of a box, where an empty result is asked whether it can be."""

DEEP = 2.0
"""Depth, in spacings, of a place within a solid that no mesh can have lost."""


def volumes_allowed(operation: Operation, first: float, second: float) -> tuple[float, float]:
    """Return the least and the greatest volume that an operation on two solids can give.

    Parameters
    ----------
    operation : {"add", "merge", "carve", "intersect"}
        What the second does to the first.
    first, second : float
        Their volumes, not negative.
    """
    if operation == "carve":
        return max(0.0, first - second), first
    if operation == "intersect":
        return 0.0, min(first, second)
    return max(first, second), first + second


def is_union(whole: Manifold, parts: Sequence[Manifold]) -> bool:
    """Whether a solid is sound, and of a volume that the union of parts can have."""
    if any(solid.status().name != "NoError" for solid in (whole, *parts)):
        return False
    volumes = [float(part.volume()) for part in parts]
    return is_volume_of_union(float(whole.volume()), volumes)


def is_volume_of_union(volume: float, parts: Sequence[float]) -> bool:
    """Whether the union of parts of some volumes can have a volume."""
    slack = EXACT * max(parts)
    return min(parts) >= 0.0 and max(parts) - slack <= volume <= sum(parts) + slack


def is_allowed(
    result: Manifold,
    operation: Operation,
    first: Manifold,
    second: Manifold,
    tolerance: float = EXACT,
) -> bool:
    """Whether a result is sound, and of a volume that the operation on two solids can give.

    An empty result is sound where nothing may be left; `is_lost` knows more. The tolerance is a
    share of the larger volume.
    """
    solids = (result, first, second)
    if any(solid.status().name != "NoError" for solid in solids):
        return False
    volume, one, other = (float(solid.volume()) for solid in solids)
    slack = tolerance * max(one, other)
    least, most = volumes_allowed(operation, one, other)
    # Written so that no number which is not one passes.
    return one >= 0.0 and other >= 0.0 and least - slack <= volume <= most + slack


def is_lost(solid: Implicit, box: Array, step: float) -> bool:
    """Whether a solid, of which nothing was found in a box (2, 3), is deep somewhere in it.

    Parameters
    ----------
    solid : Implicit
        What should be there.
    box : (2, 3) float array
        Where it can be at all.
    step : float
        Spacing of the meshes: what is thinner may be lost.
    """
    low, high = box
    if not (high > low).all():
        return False
    pitch = max(float((high - low).max()) / PROBES, 1e-300)
    axes = [
        a + (np.arange(n) + 0.5) * (c - a) / n
        for a, c, n in zip(low, high, np.ceil((high - low) / pitch).astype(int), strict=True)
    ]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return bool((solid.value(places) > DEEP * step).any())
