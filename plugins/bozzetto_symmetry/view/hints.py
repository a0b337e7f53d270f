"""Hints: what is wrong with the chosen curve, what it was read as, and what to do next."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from bozzetto.errors import UserError
from bozzetto_symmetry.editing.end_snaps import settled_ends
from bozzetto_symmetry.model.canvas import LaidInk
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.operations.second_sides import waits
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.solve.pieces import may_go_on

FIRST: Final = "Draw one side of a curve, then its mirror image; or one stroke across the plane."
"""The hint for an empty box, and where no curve is chosen."""

TAKEN: Final = {
    "pair": "Left and right belong together.",
    "self": "A curve across the plane.",
    "plane": "A curve in the centre plane.",
}
"""What a curve was read as."""

SIMPLE: Final = {1: "A flat curve across the plane.", 2: "A straight bar across the plane."}
"""What a curve across the plane was taken for where the rays say nothing, by `Trace.planes`."""

ON_PLANE: Final = (
    "It lies in its plane. Draw the next curve, or press X to read it as drawn in space."
)
ON_SURFACE: Final = (
    "It lies on the surface. Draw the next curve, or press X to read it as in space."
)
APART: Final = "Press X to read them in another way, or rub out the wrong one."
OR_MIRROR: Final = (
    "If it is only one side, draw its mirror image. Press X to read it in another way."
)
GO_ON: Final = "Draw the other side on to its end, or rub out what is too much."
OTHERWISE: Final = (
    "Draw over it to correct it, or draw the next curve. Press X to read it in another way."
)
UNDECIDED: Final = (
    "Another curve fits nearly as well; it is faint when the view is turned. Press C to take it."
)
"""In the view of the ink, the ghost lies under the curve itself."""


SETTLED: Final = {
    1: "One end settled on what it nearly meets; press M to draw freely.",
    2: "Both ends settled on what they nearly meet; press M to draw freely.",
}
"""What is said of ends that are not quite where they were drawn, by how many there are."""


def next_step(state: SymmetryState) -> str:
    """Return one line about the chosen curve: warnings first, then what is expected.

    Parameters
    ----------
    state : SymmetryState
        The curve that is chosen is the one that the line is about.
    """
    chosen = next((c for c in state.shown_curves if c.id == state.selected), None)
    if chosen is None:
        return FIRST
    try:
        trace = trace_of(chosen, state)
    except UserError as problem:
        return problem.message
    ends = 0 if trace.curve is None else settled_ends(trace.curve, chosen, state)
    told = () if ends == 0 else (SETTLED[ends],)
    goes_on = filter(None, (may_go_on(state).get(chosen.id),))
    return " ".join((*trace.warnings, *told, *goes_on, *_expected(chosen, trace)))


def _expected(curve: Curve, trace: Trace) -> Iterator[str]:
    if trace.reading == "half":  # its warnings say what it waits for
        if any(len(view.sides) > 1 for view in trace.views):
            yield APART
        return
    if curve.canvas is not None:
        yield ON_SURFACE if isinstance(curve.canvas, LaidInk) else ON_PLANE
        return
    yield SIMPLE.get(trace.planes, TAKEN[trace.reading])
    if trace.rest:
        yield GO_ON
    elif waits(curve, trace):
        yield OR_MIRROR
    else:
        yield OTHERWISE if trace.ghost is None else UNDECIDED
