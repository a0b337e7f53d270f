"""Everything that the program asks of a modeler, as questions that can be asked in any order."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from bozzetto.document.model import Model
from bozzetto.errors import Unfinished, UserError
from bozzetto.geometry.shapes import Curve
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.commands import Command
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.job import Job
from bozzetto.plugin.next_step import NextStep
from bozzetto.plugin.tool import Tool
from bozzetto.plugin.view_advice import ViewAdvice
from bozzetto.scene.display_list import Handle, Scene
from bozzetto.testing.deep_equal import fingerprint
from bozzetto.testing.synthetic_pen import Pen
from bozzetto.view.camera import Camera
from bozzetto.workbench.workbench import Workbench

Ask = Callable[[Workbench], Any]

ELSEWHERE = (613.0, 441.0, 171.0)
"""Middle and radius of a circle that no other check draws, px: its answers are not known yet."""

MOST_HANDLES = 2
"""Handles of a model that are dragged: each is as good as another."""


@dataclass(frozen=True)
class Question:
    """One thing that can be asked of a model.

    Attributes
    ----------
    name : str
        Such as "the preview of the tool mark".
    ask : callable
        ``ask(bench)`` gives the answer, which may be a text that refuses.
    """

    name: str
    ask: Ask


def questions(bench: Workbench, model: Model) -> list[Question]:
    """Return every pure question about a model: the same ones each time.

    Parameters
    ----------
    bench : Workbench
        Solves the model once, to see which handles there are.
    model : Model
        The model to ask about.
    """
    return [Question(name, _with_refusals(ask)) for name, ask in _all(bench, model)]


def answers(bench: Workbench, row: list[Question]) -> dict[str, str]:
    """Return fingerprints of the answers, by the name of the question."""
    return {question.name: fingerprint(question.ask(bench)) for question in row}


def _with_refusals(ask: Ask) -> Ask:
    def asked(bench: Workbench) -> Any:
        try:
            return ask(bench)
        except UserError as problem:
            return f"refused: {problem.message} {problem.places}"
        except Unfinished as problem:
            return f"unfinished: {problem.hint}"

    return asked


def _all(bench: Workbench, model: Model) -> Iterator[tuple[str, Ask]]:
    final = Job()
    yield "the scene of what is not solved", partial(_unsolved, model)
    yield "the scene as a preview", partial(_scene, model, Job(quality="preview"))
    yield "the scene", partial(_scene, model, final)
    yield "shapes", lambda bench: bench.shapes([model], final)
    yield "the report", lambda bench: bench.report(model, final)
    yield "the cautions", lambda bench: bench.cautions(model, final)
    yield "the curves", partial(_curves, model)
    yield "the parts", lambda bench: bench.parts.of(model)
    for number, camera in enumerate(_cameras(bench, model)):
        yield f"the advice on view {number}", partial(_advice, model, camera)
    context = _context(bench, model)
    for command in bench.commands.of(model.modeler):
        name = f"the command {command.id}"
        yield f"whether {name} can run", partial(_can_run, model, command)
        yield name, partial(_run, model, command, context)
    for tool in bench.tools(model.modeler):
        yield f"the next step with the tool {tool.id}", partial(_next_step, model, tool)
        for number, gesture in enumerate(_gestures(bench, model, tool)):
            told = f"the tool {tool.id}, gesture {number}"
            yield f"the preview of {told}", partial(_preview, model, tool, gesture, context)
            yield told, partial(_apply, model, tool, gesture, context)


def _unsolved(model: Model, bench: Workbench) -> Scene:
    return bench.model_scene(model, None).owned("")


def _scene(model: Model, job: Job, bench: Workbench) -> Scene:
    return bench.model_scene(model, bench.solve(model, job)).owned("")


def _curves(model: Model, bench: Workbench) -> tuple[Curve, ...]:
    return bench.guarded(model).curves(model.state, bench.solve(model, Job()))


def _advice(model: Model, camera: Camera, bench: Workbench) -> ViewAdvice | None:
    advice = bench.view_advice(model, camera)
    return None if advice is None else replace(advice, scene=advice.scene.owned(""))


def _can_run(model: Model, command: Command, bench: Workbench) -> bool:
    return bench.commands.can_run(model, command)


def _run(model: Model, command: Command, context: Context, bench: Workbench) -> Any:
    if command.writes:
        return bench.commands.content(model, command, context, "file")
    return bench.commands.run(model, command, context).state


def _next_step(model: Model, tool: Tool[Any], bench: Workbench) -> NextStep:
    return bench.next_step(model, tool)


def _preview(
    model: Model, tool: Tool[Any], gesture: Gesture, context: Context, bench: Workbench
) -> Scene:
    return bench.preview(model, tool, gesture, context).owned("")


def _apply(
    model: Model, tool: Tool[Any], gesture: Gesture, context: Context, bench: Workbench
) -> Any:
    return bench.apply(model, tool, gesture, context).state


def _context(bench: Workbench, model: Model) -> Context:
    """Return one context for all questions, made for the first one."""
    try:
        scene = bench.model_scene(model, bench.solve(model, Job()))
    except UserError:
        scene = bench.model_scene(model, None)
    return Context(scene=scene)


def _cameras(bench: Workbench, model: Model) -> tuple[Camera, ...]:
    """Return two views that anybody might have, and the one that is called better."""
    views = (
        Camera(),
        Camera(eye=(300.0, 400.0, -200.0), target=(10.0, -20.0, 30.0), fov_y=120.0),
    )
    advice = bench.view_advice(model, views[0])
    better = advice.better if advice is not None else None
    return views if better is None else (*views, better)


def _gestures(bench: Workbench, model: Model, tool: Tool[Any]) -> Iterator[Gesture]:
    """Yield gestures of a tool's kind, two of which begin alike: half of one, and whole."""
    for camera in _cameras(bench, model)[::2]:
        pen = Pen(camera)
        if tool.gesture == "ink":
            whole = pen.circle(*ELSEWHERE)
            half = _begun(whole)
            other = pen.along([(float(whole.x[0]), float(whole.y[0])), (300.0, 200.0)])
            for stroke in (half, whole, other, half):
                yield Ink((stroke,), committed=True)
        else:
            yield Tap(500.0, 400.0, camera)
            scene = _context(bench, model).scene
            handles = [item.id for _, item in scene.items() if isinstance(item, Handle)]
            path = pen.along([(500.0, 400.0), (520.0, 390.0), (560.0, 380.0)])
            for handle in handles[:MOST_HANDLES]:
                yield Drag(handle, _begun(path))
                yield Drag(handle, path)


def _begun(stroke: Stroke) -> Stroke:
    """Return the first half of a stroke, as while it is drawn."""
    half = slice(0, max(len(stroke) // 2, 1))
    return Stroke(
        stroke.x[half],
        stroke.y[half],
        stroke.camera,
        pressure=stroke.pressure[half],
        t=stroke.t[half],
        tool=stroke.tool,
    )
