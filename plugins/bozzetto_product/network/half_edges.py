"""Half-edges by number, and their mirror images.

A half-edge, an edge walked one way, has a number: twice that of the edge, plus one where it is
walked from end to start. The same edge the other way is ``h ^ 1``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Index
from bozzetto_product.network.net import Loop, Net


def half_edges(loop: Loop) -> tuple[int, ...]:
    """Return the numbers of a loop's half-edges."""
    return tuple(2 * edge + (not forward) for edge, forward in loop)


def loop_of_half_edges(numbers: Sequence[int]) -> Loop:
    """Return a loop by the numbers of its half-edges."""
    return tuple((int(half) // 2, int(half) % 2 == 0) for half in numbers)


def half_edge_images(net: Net) -> Index:
    """Return the number of each half-edge's mirror image; -1 for none.

    Parameters
    ----------
    net : Net
        Of m edges.

    Returns
    -------
    (2m,) int
    """
    images = np.full(2 * len(net.edges), -1)
    for number, edge in enumerate(net.edges):
        if edge.twin >= 0:
            twin = net.edges[edge.twin]
            same = edge.mirrored or twin.mirrored or edge.start == edge.end or not net.images
            back = not same and net.images[edge.start] != twin.start
            images[2 * number : 2 * number + 2] = 2 * edge.twin + np.array([back, not back])
    return images
