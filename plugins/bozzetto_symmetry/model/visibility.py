"""Which curves and lines are shown: those that are not switched off, nor a group of theirs."""

from __future__ import annotations

from bozzetto.plugin import switched_on
from bozzetto_symmetry.model.state import Curve, Line, SymmetryState

__all__ = ["shown_curves", "shown_lines"]


def shown_curves(state: SymmetryState) -> tuple[Curve, ...]:
    """In the order of the list."""
    return tuple(node for node in switched_on(state.nodes) if isinstance(node, Curve))


def shown_lines(state: SymmetryState) -> tuple[Line, ...]:
    """The construction lines, in the order of the list."""
    return tuple(node for node in switched_on(state.nodes) if isinstance(node, Line))
