"""Curves for other programs: exact splines in the frame of the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from bozzetto.geometry import Shapes
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import Trace


def shapes_of(state: SymmetryState, traces: Mapping[str, Trace]) -> Shapes:
    """Return all curves that are shown; the mirror image of a pair comes after it."""
    place = state.plane.placement
    handed = []
    for curve in state.shown_curves:
        trace = traces.get(curve.id)
        if trace is None or trace.curve is None:
            continue
        for number, made in enumerate(trace.curve.to_curves(curve.color)):
            points = place.points(made.control_points)
            handed.append(replace(made, name=_name(curve, number), control_points=points))
    return Shapes(curves=tuple(handed))


def _name(curve: Curve, number: int) -> str:
    return f"{curve.name} mirrored" if number else curve.name
