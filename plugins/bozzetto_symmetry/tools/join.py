"""Join: a stroke from the end of one curve to the end of another makes them one."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Scene
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.curve_ends import End, ends_of, with_joint
from bozzetto_symmetry.solve.curve_solver import solve_curve
from bozzetto_symmetry.solve.picking import solved_curves
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from bozzetto_symmetry.tools.erase import ErasingTool
from bozzetto_symmetry.view.scene import curve_lines

REACH: Final = 28.0
"""How near to the end of a curve a stroke must begin or end, px."""

WIDTH: Final = 2.5
"""Width of the previewed curve, px."""

_NO_END: Final = "There is no end of a curve where the stroke {where}. Draw from end to end."


class JoinCurves(ErasingTool):
    """Makes two ends one smooth curve; both ends of one curve close it.

    From an end across the centre plane to its mirror image, the curve becomes one across
    the plane, which it crosses at a right angle.
    """

    id = "join"
    title = "Join"
    icon = "icons/join.svg"
    hint = "Draw from the end of one curve to the end of another, or to its own mirror image."

    @override
    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return the curve that would come."""
        if not isinstance(gesture, Ink):
            return Scene()
        stroke = gesture.strokes[-1]
        made = _joined(state, stroke)
        curve = solve_curve(made.chosen, made) if made.chosen is not None else None
        if curve is None:
            return Scene()
        camera = Stereo.of(stroke.camera, state.plane).camera
        return Scene((Layer("preview", curve_lines(curve, state, camera, "accent", WIDTH)),))

    @override
    def draw(self, state: SymmetryState, ink: Ink, context: Context) -> SymmetryState:
        """Join the ends that each stroke leads from and to.

        Raises
        ------
        UserError
            If a stroke does not lead from end to end, or these cannot be joined.
        """
        for stroke in ink.strokes:
            state = _joined(state, stroke)
        return state


def _joined(state: SymmetryState, stroke: Stroke) -> SymmetryState:
    ends = ends_of(solved_curves(state))
    stereo = Stereo.of(stroke.camera, state.plane)
    seen = stereo.project(np.array([end.point for end in ends]).reshape(-1, 3))
    firsts = _near(ends, seen, stroke.points[0])
    lasts = _near(ends, seen, stroke.points[-1])
    for found, where in ((firsts, "begins"), (lasts, "ends")):
        if not found:
            raise UserError(_NO_END.format(where=where))
    pairs = [
        (far_one + far_other, number, one, other)
        for number, (far_one, one) in enumerate(firsts)
        for far_other, other in lasts
        if one is not other
    ]
    if not pairs:
        raise UserError(_NO_END.format(where="ends"))
    _, _, first, last = min(pairs, key=lambda entry: entry[:2])
    return with_joint(state, first, last)


def _near(ends: list[End], seen: Array, pixel: Array) -> list[tuple[float, End]]:
    """Return the ends seen near a place on the sheet, with their distances, px."""
    away = np.linalg.norm(seen - pixel, axis=1)
    return [(float(gap), end) for gap, end in zip(away, ends, strict=True) if gap <= REACH]
