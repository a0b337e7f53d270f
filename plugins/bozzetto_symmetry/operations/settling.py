"""Ends that settle where they nearly meet: all ends of all curves at once.

Ends that come near one another are one place, of which each says what its ink knows (Aitken, 1935).
What is fixed, as a corner of the box, holds them; then single ends settle on curves, on the centre
plane and on the faces of the box. Everything is worked out from the curves as their ink
says them, so neither the order of the curves nor how often it is done tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import Context
from bozzetto.view import triple
from bozzetto_symmetry.editing.end_snaps import drawn_end, with_end_snaps
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.state import Curve, EndSnap, Snap, SymmetryState
from bozzetto_symmetry.operations.end_meetings import common_places, continued, meetings
from bozzetto_symmetry.operations.open_ends import LEAST, Free, FreeEnd, ends_of, free_curves
from bozzetto_symmetry.operations.snap_candidates import snap_within
from bozzetto_symmetry.operations.snap_targets import Targets, curve_targets, targets
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.stereo.uncertainty import HAND

FARTHEST: Final = 2.0
"""How far an end goes to what does not come to meet it, in errors of a hand."""

SWEEPS: Final = 6
"""Times that ends settle on curves whose own ends settle on others."""


Places = Mapping[str, tuple[Snap, ...]]
"""Where the ends of curves settle, by their id, in the model's frame."""


def settled(
    state: SymmetryState, context: Context, without: str = "", *, box: bool = True
) -> Places:
    """Return where the ends of all curves settle that may.

    Parameters
    ----------
    state : SymmetryState
        Its curves, lines, box and plane.
    context : Context
        The curves of other models.
    without : str
        Id of a curve that does not count.
    box : bool
        Whether the edges and faces of the box count.
    """
    free, others = free_curves(state, without)
    fixed = targets(state, others, context, box=box)
    ends = [end for each in free.values() for end in ends_of(each, state)]
    taken = _met(ends, fixed, free, state)
    settling: dict[str, tuple[Snap, ...]] = {name: tuple(met) for name, met in taken.items()}
    lines = fixed.without_points("end", "corner")
    known: dict[str, Targets] = {}
    before: dict[str, tuple[Snap, ...]] = {}
    found: dict[FreeEnd, tuple[list[Targets], Snap | None]] = {}

    def on_body(end: FreeEnd) -> Snap | None:
        """Return where a single end settles; the same where what is near it has not moved."""
        near = list(_others(end, known, state))
        if end not in found or found[end][0] != near:
            found[end] = near, _on_body(end, free[end.owner], (lines, *near), state, box)
        return found[end][1]

    for _ in range(SWEEPS):
        for name, each in free.items():
            snaps = settling.get(name, ())
            if before.get(name) != snaps:
                moved = _moved(each, snaps, state)
                known[name] = curve_targets(moved, state.plane).without_points("end")
                before[name] = snaps
        after = {}
        for name in free:
            met = taken.get(name, [])
            held = {snap.end for snap in met}
            alone = [end for end in ends if end.owner == name and end.number not in held]
            rest = [on_body(end) for end in alone]
            both = (*met, *(snap for snap in rest if snap is not None))
            after[name] = tuple(sorted(both, key=lambda snap: snap.end))
        if after == settling:
            break
        settling = after
    return {name: settling.get(name, ()) for name in free}


def with_settled(
    state: SymmetryState, context: Context, *, chosen: bool = False, box: bool = True
) -> SymmetryState:
    """Return the state in which ends that nearly meet something do.

    Parameters
    ----------
    state : SymmetryState
        Its curves.
    context : Context
        The curves of other models.
    chosen : bool
        Only the chosen curve, and those whose ends settle elsewhere because of it.
    box : bool
        Whether the edges and faces of the box count.
    """
    found = settled(state, context, box=box)
    if chosen:
        node = state.chosen
        before = settled(state, context, state.selected, box=box)
        found = {
            name: snaps for name, snaps in found.items()
            if node is not None and (name == node.id or snaps != before.get(name))
        }  # fmt: skip
    for node in state.curves:
        if node.id not in found:
            continue
        base = trace_of(replace(node, end_snaps=(), axis=-1), state)
        assert base.curve is not None
        made = [end_snap_of(snap, base.curve, node, state) for snap in found[node.id]]
        snaps = tuple(snap for snap in made if snap is not None)
        if snaps != node.end_snaps:
            node = replace(node, end_snaps=snaps)
            state = replace(state.with_node(node), selected=state.selected)
    return state


def end_snap_of(snap: Snap, curve: SpaceCurve, node: Curve, state: SymmetryState) -> EndSnap | None:
    """Return a snap of the curve as one of the stroke that ends there; the last such stroke."""
    for number in range(len(node.strokes) - 1, -1, -1):
        stroke = node.strokes[number]
        for end in (0, 1):
            shown = drawn_end(curve, stroke, end, state)
            if shown is None or shown.end != snap.end:
                continue
            if not shown.mirrored:
                return EndSnap(number, end, snap.point, snap.tangent)
            way = snap.tangent
            if way is not None:
                way = triple(_turned(_turned(way, state) * MIRROR, state, back=True))
            place = state.plane.inverse.points(snap.point)[0] * MIRROR
            return EndSnap(number, end, triple(state.plane.placement.points(place)[0]), way)
    return None


def _turned(way: Sequence[float] | Array, state: SymmetryState, *, back: bool = False) -> Array:
    frame = state.plane.placement if back else state.plane.inverse
    return np.asarray(frame.directions(way)[0])


def _met(
    ends: list[FreeEnd], fixed: Targets, free: Mapping[str, Free], state: SymmetryState
) -> dict[str, list[Snap]]:
    """Return the ends that meet others, or fixed points, with their common places."""
    points = state.plane.inverse.points(fixed.points) if len(fixed.points) else fixed.points
    ways = state.plane.inverse.directions(fixed.tangents) if len(points) else points
    sides = np.where(points[:, 1:2] < 0.0, MIRROR, 1.0)
    points, ways = points * sides, ways * sides
    met = meetings(ends, points)
    axes = {
        name: _turned(AXES[each.node.axis], state)
        for name, each in free.items()
        if each.node.axis >= 0 and each.curve.reading == "pair"
    }
    places = common_places(ends, met, points, axes)
    found: dict[str, list[Snap]] = {}
    for (members, held), place in zip(met, places, strict=True):
        if len(members) < 2 and held < 0:
            continue
        for k, way in zip(
            members, continued(members, ends, ways[held] if held >= 0 else None), strict=True
        ):
            end = ends[k]
            point = state.plane.placement.points(place * end.side)[0]
            tangent = None if way is None else triple(_turned(way * end.side, state, back=True))
            found.setdefault(end.owner, []).append(Snap(end.number, triple(point), tangent))
    return found


def _moved(each: Free, snaps: tuple[Snap, ...], state: SymmetryState) -> SpaceCurve:
    """Return a curve with its ends where they settle."""
    made = [end_snap_of(snap, each.curve, each.node, state) for snap in snaps]
    node = replace(each.node, end_snaps=tuple(snap for snap in made if snap is not None))
    return with_end_snaps(each.curve, node, each.trace.sigma, state)


def _others(end: FreeEnd, bodies: Mapping[str, Targets], state: SymmetryState) -> Iterator[Targets]:
    """Yield what an end may be near of the curves that it is no end of."""
    place = state.plane.placement.points(end.place * end.side)[0]
    for name, body in bodies.items():
        low, high = body.corners
        is_near = (low - end.room <= place) & (place <= high + end.room)
        if name != end.owner and is_near.all():
            yield body


def _on_body(
    end: FreeEnd, each: Free, known: Sequence[Targets], state: SymmetryState, box: bool
) -> Snap | None:
    """Return where a single end settles on a curve, on the centre plane or on a face.

    These do not move with it, so it goes no farther than its own ink allows: `FARTHEST` errors of
    a hand, and no farther than a person sees it caught.
    """
    frame = state.plane.placement
    turn = frame.directions(np.eye(3)).T * end.side
    place = frame.points(end.place * end.side)[0]
    stretch, axes = np.linalg.eigh(turn @ end.known @ turn.T)
    stretch = np.sqrt(np.maximum(stretch, 0.0)) / (FARTHEST * HAND)
    shrink, grow = (axes * stretch) @ axes.T, (axes / np.maximum(stretch, LEAST**2)) @ axes.T
    leaving = _turned(end.leaving * end.side, state, back=True)
    snap = snap_within(
        end.number, place, (shrink, grow), Targets.joined(known), state, leaving,
        within_plane=each.curve.reading == "plane", faces=box,
    )  # fmt: skip
    if snap is None:
        return None
    return snap if end.away(state.plane.inverse.points(snap.point)[0] * end.side) <= 1.0 else None
