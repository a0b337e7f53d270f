"""Editing: what a person can do to objects and underlays, each one step of the history."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bozzetto.document import edit
from bozzetto.document.edit import Edit
from bozzetto.document.model import Document
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from bozzetto.parameters import Field, parameter_fields
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.document.history import History
    from bozzetto.document.model import Model
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.solver import Showing

__all__ = ["ObjectEdits"]


class ObjectEdits:
    """The edits that panels ask the session for.

    The session is one of these; what they need of it is named here.
    """

    if TYPE_CHECKING:
        history: History
        showing: Showing
        workbench: Workbench

        @property
        def document(self) -> Document: ...

        @property
        def selected_model(self) -> Model | None: ...

        @property
        def part_parameters(self) -> tuple[tuple[Field, Any], ...]: ...

        def commit(self, label: str, document: Document, merge_key: str | None = None) -> None: ...

        def complain(self, problem: BaseException) -> None: ...

    def edit(
        self, change: Callable[..., Edit], *details: Any, merge_key: str | None = None
    ) -> None:
        """Make an edit of `bozzetto.document.edit` that may refuse; each is one undo step."""
        try:
            document, label = change(self.document, *details)
        except UserError as problem:
            self.complain(problem)
            return
        self.commit(label, document, merge_key)

    # -- parameters --

    @property
    def parameters(self) -> tuple[tuple[Field, Any], ...]:
        """The selected model's parameters with their values."""
        model = self.selected_model
        if model is None or not hasattr(model.state, "__dataclass_fields__"):
            return ()
        return tuple(
            (field, getattr(model.state, field.name))
            for field in parameter_fields(type(model.state))
        )

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        """Change one parameter of the selected model; a slider's drag is one step."""
        model = self.selected_model
        if model is None:
            return
        try:
            if model.locked:
                raise UserError(tr("Session", "This object is locked. Unlock it to change it."))
            changed = self.workbench.set_parameters(model, {name: value})
        except (UserError, PluginFault) as problem:
            self.complain(problem)
            return
        known = (*self.parameters, *self.part_parameters)
        label = next((field.parameter.label for field, _ in known if field.name == name), name)
        key = f"parameter {model.id} {name}" if dragging else None
        self.commit(label, self.document.with_model(changed), key)

    def end_drag(self) -> None:
        """A slider was let go: the next change is a step of its own."""
        self.history.end_merge()
        self.showing.let_go()

    # -- objects --

    def set_placement(self, model_id: str, placement: Placement) -> None:
        """Move a model."""
        self.edit(edit.place_model, model_id, placement)

    def rename(self, model_id: str, name: str) -> None:
        """Call a model something else."""
        self.edit(edit.rename_model, model_id, name)

    def set_visible(self, model_id: str, visible: bool) -> None:
        """Show or hide a model."""
        self.edit(edit.show_model, model_id, visible)

    def set_locked(self, model_id: str, locked: bool) -> None:
        """Lock or unlock a model."""
        self.edit(edit.lock_model, model_id, locked)

    def set_color(self, model_id: str, color: tuple[int, int, int] | None) -> None:
        """Give a model a colour, or the clay again."""
        self.edit(edit.color_model, model_id, color)

    def delete(self, model_id: str) -> None:
        """Take a model out of the document."""
        self.edit(edit.delete_models, [model_id])

    def duplicate(self, model_id: str) -> None:
        """Put a copy of a model beside it."""
        self.edit(edit.duplicate_model, model_id)

    def move_to(self, model_id: str, index: int) -> None:
        """Change a model's place in the list."""
        self.edit(edit.move_model, model_id, index)

    # -- underlays --

    def set_underlay_opacity(
        self, underlay_id: str, opacity: float, *, dragging: bool = False
    ) -> None:
        """Let an underlay shine through more or less."""
        key = f"underlay {underlay_id}" if dragging else None
        self._change_underlay(underlay_id, key, opacity=opacity)

    def set_underlay_visible(self, underlay_id: str, visible: bool) -> None:
        """Show or hide an underlay."""
        self._change_underlay(underlay_id, None, visible=visible)

    def delete_underlay(self, underlay_id: str) -> None:
        """Take an underlay away."""
        self.edit(edit.delete_underlay, underlay_id)

    def _change_underlay(self, underlay_id: str, key: str | None, **changes: Any) -> None:
        for underlay in self.document.underlays:
            if underlay.id == underlay_id:
                self.edit(edit.change_underlay, replace(underlay, **changes), merge_key=key)
