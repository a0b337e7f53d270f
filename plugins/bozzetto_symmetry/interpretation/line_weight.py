"""Depth order of two loops by the weight of their lines.

Two loops match in two senses, and each sense places them aslant in another way. As wholes they are
as far away in either, so it says nothing which of them was drawn first or more firmly. Within a
loop, other places are the nearer ones, and people who draw with line weight press harder there. A
hand also presses harder where it moves one way, as on strokes downwards, and slackens as it goes
on: what that explains as well says nothing here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.ink.sides import Side
from bozzetto_symmetry.stereo.correspondence import Pairing
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

INDEPENDENT: Final = 12.0
"""Figures that the pressure along two loops amounts to: it wanders over a sixth of a turn."""

ROUGH: Final = 0.004
"""Standard deviation of a pen's pressure, as a share of its mean, of which nothing is known."""

LEAD: Final = 0.06
"""Share of a stroke at either end where the pen is set down or lifted."""

BY_CHANCE: Final = 2.0
"""Logarithm of the odds between two matchings that a hand which draws without weight gives in one
drawing of ten."""

PRICE: Final = (0.12, 0.5)
"""Price of leaving weight unexplained that another matching explains, px over the logarithm of the
odds, and at most. Of hands of which half draw with a weight of 15 % and half without, a steeper
price spoke four times as often for the sense that is meant as against it; this one is lower, for
the sake of hands without."""


def weight_prices(
    stereo: Stereo, pairings: Sequence[Pairing], one: Side, other: Side
) -> tuple[float, ...]:
    """Return what each matching of two loops costs for the line weight that it leaves unexplained.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    pairings : sequence of Pairing
        Of loops.
    one, other : Side
        The loops.

    Returns
    -------
    tuple of float
        px, in the order of the matchings; all 0 where the pen told no pressure.
    """
    if one.pressure is None or other.pressure is None or not pairings:
        return (0.0,) * len(pairings)
    odds = [_odds(stereo, each, one, other) for each in pairings]
    share, most = PRICE
    return tuple(min(most, share * max(0.0, max(odds) - each - BY_CHANCE)) for each in odds)


def _odds(stereo: Stereo, pairing: Pairing, one: Side, other: Side) -> float:
    """Return the logarithm of the odds that what is nearer has more weight, at least 0."""
    points = stereo.intersected(pairing.near, pairing.far)
    tables = [
        _table(stereo, place, stations, side)
        for place, stations, side in (
            (points, pairing.stations, one),
            (points * MIRROR, pairing.far_stations, other),
        )
    ]
    first, second = (len(table) for table in tables)
    if min(first, second) < INDEPENDENT:
        return 0.0
    pressure, nearness, station, *ways = np.concatenate(tables).T
    of_first = np.repeat((1.0, 0.0), (first, second))
    both = np.column_stack((of_first, 1.0 - of_first))
    habit = np.column_stack((both, both * station[:, None], *ways))
    slope = _beside(nearness, habit)
    rest = _beside(pressure, habit)
    square = float(slope @ slope)
    along = float(slope @ rest)
    if not along > 0.0 or square <= 1e-12 * float(nearness @ nearness):
        return 0.0
    before = float(rest @ rest) + len(rest) * ROUGH**2
    return 0.5 * INDEPENDENT * float(-np.log1p(-(along**2) / square / before))


def _table(stereo: Stereo, points: Array, stations: Array, side: Side) -> Array:
    """Return pressure, nearness, station and both directions of the pen, of one loop, (k, 5)."""
    assert side.pressure is not None
    share = np.arange(len(side.pixels)) / len(side.pixels)
    ahead, back = np.roll(side.pixels, -1, axis=0), np.roll(side.pixels, 1, axis=0)
    way = (ahead - back) / np.maximum(np.linalg.norm(ahead - back, axis=1, keepdims=True), 1e-12)
    station = stations % 1.0
    columns = (side.pressure / max(float(side.pressure.mean()), 1e-12), *way.T)
    firm, *ways = (np.interp(station, share, column, period=1.0) for column in columns)
    nearness = -stereo.camera.project(points)[1]
    drawn = (station > LEAD) & (station < 1.0 - LEAD) & np.isfinite(nearness)
    rows = np.column_stack((firm, nearness, station, *ways))[drawn]
    if len(rows):
        rows[:, 1] -= rows[:, 1].mean()
    return rows


def _beside(values: Array, columns: Array) -> Array:
    """Return what columns (k, n) do not explain of values (k,)."""
    solved = np.linalg.lstsq(columns, values, rcond=None)[0]
    return np.asarray(values - columns @ solved)
