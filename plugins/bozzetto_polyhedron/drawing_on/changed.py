"""A body with all that was drawn on it: planes, circles among them, and lines that are left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.drawing_on.circles import Circle
from bozzetto_polyhedron.solid.planar_body import PlanarBody


def _no_points() -> Array:
    return np.zeros((0, 3))


def _no_lines() -> Index:
    return np.zeros((0, 2), np.intp)


@dataclass(frozen=True, eq=False)
class Changed:
    """A body after what was done to it.

    Parameters
    ----------
    body : PlanarBody
        Circles are polygons in it.
    circles : tuple of Circle
        Those polygons' circles: what is left of their cylinders is found by their planes.
    points : (k, 3) float64
        Ends of lines that bound no volume yet, mm.
    lines : (m, 2) intp
        Their numbers.
    sheet : PlanarBody, optional
        Faces that those lines bound.
    joined : tuple of str
        Ids of other bodies that became part of it.
    told : tuple of str
        What a person must know.
    """

    body: PlanarBody
    circles: tuple[Circle, ...] = ()
    points: Array = field(default_factory=_no_points)
    lines: Index = field(default_factory=_no_lines)
    sheet: PlanarBody | None = None
    joined: tuple[str, ...] = ()
    told: tuple[str, ...] = ()

    def mapped(
        self,
        of_body: Callable[[PlanarBody], PlanarBody],
        of_points: Callable[[Array], Array],
        scale: float = 1.0,
    ) -> Changed:
        """Return the same elsewhere: turned, moved, mirrored, or of another size.

        Parameters
        ----------
        of_body, of_points : callable
            Where the motion takes a body, and points (n, 3).
        scale : float
            How much larger it becomes.
        """
        return replace(
            self,
            body=of_body(self.body),
            circles=tuple(_mapped(circle, of_points, scale) for circle in self.circles),
            points=of_points(self.points) if len(self.points) else self.points,
            sheet=None if self.sheet is None else of_body(self.sheet),
        )


def _mapped(circle: Circle, of_points: Callable[[Array], Array], scale: float) -> Circle:
    center, tip = of_points(np.stack((circle.center, circle.center + circle.radius * circle.axis)))
    axis = tip - center
    return replace(
        circle,
        center=center,
        axis=np.asarray(axis / np.linalg.norm(axis)),
        radius=scale * circle.radius,
    )
