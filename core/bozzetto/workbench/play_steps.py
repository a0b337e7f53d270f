"""Playback of a drawing's steps, as if a person took them one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final, assert_never

from bozzetto.errors import Unfinished, UserError
from bozzetto.ink.steps import (
    AddStep,
    CommandStep,
    DeleteStep,
    DragStep,
    DrawStep,
    DuplicateStep,
    GroupStep,
    MoveStep,
    RenameStep,
    SelectStep,
    SetStep,
    ShowStep,
    Step,
    TapStep,
    UngroupStep,
)
from bozzetto.parameters import parameter_fields
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.job import Job
from bozzetto.plugin.lazy_curves import LazyCurves
from bozzetto.scene.display_list import Scene
from bozzetto.workbench.part_edits import PartEdit

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.geometry.shapes import Curve, Shapes
    from bozzetto.ink.drawing import Drawing
    from bozzetto.plugin.context import Context
    from bozzetto.view.camera import Camera
    from bozzetto.workbench.workbench import Workbench

MOST_SEEN: Final = 32
"""Earlier states on which a gesture may have been made."""


def run_steps(
    bench: Workbench, model: Model, drawing: Drawing, context: Context, job: Job | None = None
) -> Model:
    """Return the model after all steps of a drawing; see `steps_taken`."""
    for taken in steps_taken(bench, model, drawing, context, job):
        model = taken.model
    return model


def steps_taken(
    bench: Workbench,
    model: Model,
    drawing: Drawing,
    context: Context,
    job: Job | None = None,
    *,
    first: int = 1,
) -> Iterator[PartEdit]:
    """Yield the model after each step of a drawing, with the label that it has in a history.

    Parameters
    ----------
    bench : Workbench
        Runs the modelers.
    model : Model
        New and empty.
    drawing : Drawing
        The strokes and the steps.
    context : Context
        The world around; what the model itself shows is added before every gesture, in
        preview quality, and made only if the gesture looks at it or asks for curves. That the
        model is alone is not said: no view goes along while a file is read.
    job : Job, optional
        Is told of each step, and stops in the middle of one when nobody waits any more.
    first : int
        Number of the first step, as messages name it.

    Raises
    ------
    UserError
        Names the step, counted from 1.
    PluginFault
    Cancelled
    """
    job = job or Job()
    # Gestures of a file are where the model was seen when they were made: it may go nowhere else.
    context = replace(context, alone=False)
    count = len(drawing.steps)
    for number, step in enumerate(drawing.steps, first):
        job.checkpoint((number - first) / count, f"Step {number}")
        before = model.state
        try:
            taken = _after(bench, model, step, drawing, context, job)
        except UserError as problem:
            raise UserError(f"Step {number}: {problem.message}", places=problem.places) from problem
        except Unfinished as problem:
            raise UserError(f"Step {number} is not complete. {problem.hint}") from problem
        yield taken
        model = taken.model
        # A hand that was quicker than the view drew on what it saw.
        context = replace(context, seen=(before, *context.seen)[:MOST_SEEN])


def _after(
    bench: Workbench, model: Model, step: Step, drawing: Drawing, context: Context, job: Job
) -> PartEdit:
    edits = bench.parts
    strokes = drawing.strokes

    def seen(camera: Camera) -> Context:
        own = Scene.put_off(lambda: _scene(bench, model, job))
        curves: Sequence[Curve] = context.curves
        if bench.curves.are_offered(model):

            def learnt() -> tuple[Curve, ...]:
                _ = own.layers  # they are told when the model is solved
                return (*context.curves, *bench.curves.of((model,)))

            curves = LazyCurves(learnt)
        sources: Mapping[str, Shapes] = {}
        if model.sources:
            _ = own.layers  # what it follows is known when it is solved
            sources = bench.given_sources(model)
        return replace(
            context, camera=camera, scene=context.scene + own, curves=curves, sources=sources
        )

    def gesture(tool_id: str, made: Gesture) -> PartEdit:
        tool = bench.tool(model.modeler, tool_id)
        return PartEdit(bench.apply(model, tool, made, seen(made.camera)), tool.title)

    part = _finder(bench, model)
    match step:
        case DrawStep(tool, places):
            return gesture(tool, Ink(tuple(strokes[place] for place in places), committed=True))
        case DragStep(tool, handle, place, shift, ctrl):
            return gesture(tool, Drag(handle, strokes[place], shift, ctrl))
        case TapStep(tool, (x, y), shift, ctrl, camera):
            return gesture(tool, Tap(x, y, camera or drawing.camera, shift, ctrl))
        case SetStep(values, ""):
            return PartEdit(bench.set_parameters(model, values), _labels(bench, model, values))
        case SetStep(values, name):
            return edits.set(model, part(name), values)
        case SelectStep(name):
            return PartEdit(edits.select(model, part(name) if name else ""), "Choose")
        case RenameStep(wish, name):
            return edits.rename(model, part(name), wish)
        case ShowStep(visible, name):
            return edits.show(model, part(name), visible)
        case DeleteStep(name):
            return edits.delete(model, part(name))
        case DuplicateStep(name):
            return edits.duplicate(model, part(name))
        case MoveStep(name, at, into):
            return edits.move(model, part(name), part(into) if into else "", at)
        case GroupStep(names):
            return edits.group(model, [part(name) for name in names])
        case UngroupStep(name):
            return edits.ungroup(model, part(name))
        case CommandStep(name):
            command = bench.commands.find(model.modeler, name)
            made = bench.commands.run(model, command, seen(drawing.camera))
            return PartEdit(made, command.title)
        case AddStep(name):
            added = drawing.drawings.get(name)
            if added is None:
                raise UserError(f"The drawing “{name}” is not there. Put it beside the file.")
            made = bench.sources.with_drawing(model, added, seen(drawing.camera))
            return PartEdit(made, "Add drawing")
        case _:
            assert_never(step)


def _labels(bench: Workbench, model: Model, values: Iterable[str]) -> str:
    """Return the labels of the parameters of a model, or of its parts, that have these names."""
    tree = bench.parts.of(model)
    kinds = (type(model.state), *(() if tree is None else map(type, tree.parts)))
    known = {
        field.name: field.parameter.label for kind in kinds for field in parameter_fields(kind)
    }
    names = (value.rpartition(".")[2] for value in values)
    return ", ".join(known.get(name, name) for name in names)


def _finder(bench: Workbench, model: Model) -> Callable[[str], str]:
    """Return a function from a part's name ("" is the chosen one) to its id."""

    def find(name: str) -> str:
        tree = bench.parts.of(model)
        if tree is None:
            raise UserError(f"“{model.name}” is not made of parts.")
        if name:
            return tree.find(name)
        if not tree.selected:
            raise UserError("No part is chosen. Say which one is meant.")
        return tree.selected

    return find


def _scene(bench: Workbench, model: Model, job: Job) -> Scene:
    """Return the model's scene; without its shape where that has no solution yet."""
    try:
        preview = Job(quality="preview", cancelled=job.cancelled, drawn_on=True)
        result = bench.solve(model, preview)
        bench.curves.try_to_learn(model, result)  # the next step may snap to them
        return bench.model_scene(model, result)
    except UserError:
        return bench.model_scene(model, None)
