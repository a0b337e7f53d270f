"""Snaps of the ends of a curve while it is drawn, and the axis that it runs along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto.plugin import Context
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.state import EndSnap, SymmetryState
from bozzetto_symmetry.operations.construction_lines import axis_of
from bozzetto_symmetry.operations.settling import end_snap_of, with_settled
from bozzetto_symmetry.operations.snap_candidates import snaps_of
from bozzetto_symmetry.operations.snap_targets import Targets, targets
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.solve.picking import solved_curves

STRAIGHT: Final = (1.5, 0.01)
"""How far (rms) a stroke may leave its chord that runs along an axis: px, or a share of the chord;
as bars across the plane may."""

LONGEST_DOT: Final = 40.0
"""Length of the chord, px, below which a stroke has no direction that counts."""

TOWARDS: Final = float(np.radians(2.5))
"""Angle to the direction of a vanishing point within which a stroke runs along the axis."""

ALONG_NORMAL: Final = 0.999
"""Cosine between an axis and the normal of the centre plane above which lines along the axis are
bars across the plane, which the reading itself makes straight."""

Axis = Literal[-1, 0, 1, 2]


def known_places(state: SymmetryState, context: Context, without: str = "") -> Targets:
    """Return what the pen can be caught by: all but one curve, the box, and other models.

    Parameters
    ----------
    state : SymmetryState
        Its curves, lines, box and plane.
    context : Context
        The curves of other models.
    without : str
        Id of a curve that does not count.
    """
    others = [curve for node, curve in solved_curves(state) if node.id != without]
    return targets(state, others, context)


def with_drawn_snaps(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state in which the chosen curve goes to what its ink was drawn to.

    All of it is found anew, for ink that comes later may make another curve of the first. A side
    that waits for the other one has no place in space yet, and snaps to nothing.

    Parameters
    ----------
    state : SymmetryState
        The chosen curve is the one that was just drawn.
    context : Context
        What is visible.
    """
    node = state.chosen
    if node is None:
        return state
    free = replace(node, end_snaps=(), axis=-1, edits=())
    try:
        trace = trace_of(free, state)
    except UserError:
        return state
    axis = -1 if node.canvas is not None else axis_drawn(tuple(node.strokes), state)
    if node.canvas is None:
        if axis != node.axis:
            state = state.with_node(replace(node, axis=axis))
        return with_settled(state, context, chosen=True)
    caught: tuple[EndSnap, ...] = ()
    if trace.curve is not None:
        known, camera = known_places(state, context, node.id), node.strokes[-1].camera
        snaps = snaps_of(trace.curve, trace.sigma, camera, known, state)
        found = [end_snap_of(snap, trace.curve, node, state) for snap in snaps]
        caught = tuple(snap for snap in found if snap is not None)
    if caught == node.end_snaps:
        return state
    return state.with_node(replace(node, end_snaps=caught))


def axis_drawn(strokes: Sequence[Stroke], state: SymmetryState) -> Axis:
    """Return the axis of the box that all strokes run along, straight; -1 if there is none."""
    found = {_axis_of(stroke) for stroke in strokes}
    if len(found) != 1:
        return -1
    (axis,) = found
    along_normal = axis >= 0 and abs(float(AXES[axis] @ state.plane.normal)) > ALONG_NORMAL
    return -1 if along_normal else axis


def _axis_of(stroke: Stroke) -> Axis:
    begin, end = stroke.points[0], stroke.points[-1]
    length = float(np.linalg.norm(end - begin))
    if length < LONGEST_DOT:
        return -1
    off = distances_to_polyline(stroke.points, np.stack((begin, end)))
    if np.sqrt(np.mean(off**2)) > max(STRAIGHT[0], STRAIGHT[1] * length):
        return -1
    axis = axis_of(begin, end, stroke.camera, TOWARDS)
    return (0, 1, 2)[axis] if axis is not None else -1
