"""The graph of strokes, and whether it is the one that was drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.segments import Drawn


def graph_of(strokes: Sequence[Drawn]) -> LineGraph:
    """Return lines and corners as the whole search finds them."""
    return searched(strokes).graph


def is_right(graph: LineGraph, places: Array, edges: Sequence[tuple[int, int]]) -> bool:
    """Whether corners and lines are those meant, each corner next to its own place (n, 2) px."""
    if len(graph.places) != len(places):
        return False
    nearest = corner_numbers(graph, places)
    if len(set(nearest.tolist())) != len(places):
        return False
    found = {tuple(sorted(pair)) for pair in nearest[graph.lines].tolist()}
    return found == {tuple(sorted(pair)) for pair in edges} and len(graph.lines) == len(edges)


def corner_numbers(graph: LineGraph, places: Array) -> Array:
    """Return of each corner the number of the place (n, 2), px, that is next to it, (k,)."""
    away = np.linalg.norm(graph.places[:, None] - places, axis=2)
    return np.asarray(away.argmin(axis=1))
