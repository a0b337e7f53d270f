"""Using: a shape becomes the input of another modeler."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Model
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.plugin.host.registry import ModelerInfo
    from bozzetto_app.session.session import Session

__all__ = ["Using"]


class Using(QObject):
    """Takes the shapes of objects, or of some of their parts, into a new object.

    Signals
    -------
    progressed : float, str; busy_changed : bool
    """

    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._channel = Channel("use", keep_all=True, parent=self)
        self._channel.progressed.connect(self.progressed)
        self._channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether shapes are still being taken."""
        return self._channel.busy

    @property
    def takers(self) -> tuple[ModelerInfo, ...]:
        """The modelers that can start from shapes; also those that nobody draws with."""
        return tuple(info for info in self._session.registry.modelers() if info.reads_shapes)

    def cancel(self) -> None:
        """Stop it; nothing comes of what is under way."""
        self._channel.cancel()

    def use_chosen(self, modeler_id: str) -> None:
        """Start from the chosen part, or from the selected object where none among several is."""
        model_id, part_id = self._session.chosen_among_several()
        if not model_id:
            self._session.complain(UserError(tr("Session", "Choose an object to start from.")))
            return
        self.use(modeler_id, [model_id], {model_id: [part_id]} if part_id else {})

    def use(
        self, modeler_id: str, model_ids: Sequence[str], parts: Mapping[str, Sequence[str]]
    ) -> None:
        """Start a new object from others.

        Parameters
        ----------
        modeler_id : str
            Whose object it becomes.
        model_ids : sequence of str
            The objects to start from.
        parts : mapping
            By the id of an object, those of its parts that are meant; all where it is not there.
        """
        session = self._session
        bench, history = session.workbench, session.history
        models = [session.document.model(model_id) for model_id in model_ids]

        def work(job: Job) -> Model:
            meant = [
                bench.parts.only(model, parts[model.id]) if model.id in parts else model
                for model in models
            ]
            return bench.sources.from_models(modeler_id, meant, job)

        def done(model: Model) -> None:
            if session.history is history:
                label = tr("Session", "Start from “{name}”", name=model.name)
                session.take_drawn(label, model, is_new=True)

        self._channel.submit(Request(work, done, session.complain))
