"""Edits of objects and underlays, each one step of the history."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from bozzetto.document import edit
from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.workbench.links import with_sources
from bozzetto_app.i18n import tr
from bozzetto_app.session.copy_places import step_aside, step_beside
from bozzetto_app.session.selection import why_locked
from bozzetto_app.workers.time_limit import in_time

if TYPE_CHECKING:
    from bozzetto.document.edit import Edit, Vector
    from bozzetto.document.model import Document, Model
    from bozzetto.geometry.placement import Placement
    from bozzetto.parameters import Field
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.solver import Solver
    from bozzetto_app.session.view_state import ViewState

__all__ = ["ObjectEdits", "fields_of"]


def fields_of(state: object, first: Sequence[str] = ()) -> tuple[tuple[Field, Any], ...]:
    """Return the parameters in forms of a state, or of a part, with values; some of them first."""
    if not hasattr(state, "__dataclass_fields__"):
        return ()
    from bozzetto.parameters import valued_fields

    place = {name: number for number, name in enumerate(first)}
    found = [pair for pair in valued_fields(state) if pair[0].parameter.in_forms]
    return tuple(sorted(found, key=lambda pair: place.get(pair[0].name, len(place))))


class ObjectEdits(QObject):
    """Edits of the objects and underlays of a document.

    Signals
    -------
    copied
        Objects were duplicated: there are copies beside them.
    """

    copied = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        view: ViewState,
        solver: Solver,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._view = view
        self._solver, self._notices = solver, notices

    def edit(
        self,
        change: Callable[..., Edit],
        *details: Any,
        merge_key: str | None = None,
        is_back: Callable[[Document], bool] = lambda before: False,
    ) -> None:
        """Make an edit of `bozzetto.document.edit` that may refuse.

        Parameters
        ----------
        change : callable
            Called with the document and the details.
        *details
            Further arguments of `change`.
        merge_key : str, optional
            See `DocumentModel.commit`.
        is_back : callable
            See `DocumentModel.commit`.
        """
        try:
            document, label = change(self._drawing.document, *details)
        except (UserError, PluginFault) as problem:
            self._notices.complain(problem)
            return
        self._drawing.commit(label, document, merge_key, is_back=is_back)

    # -- parameters --

    @property
    def parameters(self) -> tuple[tuple[Field, Any], ...]:
        """The parameters of the selected model with their values; none where it cannot be used."""
        model = self._selection.model
        if model is None or not self._workbench.is_usable(model):
            return ()
        return fields_of(model.state, self._workbench.first_parameters(model))

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        """Change one parameter of the selected model; the drag of a slider is one step."""
        model = self._selection.model
        if model is None:
            return
        try:
            if model.locked:
                raise UserError(why_locked())
            changed = self._workbench.set_parameters(model, {name: value})
            document = self._drawing.document.with_model(changed)
        except (UserError, PluginFault) as problem:
            self._notices.complain(problem)
            return
        fields = self.parameters
        label = next((field.parameter.label for field, _ in fields if field.name == name), name)
        key = f"parameter {model.id} {name}" if dragging else None

        def is_back(before: Document) -> bool:
            known = getattr(before.model(model.id).state, name, None)
            return known is not None and bool(known == getattr(changed.state, name, None))

        self._drawing.commit(label, document, key, is_back=is_back)

    def end_drag(self) -> None:
        """Note that a slider was released: the next change is a step of its own."""
        self._drawing.history.end_merge()
        self._solver.let_go()

    # -- objects --

    def set_placement(self, model_id: str, placement: Placement, *, dragging: bool = False) -> None:
        """Move a model; the drag of a field is one step."""
        key = f"place {model_id}" if dragging else None

        def is_back(before: Document) -> bool:
            return before.model(model_id).placement == placement

        self.edit(edit.place_model, model_id, placement, merge_key=key, is_back=is_back)

    def rename(self, model_id: str, name: str) -> None:
        """Give a model another name."""
        self.edit(edit.rename_model, model_id, name)

    def set_visible(self, model_id: str, visible: bool) -> None:
        """Show or hide a model."""
        self.edit(edit.show_model, model_id, visible)

    def set_locked(self, model_id: str, locked: bool) -> None:
        """Lock or unlock a model."""
        self.edit(edit.lock_model, model_id, locked)

    def toggle_visible(self) -> None:
        """Show or hide the selected model."""
        model = self._selection.model
        if model is not None:
            self.set_visible(model.id, not model.visible)

    def toggle_locked(self) -> None:
        """Lock or unlock the selected model."""
        model = self._selection.model
        if model is not None:
            self.set_locked(model.id, not model.locked)

    def set_color(self, model_id: str, color: tuple[int, int, int] | None) -> None:
        """Give a model a colour (RGB, 0 … 255); None restores the colour of clay."""
        self.edit(edit.color_model, model_id, color)

    def delete(self, model_id: str) -> None:
        """Delete a model."""
        before = self._drawing.document
        self.edit(edit.delete_models, [model_id])
        self.tell_frozen(before)

    def duplicate(self, *model_ids: str) -> None:
        """Put copies of models beside them, and select the last one.

        A copy follows copies where there are any.
        """
        before = self._drawing.document
        models = [model for model in before if model.id in model_ids]
        self.edit(edit.duplicate_models, model_ids, self.relinked, self._step_from(models))
        there = {model.id for model in before}
        copies = [model.id for model in self._drawing.document if model.id not in there]
        if copies:
            self._selection.select(copies[-1])
            self.copied.emit()

    def paste(self, copied: Document) -> None:
        """Put copied models where they stood, or beside what they would lie on."""
        there = {(id(model.state), model.placement) for model in copied}
        models = [m for m in self._drawing.document if (id(m.state), m.placement) in there]
        self.edit(edit.paste_models, copied, self.relinked, self._step_from(models))

    def _step_from(self, models: Sequence[Model]) -> Vector:
        """Return the way by which copies are told from models of the document, mm.

        They lie beside them and in nobody's way; of what shows nothing a little aside.
        """
        own = {model.id for model in models}
        boxes = [self._solver.extent(model.id) for model in models]
        others = [
            self._solver.extent(model.id)
            for model in self._drawing.document
            if model.visible and model.id not in own
        ]
        camera = self._view.camera
        return step_beside(camera, boxes, others) or step_aside(camera)

    def relinked(self, model: Model, sources: tuple[str, ...]) -> Model:
        """Return a model that is made from others instead, as many and in the same order."""
        registry = self._workbench.registry
        return in_time(
            registry.guard,
            model.modeler,
            "with_sources",
            lambda: with_sources(registry, model, sources),
        )

    # -- links --

    def unlink(self, model_id: str) -> None:
        """Let a model follow nothing any more; what it followed stays frozen in it."""
        self.edit(edit.unlink_model, model_id)

    def link(self, model_id: str) -> None:
        """Let a model follow again what it was unlinked from."""
        self.edit(edit.link_model, model_id)

    def unlink_selected(self) -> None:
        """Let the selected model follow nothing any more, or again what it was unlinked from."""
        model = self._selection.model
        if model is not None:
            (self.unlink if model.followed else self.link)(model.id)

    def tell_frozen(self, before: Document) -> None:
        """Say which models keep something frozen that they followed before."""
        were = {model.id: model for model in before}
        for model in self._drawing.document:
            followed = were[model.id].followed if model.id in were else ()
            kept = [f"“{source.name}”" for source in model.frozen if source.id in followed]
            if kept:
                self._notices.tell(
                    tr(
                        "Object",
                        "“{name}” keeps {names} as it was. Undo links them again.",
                        name=model.name,
                        names=" and ".join(kept),
                    )
                )

    def move_to(self, model_id: str, index: int) -> None:
        """Move a model to another place in the list, counted from 0."""
        self.edit(edit.move_model, model_id, index)

    # -- underlays --

    def set_underlay_opacity(
        self, underlay_id: str, opacity: float, *, dragging: bool = False
    ) -> None:
        """Make an underlay more or less opaque, 0 … 1; the drag of a slider is one step."""
        key = f"underlay {underlay_id}" if dragging else None
        self._change_underlay(underlay_id, key, opacity=opacity)

    def set_underlay_visible(self, underlay_id: str, visible: bool) -> None:
        """Show or hide an underlay."""
        self._change_underlay(underlay_id, None, visible=visible)

    def delete_underlay(self, underlay_id: str) -> None:
        """Delete an underlay."""
        self.edit(edit.delete_underlay, underlay_id)

    def _change_underlay(self, underlay_id: str, key: str | None, **changes: Any) -> None:
        for underlay in self._drawing.document.underlays:
            if underlay.id == underlay_id:
                self.edit(edit.change_underlay, replace(underlay, **changes), merge_key=key)
