"""The edits of a curve, done in their order."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence

from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_symmetry.editing.join import close_up, join_across, join_curves
from bozzetto_symmetry.editing.oversketch import oversketch
from bozzetto_symmetry.editing.snap import snap_end
from bozzetto_symmetry.editing.trim import trim
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import (
    Curve,
    Edit,
    Joint,
    Modification,
    Snap,
    SymmetryState,
    Trim,
)
from bozzetto_symmetry.stereo.mirror_camera import Stereo

Solve = Callable[[Curve, SymmetryState], SpaceCurve | None]
"""The curve in space of another recipe; None where it has none yet."""


def apply_edits(
    curve: SpaceCurve, edits: Sequence[Edit], state: SymmetryState, solve: Solve
) -> tuple[SpaceCurve, tuple[str, ...]]:
    """Do all edits in order, leaving out those that do not fit the curve any more.

    Parameters
    ----------
    curve : SpaceCurve
        As it was drawn, in the frame of the centre plane.
    edits : sequence of Edit
        What was done to the curve since it was drawn.
    state : SymmetryState
        For its plane and for what pulls in a modification.
    solve : callable
        What the recipes of joined curves give.

    Returns
    -------
    curve : SpaceCurve
        The curve after its edits.
    warnings : tuple of str
        Why edits that no longer fit were left out.
    """
    warnings: list[str] = []
    for edit in edits:
        try:
            curve = apply_edit(curve, edit, state, solve)
        except UserError as problem:
            warnings.append(f"A change of the curve was left out. {problem.message}")
    return curve, tuple(dict.fromkeys(warnings))


def _depends_on(curve: SpaceCurve, edit: Edit, state: SymmetryState, solve: Solve) -> Hashable:
    return (
        curve, edit, state.plane, state.centre, state.size, state.forces,
    )  # fmt: skip


@remembered(limit=512, key=_depends_on)
def apply_edit(curve: SpaceCurve, edit: Edit, state: SymmetryState, solve: Solve) -> SpaceCurve:
    """Do one edit; remembered, so that one more costs no more than itself.

    Raises
    ------
    UserError
        If it does not fit the curve.
    """
    match edit:
        case Modification():
            return _modified(curve, edit, state)
        case Trim():
            return trim(curve, edit.begin, edit.end)
        case Snap():
            return snapped(curve, edit, state)
        case Joint():
            return _joined(curve, edit, state, solve)


def snapped(curve: SpaceCurve, snap: Snap, state: SymmetryState) -> SpaceCurve:
    """Return a curve, in the frame of the plane, with an end moved to a place of the model.

    Raises
    ------
    UserError
        If the curve has no such end.
    """
    frame = state.plane.inverse
    tangent = None if snap.tangent is None else frame.directions(snap.tangent)[0]
    return snap_end(curve, snap.end, frame.points(snap.point)[0], tangent)


def _modified(curve: SpaceCurve, edit: Modification, state: SymmetryState) -> SpaceCurve:
    if not len(edit.strokes):
        return curve
    return oversketch(
        curve,
        Stereo.of(edit.strokes[0].camera, state.plane),
        tuple(edit.strokes),
        mirrored=edit.mirrored,
        forces=state.forces,
    )


def _joined(curve: SpaceCurve, edit: Joint, state: SymmetryState, solve: Solve) -> SpaceCurve:
    if edit.other is None:
        return join_across(curve, edit.end) if edit.mirrored else close_up(curve)
    other = solve(edit.other, state)
    if other is None:
        raise UserError("The curve that was joined has only one side. Draw the other one, too.")
    return join_curves(curve, edit.end, other, edit.other_end, mirrored=edit.mirrored)
