"""One way to read a drawing."""

from __future__ import annotations

from dataclasses import dataclass

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.planar_embedding import Ring

Rings = tuple[Ring, ...]
"""Of a face: its outer ring, then its holes."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Corners in space and the faces between them, as the drawing says, not yet exact.

    Parameters
    ----------
    vertices : (n, 3) float64
        One for each corner of the graph, in its order; mm, in the frame of the drawing's camera.
    faces : tuple of Rings
        Outer rings counter-clockwise seen from outside, holes the other way round.
    confidence : float
        Probability that this is the right one, 0 … 1, calibrated.
    residual : float
        Root mean square distance of the projected vertices from the corners, px.
    closed : bool
        Whether every line lies between two faces.
    warnings : tuple of str
        What a person should know, such as a view in which two axes lie on one another.
    """

    vertices: Array
    faces: tuple[Rings, ...]
    confidence: float
    residual: float
    closed: bool
    warnings: tuple[str, ...] = ()
