"""The free ends of curves in space, and their joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto_symmetry.editing.edit_sequence import apply_edit
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, Edit, Joint, SymmetryState
from bozzetto_symmetry.solve.curve_solver import solve_curve
from bozzetto_symmetry.solve.picking import solved_curves
from bozzetto_symmetry.stereo.mirror_camera import MIRROR


@dataclass(frozen=True, eq=False)
class End:
    """A free end of a curve or of its mirror image.

    Attributes
    ----------
    node : Curve
    curve : SpaceCurve
    number : {0, 1}
        As the edits count: of a curve across the plane it is 1.
    mirrored : bool
        It is the mirror image of that end.
    point : (3,) float
        In the frame of the centre plane, mm.
    """

    node: Curve
    curve: SpaceCurve
    number: int
    mirrored: bool
    point: Array


def ends_of(curves: Sequence[tuple[Curve, SpaceCurve]]) -> list[End]:
    """Return all free ends of some curves and their mirror images; a closed curve has none."""
    found = []
    for node, curve in curves:
        if curve.closed:
            continue
        for number in (1,) if curve.reading == "self" else (0, 1):
            point = curve.spline.value([curve.spline.range[number]])[0]
            for mirrored in (False,) if curve.reading == "plane" else (False, True):
                place = point * MIRROR if mirrored else point
                found.append(End(node, curve, number, mirrored, place))
    return found


def nearest_end(end: End, others: Sequence[End]) -> tuple[End, float] | None:
    """Return the end in space that is nearest to another, and how far away it is, mm.

    Its own place does not count, nor what could not be joined: the other end of the image
    of its own curve.
    """
    away = [
        (float(np.linalg.norm(other.point - end.point)), number)
        for number, other in enumerate(others)
        if _can_meet(end, other)
    ]
    if not away:
        return None
    least, number = min(away)
    return others[number], least


def _can_meet(one: End, other: End) -> bool:
    if one.node.id != other.node.id:
        return True
    return (one.number == other.number) != (one.mirrored == other.mirrored)


def with_edit(state: SymmetryState, node: Curve, curve: SpaceCurve, edit: Edit) -> SymmetryState:
    """Return the state in which one more edit is done to a curve.

    Raises
    ------
    UserError
        If the edit does not fit the curve.
    """
    apply_edit(curve, edit, state, solve_curve)
    return state.with_node(replace(node, edits=(*node.edits, edit)))


def with_nearest_joined(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state in which the chosen curve is joined to the end nearest to its own.

    Raises
    ------
    UserError
        If no curve with an end is chosen, or there is no other end.
    """
    ends = ends_of(solved_curves(state))
    own = [end for end in ends if end.node.id == state.selected and not end.mirrored]
    if not own:
        raise UserError("Choose the curve whose end is to be joined. A closed curve has none.")
    found = [(met[1], k, met[0]) for k, end in enumerate(own) if (met := nearest_end(end, ends))]
    if not found:
        raise UserError("There is no other end to join. Draw another curve first.")
    _, number, other = min(found, key=lambda entry: entry[:2])
    return with_joint(state, own[number], other)


def with_joint(state: SymmetryState, first: End, second: End) -> SymmetryState:
    """Return the state in which two ends are one place of one curve.

    Two curves become the first one. Both ends of a curve close it; an end and its mirror
    image make a curve across the plane.

    Raises
    ------
    UserError
        If these ends cannot be joined.
    """
    if first.node.id == second.node.id:
        if not _can_meet(first, second):
            raise UserError("These are ends of one curve that cannot meet. Join other ends.")
        across = first.mirrored != second.mirrored
        joint = Joint(first.number, None, second.number, mirrored=across)
        return with_edit(state, first.node, first.curve, joint)
    across = first.mirrored != second.mirrored
    joint = Joint(first.number, second.node, second.number, mirrored=across)
    made = with_edit(state, first.node, first.curve, joint)
    return replace(made.without_nodes(second.node.id), selected=first.node.id)
