"""Grouping of nodes: the connected pieces of a graph."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Faces, Index


def connected_pieces(one: Index | Faces, other: Index | Faces, count: int) -> tuple[int, Faces]:
    """Find the connected pieces of an undirected graph, and number them.

    Parameters
    ----------
    one, other : (e,) int array
        Both ends of each edge; an edge may occur more than once.
    count : int
        Number of nodes; a node without edges is a piece of its own.

    Returns
    -------
    pieces : int
        How many there are.
    number : (count,) int array
        Of the piece that each node is in.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one), np.int32), (one, other)), shape=(count, count))
    pieces, number = connected_components(graph, directed=False)
    return int(pieces), number
