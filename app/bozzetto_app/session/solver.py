"""Solve the models of the document in the background, and keep the scene of each.

Previews of all models come first, then the final results, one by one. A scene stays until a
better one replaces it; `revisions` decides which answer is better, and which work goes first.
A model without a solution, or whose plugin fails, is reported once and not tried again; its
ink is shown all the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.document.links import LinkedModels, is_same_recipe
from bozzetto.errors import Cancelled, UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto_app.session.copy_places import extent_of
from bozzetto_app.session.revisions import Revisions, Stage, Task
from bozzetto_app.workers.channel import LATE_AFTER, Channel, Request
from bozzetto_app.workers.main_thread import call_on_main_thread

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.document.model import Model
    from bozzetto.plugin.figures import Figure
    from bozzetto.plugin.job import Job
    from bozzetto.scene.display_list import Layer, Scene
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection

__all__ = ["Solver"]

Report = tuple[dict[str, Any], "Mapping[str, Figure]"]
"""Values, and the words in which they are said."""

REST: Final = 300
"""Time without a change after which a drag gets its final result, ms, though it may go on."""

LATEST_PAINT: Final = 250
"""How long the next preview waits for earlier ones to be painted, ms: where nothing had to be
repainted, no viewport reports it."""


TOGETHER: Final = 0.02
"""How long answers wait for the next one, s: a model and its quick followers are one picture."""


class _Answer(NamedTuple):
    """The scene of a model as it was at a task, and the result that it shows; None for ink."""

    task: Task
    scene: Scene
    result: Any = None


class _Answers:
    """Scenes that a worker has made and not yet handed over.

    Parameters
    ----------
    hand_on : callable
        Gets them in the order in which they were made.
    """

    def __init__(self, hand_on: Callable[[Sequence[_Answer]], None]) -> None:
        self._hand_on = hand_on
        self._made: list[_Answer] = []
        self._since = 0.0

    def add(self, answer: _Answer) -> None:
        """Keep one more, unless the first has waited long enough."""
        if not self._made:
            self._since = time.monotonic()
        self._made.append(answer)
        if time.monotonic() - self._since > TOGETHER:
            self.hand_over()

    def hand_over(self) -> None:
        """Hand over what is there."""
        if self._made:
            made, self._made = self._made, []
            self._hand_on(made)


class Solver(QObject):
    """The scenes of the models of a document, kept up to date by one worker.

    Attributes
    ----------
    report : dict
        How good the final result of the selected model is; empty until it is known.
    figures : mapping of str to Figure
        In which words and units its values are said; see `Modeler.figures`.

    Signals
    -------
    changed : str, bool
        The scene of a model (id) differs; True if it shows the solved shape of the newest
        state.
    settled : str
        A model (id) that a gesture made has its first final scene.
    report_changed
        `report` differs.
    failed
        A model has no solution; the person has been told.
    progressed : float, str; busy_changed : bool
        Work advances, starts, ends.
    """

    changed = Signal(str, bool)
    settled = Signal(str)
    report_changed = Signal()
    failed = Signal()
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.report: dict[str, Any] = {}
        self.figures: Mapping[str, Figure] = {}
        self._workbench, self._notices = workbench, notices
        self._drawing, self._selection = drawing, selection
        self._shown: dict[str, _Answer] = {}
        self._extents: dict[str, tuple[Scene, Array]] = {}
        self._revisions = Revisions()
        self._linked = LinkedModels()
        self._last_report: tuple[Model, Report] | None = None
        self._awaited: set[str] = set()
        self._quick: set[str] = set()  # ids of models whose last answer took no time to speak of
        self._channel = Channel("solve", time_limit=LATE_AFTER, is_patient=True, parent=self)
        notices.watch(self._channel)
        self._channel.progressed.connect(self.progressed)
        self._channel.busy_changed.connect(self.busy_changed)
        self._rest = QTimer(self, singleShot=True, interval=REST)
        self._rest.timeout.connect(self.let_go)
        self._paint = QTimer(self, singleShot=True, interval=LATEST_PAINT)
        self._paint.timeout.connect(lambda: self.frame_painted())
        drawing.models_changed.connect(self._solve_changed)
        drawing.applied.connect(self._awaited.add)
        drawing.closing.connect(self.forget)
        selection.changed.connect(self._selection_changed)

    @property
    def busy(self) -> bool:
        """Whether something is still being solved."""
        return self._channel.busy or self._rest.isActive()

    def layers(self) -> Iterator[Layer]:
        """Return the layers of all visible models, in the order of the document."""
        for model in self._drawing.document:
            if model.visible and model.id in self._shown:
                yield from self._shown[model.id].scene.layers

    def extent(self, model_id: str) -> Array:
        """Return the box of what is shown of a model, or would be if it were visible, (2, 3) mm.

        NaN if there is nothing; see `extent_of`.
        """
        found = self._shown.get(model_id)
        if found is None:
            return extent_of(())
        known = self._extents.get(model_id)
        if known is None or known[0] is not found.scene:
            known = self._extents[model_id] = found.scene, extent_of(found.scene.layers)
        return known[1]

    def shown(self, model_id: str) -> Model | None:
        """Return the state of a model that is shown; None if nothing of it is."""
        found = self._shown.get(model_id)
        return None if found is None else found.task.model

    def shown_result(self, model: Model) -> Any | None:
        """Return the result that is shown of exactly this recipe; None if none is."""
        found = self._shown.get(model.id)
        if found is None or not is_same_recipe(found.task.model, model):
            return None
        return found.result

    def forget(self) -> None:
        """Drop all scenes and all work: another document comes."""
        self.cancel()
        self._revisions.forget()
        self._linked.forget()
        self._shown.clear()
        self._extents.clear()
        self._awaited.clear()
        self._quick.clear()
        self._last_report = None

    def cancel(self) -> None:
        """Stop solving; what is shown stays.

        A state that was reported as slow is not tried again.
        """
        self._rest.stop()
        running, task = self._channel.running, self._revisions.running
        if running is not None and running.is_told_slow and task is not None:
            self._revisions.give_up(task.model)
        self._channel.cancel()
        self._revisions.stop()

    def let_go(self) -> None:
        """Make the final results: a drag has ended, or pauses."""
        self._rest.stop()
        if self._revisions.let_go():
            self._submit()
            self._drawing.end_drag()

    def expect_paint(self, paints: bool) -> None:
        """Note whether a viewport paints what is shown, and calls `frame_painted`."""
        self._revisions.expect_paint(paints)

    def frame_painted(self, behind: int = 0) -> None:
        """Note that a frame is on the screen: the next preview may begin.

        Parameters
        ----------
        behind : int
            How many scenes newer than the painted one the viewport was given.
        """
        if behind:
            self._paint.start()
        else:
            self._paint.stop()
        if self._revisions.painted(behind):
            self._submit()

    def _solve_changed(self) -> None:
        """Bring the scenes up to date with the document.

        While a value is dragged only previews are made; final results wait for `let_go`.
        """
        document, dragging = self._drawing.document, self._drawing.is_dragging
        known = {model.id for model in document}
        self._shown = {key: answer for key, answer in self._shown.items() if key in known}
        self._extents = {key: each for key, each in self._extents.items() if key in known}
        self._ask(dragging=dragging)
        if dragging:
            self._rest.start()
        else:
            self._rest.stop()
        self._submit()

    def _selection_changed(self) -> None:
        """Report on the model that is selected now."""
        self.report, self.figures = {}, {}
        self.report_changed.emit()
        if self._selection.model is not None:
            self._ask(dragging=False)
            self._submit()

    def _ask(self, *, dragging: bool) -> None:
        """Ask for the visible models whose plugin is here."""
        models = self._linked.resolved(self._drawing.document)
        soluble = [
            models[model.id]
            for model in self._drawing.document
            if model.visible and not self._workbench.is_foreign(model)
        ]
        running = self._channel.running
        unwanted = self._revisions.ask(soluble, self._selection.id or "", dragging=dragging)
        if running is not None and unwanted:
            running.abandon()

    def _submit(self) -> None:
        self._channel.submit(Request(self._work, lambda _: None, self._failed))

    # -- in the worker --

    def _work(self, job: Job) -> None:
        """Do the most urgent task until nothing is left."""
        answers = _Answers(lambda made: call_on_main_thread(self, self._take_all, made))
        try:
            while not job.cancelled():
                task = self._revisions.next()
                if task is None:
                    return
                job.progress(0.0, task.model.name)
                try:
                    if task.stage is Stage.REPORT:
                        self._report(task, job)
                    else:
                        self._solve(task, job, answers)
                except (UserError, PluginFault) as problem:
                    # Work that was replaced and then interrupted is no fault.
                    if not job.cancelled():
                        self._refused(task, problem)
        finally:
            answers.hand_over()

    def _refused(self, task: Task, problem: BaseException) -> None:
        """Note that a model has no solution, or no figures; it is not asked again."""
        if task.stage is Stage.REPORT:
            self._revisions.made(task)
        else:
            self._revisions.give_up(task.model)
        call_on_main_thread(self, self._complain, task, problem)

    def _solve(self, task: Task, job: Job, answers: _Answers) -> None:
        """Solve one model at one quality, or show its final result if that is cached."""
        bench, model, begun = self._workbench, task.model, time.monotonic()
        if bench.result(model, "final") is not None:
            task = task._replace(stage=Stage.FINAL)
        elif not self._revisions.has_picture(task) and bench.best_result(model) is None:
            ink = task._replace(stage=Stage.INK)
            answer = _Answer(ink, bench.model_scene(model, None))
            call_on_main_thread(self, self._take_all, (answer,))
        result = bench.solve(
            model, replace(job, quality="final" if task.stage is Stage.FINAL else "preview")
        )
        scene = bench.model_scene(model, result)
        if not job.cancelled():
            self._revisions.made(task)
            answers.add(_Answer(task, scene, result))
            is_quick = time.monotonic() - begun < TOGETHER
            (self._quick.add if is_quick else self._quick.discard)(model.id)
            if self._revisions.next_preview not in self._quick:
                answers.hand_over()

    def _report(self, task: Task, job: Job) -> None:
        """Compute the figures of a model that has its final result."""
        model = task.model
        if self._last_report is None or not is_same_recipe(self._last_report[0], model):
            # Empty first, so that a report which fails or hangs is not asked for again.
            empty: tuple[Model, Report] = (model, ({}, {}))
            self._last_report = empty
            try:
                report = self._workbench.report(model, job)
            except Cancelled:
                if self._last_report is empty:
                    self._last_report = None
                raise
            self._last_report = (model, (report, self._workbench.figures(model)))
        if not job.cancelled():
            self._revisions.made(task)
            call_on_main_thread(self, self._take_report, task, self._last_report[1])

    # -- on the window's thread --

    def _take_all(self, answers: Sequence[_Answer]) -> None:
        """Replace the scenes of some models, all before anybody looks: they are one picture."""
        for answer in [answer for answer in answers if self._replace(answer)]:
            self._tell(answer.task)

    def _replace(self, answer: _Answer) -> bool:
        """Replace a scene, unless something newer is shown; return whether it was."""
        task = answer.task
        if task.stage is Stage.PREVIEW and self._drawing.is_dragging:
            self._paint.start()
        if not self._revisions.show(task):
            return False
        self._shown[task.model.id] = answer
        return True

    def _tell(self, task: Task) -> None:
        """Say that the scene of a model differs."""
        model_id, newest = task.model.id, self._revisions.is_newest(task)
        self.changed.emit(model_id, task.stage is not Stage.INK and newest)
        if newest and task.stage is Stage.FINAL and model_id in self._awaited:
            self._awaited.discard(model_id)
            self.settled.emit(model_id)

    def _take_report(self, task: Task, report: Report) -> None:
        selected = self._selection.model
        if not self._revisions.show(task) or selected is None:
            return
        if task.model.state is selected.state:
            self.report, self.figures = report
            self.report_changed.emit()

    def _complain(self, task: Task, problem: BaseException) -> None:
        if any(task.model.state is known.state for known in self._drawing.document):
            self.failed.emit()
            self._notices.complain(problem)

    def _failed(self, problem: BaseException) -> None:
        """Report a bug of the program itself, and do not try the model again."""
        stuck = self._revisions.running
        if stuck is not None:
            self._revisions.give_up(stuck.model)
        self.failed.emit()
        self._notices.complain(problem)
        if stuck is not None:
            self._solve_changed()
