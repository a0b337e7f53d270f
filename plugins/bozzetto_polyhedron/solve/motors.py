"""Motors that begin where things are: on what has moved, or with another course meanwhile."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto_polyhedron.mechanism.assembly import ANGLE, Motion
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.fittings import Driven
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.moving import Moving

APART: Final = 1e-3
"""Distance from its course, rad or by extent, from which on a motor begins anew."""


def with_motors_begun(state: PolyhedronState, made: Moving, motion: Motion) -> PolyhedronState:
    """Return a state in which every motor is on its course; the same where all are.

    One that is elsewhere begins now, from where it is: a steady one goes on from there, others come
    to their course smoothly.
    """
    joints = made.machine.assembly.joints
    gaps = made.stepper.gaps(motion)
    chosen = state.selected
    for row, drive in joints.drives:
        turns = bool(joints.kind[row] == ANGLE)
        unit, scale = (float(np.radians(1.0)), 1.0) if turns else (METRE, made.extent * METRE)
        if abs(gaps[row]) <= APART * scale:
            continue
        offset = drive.at(motion.time) + float(gaps[row]) - drive.course.at(0.0)
        if turns:
            offset = (offset + np.pi) % (2.0 * np.pi) - np.pi
        fitting: Driven = state.node(drive.owner)
        state = state.with_node(replace(fitting, since=float(motion.time), offset=offset / unit))
    return state if state.selected == chosen else replace(state, selected=chosen)
