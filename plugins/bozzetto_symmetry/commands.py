"""Commands on the chosen curve: above all, to read it in another way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal

from bozzetto.errors import UserError
from bozzetto.plugin import Command, Context
from bozzetto_symmetry.model.state import AskedReading, Curve, SymmetryState
from bozzetto_symmetry.operations.curve_ends import with_nearest_joined
from bozzetto_symmetry.operations.joined_pieces import joined_as_asked, parted, with_joined
from bozzetto_symmetry.operations.snap_candidates import with_ends_caught
from bozzetto_symmetry.operations.trim_or_extend import with_ends_met
from bozzetto_symmetry.solve.curve_solver import trace_of, views_of

READINGS: Final[tuple[AskedReading, ...]] = ("pair", "self", "plane", "half")
"""In the order in which the key goes through those that the ink in one view says nothing of."""


def all_commands() -> Sequence[Command]:
    """Return the commands in the order of the menu."""
    return (
        Command(
            id="switch-reading",
            title="Switch reading",
            help="Read the chosen curve in another way: both sides, across, or in the plane.",
            run=_switched,
            key="X",
            enabled=_has_curve,
        ),
        Command(
            id="other-matching",
            title="Take the other matching",
            help="Match the two sides of the chosen curve in the other way that fits.",
            run=_matched_otherwise,
            key="C",
            enabled=_has_curve,
        ),
        Command(
            id="join-nearest",
            title="Join to the nearest end",
            help="Join the chosen curve smoothly to the curve whose end is nearest.",
            run=with_nearest_joined,
            enabled=_has_curve,
        ),
        Command(
            id="trim-ends",
            title="Trim ends that meet",
            help="Cut ends that overshoot, and extend ends that fall a little short.",
            run=with_ends_met,
        ),
        Command(
            id="snap-ends",
            title="Snap ends",
            help="Move the ends of the chosen curve to ends, curves, edges or planes near them.",
            run=with_ends_caught,
            enabled=_has_curve,
        ),
        Command(
            id="snapping",
            title="Snap while drawing",
            help="Let the ends of new curves snap to what is near them, or draw freely.",
            run=_snapping_switched,
            key="M",
        ),
        Command(
            id="new-curves-lie",
            title="New curves lie elsewhere",
            help="Draw in space, in the drawing plane, or on surfaces, in turn.",
            run=_laid_otherwise,
            key="L",
        ),
    )


def _has_curve(state: SymmetryState) -> bool:
    return state.chosen is not None


def _chosen(state: SymmetryState) -> Curve:
    if state.chosen is None:
        raise UserError("No curve is chosen. Choose one in the list.")
    return state.chosen


def _switched(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state with the next reading that the ink of the chosen curve allows."""
    curve = _chosen(state)
    if curve.canvas is not None:
        free = replace(curve, canvas=None, end_snaps=())
        trace_of(free, state)
        return state.with_node(free)
    if curve.goes_on and curve.reading == "auto" and not curve.pieces:
        joined = joined_as_asked(curve, state)
        if joined is not None:
            return with_joined(state, joined)
    reading = trace_of(curve, state).reading
    ways = _by_likelihood(curve, state)
    now = ways.index(reading)
    for step in range(1, len(ways)):
        at = (now + step) % len(ways)
        otherwise = _taken_apart_or_joined(curve, state) if at == 0 else None
        if otherwise is not None:
            return otherwise
        tried = replace(curve, reading=ways[at], other=False)
        try:
            trace_of(tried, state)
        except UserError:
            continue
        return state.with_node(tried)
    otherwise = _taken_apart_or_joined(curve, state)
    if otherwise is not None:
        return otherwise
    raise UserError("These strokes can be read in no other way. Draw the other side, too.")


def _taken_apart_or_joined(curve: Curve, state: SymmetryState) -> SymmetryState | None:
    """Return the state with the chosen curve's newest piece apart, or with one joined again."""
    if curve.pieces:
        return parted(state)
    joined = None if curve.goes_on else joined_as_asked(curve, state)
    return None if joined is None else with_joined(state, joined)


def _by_likelihood(curve: Curve, state: SymmetryState) -> list[AskedReading]:
    """Return all readings, the likeliest first: what is meant is then the next one, if not this."""
    found = views_of(curve, state)[0].reader.read("auto", state.bounds)
    ranked = dict.fromkeys(read.reading for read in found)
    return list(dict.fromkeys((*ranked, *READINGS)))


def _snapping_switched(state: SymmetryState, context: Context) -> SymmetryState:
    return replace(state, snapping=not state.snapping)


def _laid_otherwise(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state in which new curves lie in the next of the ways there are."""
    ways: list[Literal["space", "plane", "surface"]] = ["space", "surface"]
    if state.drawing_plane is not None:
        ways.insert(1, "plane")
    now = ways.index(state.lay) if state.lay in ways else 0
    return replace(state, lay=ways[(now + 1) % len(ways)])


def _matched_otherwise(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state with the second-best matching of the chosen curve, or the best one again."""
    curve = _chosen(state)
    turned = replace(curve, other=not curve.other)
    if trace_of(curve, state).choices < 2:
        raise UserError("There is no other way in which these strokes belong together.")
    return state.with_node(turned)
