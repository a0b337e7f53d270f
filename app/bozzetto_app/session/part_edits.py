"""Edits of the parts of an object, each one step of the history.

Only the choice of a part is no step: nobody wants to undo it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from bozzetto.document import edit
from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.workbench.part_edits import PartEdit, PartEdits
from bozzetto_app.i18n import tr
from bozzetto_app.session.object_edits import ObjectEdits, fields_of
from bozzetto_app.workers.time_limit import in_time

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.parameters import Field
    from bozzetto.plugin.part_tree import PartTree
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection

__all__ = ["ObjectParts"]

Answer = TypeVar("Answer")


class ObjectParts:
    """Edits of the parts of an object.

    Widgets cannot wait for a worker, so plugins are asked on the window's thread: one that
    hangs is interrupted.
    """

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        objects: ObjectEdits,
        notices: Notices,
    ) -> None:
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._objects, self._notices = objects, notices
        self._unreadable: dict[str, Any] = {}  # by id of the model, a state without readable parts

    # -- reading --

    def of(self, model_id: str) -> PartTree | None:
        """Return the parts of a model; None if it has none, or they cannot be read."""
        return self.of_model(self._drawing.document.model(model_id))

    def of_model(self, model: Model) -> PartTree | None:
        """Return the parts of a model, as `of` does: a long list need not look for each."""
        if model.state is self._unreadable.get(model.id):
            return None
        edits = self._workbench.parts
        known = edits.remembered(model)
        if known is not None:
            return known
        try:
            if not edits.may_have(model):
                return None
            return self._in_time(model, lambda edits: edits.of(model))
        except (UserError, PluginFault) as problem:
            # Asked for at every change of the document: reported once.
            self._unreadable[model.id] = model.state
            self._notices.complain(problem)
            return None

    @property
    def chosen(self) -> Any | None:
        """The part whose parameters are shown: the chosen one, or the only one there is."""
        tree = self._selected_tree
        if tree is None:
            return None
        only = tree.parts[0].id if len(tree.parts) == 1 else ""
        meant = tree.selected or only
        return tree.part(meant) if meant else None

    @property
    def parameters(self) -> tuple[tuple[Field, Any], ...]:
        """The parameters of the chosen part with their values."""
        model = self._selection.model
        if model is None or not self._workbench.is_usable(model):
            return ()
        return fields_of(self.chosen, self._workbench.first_parameters(model))

    @property
    def chosen_group(self) -> str:
        """Id of the chosen part of the selected model if it is a group, else ""."""
        tree = self._selected_tree
        return tree.selected if tree is not None and tree.selected in tree.groups else ""

    def chosen_among_several(self) -> tuple[str, str]:
        """Return the ids of the selected model, and of its chosen part if it has others too."""
        model, tree = self._selection.model, self._selected_tree
        several = tree is not None and len(tree.parts) > 1
        return "" if model is None else model.id, tree.selected if tree and several else ""

    @property
    def _selected_tree(self) -> PartTree | None:
        model = self._selection.model
        return None if model is None else self.of(model.id)

    # -- changing --

    def select(self, model_id: str, part_id: str) -> None:
        """Select a model and choose one of its parts, "" for none; no step of the history."""
        self._selection.select(model_id)
        tree = self.of(model_id)
        if tree is None or tree.selected == part_id:
            return
        model = self._drawing.document.model(model_id)
        try:
            chosen = self._in_time(model, lambda edits: edits.select(model, part_id))
        except (UserError, PluginFault) as problem:
            self._notices.complain(problem)
            return
        self._drawing.amend(self._drawing.document.with_model(chosen))

    def rename(self, model_id: str, part_id: str, name: str) -> None:
        """Give a part another name."""
        self._edit(model_id, lambda edits, model: edits.rename(model, part_id, name))

    def set_visible(self, model_id: str, part_id: str, visible: bool) -> None:
        """Show a part, or leave it out of the shape."""
        self._edit(model_id, lambda edits, model: edits.show(model, part_id, visible))

    def delete(self, model_id: str, part_id: str) -> None:
        """Delete a part with all that is in it."""
        self._edit(model_id, lambda edits, model: edits.delete(model, part_id))

    def duplicate(self, model_id: str, part_id: str) -> None:
        """Put a copy behind a part."""
        self._edit(model_id, lambda edits, model: edits.duplicate(model, part_id))

    def move(self, model_id: str, part_id: str, group_id: str, at: int) -> None:
        """Move a part to a place in a group, or outside all groups.

        Parameters
        ----------
        model_id, part_id : str
            The model and its part.
        group_id : str
            "" for outside all groups.
        at : int
            The new place, counted from 0 without the part.
        """
        self._edit(model_id, lambda edits, model: edits.move(model, part_id, group_id, at))

    def delete_chosen(self) -> None:
        """Delete the chosen part, or the selected model if no part among several is chosen."""
        model_id, part_id = self.chosen_among_several()
        if part_id:
            self.delete(model_id, part_id)
        else:
            self._objects.delete(model_id)

    def delete_several(
        self,
        model_ids: Sequence[str],
        parts: Mapping[str, Sequence[str]],
        underlay_ids: Sequence[str],
    ) -> None:
        """Delete models, parts of other models and underlays, all in one step.

        Parameters
        ----------
        model_ids, underlay_ids : sequence of str
            What is deleted as a whole.
        parts : mapping
            Ids of parts by the id of their model.
        """
        document, labels = self._drawing.document, []
        try:
            for model_id in parts.keys() - set(model_ids):
                model, ids = document.model(model_id), parts[model_id]
                changed, label = self._in_time(model, _deleting(model, ids))
                document = document.with_model(changed)
                labels.append(label)
            if model_ids:
                document, label = edit.delete_models(document, model_ids)
                labels.append(label)
            for underlay_id in underlay_ids:
                document, label = edit.delete_underlay(document, underlay_id)
                labels.append(label)
        except (UserError, PluginFault) as problem:
            self._notices.complain(problem)
            return
        several = tr("Session", "Delete what is chosen")
        before = self._drawing.document
        self._drawing.commit(labels[0] if len(labels) == 1 else several, document)
        self._objects.tell_frozen(before)

    def duplicate_chosen(self) -> None:
        """Copy the chosen part, or the selected model if no part among several is chosen."""
        model_id, part_id = self.chosen_among_several()
        if part_id:
            self.duplicate(model_id, part_id)
        else:
            self._objects.duplicate(model_id)

    def group(self, model_id: str, part_ids: Sequence[str]) -> None:
        """Put parts into a new group."""
        self._edit(model_id, lambda edits, model: edits.group(model, part_ids))

    def ungroup(self, model_id: str, part_id: str) -> None:
        """Dissolve a group; its parts stay where they are."""
        self._edit(model_id, lambda edits, model: edits.ungroup(model, part_id))

    def ungroup_chosen(self) -> None:
        """Dissolve the chosen group."""
        model, group = self._selection.model, self.chosen_group
        if model is not None and group:
            self.ungroup(model.id, group)

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        """Change a parameter of the chosen part; the drag of a slider is one step."""
        model, part = self._selection.model, self.chosen
        if model is not None and part is not None:
            self.set_value(model.id, part.id, name, value, dragging=dragging)

    def set_value(
        self, model_id: str, part_id: str, name: str, value: object, *, dragging: bool = False
    ) -> None:
        """Change a parameter of any part; the drag of a slider is one step."""
        tree = self.of(model_id)
        part = None if tree is None else tree.part(part_id)
        if part is None:
            return
        labels = {field.name: field.parameter.label for field, _ in fields_of(part)}

        def change(edits: PartEdits, model: Model) -> PartEdit:
            changed = edits.set(model, part_id, {name: value}).model
            return PartEdit(changed, labels.get(name, name))

        def value_in(document: Document) -> object:
            tree = self._workbench.parts.remembered(document.model(model_id))
            part = None if tree is None else tree.part(part_id)
            return getattr(part, name, None)

        key = f"part {model_id} {part_id} {name}" if dragging else None
        self._edit(model_id, change, key, is_back=lambda before: value_in(before) == value)

    def _edit(
        self,
        model_id: str,
        change: Callable[[PartEdits, Model], PartEdit],
        merge_key: str | None = None,
        is_back: Callable[[Document], bool] = lambda before: False,
    ) -> None:
        document = self._drawing.document
        try:
            model = document.model(model_id)
            changed, label = self._in_time(model, lambda edits: change(edits, model))
            document = document.with_model(changed)
        except (UserError, PluginFault) as problem:
            self._notices.complain(problem)
            return
        self._drawing.commit(label, document, merge_key, is_back=is_back)

    def _in_time(self, model: Model, ask: Callable[[PartEdits], Answer]) -> Answer:
        bench = self._workbench
        return in_time(bench.registry.guard, model.modeler, "parts", lambda: ask(bench.parts))


def _deleting(model: Model, part_ids: Sequence[str]) -> Callable[[PartEdits], PartEdit]:
    """Return the edit that deletes these parts of this model."""
    return lambda edits: edits.delete(model, *part_ids)
