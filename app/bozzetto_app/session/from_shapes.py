"""New objects that start from the shapes of others, or follow them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.plugin.host.registry import ModelerInfo
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.part_edits import ObjectParts

__all__ = ["ShapeInput"]


class ShapeInput(QObject):
    """Makes a new object from the shapes of objects, or of some of their parts.

    Attributes
    ----------
    channel : Channel
        The work under way.

    Signals
    -------
    begun
        A new object has come, which may stand elsewhere than what it was made from.
    """

    begun = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        parts: ObjectParts,
        notices: Notices,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._workbench, self._drawing = workbench, drawing
        self._parts, self._notices = parts, notices
        self.channel = Channel("use", keep_all=True, parent=self)

    @property
    def takers(self) -> tuple[ModelerInfo, ...]:
        """The modelers that can start from shapes; also those that nobody draws with."""
        return tuple(
            info
            for info in self._workbench.registry.modelers()
            if not info.abilities.isdisjoint({"read_shapes", "follow"})
        )

    def use_chosen(self, modeler_id: str) -> None:
        """Start from the chosen part, or from the selected object if no part is chosen."""
        model_id, part_id = self._parts.chosen_among_several()
        if not model_id:
            self._notices.complain(UserError(tr("Session", "Choose an object to start from.")))
            return
        self.use(modeler_id, [model_id], {model_id: [part_id]} if part_id else {})

    def use(
        self, modeler_id: str, model_ids: Sequence[str], parts: Mapping[str, Sequence[str]]
    ) -> None:
        """Start a new object from others.

        It follows them where its modeler can. Of single parts it gets a copy instead, or follows
        the whole object where its modeler takes no copy.

        Parameters
        ----------
        modeler_id : str
            The modeler of the new object.
        model_ids : sequence of str
            The objects to start from.
        parts : mapping
            By the id of an object, its parts to start from; all parts of the other objects.
        """
        bench, history = self._workbench, self._drawing.history
        known = resolved(self._drawing.document)
        models = [known[model_id] for model_id in model_ids]
        info = bench.registry.info(modeler_id)
        abilities = info.abilities
        follows = "follow" in abilities and not (parts and "read_shapes" in abilities)

        def work(job: Job) -> Model:
            if follows:
                return bench.sources.following(modeler_id, models, job)
            meant = [
                bench.parts.only(model, parts[model.id]) if model.id in parts else model
                for model in models
            ]
            return bench.sources.from_models(modeler_id, meant, job)

        def done(model: Model) -> None:
            if self._drawing.history is not history:
                return
            there = {other.id: other for other in self._drawing.document}
            if not there.keys() >= set(model.sources):
                gone = tr("Session", "What was to be followed is no longer there.")
                self._notices.complain(UserError(gone))
                return
            if follows:
                names = " and ".join(f"“{there[source].name}”" for source in model.sources)
                label = tr("Session", "Follow {names}", names=names)
            else:
                label = tr("Session", "Start from “{name}”", name=model.name)
            # What stands where the object stands would lie in it, or hide it.
            replaced = info.replaces if follows else not parts
            hidden = tuple(model_ids) if replaced else ()
            self._drawing.apply_model(label, model, is_new=True, hidden=hidden)
            self.begun.emit()
            if "follow" in abilities and not follows:
                self._notices.tell(
                    tr(
                        "Session",
                        "Parts are copied, not followed. To follow the whole object, choose its "
                        "row in the list of objects.",
                    )
                )

        self.channel.submit(Request(work, done, self._notices.complain))
