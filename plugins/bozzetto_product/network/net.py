"""Curves cut at their joints: nodes and edges."""

from __future__ import annotations

from dataclasses import dataclass

from bozzetto.arrays import Array
from bozzetto.geometry import Spline


@dataclass(frozen=True, eq=False)
class ToldNormals:
    """Normals of the surface along an edge that are known and need not be found.

    Parameters
    ----------
    parameters : (m,) float
        Of the edge's spline, rising, over its range.
    normals : (m, 3) float
        Unit, to any side.
    """

    parameters: Array
    normals: Array


@dataclass(frozen=True, eq=False)
class Edge:
    """A piece of a curve between two joints that follow one another.

    Parameters
    ----------
    spline : Spline
        Clamped, in space; it begins and ends in the very numbers of its nodes. Only an edge
        without a joint is a closed spline.
    start, end : int
        Numbers of nodes; -1 for a closed edge without a joint.
    curve : str
        Id of the curve.
    piece : int
        Which piece of the curve, from 0.
    mirrored : bool
        It is a piece of the curve's mirror image.
    twin : int
        Number of the edge that is its mirror image, exactly; its own where it lies in the plane
        or is symmetric by itself; -1 for none.
    crease : float
        0 is smooth, 1 a crease; NaN where the network decides.
    span : (float, float)
        The shares of the curve's parameter range over which it goes; of a mirror image, those of
        the curve.
    normals : ToldNormals, optional
        Of a surface that it lies on.
    """

    spline: Spline
    start: int
    end: int
    curve: str
    piece: int = 0
    mirrored: bool = False
    twin: int = -1
    crease: float = float("nan")
    span: tuple[float, float] = (0.0, 1.0)
    normals: ToldNormals | None = None


@dataclass(frozen=True, eq=False)
class Net:
    """Edges between nodes.

    Parameters
    ----------
    nodes : (n, 3) float64
        mm.
    edges : tuple of Edge
    joints : tuple of (str, bool)
        For each node the id of its joint, and whether it is the mirror image of that joint; the id
        is "" at a free end.
    images : tuple of int
        For each node the number of its mirror image, its own in the plane; -1 for none.
    """

    nodes: Array
    edges: tuple[Edge, ...]
    joints: tuple[tuple[str, bool], ...] = ()
    images: tuple[int, ...] = ()


HalfEdge = tuple[int, bool]
"""Number of an edge, and whether it is walked from its start to its end."""

Loop = tuple[HalfEdge, ...]
"""Head to tail: the outline of a surface, and those of holes in it behind; see `outlines`."""
