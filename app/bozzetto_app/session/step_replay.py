"""Replay of a drawing with steps: its ink is seen, and each step is taken in its turn."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.document.model import Model
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.steps import DragStep, DrawStep, Step
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.context import Context
from bozzetto.plugin.job import Job
from bozzetto.workbench.part_edits import PartEdit
from bozzetto.workbench.play_steps import steps_taken
from bozzetto_app.i18n import tr
from bozzetto_app.session.replay_ink import PAUSE, TICK_MS, beginning, samples_after
from bozzetto_app.session.session import Session
from bozzetto_app.workers.channel import Request

__all__ = ["StepReplay"]


class StepReplay(QObject):
    """Plays a drawing with steps into a session: one after the other, as the file has them.

    Every step is one of the history, made by the same function that builds the file without a
    window. Strokes are seen through the views in which they were drawn.

    Parameters
    ----------
    session : Session
    drawing : Drawing
    speed : float
        2 is twice as fast as the drawing was made.

    Signals
    -------
    finished
        After the last step, or when the replay was stopped.
    inked : Stroke or None
        See `Replay`.
    """

    finished = Signal()
    inked = Signal(object)

    def __init__(
        self,
        session: Session,
        drawing: Drawing,
        *,
        speed: float = 2.0,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._session, self._drawing, self._speed = session, drawing, speed
        self._modeler = session.toolbox.modeler
        self._steps: list[Step] = list(drawing.steps)
        self._strokes: list[Stroke] = []
        self._model: Model | None = None
        self._pen_down = 0.0
        self._runs = False
        self._timer = QTimer(self)
        self._timer.setInterval(TICK_MS)
        self._timer.timeout.connect(self._tick)

    def start(self) -> None:
        """Begin a model, and put the pen down."""
        self._runs = True
        bench, context = self._session.workbench, self._context()
        name = self._drawing.name

        def work(job: Job) -> PartEdit:
            title = bench.registry.info(self._modeler).title
            made = bench.create(self._modeler, context, name=name)
            return PartEdit(made, tr("Replay", "New {title}", title=title))

        self._submit(work)

    def stop(self) -> None:
        """Take the pen away; steps that were taken stay."""
        if self._runs:
            self._runs = False
            self._timer.stop()
            self.inked.emit(None)
            self.finished.emit()

    def _context(self) -> Context:
        drawing = self._drawing
        return Context(camera=drawing.camera, facts=drawing.facts, pictures=drawing.pictures)

    def _next(self) -> None:
        """Show the ink of the next step, or take it at once where it has none."""
        if not self._steps:
            self.stop()
            return
        self._strokes = [self._drawing.strokes[k] for k in _strokes_of(self._steps[0])]
        self._pen_down = time.monotonic()
        if self._strokes:
            self._look()
            self._timer.start()
        else:
            self._take()

    def _look(self) -> None:
        """See the sheet as it was seen for the stroke."""
        view = self._session.view
        view.set_camera(self._strokes[0].camera.with_viewport(*view.camera.viewport))

    def _tick(self) -> None:
        stroke = self._strokes[0]
        passed = (time.monotonic() - self._pen_down) * self._speed
        if passed < 0.0:
            return
        shown = samples_after(stroke, passed)
        self.inked.emit(beginning(stroke, max(shown, 1)))
        if shown < len(stroke):
            return
        self._strokes.pop(0)
        self._pen_down = time.monotonic() + PAUSE
        if not self._strokes:
            self._timer.stop()
            self._take()

    def _take(self) -> None:
        """Take the first step that is left."""
        number, model = len(self._drawing.steps) - len(self._steps) + 1, self._model
        bench, context = self._session.workbench, self._context()
        assert model is not None
        one = replace(self._drawing, steps=(self._steps.pop(0),))
        self._submit(lambda job: next(steps_taken(bench, model, one, context, job, first=number)))

    def _submit(self, work: Callable[[Job], PartEdit]) -> None:
        """Take a step in a worker; one that only chooses a part is none of the history."""
        session, before = self._session, self._model

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
            self._model = session.drawing.document.model(model.id)
            self._next()

        def failed(problem: BaseException) -> None:
            session.notices.complain(problem)
            self.stop()

        session.gestures.edits.submit(Request(taken, done, failed))


def _strokes_of(step: Step) -> Sequence[int]:
    if isinstance(step, DrawStep):
        return step.strokes
    return (step.stroke,) if isinstance(step, DragStep) else ()
