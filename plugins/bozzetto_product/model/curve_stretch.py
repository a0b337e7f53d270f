"""Parts of a curve over which surfaces meet in a way of their own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

from bozzetto_product.model.curves import CREASES, Curve, Stretch

LAPS: Final = (-1.0, 0.0, 1.0)
"""Rounds of a closed curve by which a stretch over its seam is met."""

SHORTEST: Final = 1e-9
"""Least share of a curve that is a stretch."""


def crease_over(curve: Curve, low: float, high: float) -> float:
    """Return the crease of a piece of a curve: 0 to 1, NaN where the network decides.

    Parameters
    ----------
    curve : Curve
        Whose stretches count; where none is over the middle of the piece, its own kind of edge.
    low, high : float
        The shares of its parameter range between which the piece lies.
    """
    middle = 0.5 * (low + high)
    for one in curve.stretches:
        if any(one.low < middle + lap < one.high for lap in LAPS):
            return CREASES.get(one.edge, one.crease)
    return CREASES.get(curve.edge, curve.crease)


def with_stretch(curve: Curve, low: float, high: float, chosen: Stretch | None) -> Curve:
    """Return a curve of which a piece has an edge of its own, or again that of the whole.

    Parameters
    ----------
    curve : Curve
        The curve.
    low, high : float
        The shares of its parameter range between which the piece lies.
    chosen : Stretch, optional
        How surfaces meet there; None is as over the whole curve.
    """
    rest = list(_without(curve.stretches, low, high))
    if chosen is not None:
        rest.append(replace(chosen, low=low, high=high))
    return replace(curve, stretches=tuple(sorted(rest, key=lambda one: one.low)))


def _without(stretches: Iterable[Stretch], low: float, high: float) -> Iterator[Stretch]:
    """Yield what is left of stretches outside a piece of their curve."""
    for one in stretches:
        parts = [(one.low, one.high)]
        for lap in LAPS:
            parts = [
                piece
                for begin, end in parts
                for piece in ((begin, min(end, low + lap)), (max(begin, high + lap), end))
            ]
            parts = [(begin, end) for begin, end in parts if end - begin > SHORTEST]
        yield from (replace(one, low=begin, high=end) for begin, end in parts)


def stretches_within(
    stretches: Iterable[Stretch], low: float, high: float, onto: tuple[float, float] = (0.0, 1.0)
) -> tuple[Stretch, ...]:
    """Return the stretches over a part of a curve, as those of another curve.

    Parameters
    ----------
    stretches : iterable of Stretch
        Of the curve.
    low, high : float
        The shares of its parameter range between which the part lies.
    onto : (float, float)
        The shares at which the part begins and ends on the other curve; the greater one first where
        that runs the other way.
    """
    begin, end = onto
    found = []
    for one in stretches:
        for lap in LAPS:
            first, last = max(one.low + lap, low), min(one.high + lap, high)
            if last - first <= SHORTEST:
                continue
            ends = [begin + (at - low) / (high - low) * (end - begin) for at in (first, last)]
            found.append(replace(one, low=min(ends), high=max(ends)))
    return tuple(sorted(found, key=lambda one: one.low))
