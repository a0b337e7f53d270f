"""Curves in pieces: the recipe of each piece, as a node of its own."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from string import ascii_lowercase
from typing import Final

from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, SymmetryState, Trim

Stretch = tuple[float, float]
"""Begin and end of a piece, in the shares of `Trim`."""

STUB: Final = 0.03
"""Share of a curve below which what is left of it is a stub that nobody wants."""


def cut_at(curve: SpaceCurve, shares: Sequence[float]) -> tuple[Stretch, ...]:
    """Return the pieces of a curve that is cut at some places, in their order.

    A closed curve gives as many pieces as cuts, unless it crosses the plane: then its half
    has one more.

    Parameters
    ----------
    curve : SpaceCurve
        The curve in space.
    shares : sequence of float
        As in `Trim`.
    """
    cuts = sorted(set(shares))
    if not cuts:
        return ((0.0, 1.0),)
    if curve.closed and curve.reading != "self":
        cuts.append(cuts[0] + 1.0)
    else:
        cuts = [0.0, *cuts, 1.0]
    return tuple(itertools.pairwise(cuts))


def without_stretch(curve: SpaceCurve, stretch: Stretch) -> tuple[Stretch, ...]:
    """Return what is left of a curve of which a stretch is cut out, without stubs."""
    begin, end = stretch
    if curve.closed and curve.reading != "self":
        left = [(end % 1.0, end % 1.0 + 1.0 - (end - begin))]
    else:
        left = [(0.0, begin), (end, 1.0)]
    return tuple((low, high) for low, high in left if high - low > STUB)


def replace_by_pieces(
    state: SymmetryState, node: Curve, stretches: Sequence[Stretch]
) -> SymmetryState:
    """Return a state in which a curve is replaced by pieces of it.

    The first piece keeps the curve's id and name and is chosen; the others come right after
    it and are called "… b", "… c" and so on. Without any piece the curve is gone.
    """
    if not stretches:
        return state.without_nodes(node.id)
    pieces = [replace(node, edits=(*node.edits, Trim(*stretch))) for stretch in stretches]
    place = state.nodes.index(node)
    state = replace(
        state,
        nodes=(*state.nodes[:place], pieces[0], *state.nodes[place + 1 :]),
        selected=node.id,
    )
    for number, piece in enumerate(pieces[1:], 1):
        named = replace(piece, id=state.unused_id(), name=_name(state, node.name))
        at = place + number
        state = replace(state, nodes=(*state.nodes[:at], named, *state.nodes[at:]))
    return state


def _name(state: SymmetryState, name: str) -> str:
    """Return the name with the next letter that is free."""
    head, _, letter = name.rpartition(" ")
    stem = head if head and letter in tuple(ascii_lowercase) else name
    taken = {node.name for node in state.nodes}
    free = (f"{stem} {letter}" for letter in ascii_lowercase[1:])
    return next((name for name in free if name not in taken), state.unused_name(stem))
