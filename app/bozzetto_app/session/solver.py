"""Showing: solves what is on the sheet in the background and keeps the picture of each model.

First a preview of everything, so that a shape stands within a blink; then the final
results, one by one. What was shown stays until something better is there; which answer is
better, and which work goes first, is said by `revisions`. A recipe that has no solution, or
whose plugin fails over it, is complained about once and not tried again; its ink is shown
all the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.document.model import Document, Model
from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Layer, Scene
from bozzetto.workbench.workbench import Workbench
from bozzetto_app.session.revisions import Revisions, Stage, Task
from bozzetto_app.workers.channel import Channel, Request
from bozzetto_app.workers.main_thread import ring

__all__ = ["Showing"]

SOLVE_LIMIT = 60.0
"""Seconds a solve may go on without a sign of progress before it counts as hung."""

REST: Final = 300
"""Time without a change after which a drag gets its final picture, ms, though it may go on."""


class Showing(QObject):
    """The pictures of a document's models, kept up to date by one worker.

    Signals
    -------
    changed : str, bool
        A model's (id) picture is another one; True if it shows the solved shape of the
        newest state.
    settled : str
        A model (id) that was waiting for it has its final picture.
    reported : Model, dict
        Figures of the model asked for.
    failed : object
        The exception with which a model refused to be solved or shown.
    slow : Hung
        A solve goes on for long.
    rested
        A drag has ended or rests.
    progressed : float, str; busy_changed : bool
    """

    changed = Signal(str, bool)
    settled = Signal(str)
    reported = Signal(object, object)
    failed = Signal(object)
    rested = Signal()
    slow = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, workbench: Workbench, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workbench = workbench
        self._document = Document()
        self._selected: Model | None = None
        self._shown: dict[str, tuple[Model, Scene]] = {}
        self._revisions = Revisions()
        self._last_report: tuple[Any, dict[str, Any]] | None = None
        self._awaited: set[str] = set()
        self._channel = Channel("solve", time_limit=SOLVE_LIMIT, is_patient=True, parent=self)
        self._channel.slow.connect(self.slow)
        self._channel.progressed.connect(self.progressed)
        self._channel.busy_changed.connect(self.busy_changed)
        self._rest = QTimer(self, singleShot=True, interval=REST)
        self._rest.timeout.connect(self.let_go)

    @property
    def busy(self) -> bool:
        """Whether something is still being solved."""
        return self._channel.busy or self._rest.isActive()

    def layers(self) -> Iterator[Layer]:
        """The layers of all visible models, in the document's order."""
        for model in self._document:
            if model.visible and model.id in self._shown:
                yield from self._shown[model.id][1].layers

    def shown(self, model_id: str) -> Model | None:
        """The model, as it was, whose picture is shown; None where there is none."""
        found = self._shown.get(model_id)
        return None if found is None else found[0]

    def await_final(self, model_id: str) -> None:
        """Ask for `settled` when this model's final picture is there."""
        self._awaited.add(model_id)

    def forget(self) -> None:
        """Drop every picture and all work: another document comes."""
        self.cancel()
        self._revisions.forget()
        self._shown.clear()
        self._awaited.clear()
        self._last_report = None

    def cancel(self) -> None:
        """Stop solving; what is shown stays.

        What had been told as slow is not tried again until it is another.
        """
        self._rest.stop()
        running, task = self._channel.running, self._revisions.running
        if running is not None and running.is_told_slow and task is not None:
            self._revisions.give_up(task.model)
        self._channel.cancel()
        self._revisions.stop()

    def show(self, document: Document, selected: Model | None, *, dragging: bool = False) -> None:
        """Bring the pictures up to date with a document, and report on the selected model.

        Parameters
        ----------
        document : Document
        selected : Model, optional
        dragging : bool
            Whether more changes of the same kind are to be expected: previews are made, and
            finals wait for `let_go`, or for a rest.
        """
        self._document, self._selected = document, selected
        known = {model.id for model in document}
        self._shown = {key: pair for key, pair in self._shown.items() if key in known}
        running = self._channel.running
        chosen = "" if selected is None else selected.id
        unwanted = self._revisions.ask(self._soluble(document), chosen, dragging=dragging)
        if running is not None and unwanted:
            running.abandon()
        if dragging:
            self._rest.start()
        else:
            self._rest.stop()
        self._channel.submit(Request(self._work, lambda _: None, self._failed))

    def let_go(self) -> None:
        """Make the finals: a drag has ended, or rests."""
        self._rest.stop()
        if self._revisions.let_go():
            self._channel.submit(Request(self._work, lambda _: None, self._failed))
            self.rested.emit()

    def _soluble(self, document: Document) -> list[Model]:
        """The models to be solved: those that can be seen and whose plugin is here."""
        return [
            model for model in document if model.visible and not self._workbench.is_foreign(model)
        ]

    # -- in the worker --

    def _work(self, job: Job) -> None:
        """Do what is most urgent until nothing is left."""
        while not job.cancelled():
            task = self._revisions.next()
            if task is None:
                return
            job.progress(0.0, task.model.name)
            try:
                if task.stage is Stage.REPORT:
                    self._report(task, job)
                else:
                    self._solve(task, job)
            except (UserError, PluginFault) as problem:
                # Work that was overtaken and then interrupted is nobody's fault.
                if not job.cancelled():
                    self._refused(task, problem)

    def _refused(self, task: Task, problem: BaseException) -> None:
        """A model has no solution, or no figures; it is not asked again."""
        if task.stage is Stage.REPORT:
            self._revisions.made(task)
        else:
            self._revisions.give_up(task.model)
        ring(self, self._complain, task, problem)

    def _solve(self, task: Task, job: Job) -> None:
        """One model at one quality, or its final result where that is remembered."""
        bench, model = self._workbench, task.model
        if bench.result(model, "final") is not None:
            task = replace(task, stage=Stage.FINAL)
        elif not self._revisions.has_picture(task) and bench.best_result(model) is None:
            ink = replace(task, stage=Stage.INK)
            ring(self, self._take, ink, bench.model_scene(model, None))
        result = bench.solve(
            model, replace(job, quality="final" if task.stage is Stage.FINAL else "preview")
        )
        scene = bench.model_scene(model, result)
        if not job.cancelled():
            self._revisions.made(task)
            ring(self, self._take, task, scene)

    def _report(self, task: Task, job: Job) -> None:
        """The figures of a model that has its final result."""
        model = task.model
        if self._last_report is None or self._last_report[0] is not model.state:
            # Empty first, so that a report which fails or hangs is not asked for again.
            self._last_report = (model.state, {})
            self._last_report = (model.state, self._workbench.report(model, job))
        if not job.cancelled():
            self._revisions.made(task)
            ring(self, self._take_report, task, self._last_report[1])

    # -- on the window's thread --

    def _take(self, task: Task, scene: Scene) -> None:
        """Exchange one model's picture."""
        model_id = task.model.id
        if not self._revisions.show(task):
            return
        self._shown[model_id] = (task.model, scene)
        newest = self._revisions.is_newest(task)
        self.changed.emit(model_id, task.stage is not Stage.INK and newest)
        if newest and task.stage is Stage.FINAL and model_id in self._awaited:
            self._awaited.discard(model_id)
            self.settled.emit(model_id)

    def _take_report(self, task: Task, report: dict[str, Any]) -> None:
        if self._revisions.show(task):
            self.reported.emit(task.model, report)

    def _complain(self, task: Task, problem: BaseException) -> None:
        if any(task.model.state is known.state for known in self._document):
            self.failed.emit(problem)

    def _failed(self, problem: BaseException) -> None:
        """A mistake of the program itself: the model is not tried again."""
        stuck = self._revisions.running
        if stuck is not None:
            self._revisions.give_up(stuck.model)
        self.failed.emit(problem)
        if stuck is not None:
            self.show(self._document, self._selected)
