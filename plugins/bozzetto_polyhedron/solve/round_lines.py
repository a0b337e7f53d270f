"""Rims and arcs of a drawing where they are seen: on its sheet, and on the solid that it became."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.model.same_view import camera_of, on_sheet
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.rounds.ellipses import TURN
from bozzetto_polyhedron.rounds.round_things import Reading
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solve.pipeline import Solved

SAMPLES: Final = 73
"""Points of an ellipse."""

ON_CURVE: Final = 0.03
"""Distance of a vertex from a curve as it was drawn, in diagonals, within which it lies on it."""


@dataclass(frozen=True, eq=False)
class RoundLine:
    """A rim, or an arc.

    Parameters
    ----------
    strokes : frozenset of int
        All of what is round with it: both rims of a cylinder and its sides, or both arcs.
    drawn : (n, 2) float64
        In the drawing, px.
    points : (m, 3) float64
        Where it is now, mm in the frame of the model; empty where nothing came of it.
    """

    strokes: frozenset[int]
    drawn: Array
    points: Array


def round_lines(body: Body, found: Solved) -> list[RoundLine]:
    """Return what of a drawing was understood as round."""
    reading = straightened(body.strokes, body.evidence).reading
    if reading is None:
        return []
    return [
        RoundLine(strokes, curve, _places(body, found, curve, ON_CURVE * reading.size))
        for strokes, curve in _curves(reading)
    ]


def is_column(body: Body) -> bool:
    """Whether a drawing has nothing but cylinders: its lines are the box about the largest one."""
    return straightened(body.strokes, body.evidence).column is not None


def _curves(reading: Reading) -> Iterator[tuple[frozenset[int], Array]]:
    """Yield every curve, px, with the strokes of all that is round with it."""
    owners = {number: barrel for barrel in reading.barrels for number in (barrel.near, barrel.far)}
    turn = np.linspace(0.0, TURN, SAMPLES)
    for number, rim in enumerate(reading.rims):
        own = set(rim.strokes)
        if number in owners:
            barrel = owners[number]
            own |= {*reading.rims[barrel.near].strokes, *reading.rims[barrel.far].strokes}
            own |= set(barrel.tangents)
        yield frozenset(own), rim.ellipse.at(turn)
    for bend in reading.bends:
        for shift in (np.zeros(2), bend.shift):
            yield frozenset(bend.strokes), bend.arc + shift


def _places(body: Body, found: Solved, curve: Array, reach: float) -> Array:
    """Return the vertices that lie on a curve as it was drawn, in the order of the curve."""
    if body.choice is None or found.body is None:
        return on_sheet(body, curve)
    vertices = found.body.vertices
    seen = camera_of(body).project(body.placement.inverse().points(vertices))[0]
    away = np.linalg.norm(seen[:, None] - curve, axis=2)
    straight = np.zeros(len(vertices), bool)
    if found.base is not None:
        gaps = np.linalg.norm(vertices[:, None] - found.base.vertices, axis=2)
        straight = gaps.min(axis=1) <= 1e-9 * float(np.ptp(vertices, axis=0).max())
    near = np.flatnonzero((away.min(axis=1) <= reach) & ~straight)
    ordered = near[np.argsort(away[near].argmin(axis=1), kind="stable")]
    return vertices[[*ordered, *ordered[: 1 if np.allclose(curve[0], curve[-1]) else 0]]]
