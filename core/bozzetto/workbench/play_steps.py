"""Playback of a drawing's steps, as if a person took them one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final, assert_never

from bozzetto.document.model import Model
from bozzetto.errors import Unfinished, UserError
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.steps import (
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
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.workbench.workbench import Workbench

MOST_SEEN: Final = 32
"""Earlier states on which a gesture may have been made."""


def run_steps(
    bench: Workbench, model: Model, drawing: Drawing, context: Context, job: Job | None = None
) -> Model:
    """Return the model after all steps of a drawing.

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
        preview quality.
    job : Job, optional
        Is told of each step, and stops in the middle of one when nobody waits any more.

    Raises
    ------
    UserError
        Names the step, counted from 1.
    PluginFault
    Cancelled
    """
    job = job or Job()
    count = len(drawing.steps)
    for number, step in enumerate(drawing.steps, 1):
        job.checkpoint((number - 1) / count, f"Step {number} of {count}")
        before = model.state
        try:
            model = _after(bench, model, step, drawing, context, job)
        except UserError as problem:
            raise UserError(f"Step {number}: {problem.message}", places=problem.places) from problem
        except Unfinished as problem:
            raise UserError(f"Step {number} is not complete. {problem.hint}") from problem
        # A hand that was quicker than the view drew on what it saw.
        context = replace(context, seen=(before, *context.seen)[:MOST_SEEN])
    return model


def _after(
    bench: Workbench, model: Model, step: Step, drawing: Drawing, context: Context, job: Job
) -> Model:
    edits = bench.parts
    strokes = drawing.strokes

    def seen(camera: Camera) -> Context:
        scene = context.scene + _scene(bench, model, job)
        curves = context.curves + bench.curves.of((model,))
        return replace(context, camera=camera, scene=scene, curves=curves)

    def gesture(tool: str, made: Gesture) -> Model:
        return bench.apply(model, bench.tool(model.modeler, tool), made, seen(made.camera))

    part = _finder(bench, model)
    match step:
        case DrawStep(tool, places):
            return gesture(tool, Ink(tuple(strokes[place] for place in places), committed=True))
        case DragStep(tool, handle, place, shift, ctrl):
            return gesture(tool, Drag(handle, strokes[place], shift, ctrl))
        case TapStep(tool, (x, y), shift, ctrl, camera):
            return gesture(tool, Tap(x, y, camera or drawing.camera, shift, ctrl))
        case SetStep(values, ""):
            return bench.set_parameters(model, values)
        case SetStep(values, name):
            return edits.set(model, part(name), values).model
        case SelectStep(name):
            return edits.select(model, part(name) if name else "")
        case RenameStep(wish, name):
            return edits.rename(model, part(name), wish).model
        case ShowStep(visible, name):
            return edits.show(model, part(name), visible).model
        case DeleteStep(name):
            return edits.delete(model, part(name)).model
        case DuplicateStep(name):
            return edits.duplicate(model, part(name)).model
        case MoveStep(name, at, into):
            return edits.move(model, part(name), part(into) if into else "", at).model
        case GroupStep(names):
            return edits.group(model, [part(name) for name in names]).model
        case UngroupStep(name):
            return edits.ungroup(model, part(name)).model
        case CommandStep(name):
            command = bench.commands.find(model.modeler, name)
            return bench.commands.run(model, command, seen(drawing.camera))
        case _:
            assert_never(step)


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
        result = bench.solve(model, Job(quality="preview", cancelled=job.cancelled))
        bench.curves.try_to_learn(model, result)  # the next step may snap to them
        return bench.model_scene(model, result)
    except UserError:
        return bench.model_scene(model, None)
