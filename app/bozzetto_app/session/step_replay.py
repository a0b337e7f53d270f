"""Replay of a drawing with steps: its ink is seen, and each step is taken in its turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.document.links import resolved
from bozzetto.ink.steps import DragStep, DrawStep, Step
from bozzetto.plugin.context import Context
from bozzetto.workbench.part_edits import PartEdit
from bozzetto.workbench.play_steps import steps_taken
from bozzetto_app.i18n import tr
from bozzetto_app.session.pen_replay import PenReplay
from bozzetto_app.workers.channel import Request

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.plugin.job import Job

__all__ = ["StepReplay"]


class StepReplay(PenReplay):
    """Plays a drawing with steps into a session: one after the other, as the file has them.

    Every step is one of the history, made by the same function that builds the file without a
    window. Strokes are seen through the views in which they were drawn.
    """

    def start(self) -> None:
        """Begin a model, and put the pen down."""
        self._modeler = self.session.toolbox.modeler
        self._steps: list[Step] = list(self.drawing.steps)
        self._model: Model | None = None
        self._runs = True
        bench, context = self.session.workbench, self._context()

        def work(job: Job) -> PartEdit:
            title = bench.registry.info(self._modeler).title
            made = bench.sources.begun(self._modeler, self.drawing, context, job)
            assert made is not None  # a drawing without steps is no replay of steps
            return PartEdit(made, tr("Replay", "New {title}", title=title))

        self._submit(work)

    def stop(self) -> None:
        """Take the pen away; steps that were taken stay."""
        if self._runs:
            self._runs = False
            self.take_pen_away()
            self.finished.emit()

    def all_lifted(self) -> None:
        self._take()

    def _context(self) -> Context:
        drawing = self.drawing
        return Context(
            camera=drawing.camera,
            facts=drawing.facts,
            pictures=drawing.pictures,
            drawings=drawing.drawings,
        )

    def _next(self) -> None:
        """Show the ink of the next step, or take it at once where it has none."""
        if not self._steps:
            self.stop()
            return
        self.strokes = [self.drawing.strokes[k] for k in _strokes_of(self._steps[0])]
        if self.strokes:
            self._look()
            self.draw()
        else:
            self._take()

    def _look(self) -> None:
        """See the sheet as it was seen for the stroke."""
        view = self.session.view
        view.set_camera(self.strokes[0].camera.with_viewport(*view.camera.viewport))

    def _take(self) -> None:
        """Take the first step that is left."""
        number, model = len(self.drawing.steps) - len(self._steps) + 1, self._model
        bench, context = self.session.workbench, self._context()
        assert model is not None
        one = replace(self.drawing, steps=(self._steps.pop(0),))
        self._submit(lambda job: next(steps_taken(bench, model, one, context, job, first=number)))

    def _submit(self, work: Callable[[Job], PartEdit]) -> None:
        """Take a step in a worker; one that only chooses a part is none of the history."""
        session, before = self.session, self._model

        def taken(job: Job) -> tuple[PartEdit, bool]:
            made = work(job)
            bench = session.workbench
            chosen = before is not None and bench.parts.only_choice_differs(before, made.model)
            return made, chosen

        def done(answer: tuple[PartEdit, bool]) -> None:
            if not self._runs:
                return
            (model, label), only_chosen = answer
            self.inked.emit(None)
            session.drawing.apply_model(
                label, model, is_new=before is None, only_chosen=only_chosen
            )
            self._model = resolved(session.drawing.document)[model.id]
            self._next()

        def failed(problem: BaseException) -> None:
            session.notices.complain(problem)
            self.stop()

        session.gestures.edits.submit(Request(taken, done, failed))


def _strokes_of(step: Step) -> Sequence[int]:
    if isinstance(step, DrawStep):
        return step.strokes
    return (step.stroke,) if isinstance(step, DragStep) else ()
