"""Tension and compression of bars, links and springs where everything is now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.mechanism.analysis import Balance, balance_of
from bozzetto_polyhedron.mechanism.assembly import DISTANCE, Motion
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.mechanism.springs import tensions
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.moving import Moving

MOST_ROWS: Final = 900
"""Rows of joints of which forces are worked out: more would make everybody wait."""

BALANCED: Final = 0.02
"""Share of the largest load that may be left where a pose counts as balanced."""


@dataclass(frozen=True, eq=False)
class BarForces:
    """Forces along bars.

    Parameters
    ----------
    ends : (k, 2, 3) float64
        Where the bars are now, mm.
    newtons : (k,) float64
        Positive for a bar that is pulled.
    balanced : bool
        Whether it would stay at rest in this pose.
    """

    ends: Array
    newtons: Array
    balanced: bool


def forces_of(state: PolyhedronState, made: Moving) -> BarForces | None:
    """Return the forces in all bars, at rest in this pose; None where there are too many."""
    assembly, motion = made.machine.assembly, made.motion(state.moved)
    if len(assembly.joints) > MOST_ROWS:
        return None
    balance = balance_of(assembly, motion, made.stepper.loads(motion))
    ends, newtons = _links(made, motion, balance)
    for number, bars in enumerate(made.machine.bars):
        places = made.machine.moved(number, motion)
        for edge, piece in zip(made.machine.shapes[number].edges, bars, strict=False):
            ends.append(places[edge])
            newtons.append(_axial(made, motion, balance, int(piece), places[edge]))
    springs = assembly.springs
    for k, pull in enumerate(tensions(springs, motion)):
        one = _place(motion, int(springs.first[k]), springs.first_point[k])
        ends.append(
            np.stack((one, _place(motion, int(springs.second[k]), springs.second_point[k])))
        )
        newtons.append(float(pull))
    return BarForces(
        np.reshape(np.array(ends, float), (-1, 2, 3)),
        np.array(newtons, float),
        balance.left < BALANCED,
    )


def _links(made: Moving, motion: Motion, balance: Balance) -> tuple[list[Array], list[float]]:
    """Return massless bars: one row each."""
    joints = made.machine.assembly.joints
    ends: list[Array] = []
    newtons: list[float] = []
    for row in np.flatnonzero(joints.kind == DISTANCE):
        one = _place(motion, int(joints.first[row]), joints.first_point[row])
        other = _place(motion, int(joints.second[row]), joints.second_point[row])
        ends.append(np.stack((one, other)))
        newtons.append(-float(balance.rows[row]))
    return ends, newtons


def _axial(made: Moving, motion: Motion, balance: Balance, piece: int, ends: Array) -> float:
    """Return the tension in the middle of a rigid bar, from what its joints do to both halves."""
    joints = made.machine.assembly.joints
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    total = 0.0
    for bodies, points, given in (
        (joints.first, joints.first_point, balance.on_first),
        (joints.second, joints.second_point, balance.on_second),
    ):
        rows = np.flatnonzero(bodies == piece)
        sides = np.sign((points[rows] @ motion.turns[piece].T) @ along)
        total += 0.5 * float(sides @ (given[rows, :3] @ along))
    return total


def _place(motion: Motion, body: int, point: Array) -> Array:
    """Return where a point of a body is, (3,) mm; one of the ground where it stands."""
    if body < 0:
        return np.asarray(point / METRE)
    return np.asarray((motion.places[body] + motion.turns[body] @ point) / METRE)
