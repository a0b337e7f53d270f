"""Ends that nearly meet, cut where they pass and extended where they fall short.

Kara & Shimada, section 13.2, compare the curves as they were with what each way of trimming
makes of them, and take the one that changes the whole curves least.
"""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import arc_length
from bozzetto.plugin import Context
from bozzetto.view import triple
from bozzetto_symmetry.editing.snap import FADE, LEAST_FADE
from bozzetto_symmetry.editing.trim import share_of
from bozzetto_symmetry.model.state import Snap, SymmetryState, Trim
from bozzetto_symmetry.operations.curve_ends import End, ends_of, with_edit
from bozzetto_symmetry.solve.picking import solved_curves
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

NEARLY: Final = 0.15
"""Gap between ends that nearly meet, as a share of the shorter curve. Ends that pass by one
another may overlap by as much."""

CLOSE: Final = 0.05
"""Gap between an end and the curve that it nearly meets, as a share of the one that ends."""

MEETING: Final = 1e-6
"""Gap, as a share of the shorter curve, of what does meet."""

LOOKS: Final = 512
"""Places by which a curve's length is measured."""

CUTS: Final = 64
"""Places at which each end is tried to be cut, and up to which it is tried to be extended."""


def with_ends_met(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state in which ends that nearly meet do meet.

    They are those of the chosen curve, or where none is chosen all.

    Ends look for other ends first; one that finds none looks for a curve to end on.

    Raises
    ------
    UserError
        If no ends nearly meet.
    """
    used: set[tuple[str, int]] = set()
    for first, second in _pairs(state):
        keys = {(end.node.id, end.number) for end in (first, second)}
        if not keys & used:
            used |= keys
            state = meet_half_way(state, first, second)
    for end in _chosen(state, ends_of(solved_curves(state))):
        if not end.mirrored and (end.node.id, end.number) not in used:
            led = _led_to_curve(state, end)
            used |= set() if led is None else {(end.node.id, end.number)}
            state = led or state
    if not used:
        raise UserError("No ends nearly meet here. Draw the curves closer, or join their ends.")
    return state


def _chosen(state: SymmetryState, ends: list[End]) -> list[End]:
    """Return the ends of the chosen curve; all of them where none with an end is chosen."""
    own = [end for end in ends if end.node.id == state.selected]
    return own or ends


def _pairs(state: SymmetryState) -> list[tuple[End, End]]:
    """Return pairs of ends that nearly meet, the closest first."""
    ends = ends_of(solved_curves(state))
    asked = {end.node.id for end in _chosen(state, ends)}
    found = []
    for number, (one, other) in enumerate(itertools.combinations(ends, 2)):
        if one.mirrored or not asked & {one.node.id, other.node.id}:
            continue
        if one.node.id == other.node.id and (one.number == other.number) != other.mirrored:
            continue
        reach = min(_length(one), _length(other))
        gap = float(np.linalg.norm(one.point - other.point))
        if MEETING * reach < gap <= NEARLY * reach:
            found.append((gap, number, one, other))
    return [(one, other) for _, _, one, other in sorted(found, key=lambda entry: entry[:2])]


def _length(end: End) -> float:
    """Return the length of the curve, or of the half of one across the plane, mm."""
    return end.curve.spline.length * (0.5 if end.curve.reading == "self" else 1.0)


def meet_half_way(state: SymmetryState, first: End, second: End) -> SymmetryState:
    """Return the state in which two ends meet half-way, cut back or extended.

    The change of a curve is the mean distance, over its whole length, of its places from what
    it becomes. A length that is cut off or added straight ahead counts by half its square; the
    end then moves to the meeting point, by half the gap, and takes a stretch of the curve with
    it. The places at which both curves together change least are chosen.
    """
    one, other = _now(state, first), _now(state, second)
    places, cuts, parameters = zip(*(_stretch(end) for end in (one, other)), strict=True)
    gap = np.linalg.norm(places[0][:, None] - places[1], axis=2)
    cost = _changed(cuts[0][:, None], gap, one) + _changed(cuts[1], gap, other)
    if one.node.id == other.node.id and one.number == other.number:
        # An end and its own image are cut at the same place.
        cost = np.where(np.eye(len(cost), dtype=bool), cost, np.inf)
    best = np.unravel_index(int(np.argmin(cost)), cost.shape)
    middle = 0.5 * (places[0][best[0]] + places[1][best[1]])
    moved = [(one, 0), (other, 1)]
    if (one.node.id, one.number) == (other.node.id, other.number):
        moved = moved[:1]
    for end, number in moved:
        place = int(best[number])
        goal = middle * MIRROR if end.mirrored else middle
        trim = bool(cuts[number][place] > 0.0)
        state = _led(state, end, float(parameters[number][place]), goal, trim=trim)
    return state


def _led_to_curve(state: SymmetryState, end: End) -> SymmetryState | None:
    """Return the state in which an end lies on the curve that it nearly meets; None if it does.

    Only the curve that ends there changes.
    """
    end = _now(state, end)
    places, cuts, parameters = _stretch(end)
    best: tuple[float, int, Array] | None = None
    for node, curve in solved_curves(state):
        for spline in curve.curves() if node.id != end.node.id else ():
            feet = spline.value(spline.foot_points(places))
            gap = np.linalg.norm(places - feet, axis=1)
            cost = np.where(gap <= CLOSE * _length(end), _changed(cuts, 2.0 * gap, end), np.inf)
            number = int(np.argmin(cost))
            if cost[number] < (np.inf if best is None else best[0]):
                best = float(cost[number]), number, feet[number]
    if best is None or best[0] <= MEETING * _length(end):
        return None
    _, number, goal = best
    return _led(state, end, float(parameters[number]), goal, trim=bool(cuts[number] > 0.0))


def _now(state: SymmetryState, end: End) -> End:
    """Return the same end of the curve as it is in a state."""
    (found,) = (
        one
        for one in ends_of(solved_curves(state))
        if (one.node.id, one.number, one.mirrored) == (end.node.id, end.number, end.mirrored)
    )
    return found


def _stretch(end: End) -> tuple[Array, Array, Array]:
    """Return places about an end, how much would be cut off for each, mm, and their parameters.

    What is below 0 extends the curve straight ahead.
    """
    spline = end.curve.spline
    begin, last = spline.range
    at = np.linspace(begin, last, LOOKS) if end.number == 0 else np.linspace(last, begin, LOOKS)
    along = arc_length(spline.value(at))
    reach = NEARLY * _length(end)
    cuts = reach * np.arange(-CUTS, CUTS + 1) / CUTS
    parameters = np.interp(cuts, along, at)
    ahead = spline.derivative(at[:1])[0] * (1.0 if end.number else -1.0)
    ahead /= max(float(np.linalg.norm(ahead)), 1e-300)
    places = spline.value(parameters) + np.maximum(-cuts, 0.0)[:, None] * ahead
    return places * MIRROR if end.mirrored else places, cuts, parameters


def _changed(cut: Array, gap: Array, end: End) -> Array:
    """Return the mean distance of the whole curve from what it becomes, mm."""
    length = _length(end)
    way = 0.5 * gap
    fade = np.minimum(length, np.maximum(FADE * way, LEAST_FADE * length))
    return np.asarray((0.5 * cut**2 + 0.5 * way * fade) / length)


def _led(state: SymmetryState, end: End, at: float, goal: Array, *, trim: bool) -> SymmetryState:
    """Return a state with an end cut back to a parameter, if `trim`, and moved to a place."""
    if trim:
        end = _now(state, end)
        share = share_of(end.curve, at)
        edit = Trim(share, 1.0) if end.number == 0 else Trim(0.0, share)
        state = with_edit(state, end.node, end.curve, edit)
    end = _now(state, end)
    place = triple(state.plane.placement.points(goal)[0])
    return with_edit(state, end.node, end.curve, Snap(end.number, place))
