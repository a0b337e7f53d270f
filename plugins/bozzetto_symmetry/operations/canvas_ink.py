"""Curves of ink drawn in a plane or on the surface of another object."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import closest_on_mesh
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.model.canvas import DrawingPlane, LaidInk
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.operations.assign_stroke import runs_along
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

BRIDGE: Final = 24.0
"""Longest way beside a surface, px, over which ink goes on."""


def add_in_plane(
    state: SymmetryState, strokes: tuple[Stroke, ...], plane: DrawingPlane
) -> SymmetryState:
    """Return the state with curves in a plane; ink along the chosen one is more ink of it.

    Raises
    ------
    UserError
        If the ink is a dot, or the plane is seen edge-on.
    """
    for stroke in strokes:
        chosen = state.chosen
        if chosen is not None and chosen.canvas == plane:
            trace = trace_of(chosen, state)
            if runs_along((stroke,), trace, state):
                more = replace(chosen, strokes=chosen.strokes.extended((stroke,)))
                trace_of(more, state)
                state = state.with_node(more)
                continue
        state = _with_curve(state, stroke, plane)
    return state


def add_on_surface(
    state: SymmetryState, strokes: tuple[Stroke, ...], context: Context
) -> SymmetryState:
    """Return the state with a curve for every stroke, on the surface that is seen under it.

    Raises
    ------
    UserError
        If there is no surface under the ink, or only under less than half of it.
    """
    for stroke in strokes:
        state = _with_curve(state, stroke, laid_ink(stroke, context, state.plane))
    return state


def laid_ink(stroke: Stroke, context: Context, plane: CentrePlane) -> LaidInk:
    """Return where a stroke lies on the surface of another object.

    Parameters
    ----------
    stroke : Stroke
        In the frame of the model.
    context : Context
        What is visible, in the same frame.
    plane : CentrePlane
        In which its mirror image is looked for on the same surface.

    Raises
    ------
    UserError
        If less than half of the stroke is over one surface.
    """
    runs = [run for run in context.project(stroke, bridge=BRIDGE).runs if len(run.points) > 1]
    if not runs:
        raise UserError("There is no surface here. Draw on another object, or in space.")
    run = max(runs, key=lambda each: float(each.at[-1] - each.at[0]))
    number = np.arange(len(stroke.points))
    seen = stroke.points[(number >= run.at[0]) & (number <= run.at[-1])]
    if len(seen) < 2 or length_of(seen) < 0.5 * length_of(stroke.points):
        raise UserError("The stroke leaves the surface. Draw it so that it stays on one surface.")
    image = plane.placement.points(plane.inverse.points(run.points) * MIRROR)
    off = closest_on_mesh(run.item.mesh, image).distances
    return LaidInk(run.places, run.points, run.normals, float(off.max()))


def _with_curve(
    state: SymmetryState, stroke: Stroke, canvas: DrawingPlane | LaidInk
) -> SymmetryState:
    curve = Curve(
        id=state.unused_id(),
        name=state.unused_name("Curve"),
        strokes=Strokes((stroke,)),
        canvas=canvas,
        color=stroke.color,
    )
    trace_of(curve, state)
    return state.with_node(curve)
