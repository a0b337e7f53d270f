"""Models made of parts: what the host needs to list, choose and change them.

A modeler whose state holds named parts (outlines, curves, faces …) shows them through one
lens: the row of parts out of a state, and a state with another row in. Renaming, hiding,
ordering, grouping, deleting, duplicating and setting parameters of a part are then the
host's work, the same for every modeler.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

__all__ = ["HasParts", "Part"]


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

    id: str
    name: str
    visible: bool
    within: str


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
        """All parts of a state, in the order in which they are listed and put together."""
        ...

    def selected_part(self, state: Any) -> str:
        """Id of the part that is chosen; "" for none."""
        ...

    def is_group(self, part: Any) -> bool:
        """Whether other parts can be put into this one."""
        ...

    def with_parts(self, state: Any, parts: tuple[Any, ...], selected: str) -> Any:
        """A state with another row of parts.

        Raises
        ------
        UserError
            If these parts make no model; the message says what to do instead.
        """
        ...

    def new_group(self, state: Any) -> Any:
        """An empty group with an unused id and name; None where there are no groups."""
        ...
