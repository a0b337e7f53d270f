"""How likely lines and corners are those that were meant.

The likeliest draft need not be the right one: where two corners are hardly farther apart than the
hand is unsteady, or another way to join lines costs little more, it is wrong more often. A logistic
regression over such traits tells how often; its numbers are in `certainty_numbers`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.certainty_numbers import LOG_ODDS, TRAITS
from bozzetto_polyhedron.graph.draft import CROWDED, Draft
from bozzetto_polyhedron.graph.likelihood import strain_of
from bozzetto_polyhedron.graph.line_graph import LineGraph

COST: Final = 5.0
"""Cost of other lines in units of which it counts: a trait of its inverse hyperbolic sine."""

FARTHEST: Final = 1.0
"""Distance of corners that have no other beside them, diagonals."""


def line_traits(graph: LineGraph, draft: Draft, cost: float, size: float) -> Array:
    """Return what tells how likely lines are right, (len(TRAITS),).

    Parameters
    ----------
    graph : LineGraph
        Handed over from the draft, with what looks wrong about it.
    draft : Draft
        Of at least one line.
    cost : float
        By which the closest other lines are worse, nats; infinite where there are none.
    size : float
        Diagonal of the drawing, px.
    """
    places, noise = graph.places / size, graph.noise / size
    kinds = {each.what for each in graph.health}
    strains = np.array(
        [strain_of(draft.sums[k]) / max(1, 2 * draft.degrees[k] - 2) for k in draft.sums]
    )
    return np.array(
        (
            float(np.arcsinh(min(cost, 1e6) / COST)),
            float(sum(degree >= CROWDED for degree in draft.degrees.values())),
            float(np.log(closest_corners(places) / noise)),
            float(np.log(closest_to_lines(places, graph.lines) / noise)),
            float(np.log(max(1, len(graph.lines)))),
            noise,
            float(np.log(max(float(strains.max()), 1e-3) / max(float(strains.mean()), 1e-3))),
            float(not draft.is_whole),
            float("second reading" in kinds),
            float(bool(kinds - {"second reading"})),
        )
    )


def certainty_of(traits: Array) -> float:
    """Return the probability that lines are right from their traits, (len(TRAITS),)."""
    low, high, weights = np.array(list(TRAITS.values())).T
    odds = LOG_ODDS + float(weights @ np.clip(traits, low, high))
    return float(1.0 / (1.0 + np.exp(-odds)))


def _closest(away: Array) -> float:
    return max(1e-6, float(away.min(initial=FARTHEST)))


def closest_corners(places: Array) -> float:
    """Return the least distance of two corners, (n, 2), at most `FARTHEST`."""
    away = np.linalg.norm(places[:, None] - places, axis=2)
    np.fill_diagonal(away, FARTHEST)
    return _closest(np.asarray(away))


def closest_to_lines(places: Array, lines: Index) -> float:
    """Return the least distance of a corner from a line that does not end there."""
    start, span = places[lines[:, 0]], places[lines[:, 1]] - places[lines[:, 0]]
    square = np.maximum((span**2).sum(1), 1e-12)
    share = np.clip(((places[:, None] - start) * span).sum(2) / square, 0.0, 1.0)
    away = np.linalg.norm(places[:, None] - start - share[..., None] * span, axis=2)
    own: Flags = (np.arange(len(places))[:, None, None] == lines).any(2)
    return _closest(np.where(own, FARTHEST, away))
