"""The parts of one state as a tree, and what a person can do to it: pure functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from bozzetto.document.model import check_name, numbered_name
from bozzetto.errors import UserError
from bozzetto.parameters import set_parameters


@dataclass(frozen=True)
class PartTree:
    """All parts of a state, which of them hold others, and which is chosen.

    Parameters
    ----------
    parts : tuple of Part
        In the modeler's order; what matters of it is the order of those within one group.
    groups : frozenset of str
        Ids of those that can have others in them.
    selected : str
        Id of the chosen one; "" for none.

    Notes
    -----
    Every method that changes something gives another tree. A part that is not there is
    refused with `UserError`, as is what makes no tree.
    """

    parts: tuple[Any, ...] = ()
    groups: frozenset[str] = frozenset()
    selected: str = ""

    # -- reading --

    def part(self, part_id: str) -> Any:
        """Return the part of that id."""
        for part in self.parts:
            if part.id == part_id:
                return part
        raise UserError("That part is no longer in the object. Choose another one.")

    def find(self, name: str) -> str:
        """Return the id of the one part of that name, or else of that id."""
        found = [part.id for part in self.parts if part.name == name]
        if len(found) > 1:
            raise UserError(f"{len(found)} parts are called “{name}”. Rename all but one.")
        if found or any(part.id == name for part in self.parts):
            return found[0] if found else name
        known = ", ".join(part.name for part in self.parts) or "none"
        raise UserError(f"There is no part “{name}”; there are: {known}.")

    def within(self, group_id: str) -> tuple[Any, ...]:
        """Return the parts directly in a group, in order; of "" those that are in none."""
        return tuple(part for part in self.parts if part.within == group_id)

    def rows(self, group_id: str = "", depth: int = 0) -> Iterator[tuple[Any, int]]:
        """Yield every part with its depth, each group before what is in it."""
        for part in self.within(group_id):
            yield part, depth
            if part.id in self.groups:
                yield from self.rows(part.id, depth + 1)

    def family(self, part_id: str) -> tuple[Any, ...]:
        """Return a part and all that is in it."""
        return (self.part(part_id), *(part for part, _ in self.rows(part_id)))

    # -- changing --

    def chosen(self, part_id: str) -> PartTree:
        """Return the tree with another part chosen, or none."""
        if part_id:
            self.part(part_id)
        return replace(self, selected=part_id)

    def renamed(self, part_id: str, name: str) -> PartTree:
        """Return the tree with a part renamed."""
        check_name(name.strip())
        return self._with(replace(self.part(part_id), name=name.strip()))

    def shown(self, part_id: str, visible: bool) -> PartTree:
        """Return the tree with a part shown or hidden."""
        return self._with(replace(self.part(part_id), visible=visible))

    def valued(self, part_id: str, values: Mapping[str, object]) -> PartTree:
        """Return the tree with parameters of a part changed."""
        part = self.part(part_id)
        return self._with(set_parameters(part, dict(values), f"“{part.name}”"))

    def without(self, *part_ids: str) -> PartTree:
        """Return the tree without some parts; a neighbour is chosen if one of them was."""
        gone = {part.id for part_id in part_ids for part in self.family(part_id)}
        kept = tuple(part for part in self.parts if part.id not in gone)
        near = self.selected
        while near in gone:
            part = self.part(near)
            row = self.within(part.within)
            place = row.index(part)
            others = (*row[place + 1 :], *reversed(row[:place]))
            near = next((other.id for other in others if other.id not in gone), part.within)
        return PartTree(kept, self.groups - gone, near)

    def only(self, part_ids: Iterable[str]) -> PartTree:
        """Return the tree with only some parts, their content, and the groups around them."""
        kept = {part.id for part_id in part_ids for part in self.family(part_id)}
        for part_id in tuple(kept):
            around = self.part(part_id).within
            while around:
                kept.add(around)
                around = self.part(around).within
        parts = tuple(part for part in self.parts if part.id in kept)
        return PartTree(parts, self.groups & kept, self.selected if self.selected in kept else "")

    def doubled(self, part_id: str) -> PartTree:
        """Return the tree with a copy behind a part, with all that is in it; the copy is chosen."""
        tree, new_ids = self, {self.part(part_id).within: self.part(part_id).within}
        copies = []
        for part in self.family(part_id):
            new_ids[part.id] = tree._unused_id()
            copy = replace(
                part,
                id=new_ids[part.id],
                name=numbered_name(part.name, {one.name for one in tree.parts}),
                within=new_ids[part.within],
            )
            copies.append(copy)
            groups = tree.groups | ({copy.id} if part.id in tree.groups else set())
            tree = PartTree((*tree.parts, copy), groups, tree.selected)
        place = self.parts.index(self.part(part_id)) + 1
        parts = (*self.parts[:place], *copies, *self.parts[place:])
        return PartTree(parts, tree.groups, copies[0].id)

    def moved(self, part_id: str, group_id: str, at: int) -> PartTree:
        """Return the tree with a part at another place.

        Parameters
        ----------
        part_id : str
            The part to move.
        group_id : str
            The group that it shall be in; "" for none.
        at : int
            Its place among those in there, counted from 0 without it; the nearest there is.
        """
        part = self.part(part_id)
        if group_id and group_id not in self.groups:
            raise UserError(f"“{self.part(group_id).name}” is not a group. Choose a group.")
        if group_id in {inner.id for inner in self.family(part_id)}:
            raise UserError(f"“{part.name}” cannot be put into itself. Choose another group.")
        others = tuple(other for other in self.parts if other.id != part_id)
        row = [other for other in others if other.within == group_id]
        place = max(0, min(at, len(row)))
        index = others.index(row[place]) if place < len(row) else len(others)
        moved = replace(part, within=group_id)
        return replace(self, parts=(*others[:index], moved, *others[index:]))

    def grouped(self, part_ids: Iterable[str], group: Any) -> PartTree:
        """Return the tree with parts in a new group, which stands where the first of them stood.

        Parameters
        ----------
        part_ids : iterable of str
            What lies within another one of these goes with that one.
        group : Part
            Empty and new; it becomes chosen.
        """
        wanted = {self.part(part_id).id for part_id in part_ids}
        inner = {part.id for part_id in wanted for part in self.family(part_id)[1:]}
        members = [part for part, _ in self.rows() if part.id in wanted - inner]
        if not members:
            raise UserError("Choose the parts that shall make a group.")
        first = members[0]
        place = self.parts.index(first)
        parts = (*self.parts[:place], replace(group, within=first.within), *self.parts[place:])
        tree = PartTree(parts, self.groups | {group.id}, group.id)
        for number, part in enumerate(members):
            tree = tree.moved(part.id, group.id, number)
        return tree

    def ungrouped(
        self, group_id: str, released: Callable[[Any, Any], Any] = lambda part, group: part
    ) -> PartTree:
        """Return the tree with a group dissolved: what is in it stands where it stood.

        Parameters
        ----------
        group_id : str
            The group to dissolve.
        released : callable
            ``released(part, group)`` gives a part without the group's influence.
        """
        group = self.part(group_id)
        if group_id not in self.groups:
            raise UserError(f"“{group.name}” is not a group. Choose a group.")
        freed = {
            part.id: replace(
                released(part, group), within=group.within, visible=part.visible and group.visible
            )
            for part in self.within(group_id)
        }
        others = tuple(part for part in self.parts if part.id not in freed)
        place = others.index(group)
        parts = (*others[:place], *freed.values(), *others[place + 1 :])
        first = next(iter(freed), group.within)
        selected = first if self.selected == group_id else self.selected
        return PartTree(parts, self.groups - {group_id}, selected)

    def _with(self, part: Any) -> PartTree:
        parts = tuple(part if old.id == part.id else old for old in self.parts)
        return replace(self, parts=parts)

    def _unused_id(self) -> str:
        taken = {part.id for part in self.parts}
        return next(f"n{k}" for k in range(1, len(taken) + 2) if f"n{k}" not in taken)
