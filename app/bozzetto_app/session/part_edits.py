"""Editing parts: what a person can do to the parts of an object, each one step of the history.

Only a choice is no step: nobody wants to take it back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from bozzetto.document import edit
from bozzetto.errors import UserError
from bozzetto.parameters import Field, parameter_fields
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.part_tree import PartTree
from bozzetto.workbench.part_edits import PartEdit, PartEdits
from bozzetto_app.i18n import tr
from bozzetto_app.workers.time_limit import in_time

if TYPE_CHECKING:
    from bozzetto.document.history import History
    from bozzetto.document.model import Document, Model
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.workbench.workbench import Workbench

__all__ = ["PartEditing"]

Answer = TypeVar("Answer")


class PartEditing:
    """The edits of parts that panels ask the session for.

    The session is one of these; what they need of it is named here.
    """

    if TYPE_CHECKING:
        history: History
        registry: Registry
        workbench: Workbench

        @property
        def document(self) -> Document: ...

        @property
        def selected_model(self) -> Model | None: ...

        def commit(self, label: str, document: Document, merge_key: str | None = None) -> None: ...

        def amend(self, document: Document) -> None: ...

        def complain(self, problem: BaseException) -> None: ...

        def select(self, model_id: str | None) -> None: ...

        def delete(self, model_id: str) -> None: ...

        def duplicate(self, model_id: str) -> None: ...

    # -- reading --

    def parts_of(self, model_id: str) -> PartTree | None:
        """The parts of a model; None where it is not made of parts, or they cannot be read."""
        model = self.document.model(model_id)
        if model.state is self._unreadable.get(model_id):
            return None
        edits = self.workbench.parts
        known = edits.remembered(model)
        if known is not None:
            return known
        try:
            if not edits.may_have(model):
                return None
            return self._in_time(model, lambda edits: edits.of(model))
        except (UserError, PluginFault) as problem:
            # Asked for at every change of the document: complained about once.
            self._unreadable[model_id] = model.state
            self.complain(problem)
            return None

    @property
    def _unreadable(self) -> dict[str, Any]:
        """By the id of the model, a state whose parts cannot be read."""
        known: dict[str, Any] = self.__dict__.setdefault("_unreadable_parts", {})
        return known

    @property
    def chosen_part(self) -> Any | None:
        """The part whose parameters are shown: the chosen one, or the only one there is."""
        model = self.selected_model
        tree = None if model is None else self.parts_of(model.id)
        if tree is None:
            return None
        only = tree.parts[0].id if len(tree.parts) == 1 else ""
        meant = tree.selected or only
        return tree.part(meant) if meant else None

    @property
    def part_parameters(self) -> tuple[tuple[Field, Any], ...]:
        """The chosen part's parameters with their values."""
        part = self.chosen_part
        if part is None:
            return ()
        return tuple((field, getattr(part, field.name)) for field in parameter_fields(type(part)))

    # -- changing --

    def select_part(self, model_id: str, part_id: str) -> None:
        """Select a model and choose one of its parts, "" for none; no step of the history."""
        self.select(model_id)
        tree = self.parts_of(model_id)
        if tree is None or tree.selected == part_id:
            return
        model = self.document.model(model_id)
        try:
            chosen = self._in_time(model, lambda edits: edits.select(model, part_id))
        except (UserError, PluginFault) as problem:
            self.complain(problem)
            return
        self.amend(self.document.with_model(chosen))

    def rename_part(self, model_id: str, part_id: str, name: str) -> None:
        """Call a part something else."""
        self._edit_part(model_id, lambda edits, model: edits.rename(model, part_id, name))

    def set_part_visible(self, model_id: str, part_id: str, visible: bool) -> None:
        """Show a part, or leave it out of the shape."""
        self._edit_part(model_id, lambda edits, model: edits.show(model, part_id, visible))

    def delete_part(self, model_id: str, part_id: str) -> None:
        """Take a part out, with all that is in it."""
        self._edit_part(model_id, lambda edits, model: edits.delete(model, part_id))

    def duplicate_part(self, model_id: str, part_id: str) -> None:
        """Put a copy behind a part."""
        self._edit_part(model_id, lambda edits, model: edits.duplicate(model, part_id))

    def move_part(self, model_id: str, part_id: str, group_id: str, at: int) -> None:
        """Give a part another place, counted from 0 without it in a group or outside all."""
        self._edit_part(model_id, lambda edits, model: edits.move(model, part_id, group_id, at))

    def delete_chosen(self) -> None:
        """Take out the chosen part, or the selected model where no part among several is."""
        model_id, part_id = self.chosen_among_several()
        if part_id:
            self.delete_part(model_id, part_id)
        else:
            self.delete(model_id)

    def delete_several(
        self,
        model_ids: Sequence[str],
        parts: Mapping[str, Sequence[str]],
        underlay_ids: Sequence[str],
    ) -> None:
        """Take out models, parts of other models and underlays, all in one step.

        Parameters
        ----------
        model_ids, underlay_ids : sequence of str
        parts : mapping
            Ids of parts by that of their model.
        """
        document, labels = self.document, []
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
            self.complain(problem)
            return
        several = tr("Session", "Delete what is chosen")
        self.commit(labels[0] if len(labels) == 1 else several, document)

    def duplicate_chosen(self) -> None:
        """Copy the chosen part, or the selected model where no part among several is."""
        model_id, part_id = self.chosen_among_several()
        if part_id:
            self.duplicate_part(model_id, part_id)
        else:
            self.duplicate(model_id)

    def chosen_among_several(self) -> tuple[str, str]:
        """Ids of the selected model, and of its chosen part where it has others too."""
        model = self.selected_model
        tree = None if model is None else self.parts_of(model.id)
        several = tree is not None and len(tree.parts) > 1
        return "" if model is None else model.id, tree.selected if tree and several else ""

    def group_parts(self, model_id: str, part_ids: Sequence[str]) -> None:
        """Put parts into a new group."""
        self._edit_part(model_id, lambda edits, model: edits.group(model, part_ids))

    def ungroup_part(self, model_id: str, part_id: str) -> None:
        """Dissolve a group; what is in it stays where it is."""
        self._edit_part(model_id, lambda edits, model: edits.ungroup(model, part_id))

    @property
    def chosen_group(self) -> str:
        """Id of the chosen part of the selected model if it is a group, else ""."""
        model = self.selected_model
        tree = None if model is None else self.parts_of(model.id)
        return tree.selected if tree is not None and tree.selected in tree.groups else ""

    def ungroup_chosen(self) -> None:
        """Dissolve the chosen group."""
        model, group = self.selected_model, self.chosen_group
        if model is not None and group:
            self.ungroup_part(model.id, group)

    def set_part_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        """Change a parameter of the chosen part; a slider's drag is one step."""
        model, part = self.selected_model, self.chosen_part
        if model is None or part is None:
            return
        labels = {field.name: field.parameter.label for field, _ in self.part_parameters}

        def change(edits: PartEdits, model: Model) -> PartEdit:
            changed = edits.set(model, part.id, {name: value}).model
            return PartEdit(changed, labels.get(name, name))

        key = f"part {model.id} {part.id} {name}" if dragging else None
        self._edit_part(model.id, change, key)

    def _edit_part(
        self,
        model_id: str,
        change: Callable[[PartEdits, Model], PartEdit],
        merge_key: str | None = None,
    ) -> None:
        try:
            model = self.document.model(model_id)
            changed, label = self._in_time(model, lambda edits: change(edits, model))
        except (UserError, PluginFault) as problem:
            self.complain(problem)
            return
        self.commit(label, self.document.with_model(changed), merge_key)

    def _in_time(self, model: Model, ask: Callable[[PartEdits], Answer]) -> Answer:
        """Widgets cannot wait for a worker: a plugin that hangs here is interrupted."""
        guard, edits = self.registry.guard, self.workbench.parts
        return in_time(guard, model.modeler, "parts", lambda: ask(edits))


def _deleting(model: Model, part_ids: Sequence[str]) -> Callable[[PartEdits], PartEdit]:
    """The edit that takes these parts out of this model."""
    return lambda edits: edits.delete(model, *part_ids)
