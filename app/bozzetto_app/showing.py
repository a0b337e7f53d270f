"""Showing: solves what is on the sheet in the background and keeps the picture of each model.

First a preview of everything, so that a shape stands within a blink; then the final
results, one by one. What was shown stays until something better is there. A recipe that
has no solution, or whose plugin fails over it, is complained about once and not tried
again; its ink is shown all the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Document, Model
from bozzetto.errors import UserError
from bozzetto.plugin.guard import PluginFault
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Layer, Scene
from bozzetto.workbench import Workbench
from bozzetto_app.doorbell import ring
from bozzetto_app.jobs import Channel, Request

__all__ = ["Showing"]

SOLVE_LIMIT = 60.0
"""Seconds a solve may go on without a sign of progress before it counts as hung."""

UNSOLVED: Final = object()
"""Stands for the result of a recipe that is shown before it is solved."""


class Showing(QObject):
    """The pictures of a document's models, kept up to date by one worker.

    Signals
    -------
    changed : str, bool
        A model's (id) picture is another one; True if it shows a solved shape.
    settled : str
        A model (id) that was waiting for it has its final picture.
    reported : Model, dict
        Figures of the model asked for.
    failed : object
        The exception with which a model refused to be solved or shown.
    progressed : float, str; busy_changed : bool
    """

    changed = Signal(str, bool)
    settled = Signal(str)
    reported = Signal(object, object)
    failed = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, workbench: Workbench, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workbench = workbench
        self._document = Document()
        self._shown: dict[str, tuple[Model, Any, Scene]] = {}
        self._insoluble: dict[str, Any] = {}
        self._in_hand: Model | None = None
        self._last_report: tuple[Any, dict[str, Any]] | None = None
        self._awaited: set[str] = set()
        self._channel = Channel("solve", time_limit=SOLVE_LIMIT, parent=self)
        self._channel.progressed.connect(self.progressed)
        self._channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether something is still being solved."""
        return self._channel.busy

    def layers(self) -> Iterator[Layer]:
        """The layers of all visible models, in the document's order."""
        for model in self._document:
            if model.visible and model.id in self._shown:
                yield from self._shown[model.id][2].layers

    def await_final(self, model_id: str) -> None:
        """Ask for `settled` when this model's final picture is there."""
        self._awaited.add(model_id)

    def forget(self) -> None:
        """Drop every picture and all work: another document comes."""
        self._channel.cancel()
        self._shown.clear()
        self._insoluble.clear()
        self._awaited.clear()
        self._last_report = None

    def cancel(self) -> None:
        """Stop solving; what is shown stays."""
        self._channel.cancel()

    def show(self, document: Document, selected: Model | None) -> None:
        """Bring the pictures up to date with a document, and report on the selected model."""
        self._document = document
        known = {model.id for model in document}
        self._shown = {key: value for key, value in self._shown.items() if key in known}
        self._insoluble = {key: value for key, value in self._insoluble.items() if key in known}
        if self._channel.running is not None and self._is_urgent(document):
            self._channel.running.abandon()

        def work(job: Job) -> tuple[Model, dict[str, Any]] | None:
            for quality in ("preview", "final"):
                for model in self._soluble(document):
                    if document is not self._document:
                        return None
                    self._in_hand = model
                    self._solve(model, replace(job, quality=quality))
            self._in_hand = selected
            return self._report(selected, job)

        def done(answer: tuple[Model, dict[str, Any]] | None) -> None:
            if answer is not None:
                self.reported.emit(*answer)

        def failed(problem: BaseException) -> None:
            """A plugin hangs: the others' models get their turn."""
            stuck = self._in_hand
            if stuck is not None:
                self._insoluble[stuck.id] = stuck.state
            self.failed.emit(problem)
            if stuck is not None:
                self.show(self._document, selected)

        self._channel.submit(Request(work, done, failed))

    def _soluble(self, document: Document) -> list[Model]:
        """The models to be solved: those that can be seen, and for which there is hope."""
        return [
            model
            for model in document
            if model.visible
            and not self._workbench.is_foreign(model)
            and self._insoluble.get(model.id) is not model.state
        ]

    def _is_urgent(self, document: Document) -> bool:
        """Whether the work in hand is unwanted, or has to wait for a model without a shape."""
        in_hand = self._in_hand
        wanted = self._soluble(document)
        if in_hand is None or all(model.state is not in_hand.state for model in wanted):
            return True
        return any(
            model.state is not in_hand.state and self._workbench.best_result(model) is None
            for model in wanted
        )

    def _solve(self, model: Model, job: Job) -> None:
        """In the worker: one model at one quality, unless that is shown already."""
        bench = self._workbench
        if job.quality == "preview" and bench.result(model, "final") is not None:
            return
        try:
            shown = self._shown.get(model.id)
            if shown is None and bench.best_result(model) is None:
                ring(self, self._take, model, UNSOLVED, bench.model_scene(model, None))
            result = bench.solve(model, job)
            if shown is not None and shown[0] is model and shown[1] is result:
                return
            ring(self, self._take, model, result, bench.model_scene(model, result))
        except (UserError, PluginFault) as problem:
            # Work that was overtaken and then interrupted is nobody's fault.
            if not job.cancelled():
                self._insoluble[model.id] = model.state
                ring(self, self._take, model, UNSOLVED, problem)

    def _report(self, model: Model | None, job: Job) -> tuple[Model, dict[str, Any]] | None:
        """In the worker: the figures of a model that has its final result."""
        if model is None or self._workbench.result(model, "final") is None:
            return None
        if self._last_report is None or self._last_report[0] is not model.state:
            # Empty first, so that a report which fails or hangs is not asked for again.
            self._last_report = (model.state, {})
            try:
                self._last_report = (model.state, self._workbench.report(model, job))
            except (UserError, PluginFault) as problem:
                if not job.cancelled():
                    ring(self, self._take, model, UNSOLVED, problem)
        return model, self._last_report[1]

    def _take(self, model: Model, result: Any, answer: Any) -> None:
        """On the window's thread: exchange one model's picture."""
        if isinstance(answer, BaseException):
            if any(model.state is known.state for known in self._document):
                self.failed.emit(answer)
            return
        if all(model is not known for known in self._document):
            return
        self._shown[model.id] = (model, result, answer)
        self.changed.emit(model.id, result is not UNSOLVED)
        if model.id in self._awaited and result is self._workbench.result(model, "final"):
            self._awaited.discard(model.id)
            self.settled.emit(model.id)
