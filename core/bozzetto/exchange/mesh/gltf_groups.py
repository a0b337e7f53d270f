"""Hierarchy of parts in glTF: nodes that hold those of the parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.geometry.shapes import Solid, Surface


def in_groups(
    nodes: list[dict[str, Any]], parts: Sequence[Solid | Surface], *, is_still: bool = True
) -> list[int]:
    """Put the nodes of parts into nodes named by their paths; return the roots of the parts.

    What is in a part is in its node, where nothing moves: else it would move with it. The node of
    a part on a skin stays a root: the format says that the place of such a node does not count.

    Parameters
    ----------
    nodes : list of dict
        Those of the parts come first; more are added.
    parts : sequence of Solid or Surface
        What they are the nodes of.
    is_still : bool
        Whether no part moves.
    """
    known: dict[tuple[str, ...], int] = {}
    for number, part in enumerate(parts):
        if part.skin is None and is_still:
            known.setdefault((*part.path, part.name), number)
    roots: list[int] = []
    for number, part in enumerate(parts):
        path = () if part.skin is not None else part.path
        _held(number, path, nodes, known, roots)
    return roots


def _held(
    number: int,
    path: tuple[str, ...],
    nodes: list[dict[str, Any]],
    known: dict[tuple[str, ...], int],
    roots: list[int],
) -> None:
    """Put a node into that of a path, and make those of the path that lack."""
    while path:
        holder = known.get(path)
        is_new = holder is None
        if holder is None:
            holder = known[path] = len(nodes)
            nodes.append({"name": path[-1]})
        nodes[holder].setdefault("children", []).append(number)
        if not is_new:
            return
        number, path = holder, path[:-1]
    roots.append(number)
