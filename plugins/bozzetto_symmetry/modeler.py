"""The symmetry modeler: ink in; symmetric curves in space out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any, Final

from bozzetto.errors import UserError
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.geometry import Shapes
from bozzetto.ink import Drawing, is_one_view
from bozzetto.plugin import (
    Caution,
    Command,
    Context,
    Group,
    Job,
    NextStep,
    PartsModeler,
    Tool,
    ViewAdvice,
    override,
)
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_symmetry.commands import all_commands
from bozzetto_symmetry.export import shapes_of
from bozzetto_symmetry.model.facts import box_about, box_around, box_facts, readings_of
from bozzetto_symmetry.model.state import Curve, Line, SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.operations.second_sides import waiting_view
from bozzetto_symmetry.operations.settling import with_settled
from bozzetto_symmetry.report import FIGURES, cautions_of, report_of
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.tools import all_tools
from bozzetto_symmetry.tools.draw_curve import DrawCurve
from bozzetto_symmetry.view.hints import FIRST, next_step
from bozzetto_symmetry.view.scene import scene_of
from bozzetto_symmetry.view.vanishing_lines import seen_from
from bozzetto_symmetry.view.view_advice import advice, directions, first_advice

FIRST_NEEDED: Final = (
    "scipy.interpolate", "scipy.linalg", "scipy.ndimage", "scipy.sparse.linalg", "scipy.spatial",
)  # fmt: skip
"""What reading and fitting a curve imports: up to a second's work."""

ON_GROUND: Final[Mapping[str, Any]] = {"centre": (0.0, 0.0, 0.5 * SymmetryState().height)}
"""Where a box stands that no file describes: things stand on the ground, at z = 0."""


FOR_CURVES: Final = ("join", "split", "modify")
"""Tools that have nothing to work on where the chosen curve is half a curve."""

WAITS_ELSEWHERE: Final = (
    "The chosen curve waits for its other side. Draw it here, or in the view of the first one."
)


@dataclass(frozen=True, eq=False)
class SymmetryResult:
    """The curves that the recipes gave.

    Attributes
    ----------
    traces : dict of str to Trace
        By the id of the curve, in their order.
    problems : dict of str to str
        Curves that could not be read, by id, and why.
    """

    traces: Mapping[str, Trace]
    problems: Mapping[str, str]


class Symmetry(PartsModeler[SymmetryState, SymmetryResult]):
    """Both sides of a symmetric curve, drawn in perspective (Bae, Kijima & Kim 2004)."""

    id = "bozzetto.symmetry"
    state_type = SymmetryState
    part_types = (Curve, Line, Group)
    first_parameters = ("symmetry", "reading", "other")
    figures = FIGURES

    @override
    def create(self, context: Context) -> SymmetryState:
        """Return an empty box: the one that a file gives, or 200 × 100 × 100 mm on the ground.

        Beside objects that are far larger or smaller it is as large as these, and about them.
        """
        given = box_facts(context.facts)
        usual = {} if given else {**ON_GROUND, **box_about(context.scene)}
        return replace(SymmetryState(), **usual, **given)

    @override
    def tools(self) -> Sequence[Tool[SymmetryState]]:
        """Return the tools of the pen, most used first."""
        return all_tools()

    @override
    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> SymmetryState:
        """Return the curves of a drawing.

        Strokes of one name are one curve; others go where they belong. Where the file gives no box,
        it is one with room for all the ink, and no end settles on it.

        Raises
        ------
        UserError
            If the drawing is empty, or its box or plane makes no sense.
        """
        if not len(drawing.strokes):
            raise UserError("The drawing has no strokes. Draw a curve first.")
        strokes, state = tuple(drawing.strokes), self.create(context)
        given = context.facts.get("box") is not None
        if not given:
            state = replace(state, **box_around(strokes, state.plane))
        drawn = add_drawing(state, strokes, readings_of(context.facts), job.checkpoint)
        return with_settled(drawn, context, box=given)

    @override
    def solve(self, state: SymmetryState, job: Job) -> SymmetryResult:
        """Solve every curve by itself; what did not change is remembered."""
        traces: dict[str, Trace] = {}
        problems: dict[str, str] = {}
        for number, curve in enumerate(state.curves):
            job.checkpoint(number / len(state.curves), curve.name)
            try:
                traces[curve.id] = trace_of(curve, state)
            except UserError as problem:
                problems[curve.id] = problem.message
        return SymmetryResult(traces, problems)

    @override
    def scene(self, state: SymmetryState, result: SymmetryResult | None) -> Scene:
        """Return the see-through box, the curves, and how sure each of them is."""
        return scene_of(state, {} if result is None else result.traces)

    @override
    def shapes(self, state: SymmetryState, result: SymmetryResult) -> Shapes:
        """Return the curves, exact; of a pair both."""
        return shapes_of(state, result.traces)

    @override
    def curves(self, state: SymmetryState, result: SymmetryResult) -> tuple[ShapeCurve, ...]:
        """Return the same curves, for the tools of other models to snap to."""
        return shapes_of(state, result.traces).curves

    @override
    def report(self, state: SymmetryState, result: SymmetryResult, job: Job) -> Mapping[str, Any]:
        """Return readings, control points and uncertainties of all curves."""
        return report_of(state, result.traces, result.problems, job)

    @override
    def cautions(self, state: SymmetryState, result: SymmetryResult) -> tuple[Caution, ...]:
        """Return curves that are missing or not sure, and why."""
        return cautions_of(state, result.traces, result.problems)

    @override
    def commands(self) -> Sequence[Command]:
        """Return the commands on the chosen curve."""
        return all_commands()

    @override
    def next_step(self, state: SymmetryState, tool: Tool[SymmetryState]) -> NextStep:
        """Return what the tool says; where a curve is missing or waits, that it is to be drawn."""
        if tool.id in FOR_CURVES and not state.nodes:
            return NextStep(FIRST, tool=DrawCurve.id)
        if tool.id in FOR_CURVES and waiting_view(state) is not None:
            return NextStep(next_step(state), tool=DrawCurve.id)
        return tool.next_step(state)

    @override
    def view_advice(self, state: SymmetryState, camera: Camera, job: Job) -> ViewAdvice:
        """Return how exact a curve becomes in a view, and what of the box depends on the view.

        While the chosen curve waits for its other side, the way back to its view. Of an empty
        box it is asked before anything is drawn: time to import what the first curve needs, so
        that no pen is held up by it.
        """
        if not state.nodes:
            for name in FIRST_NEEDED:
                job.checkpoint(0.0, "")
                import_module(name)
        scene, waiting = seen_from(state, camera), waiting_view(state)
        if waiting is not None and not is_one_view(camera, waiting):
            there = advice(waiting, state.plane, state.centre, state.diagonal)
            if there.level != "refuse":
                return ViewAdvice("warn", WAITS_ELSEWHERE, waiting, scene)
        if not state.nodes:
            judged = first_advice(camera, state)
        else:
            lines = directions(state, job)
            judged = advice(camera, state.plane, state.centre, state.diagonal, lines)
        return ViewAdvice(judged.level, judged.message, judged.better, scene)
