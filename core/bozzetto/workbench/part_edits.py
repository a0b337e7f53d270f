"""Edits of the parts of models, read and changed through their modelers.

What a person can do to a part is the same for every modeler, so it is done here. Nothing
changes a model: every edit gives another one, with the label for the history. All calls
into the plugin pass the guard, and so does what it says its parts are.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

from bozzetto.errors import UserError
from bozzetto.workbench.links import with_state

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.plugin.guard.guarded_modeler import GuardedModeler
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.part_tree import PartTree


class PartEdit(NamedTuple):
    """A model with other parts, and what was done."""

    model: Model
    label: str


class PartEdits:
    """Edits of the parts of a model.

    Parameters
    ----------
    registry : Registry
        Where modelers come from, and the guard.

    Notes
    -----
    Edits raise `UserError` where the model is locked or has no such part, and
    `PluginFault` where the modeler fails over it. May be used from any thread.
    """

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._known: dict[int, tuple[weakref.ref[Any], PartTree]] = {}

    # -- reading --

    def of(self, model: Model) -> PartTree | None:
        """Return the parts of a model; None where its modeler knows of none, or is absent.

        Raises
        ------
        PluginFault
            If they are none that can be listed.
        """
        return self._read(model) if self.may_have(model) else None

    @staticmethod
    def may_have(model: Model) -> bool:
        """Whether a model is made of parts; asks no plugin."""
        from bozzetto.plugin.parts import PartsState

        return isinstance(model.state, PartsState)

    def remembered(self, model: Model) -> PartTree | None:
        """Return the parts of a model where they have been asked for; asks no plugin."""
        known = self._known.get(id(model.state))
        return known[1] if known is not None and known[0]() is model.state else None

    def _read(self, model: Model) -> PartTree:
        known = self.remembered(model)
        if known is not None:
            return known
        key, tree = id(model.state), self._registry.guarded(model.modeler).parts(model.state)
        if tree is None:
            raise UserError(f"“{model.name}” is not made of parts.")
        with suppress(TypeError):  # a state with slots cannot be watched
            # Kept for as long as the state is: a long list asks for all of them.
            watched = weakref.ref(model.state, lambda _: self._known.pop(key, None))
            self._known[key] = (watched, tree)
        return tree

    # -- changing --

    def select(self, model: Model, part_id: str) -> Model:
        """Return the model with another part chosen, "" for none; also where it is locked."""
        return self._changed(model, lambda tree: tree.chosen(part_id))

    def rename(self, model: Model, part_id: str, name: str) -> PartEdit:
        """Call a part something else."""
        changed = self._edited(model, lambda tree: tree.renamed(part_id, name))
        return PartEdit(changed, f"Rename to “{self._name(changed, part_id)}”")

    def show(self, model: Model, part_id: str, visible: bool) -> PartEdit:
        """Show a part, or leave it out of the shape."""
        changed = self._edited(model, lambda tree: tree.shown(part_id, visible))
        return PartEdit(changed, f"{'Show' if visible else 'Hide'} “{self._name(model, part_id)}”")

    def delete(self, model: Model, *part_ids: str) -> PartEdit:
        """Take parts out, with all that is in them."""
        changed = self._edited(model, lambda tree: tree.without(*part_ids))
        return PartEdit(changed, f"Delete {self._names_of(model, part_ids)}")

    def duplicate(self, model: Model, part_id: str) -> PartEdit:
        """Put a copy behind a part, with all that is in it; the copy is chosen."""
        changed = self._edited(model, lambda tree: tree.doubled(part_id))
        return PartEdit(changed, f"Duplicate “{self._name(model, part_id)}”")

    def move(self, model: Model, part_id: str, group_id: str, at: int) -> PartEdit:
        """Give a part another place; see `PartTree.moved`."""
        changed = self._edited(model, lambda tree: tree.moved(part_id, group_id, at))
        return PartEdit(changed, f"Reorder “{self._name(model, part_id)}”")

    def group(self, model: Model, part_ids: Iterable[str]) -> PartEdit:
        """Put parts into a new group, which is then chosen."""
        ids = tuple(part_ids)
        state = self._unlocked(model).grouped(model.state, ids)
        return PartEdit(self._with(model, state), f"Group {self._names_of(model, ids)}")

    def ungroup(self, model: Model, group_id: str) -> PartEdit:
        """Dissolve a group: what is in it stands where it stood."""
        state = self._unlocked(model).ungrouped(model.state, group_id)
        return PartEdit(self._with(model, state), f"Ungroup “{self._name(model, group_id)}”")

    def only(self, model: Model, part_ids: Iterable[str]) -> Model:
        """Return the model with nothing but some of its parts and the groups around them."""
        ids = tuple(part_ids)
        return self._changed(model, lambda tree: tree.only(ids))

    def set(self, model: Model, part_id: str, values: Mapping[str, object]) -> PartEdit:
        """Change parameters of a part."""
        changed = self._edited(model, lambda tree: tree.valued(part_id, values))
        return PartEdit(changed, f"Change “{self._name(model, part_id)}”")

    def set_parameters(self, model: Model, values: Mapping[str, object]) -> Model:
        """Return the model with parameters of its own changed, or else of its parts.

        “Part 2.blend” names a part's; a name that the state does not know means the chosen
        part, or all parts that have it where the chosen one has not.
        """
        from bozzetto.parameters import parameter_fields, set_parameters

        modeler, tree = self._registry.guarded(model.modeler), self.of(model)
        own = {field.name for field in parameter_fields(type(model.state))}
        inner = {name: value for name, value in values.items() if name not in own}
        state = model.state
        if tree is None:
            own = set(values)
        elif inner:
            state = modeler.with_parts(state, lambda tree: _with_values(tree, inner, own))
        outer = {name: value for name, value in values.items() if name in own}
        state = modeler.change(state, lambda now: set_parameters(now, outer))
        return with_state(self._registry, model, state)

    def idle(self, model: Model, names: Iterable[str]) -> list[str]:
        """Return why parameters change nothing, for those that do not; as `set_parameters`."""
        from bozzetto.parameters import idle_parameters, parameter_fields, valued_fields

        tree = self.of(model)
        parts = () if tree is None else tree.parts
        own = {field.name for field in parameter_fields(type(model.state))}
        said = []
        for name in names:
            owner, _, plain = name.rpartition(".")
            of_part = [part for part in parts if owner in ("", part.name) and plain in _names(part)]
            holders = [model.state] if name in own else of_part
            reasons = [idle_parameters(valued_fields(holder)).get(plain, "") for holder in holders]
            if reasons and all(reasons):
                said.append(reasons[0])
        return said

    def only_choice_differs(self, before: Model, after: Model) -> bool:
        """Whether two models are the same once nothing is chosen in either."""
        if self.of(before) is None or self.of(after) is None:
            return False
        one, other = (self.select(model, "").state for model in (before, after))
        return self._registry.guarded(before.modeler).is_same(one, other)

    # -- inside --

    def _edited(self, model: Model, change: Callable[[PartTree], PartTree]) -> Model:
        return self._with(model, self._unlocked(model).with_parts(model.state, change))

    def _changed(self, model: Model, change: Callable[[PartTree], PartTree]) -> Model:
        return self._with(
            model, self._registry.guarded(model.modeler).with_parts(model.state, change)
        )

    def _unlocked(self, model: Model) -> GuardedModeler:
        if model.locked:
            raise UserError(
                f"“{model.name}” is locked. Unlock it in the object list to change its parts."
            )
        return self._registry.guarded(model.modeler)

    def _with(self, model: Model, state: Any) -> Model:
        changed = with_state(self._registry, model, state)
        self._read(changed)
        return changed

    def _names_of(self, model: Model, part_ids: tuple[str, ...]) -> str:
        """Return words for a label: the one part's name, or how many there are."""
        if len(part_ids) == 1:
            return f"“{self._name(model, part_ids[0])}”"
        return f"{len(part_ids)} parts"

    def _name(self, model: Model, part_id: str) -> str:
        return str(self._read(model).part(part_id).name)


def _with_values(tree: PartTree, values: Mapping[str, object], own: set[str]) -> PartTree:
    """Return the parts with parameters changed; `own` are those of the state, for messages."""
    for name, value in values.items():
        owner, _, plain = name.rpartition(".")
        if owner:
            tree = tree.valued(tree.find(owner), {plain: value})
            continue
        having = [part.id for part in tree.parts if plain in _names(part)]
        if not having:
            known = ", ".join(sorted(own.union(*map(_names, tree.parts)))) or "none"
            raise UserError(f"There is no parameter {name!r}; this object has: {known}.")
        for part_id in [tree.selected] if tree.selected in having else having:
            tree = tree.valued(part_id, {plain: value})
    return tree


def _names(part: Any) -> set[str]:
    from bozzetto.parameters import parameter_fields

    return {field.name for field in parameter_fields(type(part))}
