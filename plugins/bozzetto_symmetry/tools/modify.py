"""Modify: a stroke over a curve bends it, in any view, together with its mirror image."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes, distances_to_polyline, is_one_view, on_canvas
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Scene
from bozzetto_symmetry.editing.edit_sequence import apply_edit
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, Edit, Modification, SymmetryState
from bozzetto_symmetry.solve.curve_solver import solve_curve
from bozzetto_symmetry.solve.picking import Seen, seen_curves, target_of
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from bozzetto_symmetry.tools.erase import ErasingTool
from bozzetto_symmetry.view.scene import curve_lines

WIDTH: Final = 2.5
"""Width of the previewed curve, px."""

SETTLES: Final = 14.0
"""Mean distance, px, within which a stroke goes with the ones drawn just before: the curve
settles between them. One drawn farther away overrules them."""

_NOTHING: Final = "There is no curve near the stroke. Draw over the curve that is to change."


class Modify(ErasingTool):
    """Bends the nearest curve towards what is drawn over it, or over its mirror image.

    Each stroke acts at once on the curve as it stands. Strokes close to the ones before act
    together with them, and the firmer ones count for more.
    """

    id = "modify"
    title = "Modify"
    icon = "icons/modify.svg"
    hint = "Draw over a curve where it is to run; press harder to pull it closer."

    @override
    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return the curve that would come."""
        if not isinstance(gesture, Ink):
            return Scene()
        stroke = gesture.strokes[-1]
        _, curve = _changed(state, stroke)
        camera = Stereo.of(stroke.camera, state.plane).camera
        # It replaces the heat band, which belongs to the curve as it is.
        return Scene((Layer("heat", curve_lines(curve, state, camera, "accent", WIDTH)),))

    @override
    def draw(self, state: SymmetryState, ink: Ink, context: Context) -> SymmetryState:
        """Bend the curves that the strokes are drawn over.

        Raises
        ------
        UserError
            If there is no curve near a stroke, or the view says too little about it.
        """
        for stroke in ink.strokes:
            node, _ = _changed(state, stroke)
            state = state.with_node(node)
        return state


def _changed(state: SymmetryState, stroke: Stroke) -> tuple[Curve, SpaceCurve]:
    """Return the curve that a stroke is drawn over, and what the stroke makes of it."""
    target = target_of(seen_curves(state, stroke.camera), stroke.points, state.selected)
    if target is None:
        raise UserError(_NOTHING)
    before, change = _modification(target, stroke)
    base = replace(target.node, edits=before)
    start = target.curve if before == target.node.edits else solve_curve(base, state)
    assert start is not None  # no edit makes a curve wait again
    curve = apply_edit(start, change, state, solve_curve)
    return replace(base, edits=(*before, change)), curve


def _modification(target: Seen, stroke: Stroke) -> tuple[tuple[Edit, ...], Modification]:
    """Return the edits before, and the change: the last one with this stroke, or a new one."""
    edits = target.node.edits
    alone = Modification(Strokes((stroke,)), target.mirrored)
    if not edits or not isinstance(edits[-1], Modification):
        return edits, alone
    last = edits[-1]
    canvas = last.strokes[0].camera
    if last.mirrored != target.mirrored or not is_one_view(stroke.camera, canvas):
        return edits, alone
    stroke = on_canvas(stroke, canvas)
    away = min(
        float(np.mean(distances_to_polyline(stroke.points, one.points))) for one in last.strokes
    )
    if away > SETTLES:
        return edits, alone
    return edits[:-1], replace(last, strokes=last.strokes.extended((stroke,)))
