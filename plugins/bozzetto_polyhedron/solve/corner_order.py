"""The order of corners: it does not hang on that of strokes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto_polyhedron.graph.line_graph import LineGraph


def in_order(graph: LineGraph) -> LineGraph:
    """Return a graph with corners from left to right, whatever the order of its strokes.

    Searches for answers begin with numbers of corners: so they end alike, too.
    """
    if not len(graph.lines):
        return graph
    corners = np.lexsort(graph.places.round(6).T[::-1])
    numbers = np.empty(len(corners), np.intp)
    numbers[corners] = np.arange(len(corners))
    lines = np.sort(numbers[graph.lines], axis=1)
    rows = np.lexsort(lines.T[::-1])
    return replace(
        graph,
        places=graph.places[corners],
        lines=lines[rows],
        light=graph.light[rows],
        strokes=tuple(graph.strokes[row] for row in rows),
    )
