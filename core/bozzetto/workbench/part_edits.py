"""Edits of the parts of models, read and changed through their modelers.

What a person can do to a part is the same for every modeler, so it is done here. Nothing
changes a model: every edit gives another one, with the label for the history. All calls
into the plugin pass the guard, and so does what it says its parts are.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from bozzetto.document.model import Model, OpaqueState
from bozzetto.errors import UserError
from bozzetto.parameters import parameter_fields, set_parameters
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.modeler import Modeler
from bozzetto.plugin.part_tree import PartTree
from bozzetto.plugin.parts import HasParts, ReleasesParts


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
        if not self.may_have(model):
            return None
        modeler = self._registry.modeler(model.modeler)
        return self._read(model, modeler) if isinstance(modeler, HasParts) else None

    def may_have(self, model: Model) -> bool:
        """Whether a model is made of parts; asks no plugin."""
        if isinstance(model.state, OpaqueState):
            return False
        return isinstance(self._registry.modeler(model.modeler), HasParts)

    def remembered(self, model: Model) -> PartTree | None:
        """Return the parts of a model where they have been asked for; asks no plugin."""
        known = self._known.get(id(model.state))
        return known[1] if known is not None and known[0]() is model.state else None

    def _read(self, model: Model, modeler: HasParts) -> PartTree:
        known = self.remembered(model)
        if known is not None:
            return known
        guard, key = self._registry.guard, id(model.state)
        told = guard.call(model.modeler, "parts", _tree_of, modeler, model.state)
        tree = guard.check_parts(model.modeler, told)
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
        modeler = self._modeler_of(model)

        def change(tree: PartTree) -> PartTree:
            group = modeler.new_group(model.state)
            if group is None:
                raise UserError(f"{model.name} has no groups.")
            return tree.grouped(ids, group)

        changed = self._edited(model, change)
        return PartEdit(changed, f"Group {self._names_of(model, ids)}")

    def ungroup(self, model: Model, group_id: str) -> PartEdit:
        """Dissolve a group: what is in it stands where it stood."""
        modeler = self._modeler_of(model)

        def change(tree: PartTree) -> PartTree:
            if isinstance(modeler, ReleasesParts):
                return tree.ungrouped(group_id, modeler.released)
            return tree.ungrouped(group_id)

        changed = self._edited(model, change)
        return PartEdit(changed, f"Ungroup “{self._name(model, group_id)}”")

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
        modeler = self._registry.modeler(model.modeler)
        guard = self._registry.guard
        tree = self.of(model)
        changed = guard.call(
            model.modeler, "its state", _with_values, modeler, model.state, tree, dict(values)
        )
        guard.check_state(model.modeler, modeler.state_type, changed, model.state)
        return replace(model, state=changed)

    def only_choice_differs(self, before: Model, after: Model) -> bool:
        """Whether two models are the same once nothing is chosen in either."""
        if self.of(before) is None or self.of(after) is None:
            return False
        one, other = (self.select(model, "").state for model in (before, after))
        return self._registry.guard.call(
            before.modeler, "its state", lambda one, two: bool(one == two), one, other
        )

    # -- through the lens --

    def _edited(self, model: Model, change: Callable[[PartTree], PartTree]) -> Model:
        if model.locked:
            raise UserError(
                f"“{model.name}” is locked. Unlock it in the object list to change its parts."
            )
        return self._changed(model, change)

    def _changed(self, model: Model, change: Callable[[PartTree], PartTree]) -> Model:
        modeler = self._modeler_of(model)
        guard = self._registry.guard
        tree = self._read(model, modeler)

        def work(state: Any) -> Any:
            new = change(tree)
            return modeler.with_parts(state, new.parts, new.selected)

        state = guard.call(model.modeler, "with_parts", work, model.state)
        state_type = self._registry.modeler(model.modeler).state_type
        guard.check_state(model.modeler, state_type, state)
        changed = replace(model, state=state)
        self._read(changed, modeler)
        return changed

    def _modeler_of(self, model: Model) -> HasParts:
        modeler = self._registry.modeler(model.modeler)
        if not isinstance(modeler, HasParts):
            raise UserError(f"“{model.name}” is not made of parts.")
        return modeler

    def _names_of(self, model: Model, part_ids: tuple[str, ...]) -> str:
        """Return words for a label: the one part's name, or how many there are."""
        if len(part_ids) == 1:
            return f"“{self._name(model, part_ids[0])}”"
        return f"{len(part_ids)} parts"

    def _name(self, model: Model, part_id: str) -> str:
        return str(self._read(model, self._modeler_of(model)).part(part_id).name)


def _tree_of(modeler: HasParts, state: Any) -> PartTree:
    parts = modeler.parts(state)
    groups = frozenset(part.id for part in parts if modeler.is_group(part))
    return PartTree(parts, groups, modeler.selected_part(state))


def _with_values(
    modeler: Modeler[Any, Any], state: Any, tree: PartTree | None, values: dict[str, object]
) -> Any:
    """Return a state with parameters of its own, or else of its parts, changed."""
    own = {field.name for field in parameter_fields(type(state))}
    inner = {name: value for name, value in values.items() if name not in own}
    if tree is None or not inner or not isinstance(modeler, HasParts):
        return set_parameters(state, values)
    new = tree
    for name, value in inner.items():
        owner, _, plain = name.rpartition(".")
        if owner:
            new = new.valued(new.find(owner), {plain: value})
            continue
        having = [part.id for part in new.parts if plain in _names(part)]
        if not having:
            known = ", ".join(sorted(own.union(*map(_names, new.parts)))) or "none"
            raise UserError(f"There is no parameter {name!r}; this object has: {known}.")
        for part_id in [new.selected] if new.selected in having else having:
            new = new.valued(part_id, {plain: value})
    state = modeler.with_parts(state, new.parts, new.selected)
    return set_parameters(state, {name: values[name] for name in values if name in own})


def _names(part: Any) -> set[str]:
    return {field.name for field in parameter_fields(type(part))}
