"""A template between two others: the ends and the tangents of every edge go from one to the other.

Both have the same network. Nodes go on straight lines. Of a tangent the direction goes, and the
logarithm of the length: so the ratio of the two tangents of a joint goes the same way, and surfaces
that are smooth in both templates are smooth in all between (`geometry.patches.locked`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto_car.template.model import Template


def can_blend(first: Template, second: Template) -> bool:
    """Whether two templates have the same network, nodes and edges in the same order."""
    return (
        first.names == second.names
        and first.edges.shape == second.edges.shape
        and bool((first.edges == second.edges).all())
        and [patch.edges for patch in first.patches] == [patch.edges for patch in second.patches]
    )


def blended(first: Template, second: Template, share: float) -> Template:
    """Return a template between two.

    Parameters
    ----------
    first : Template
        The template whose words, windows, lamps and rules it has.
    second : Template
        Another one with the same network; see `can_blend`.
    share : float
        How far to go from the first (0) to the second (1).

    Raises
    ------
    ValueError
        If the networks differ.
    """
    if not can_blend(first, second):
        raise ValueError(f"{first.id} and {second.id} have different networks")
    if share <= 0.0:
        return first
    return replace(
        first,
        id=f"{first.id}_{second.id}"[:40],
        positions=(1.0 - share) * first.positions + share * second.positions,
        tangents=_between(first.tangents, second.tangents, share),
        creases=first.creases | second.creases,
    )


def _between(first: Array, second: Array, share: float) -> Array:
    """Return vectors between others: directions by their mean, lengths by their logarithms."""
    lengths = [np.linalg.norm(one, axis=-1, keepdims=True) for one in (first, second)]
    one, other = (
        vectors / np.where(length > 0.0, length, 1.0)
        for vectors, length in zip((first, second), lengths, strict=True)
    )
    way = (1.0 - share) * one + share * other
    size = np.linalg.norm(way, axis=-1, keepdims=True)
    length = lengths[0] ** (1.0 - share) * lengths[1] ** share
    return np.asarray(way * (length / np.where(size > 0.0, size, 1.0)))
