"""Where curves may go on from one another, because the pen was lifted there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from bozzetto.errors import UserError
from bozzetto.ink import carried_places, is_one_view
from bozzetto_symmetry.ink.continuation import Continuation, continuation
from bozzetto_symmetry.ink.sides import Side
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import trace_if_any, views_of

MAY_GO_ON: Final = "It may go on where “{}” ends. Press X to take both for one line."


@dataclass(frozen=True)
class Link:
    """Two strokes of two curves, of which one may go on where the other ended."""

    curves: tuple[str, str]
    strokes: tuple[int, int]
    how: Continuation


def open_links(curve: Curve, state: SymmetryState) -> tuple[Link, ...]:
    """Return where a curve may go on from others that it is not joined to, the smoothest first."""
    if not can_be_joined(curve):
        return ()
    found = [
        link
        for other in others_in_view(state, curve)
        if can_be_joined(other)
        for link in links_between([curve, other], state)
    ]
    return tuple(sorted(found, key=lambda link: (link.how.bend, link.curves)))


def may_go_on(curve: Curve, state: SymmetryState) -> tuple[str, ...]:
    """Return what is said of a curve that may go on from another one, and was not taken so."""
    if not curve.goes_on:
        return ()
    names = {node.id: node.name for node in state.curves}
    for link in open_links(curve, state):
        both = [node for node in state.curves if node.id in link.curves]
        if all(node.goes_on for node in both) and any(_lacks(node, state) for node in both):
            other = next(name for name in link.curves if name != curve.id)
            return (MAY_GO_ON.format(names[other]),)
    return ()


def _lacks(curve: Curve, state: SymmetryState) -> bool:
    """Return whether ink of a curve waits for more, so that it matters what goes on with it."""
    trace = trace_if_any(curve, state)
    return trace is not None and (trace.reading == "half" or trace.rest > 0.0)


def can_be_joined(curve: Curve) -> bool:
    """Return whether the ink of a curve is all that it is: in the air, and not edited."""
    return curve.canvas is None and not curve.edits and len(curve.strokes) > 0


def others_in_view(state: SymmetryState, curve: Curve) -> list[Curve]:
    """Return the other curves of which all ink is in the view of a curve."""
    camera = curve.strokes[0].camera
    return [
        node for node in state.shown_curves
        if node.id != curve.id
        and all(is_one_view(camera, stroke.camera) for stroke in node.strokes)
    ]  # fmt: skip


def _lines(curve: Curve, state: SymmetryState) -> list[tuple[Side, tuple[int, ...]]]:
    """Return the open sides of a curve, with the numbers of their strokes in it."""
    try:
        (view,) = views_of(curve, state, curve.reading)
    except (UserError, ValueError):
        return []
    return [
        (side, tuple(view.numbers[k] for k in side.strokes))
        for side in view.sides
        if not side.closed
    ]


def links_between(curves: Sequence[Curve], state: SymmetryState) -> tuple[Link, ...]:
    """Return where some curves may go on from one another."""
    lines = [(curve, side, numbers) for curve in curves for side, numbers in _lines(curve, state)]
    found = []
    for (one, side, numbers), (other, that, others) in combinations(lines, 2):
        if one.id == other.id:
            continue
        first, second = one.strokes[0].camera, other.strokes[0].camera
        pixels = that.pixels if first == second else carried_places(that.pixels, second, first)
        how = continuation(side.pixels, pixels, max(side.noise, that.noise))
        if how is not None:
            found.append(Link((one.id, other.id), (numbers[-1], others[-1]), how))
    return tuple(found)
