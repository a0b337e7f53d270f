"""The curves of what is round in a drawing, and names for them that do not hang on their order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import distances_to_polyline
from bozzetto_polyhedron.rounds.ellipses import TURN
from bozzetto_polyhedron.rounds.round_things import Reading

SAMPLES: Final = 73
"""Points of an ellipse."""

NEAR: Final = 0.05
"""Distance from a place to a curve, in diagonals, beyond which that curve is gone."""


@dataclass(frozen=True, eq=False)
class RoundCurve:
    """A rim, or one of the two arcs of a rounded corner, as it was drawn.

    Parameters
    ----------
    number : int
        Of the rim, or of the bend counted on from the rims; both rims of a cylinder have that of
        the near one.
    strokes : frozenset of int
        All of what is round with it: both rims of a cylinder and its sides, or both arcs.
    drawn : (n, 2) float64
        px.
    """

    number: int
    strokes: frozenset[int]
    drawn: Array


def curves_of(reading: Reading) -> list[RoundCurve]:
    """Return every curve that was understood as round."""
    owners = {number: barrel for barrel in reading.barrels for number in (barrel.near, barrel.far)}
    turn = np.linspace(0.0, TURN, SAMPLES)
    made = []
    for number, rim in enumerate(reading.rims):
        own, name = set(rim.strokes), number
        if number in owners:
            barrel = owners[number]
            own |= {*reading.rims[barrel.near].strokes, *reading.rims[barrel.far].strokes}
            own |= set(barrel.tangents)
            name = barrel.near
        made.append(RoundCurve(name, frozenset(own), rim.ellipse.at(turn)))
    for number, bend in enumerate(reading.bends, len(reading.rims)):
        for shift in (np.zeros(2), bend.shift):
            made.append(RoundCurve(number, frozenset(bend.strokes), bend.arc + shift))
    return made


def name_of(curve: RoundCurve, reading: Reading) -> Array:
    """Return the place on a curve that is farthest from all others, (2,) px: it names the curve."""
    away = np.full(len(curve.drawn), np.inf)
    for other in curves_of(reading):
        if other.number != curve.number:
            away = np.minimum(away, distances_to_polyline(curve.drawn, other.drawn))
    return np.asarray(curve.drawn[int(np.argmax(away))])


def number_at(reading: Reading, place: Array) -> int | None:
    """Return the number of the curve that runs through a place, px, if there still is one."""
    curves = curves_of(reading)
    away = [
        float(distances_to_polyline(np.reshape(place, (1, 2)), each.drawn)[0]) for each in curves
    ]
    if not away or min(away) > NEAR * reading.size:
        return None
    return curves[int(np.argmin(away))].number
