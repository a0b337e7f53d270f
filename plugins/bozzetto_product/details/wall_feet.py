"""Feet of walls between creases and corners: they slide along their course towards the mitres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import BSplineSurface
from bozzetto_product.details.levels import Level
from bozzetto_product.details.region import SAME_BREAK, OutlineEdge
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.zones import CreaseEdge

SLOPE: Final = 1e-5
"""Share of a run over which its slope at an end is taken."""


@dataclass(eq=False)
class Node:
    """A place where outlines or creases end.

    Parameters
    ----------
    place : (3,) float
        mm.
    ends : list of (CreaseEdge, float)
        Creases that end there, and at which of their parameters.
    at : dict
        Where it is on the floor of each zone, (2,).
    slides : dict
        On an outline: how far along it that is for each zone, as a parameter.
    """

    place: Array
    ends: list[tuple[CreaseEdge, float]] = field(default_factory=list)
    at: dict[int, Array] = field(default_factory=dict)
    slides: dict[int, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Run:
    """A part of an outline between creases and corners.

    Parameters
    ----------
    ring : int
    period : float
        Parameters of the ring.
    ends : (float, float)
        Its own; the second one may be beyond the period.
    slides : (float, float)
        How far along the outline the feet of its ends are moved, as parameters.
    feet : (Array or None, Array or None)
        Where these are on the floor, (2,); None where nothing moves them.
    """

    ring: int
    period: float
    ends: tuple[float, float]
    slides: tuple[float, float]
    feet: tuple[Array | None, Array | None]

    def slid(self, level: Level) -> Level:
        """Return a level on which the feet of walls slide towards those of the ends, evenly."""
        places = level.places
        assert places is not None
        if self.feet[0] is None and self.feet[1] is None:
            return level
        low, high = self.ends

        # At its end it is the run's own course that counts, not that behind the corner or crease.
        last = high - 1e-12 * max(1.0, high)

        def own(at: Array) -> Array:
            at = np.clip(at, low, last)
            return places(self.ring, np.where(at > self.period, at - self.period, at), None)

        step = SLOPE * (high - low)
        ends = np.array((low, high))
        borders = own(ends)
        slopes = (own(ends + np.array((step, -step))) - borders) / np.array([[step], [-step]])

        def moved(at: Array) -> Array:
            share = (at - low) / (high - low)
            to = at + (1.0 - share) * self.slides[0] + share * self.slides[1]
            found = own(np.clip(to, low, high))
            found += np.minimum(to - low, 0.0)[:, None] * slopes[0]
            return np.asarray(found + np.maximum(to - high, 0.0)[:, None] * slopes[1])

        # At a corner that what is behind it says counts, on both sides.
        corners = places(self.ring, np.where(ends >= self.period, ends - self.period, ends), None)
        rests = [
            (corners[k] if foot is None else foot) - moved(ends)[k]
            for k, foot in enumerate(self.feet)
        ]

        def slid(number: int, t: Array, over: BSplineSurface | None) -> Array:
            at = np.where(t < low - SAME_BREAK, t + self.period, t)
            share = ((at - low) / (high - low))[:, None]
            return np.asarray(moved(at) + (1.0 - share) * rests[0] + share * rests[1])

        return Level(level.floor, slid)


def run_of(
    edges: Sequence[OutlineEdge],
    rings: Sequence[Ring],
    nodes: Mapping[int, Node],
    zone: int,
    number: int,
) -> Run:
    """Return the run of an outline that an edge is part of."""
    ring = rings[edges[number].ring]
    own = [k for k, edge in enumerate(edges) if edge.ring == edges[number].ring]
    place = own.index(number)

    def ends(k: int) -> bool:
        at = _snapped(edges[k].start)
        return bool(nodes[k].at) or (at == round(at) and ring.turns[round(at)] != 0.0)

    first = next((k for k in (own[place - j] for j in range(len(own))) if ends(k)), None)
    if first is None:
        return Run(edges[number].ring, ring.end, (0.0, ring.end), (0.0, 0.0), (None, None))
    last = next(k for k in (own[(place + 1 + j) % len(own)] for j in range(len(own))) if ends(k))
    low, high = (_snapped(edges[k].start) for k in (first, last))
    high += ring.end if high <= low else 0.0
    return Run(
        edges[number].ring,
        ring.end,
        (low, high),
        (nodes[first].slides.get(zone, 0.0), nodes[last].slides.get(zone, 0.0)),
        (nodes[first].at.get(zone), nodes[last].at.get(zone)),
    )


def following(edges: Sequence[OutlineEdge], number: int) -> int:
    """Return the number of the edge that follows one on its outline."""
    ring = edges[number].ring
    if number + 1 < len(edges) and edges[number + 1].ring == ring:
        return number + 1
    return next(k for k, edge in enumerate(edges) if edge.ring == ring)


def _snapped(at: float) -> float:
    """Return a parameter at which a stretch begins, where it is one but for rounding."""
    return float(round(at)) if abs(at - round(at)) <= SAME_BREAK else at
