"""The border of a drawing, inside which all hidden lines of a solid are seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection, FillRule

from bozzetto.arrays import Array
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.planar_faces import inside


@dataclass(frozen=True, eq=False)
class Outline:
    """Outer borders of what lines enclose.

    Parameters
    ----------
    rings : tuple of (k, 2) array
        Polygons, diagonals.
    """

    rings: tuple[Array, ...]

    def covers(self, place: Array) -> bool:
        """Whether a place (2,) is inside."""
        return bool(self.cover(place[None]).any())

    def cover(self, places: Array) -> Array:
        """Whether places (n, 2) are inside, (n,) of bool."""
        found = np.zeros(len(places), bool)
        for ring in self.rings:
            found |= inside(places, ring)
        return found


def outline_of(drawing: Drawing, reach: float) -> Outline:
    """Return the border of a drawing: gaps up to twice the reach are closed.

    Parameters
    ----------
    drawing : Drawing
        Visible lines.
    reach : float
        By which the border lies outside the lines, diagonals.
    """
    ends = drawing.points[drawing.lines]
    spans = ends[:, 1] - ends[:, 0]
    along = reach * spans / np.maximum(np.linalg.norm(spans, axis=1), 1e-12)[:, None]
    beside = along[:, ::-1] * (-1.0, 1.0)
    strips = np.stack(
        (
            ends[:, 0] - along - beside,
            ends[:, 1] + along - beside,
            ends[:, 1] + along + beside,
            ends[:, 0] - along + beside,
        ),
        axis=1,
    )
    joined = CrossSection(list(strips), FillRule.NonZero)
    rings = [np.asarray(ring) for ring in joined.to_polygons()]
    return Outline(tuple(ring for ring in rings if _area(ring) > 0.0))


def _area(ring: Array) -> float:
    following = np.roll(ring, -1, axis=0)
    return float((ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0]).sum() / 2.0)
