"""Models made of parts: named outlines, curves, faces …, in groups.

A modeler whose state is a `PartsState` gets the list of parts with it: choosing, renaming, hiding,
ordering, grouping, deleting, duplicating and setting parameters of a part are the host's work, the
same for every modeler.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self, TypeVar

from bozzetto.plugin.modeler import Modeler


@dataclass(frozen=True, eq=False)  # else a derived class that says so, too, compares these alone
class Part:
    """A named part of a model; the `Parameter` fields of a derived class make its form.

    Parameters
    ----------
    id : str
        Unique within the state, not empty.
    name : str
    visible : bool
        Whether it counts for the shape.
    within : str
        Id of the group that it is in; "" for none.
    """

    id: str = ""
    name: str = ""
    visible: bool = True
    within: str = ""


@dataclass(frozen=True)
class Group(Part):
    """A part that holds others."""


AnyPart = TypeVar("AnyPart", bound=Part)
State = TypeVar("State", bound="PartsState")
Result = TypeVar("Result")


@dataclass(frozen=True)
class PartsState:
    """A state that is made of parts.

    Parameters
    ----------
    nodes : tuple of Part
        All parts and groups, in the order in which they are listed and put together. A derived
        class narrows the annotation, for documents are read through it.
    selected : str
        Id of the one that is chosen; "" for none.
    """

    nodes: tuple[Any, ...] = ()
    selected: str = ""

    def node(self, node_id: str) -> Any:
        """Return the part or group of an id.

        Raises
        ------
        KeyError
            If there is none.
        """
        for node in self.nodes:
            if node.id == node_id:
                return node
        raise KeyError(node_id)

    def chosen_of(self, kind: type[AnyPart]) -> AnyPart | None:
        """Return the chosen part, if there is one and it is of a kind."""
        return next((node for node in self.of_kind(kind) if node.id == self.selected), None)

    def of_kind(self, kind: type[AnyPart]) -> tuple[AnyPart, ...]:
        """Return all parts of a kind, in their order."""
        return tuple(node for node in self.nodes if isinstance(node, kind))

    def shown(self, kind: type[AnyPart]) -> tuple[AnyPart, ...]:
        """Return the parts of a kind that are visible, as are all groups around them."""
        by_id = {node.id: node for node in self.nodes}

        def is_shown(node: Part) -> bool:
            passed: set[str] = set()
            while node.visible and node.within in by_id and node.within not in passed:
                passed.add(node.within)
                node = by_id[node.within]
            return node.visible

        return tuple(node for node in self.of_kind(kind) if is_shown(node))

    def with_node(self, node: Part) -> Self:
        """Return the state with a part in the place of the one of its id, or at the end; chosen."""
        if all(old.id != node.id for old in self.nodes):
            return replace(self, nodes=(*self.nodes, node), selected=node.id)
        nodes = tuple(node if old.id == node.id else old for old in self.nodes)
        return replace(self, nodes=nodes, selected=node.id)

    def without_nodes(self, *node_ids: str) -> Self:
        """Return the state without some parts; what lay in a group that goes stays."""
        nodes = tuple(node for node in self.nodes if node.id not in node_ids)
        return replace(
            self, nodes=nodes, selected="" if self.selected in node_ids else self.selected
        )

    def unused_id(self) -> str:
        """Return an id that no part has, such as n1."""
        taken = {node.id for node in self.nodes}
        return next(f"n{k}" for k in range(1, len(taken) + 2) if f"n{k}" not in taken)

    def unused_name(self, stem: str) -> str:
        """Return a name that no part has: the stem and a number."""
        taken = {node.name for node in self.nodes}
        return next(f"{stem} {k}" for k in range(1, len(taken) + 2) if f"{stem} {k}" not in taken)


class PartsModeler(Modeler[State, Result]):
    """A modeler of which the states are made of parts.

    Attributes
    ----------
    part_types : tuple of type
        What its parts can be; their parameters are known before any part is drawn. Where one of
        them is derived from `Group`, parts can be grouped.
    """

    part_types: ClassVar[tuple[type[Part], ...]]

    def with_parts(self, state: State, nodes: tuple[Any, ...], selected: str) -> State:
        """Return a state with other parts, and another one chosen.

        Raises
        ------
        UserError
            If these parts make no model; the message says what to do instead.
        """
        return replace(state, nodes=nodes, selected=selected)

    def new_group(self, state: State) -> Any:
        """Return an empty group with an unused id and name; None where there are no groups."""
        kind = next((kind for kind in self.part_types if issubclass(kind, Group)), None)
        return kind and kind(id=state.unused_id(), name=state.unused_name("Group"))

    def released(self, part: Any, group: Any) -> Any:
        """Return a part as it must be when the group directly around it is dissolved.

        For groups that do more than hold: they move what is in them, for example. Its `within`
        and its visibility are the host's work.
        """
        return part
