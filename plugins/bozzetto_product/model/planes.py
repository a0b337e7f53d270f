"""Points and planes, as states keep them."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Plane:
    """A plane by one of its points and its unit normal; mm."""

    point: Point
    normal: Point
