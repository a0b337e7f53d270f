"""Showing: solves what is on the sheet in the background and keeps the picture of each model.

First a preview of everything, so that a shape stands within a blink; then the final
results, one by one. What was shown stays until something better is there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Document, Model
from bozzetto.errors import UserError
from bozzetto.plugin.guard import PluginFault
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Layer, Scene
from bozzetto.workbench import Workbench
from bozzetto_app.jobs import Channel, Request

__all__ = ["Showing"]


class Showing(QObject):
    """The pictures of a document's models, kept up to date by one worker.

    Signals
    -------
    changed
        Some model's picture is another one.
    settled : str
        A model (id) that was waiting for it has its final picture.
    reported : Model, dict
        Figures of the model asked for.
    failed : object
        The exception with which a model refused to be solved or shown.
    progressed : float, str; busy_changed : bool
    """

    changed = Signal()
    settled = Signal(str)
    reported = Signal(object, object)
    failed = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)
    _solved = Signal(object, object, object)

    def __init__(self, workbench: Workbench, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workbench = workbench
        self._document = Document()
        self._shown: dict[str, tuple[Model, Any, Scene]] = {}
        self._awaited: set[str] = set()
        self._channel = Channel("solve", parent=self)
        self._channel.progressed.connect(self.progressed)
        self._channel.busy_changed.connect(self.busy_changed)
        self._solved.connect(self._take)

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
        self._awaited.clear()

    def cancel(self) -> None:
        """Stop solving; what is shown stays."""
        self._channel.cancel()

    def show(self, document: Document, selected: Model | None) -> None:
        """Bring the pictures up to date with a document, and report on the selected model."""
        self._document = document
        known = {model.id for model in document}
        self._shown = {key: value for key, value in self._shown.items() if key in known}
        if self._channel.running is not None:
            self._channel.running.abandon()

        def work(job: Job) -> tuple[Model, dict[str, Any]] | None:
            for quality in ("preview", "final"):
                for model in document:
                    if model.visible and not self._workbench.is_foreign(model):
                        self._solve(model, replace(job, quality=quality))
            if selected is None or self._workbench.result(selected, "final") is None:
                return None
            return selected, self._workbench.report(selected, job)

        def done(answer: tuple[Model, dict[str, Any]] | None) -> None:
            if answer is not None:
                self.reported.emit(*answer)

        self._channel.submit(Request(work, done, self.failed.emit))

    def _solve(self, model: Model, job: Job) -> None:
        """In the worker: one model at one quality, unless that is shown already."""
        bench = self._workbench
        if job.quality == "preview" and bench.result(model, "final") is not None:
            return
        try:
            result = bench.solve(model, job)
            shown = self._shown.get(model.id)
            if shown is not None and shown[0] is model and shown[1] is result:
                return
            self._solved.emit(model, result, bench.model_scene(model, result))
        except (UserError, PluginFault) as problem:
            self._solved.emit(model, None, problem)

    def _take(self, model: Model, result: Any, answer: Any) -> None:
        """On the window's thread: exchange one model's picture."""
        if all(model is not known for known in self._document):
            return
        if isinstance(answer, BaseException):
            self.failed.emit(answer)
            return
        self._shown[model.id] = (model, result, answer)
        self.changed.emit()
        if model.id in self._awaited and result is self._workbench.result(model, "final"):
            self._awaited.discard(model.id)
            self.settled.emit(model.id)
