"""The report on the curves: plain values in the frame of the model, mm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from bozzetto.plugin import Caution, Figure, Job
from bozzetto_symmetry.editing.end_snaps import settled_ends
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import MOST_MARGIN, Trace
from bozzetto_symmetry.solve.pieces import may_go_on

FIGURES: Final[Mapping[str, Figure]] = {
    "reading": Figure(
        "Read as",
        "What the strokes of the curve were taken for",
        values={
            "pair": "left and right",
            "self": "across the plane",
            "plane": "in the plane",
            "half": "one side, waiting",
            "none": "nothing",
        },
        verdicts={"none": False},
    ),
    "margin": Figure(
        "Next reading",
        "How many times worse the next best reading fits; near 1 it is a guess",
        "×",
        digits=1,
        most=MOST_MARGIN,
        beyond="none",
    ),
    "sigma": Figure(
        "Off per pixel",
        "Error of points in space for one pixel of error in the drawing",
        "mm",
        digits=2,
        spread=True,
    ),
    "rms": Figure(
        "Off the ink",
        "Distance of the strokes from the picture of the curve (RMS)",
        "px",
        digits=2,
    ),
    "settled": Figure("Ends settled", "How many ends went to what they nearly meet"),
    "degree": Figure(""),
    "size": Figure("Size", "Length, width and height", "mm", digits=1),
    "center": Figure("Centre", "Middle of the box", "mm", digits=1),
}
"""The words of the report; `Modeler.figures`."""


def report_of(
    state: SymmetryState, traces: Mapping[str, Trace], problems: Mapping[str, str], job: Job
) -> dict[str, Any]:
    """Return how every curve was read, its spline, and how sure its places are.

    Returns
    -------
    dict
        ``"curves"``: for each ``"id"``, ``"name"``, ``"reading"`` (``"pair"``, ``"self"``,
        ``"plane"``, ``"half"``; ``"none"`` where the strokes make no sense), ``"margin"``
        (cost of the next best reading over the cost of this one), ``"degree"``,
        ``"closed"``, ``"knots"``, ``"control_points"``, ``"points"`` and ``"sigma"``
        (together along the side that was drawn; sigma is the standard deviation across the
        curve of a hand that errs by 1 px, mm), ``"rms"`` (ink from the curve's image,
        px), ``"settled"`` (how many ends went to what they nearly meet) and ``"warnings"``; of a
        pair the mirror image's ``"mirrored_control_points"``.
    """
    plane, goes_on = state.plane, may_go_on(state)
    entries = []
    for number, curve in enumerate(state.curves):
        job.checkpoint(number / len(state.curves), curve.name)
        entries.append(
            _entry(curve, traces[curve.id], state, goes_on.get(curve.id, ""))
            if curve.id in traces
            else _nothing(curve) | {"warnings": [problems.get(curve.id, "")]}
        )
    return {
        "curves": entries,
        "box": {"center": list(state.centre), "size": list(state.size)},
        "plane": {"point": list(plane.point), "normal": list(plane.normal)},
        "unit": "mm",
    }


def cautions_of(
    state: SymmetryState, traces: Mapping[str, Trace], problems: Mapping[str, str]
) -> tuple[Caution, ...]:
    """Return cautions about curves that could not be read, wait for a side, or are not sure."""
    cautions, goes_on = [], may_go_on(state)
    for curve in state.curves:
        trace = traces.get(curve.id)
        warnings: tuple[str, ...] = (problems.get(curve.id, ""),)
        if trace is not None:
            warnings = (*trace.warnings, goes_on.get(curve.id, ""))
        cautions += [Caution(f"“{curve.name}”: {text}") for text in warnings if text]
    return tuple(cautions)


def _nothing(curve: Curve) -> dict[str, Any]:
    return {
        "id": curve.id, "name": curve.name, "reading": "none", "margin": 0.0, "degree": 3,
        "closed": False, "knots": [], "control_points": [], "points": [], "sigma": [],
        "rms": 0.0, "settled": 0, "warnings": [],
    }  # fmt: skip


def _entry(curve: Curve, trace: Trace, state: SymmetryState, goes_on: str) -> dict[str, Any]:
    entry = _nothing(curve) | {
        "reading": trace.reading,
        "margin": trace.margin,
        "rms": trace.rms,
        "warnings": [*trace.warnings, *filter(None, (goes_on,))],
    }
    if trace.curve is None:
        return entry
    place = state.plane.placement
    handed = trace.curve.to_curves()
    entry |= {
        "degree": handed[0].degree,
        "closed": trace.curve.closed,
        "settled": settled_ends(trace.curve, curve, state),
        "knots": handed[0].knots.tolist(),
        "control_points": place.points(handed[0].control_points).tolist(),
        "points": place.points(trace.points).tolist(),
        "sigma": trace.sigma.tolist(),
    }
    if len(handed) > 1:
        entry["mirrored_control_points"] = place.points(handed[1].control_points).tolist()
    return entry
