"""Models made of parts: what the host needs to list, choose and change them.

A modeler whose state holds named parts (outlines, curves, faces …) shows them through one
lens: the row of parts out of a state, and a state with another row in. Renaming, hiding,
ordering, grouping, deleting, duplicating and setting parameters of a part are then the
host's work, the same for every modeler.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol, TypeVar, runtime_checkable


class Part(Protocol):
    """A frozen dataclass with these fields; its `Parameter` fields make its form.

    Attributes
    ----------
    id : str
        Unique within the state, not empty.
    name : str
    visible : bool
    within : str
        Id of the part that it belongs to; "" for none. Only parts for which
        `HasParts.is_group` holds have others in them.
    """

    @property
    def id(self) -> str: ...  # noqa: D102

    @property
    def name(self) -> str: ...  # noqa: D102

    @property
    def visible(self) -> bool: ...  # noqa: D102

    @property
    def within(self) -> str: ...  # noqa: D102


Kind = TypeVar("Kind", bound=Part)


def with_part(parts: Iterable[Kind], part: Kind) -> tuple[Kind, ...]:
    """Return the parts with one in the place of the one of its id, or at the end."""
    row = tuple(parts)
    if any(old.id == part.id for old in row):
        return tuple(part if old.id == part.id else old for old in row)
    return (*row, part)


def unused_id(parts: Iterable[Part]) -> str:
    """Return an id that no part has, such as n1."""
    taken = {part.id for part in parts}
    return next(f"n{k}" for k in range(1, len(taken) + 2) if f"n{k}" not in taken)


def unused_name(parts: Iterable[Part], stem: str) -> str:
    """Return a name that no part has: the stem and a number."""
    taken = {part.name for part in parts}
    return next(f"{stem} {k}" for k in range(1, len(taken) + 2) if f"{stem} {k}" not in taken)


def switched_on(parts: Iterable[Kind]) -> tuple[Kind, ...]:
    """Return those parts of a state that are visible, as are all groups around them."""
    row = tuple(parts)
    by_id = {part.id: part for part in row}

    def is_shown(part: Kind) -> bool:
        passed: set[str] = set()
        while part.visible and part.within in by_id and part.within not in passed:
            passed.add(part.within)
            part = by_id[part.within]
        return part.visible

    return tuple(part for part in row if is_shown(part))


@runtime_checkable
class HasParts(Protocol):
    """A modeler whose states are made of parts.

    Attributes
    ----------
    part_types : tuple of type
        What its parts can be; their parameters are known before any part is drawn.
    """

    part_types: tuple[type[Any], ...]

    def parts(self, state: Any) -> tuple[Any, ...]:
        """Return all parts of a state, in the order in which they are listed and put together."""
        ...

    def selected_part(self, state: Any) -> str:
        """Return the id of the part that is chosen; "" for none."""
        ...

    def is_group(self, part: Any) -> bool:
        """Whether other parts can be put into this one."""
        ...

    def with_parts(self, state: Any, parts: tuple[Any, ...], selected: str) -> Any:
        """Return a state with another row of parts.

        Raises
        ------
        UserError
            If these parts make no model; the message says what to do instead.
        """
        ...

    def new_group(self, state: Any) -> Any:
        """Return an empty group with an unused id and name; None where there are no groups."""
        ...


@runtime_checkable
class ReleasesParts(Protocol):
    """A modeler whose groups do more than hold: they move what is in them, for example."""

    def released(self, part: Any, group: Any) -> Any:
        """Return a part as it must be when the group directly around it is dissolved.

        Its `within` and its visibility are the host's work.
        """
        ...
