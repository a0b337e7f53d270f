"""The order in which the nodes of the tree are combined, for any type of solid."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TypeVar

from bozzetto.errors import UserError
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState

Solid = TypeVar("Solid")


def put_together(
    state: SilhouetteState,
    part: Callable[[Part, Solid | None], Solid],
    moved: Callable[[Solid, Group], Solid],
    joined: Callable[[Solid, Solid, Part | Group], Solid | None],
    within: str = "",
) -> Solid | None:
    """Combine the nodes of a group that are switched on, from first to last; None for nothing.

    The first node is the shape that the others act on, whatever its own operation. Where it
    is switched off, or nothing is left, the next node that adds is the first.

    Parameters
    ----------
    state : SilhouetteState
        The tree of nodes.
    part : callable
        A part by itself, in the frame of its group; gets what comes before it, None for
        nothing.
    moved : callable
        What is in a group, where the group stands.
    joined : callable
        What comes before a node with the node.
    within : str
        Id of the group; "" for the whole tree.

    Raises
    ------
    UserError
        If a part's ink is no outline; the message begins with the name of the part.
    """
    before: Solid | None = None
    first = True
    for node in state.nodes:
        if node.within != within:
            continue
        if not node.visible:
            first = False
            continue
        with _naming(node):
            if isinstance(node, Group):
                inside = put_together(state, part, moved, joined, node.id)
                alone = None if inside is None else moved(inside, node)
            else:
                alone = part(node, before)
            if alone is None:
                continue
            if before is not None:
                before = joined(before, alone, node)
            elif first or node.operation in ("add", "merge"):
                before = alone
            first = False
    return before


def without_blends(state: SilhouetteState) -> SilhouetteState:
    """Return a state of the same nodes with sharp creases, and without strokes of paint."""
    return SilhouetteState(tuple(replace(node, blend=0.0) for node in state.unpainted))


@contextmanager
def _naming(node: Part | Group) -> Iterator[None]:
    """Let a mistake in a part begin with the part's name."""
    try:
        yield
    except UserError as error:
        if isinstance(node, Group) or not node.name:
            raise
        raise UserError(f"{node.name}: {error.message}", places=error.places) from error
