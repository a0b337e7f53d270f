"""Curves taken away, turned round, cut in pieces and joined to one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Index
from bozzetto.errors import UserError
from bozzetto.geometry import DEGREE, Spline
from bozzetto_product.model.curve_stretch import stretches_within, with_stretch
from bozzetto_product.model.curves import Curve, LaidPlaces, Stretch
from bozzetto_product.model.joints import Boundary, Joint, Meeting, Run
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.boundaries import (
    joined_runs,
    joints_in_use,
    outlines_of_boundary,
    span_of,
    split_run,
    with_boundaries,
)
from bozzetto_product.operations.end_moves import moved_to_ends
from bozzetto_product.operations.meetings import (
    curve_of,
    parameter_at,
    place_at,
    share_at,
    spline_of,
    splines_of,
    unused_joint_ids,
)
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.operations.tangents import end_direction, with_end_direction
from bozzetto_product.projection.spline_basis import chord_length

SHORTEST: Final = 1e-6
"""Least share of a curve that is a piece of its own."""

BACK: Final = -0.5
"""Cosine of the turn at a joint below which two curves cannot run on as one: 120°."""

NEAR: Final = 0.1
"""Gap, as a share of the shorter curve, that is closed by moving both ends; a wider one is
bridged."""


def delete_curves(state: ProductState, *curve_ids: str) -> ProductState:
    """Return the network without some curves, and without the surfaces and holes that they bound.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    *curve_ids : str
        Ids of curves; unknown ones count for nothing.
    """

    def kept(boundary: Boundary) -> Boundary | None:
        rim, *holes = (
            () if any(run.curve in curve_ids for run in outline) else outline
            for outline in outlines_of_boundary(boundary)
        )
        return tuple(run for outline in (rim, *holes) for run in outline) if rim else None

    return without_idle_joints(with_boundaries(state.without_nodes(*curve_ids), kept))


def without_idle_joints(state: ProductState) -> ProductState:
    """Return the network without joints at which nothing meets any more."""
    names, used = set(splines_of(state)), joints_in_use(state)
    joints = []
    for joint in state.joints:
        meetings = tuple(meet for meet in joint.meetings if meet.curve in names)
        if len(meetings) > 1 or (meetings and (joint.in_plane or joint.id in used)):
            joints.append(
                joint if meetings == joint.meetings else replace(joint, meetings=meetings)
            )
    return replace(state, joints=tuple(joints))


def turn_curve(state: ProductState, curve_id: str) -> ProductState:
    """Return the network with a curve that runs the other way."""
    curve = curve_of(state, curve_id)
    assert curve.spline is not None
    meetings_turned = [
        replace(
            joint,
            meetings=tuple(
                replace(meet, at=1.0 - meet.at) if meet.curve == curve_id else meet
                for meet in joint.meetings
            ),
        )
        for joint in state.joints
    ]
    laid = None if curve.laid is None else _laid_taken(curve.laid, slice(None, None, -1))
    stretches = stretches_within(curve.stretches, 0.0, 1.0, (1.0, 0.0))
    turned = replace(curve, spline=curve.spline.reversed(), laid=laid, stretches=stretches)
    nodes = tuple(turned if node.id == curve_id else node for node in state.nodes)
    state = replace(state, nodes=nodes, joints=tuple(meetings_turned))

    def change(boundary: Boundary) -> Boundary:
        return tuple(
            replace(run, forward=not run.forward) if run.curve == curve_id else run
            for run in boundary
        )

    return settled_state(with_boundaries(state, change), {})


def split_curve(
    state: ProductState, curve_id: str, shares: Sequence[float]
) -> tuple[ProductState, tuple[str, ...]]:
    """Cut a curve; its pieces stay joined, and what met it still does.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    curve_id : str
        Id of the curve.
    shares : sequence of float
        Where to cut, as shares of its range.

    Returns
    -------
    state : ProductState
        The first piece keeps the id of the curve.
    pieces : tuple of str
        Ids of the pieces, along the curve; of a closed curve from the first cut.

    Raises
    ------
    UserError
        If there is no such curve, or no place inside it to cut it at.
    """
    curve, spline = curve_of(state, curve_id), spline_of(state, curve_id)
    wanted = [float(share) % 1.0 if spline.closed else float(share) for share in shares]
    inside = [share for share in wanted if spline.closed or SHORTEST < share < 1.0 - SHORTEST]
    cuts = sorted(set(inside))
    cuts = [cut for k, cut in enumerate(cuts) if k == 0 or cut - cuts[k - 1] > SHORTEST]
    if not cuts:
        raise UserError("The curve cannot be cut there. Choose a place inside it.")
    parts = exact_pieces(spline, cuts)
    names = [curve_id]
    for _ in parts[1:]:
        names.append(_unused_id(state, names))
    joints, marks = _joints_of_pieces(state.joints, curve_id, spline.closed, cuts, names)
    stops = [*cuts, cuts[0] + 1.0] if spline.closed else [0.0, *cuts, 1.0]
    nodes = []
    for node in state.nodes:
        if node.id != curve_id:
            nodes.append(node)
            continue
        for number, (name, part) in enumerate(zip(names, parts, strict=True)):
            title = node.name if number == 0 else f"{node.name} {number + 1}".strip()
            piece = _part_of(curve, stops[number], stops[number + 1])
            nodes.append(replace(piece, id=name, name=title, spline=part))
    spans = {
        run: span_of(run, state.joints, spline.closed)
        for boundary in _boundaries(state)
        for run in boundary
        if run.curve == curve_id
    }

    def change(boundary: Boundary) -> Boundary:
        runs: list[Run] = []
        for run in boundary:
            runs.extend(split_run(run, spans[run], marks, names) if run in spans else [run])
        return tuple(runs)

    changed = with_boundaries(state, change)
    patches = {node.id: node for node in changed.nodes}
    new = replace(
        changed, nodes=tuple(patches.get(n.id, n) if n.id not in names else n for n in nodes)
    )
    # Places inside a piece are evaluated anew: what meets there follows to the last bit.
    return settled_state(replace(new, joints=joints), {}), tuple(names)


def join_curves(
    state: ProductState, first: str, first_end: float, second: str, second_end: float
) -> ProductState:
    """Make one curve of two, which runs smoothly over the place where they meet.

    Both ends give way to one another: in place where the gap is small, else a bridge is laid,
    and in direction. What met them there meets the inside of the one curve.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    first, second : str
        Ids of the curves; the one that comes has the id of the first.
    first_end, second_end : {0, 1}
        Which of their ends meet.

    Returns
    -------
    ProductState

    Raises
    ------
    UserError
        If one of them is closed, both are the same, only one has a mirror image, or their ends
        point back at one another.
    """
    one, other = curve_of(state, first), curve_of(state, second)
    if first == second:
        raise UserError("A curve cannot be joined to itself. Trim closes it at a corner.")
    if spline_of(state, first).closed or spline_of(state, second).closed:
        raise UserError("A closed curve has no end to join. Split it first.")
    if one.mirrored != other.mirrored:
        raise UserError("One of these curves has a mirror image, the other has none. Mirror both.")
    if first_end != 1.0:
        state = turn_curve(state, first)
    if second_end != 0.0:
        state = turn_curve(state, second)
    one, other = curve_of(state, first), curve_of(state, second)
    whole, seams = chained(_smooth_row(spline_of(state, first), spline_of(state, second)))
    lows = {first: 0.0, second: seams[-1]}
    highs = {first: seams[0], second: 1.0}
    strokes = one.strokes.extended(tuple(other.strokes))
    merged = replace(one, spline=whole, strokes=strokes, laid=None)
    merged = replace(merged, stretches=_stretches_of_both(one, other, seams))
    if one.plane != other.plane:
        merged = replace(merged, plane=None)
    return _as_one(state, merged, second, lows, highs)


def _stretches_of_both(one: Curve, other: Curve, seams: Sequence[float]) -> tuple[Stretch, ...]:
    """Return the stretches of a curve of two, the first of which says how all of it meets."""
    own = stretches_within(one.stretches, 0.0, 1.0, (0.0, seams[0]))
    if (other.edge, other.crease) != (one.edge, one.crease):
        given = other.stretches
        other = replace(other, stretches=(Stretch(0.0, 1.0, other.edge, other.crease),))
        for each in given:
            other = with_stretch(other, each.low, each.high, each)
    return (*own, *stretches_within(other.stretches, 0.0, 1.0, (seams[-1], 1.0)))


def chained(parts: Sequence[Spline]) -> tuple[Spline, list[float]]:
    """Return clamped splines that meet in place and direction as one of continuous speed.

    Returns
    -------
    spline : Spline
        In space, mm.
    seams : list of float
        Shares of its range at which the parts meet.
    """
    whole = parts[0]
    seams = []
    for part in parts[1:]:
        meeting = whole.range[1]
        before = float(np.linalg.norm(whole.derivative([meeting])[0]))
        after = float(np.linalg.norm(part.derivative([part.range[0]])[0]))
        pace = after / before if before > 0.0 and after > 0.0 else 1.0
        later = meeting + pace * (part.knots[DEGREE + 1 :] - part.range[0])
        whole = Spline(
            np.concatenate((whole.knots[: -DEGREE - 1], (meeting, meeting), later)),
            np.vstack((whole.control_points[:-1], part.control_points[1:])),
        )
        seams.append(meeting)
    return whole, [share_at(whole, seam) for seam in seams]


def _smooth_row(one: Spline, other: Spline) -> list[Spline]:
    """Return two curves whose end and start agree in place and direction, bridged if need be."""
    end, start = np.array(one.control_points[-1]), np.array(other.control_points[0])
    gap = float(np.linalg.norm(start - end))
    shorter = min(chord_length(one), chord_length(other))
    if gap > NEAR * shorter:
        return [one, _bridge(one, other), other]
    if gap > 0.0:
        share = chord_length(other) / (chord_length(one) + chord_length(other))
        place = end + share * (start - end)
        one = moved_to_ends(one, one.control_points[0], place)
        other = moved_to_ends(other, place, other.control_points[-1])
    ahead, onward = -end_direction(one, 1.0), end_direction(other, 0.0)
    if float(ahead @ onward) < BACK:
        raise UserError("These ends point back at one another. Join other ends.")
    along = ahead + onward
    along = along / np.linalg.norm(along)
    return [with_end_direction(one, 1.0, -along), with_end_direction(other, 0.0, along)]


def _bridge(one: Spline, other: Spline) -> Spline:
    """Return the cubic from the end of one curve to the start of another, with their directions.

    Its speeds are those of a circle's arc, chord / cos²(θ/4) for a turn of θ.
    """
    ahead, onward = -end_direction(one, 1.0), end_direction(other, 0.0)
    start, end = one.control_points[-1], other.control_points[0]
    turn = np.arccos(float(np.clip(ahead @ onward, -1.0, 1.0)))
    speed = float(np.linalg.norm(end - start)) / np.cos(0.25 * turn) ** 2 / DEGREE
    return Spline.uniform(np.stack((start, start + speed * ahead, end - speed * onward, end)))


def _as_one(
    state: ProductState, merged: Curve, second: str, lows: dict[str, float], highs: dict[str, float]
) -> ProductState:
    """Return the network with two curves exchanged for one."""
    first = merged.id

    def moved(meet: Meeting) -> Meeting:
        if meet.curve not in lows:
            return meet
        low, high = lows[meet.curve], highs[meet.curve]
        return replace(meet, curve=first, at=low + meet.at * (high - low))

    joints, at_seam = [], []
    for joint in state.joints:
        ends = [(meet.curve, meet.at) for meet in joint.meetings]
        meetings = tuple(dict.fromkeys(moved(meet) for meet in joint.meetings))
        if (first, 1.0) in ends or (second, 0.0) in ends:
            at_seam.append(joint.id)
            seam = {moved(Meeting(first, 1.0)).at, moved(Meeting(second, 0.0)).at}
            inner = [meet for meet in meetings if meet.curve == first and meet.at in seam][:1]
            others = [meet for meet in meetings if meet.curve != first or meet.at not in seam]
            meetings = (*inner, *others)
        joints.append(replace(joint, meetings=meetings))

    def change(boundary: Boundary) -> Boundary:
        runs = tuple(replace(run, curve=first) if run.curve == second else run for run in boundary)
        for name in at_seam:
            runs = joined_runs(runs, first, name)
        return runs

    nodes = tuple(merged if node.id == first else node for node in state.nodes if node.id != second)
    new = with_boundaries(replace(state, nodes=nodes, joints=tuple(joints)), change)
    assert merged.spline is not None
    return settled_state(without_idle_joints(replace(new, selected=first)), {first: merged.spline})


def exact_pieces(spline: Spline, cuts: Sequence[float]) -> list[Spline]:
    """Return the pieces of a curve, which begin and end in the very same numbers."""
    parts = list(spline.split(*(parameter_at(spline, cut) for cut in cuts)))
    places = [place_at(spline, cut) for cut in cuts]
    made = []
    for number, part in enumerate(parts):
        points = np.array(part.control_points)
        if spline.closed:
            points[0], points[-1] = places[number], places[(number + 1) % len(places)]
        else:
            points[0] = places[number - 1] if number else points[0]
            points[-1] = places[number] if number < len(places) else points[-1]
        made.append(Spline(part.knots, points))
    return made


def _joints_of_pieces(
    joints: Sequence[Joint], curve: str, closed: bool, cuts: Sequence[float], names: Sequence[str]
) -> tuple[tuple[Joint, ...], list[tuple[float, str]]]:
    """Return all joints after a cut, and the share and joint of each cut."""

    def pieces_at(cut: int) -> tuple[Meeting, ...]:
        before = names[cut - 1] if closed else names[cut]
        after = names[cut] if closed else names[cut + 1]
        return Meeting(before, 1.0), Meeting(after, 0.0)

    def moved(meet: Meeting) -> tuple[Meeting, ...]:
        if meet.curve != curve:
            return (meet,)
        for number, cut in enumerate(cuts):
            if abs(meet.at - cut) <= SHORTEST:
                return tuple(replace(one, mirrored=meet.mirrored) for one in pieces_at(number))
        stops = [*cuts, cuts[0] + 1.0] if closed else [0.0, *cuts, 1.0]
        at = meet.at + (1.0 if closed and meet.at < cuts[0] else 0.0)
        number = max(k for k in range(len(stops) - 1) if stops[k] <= at)
        low, high = stops[number], stops[number + 1]
        return (replace(meet, curve=names[number], at=(at - low) / (high - low)),)

    new = []
    marks: dict[int, str] = {}
    for joint in joints:
        for number, cut in enumerate(cuts):
            if any(m.curve == curve and abs(m.at - cut) <= SHORTEST for m in joint.meetings):
                marks[number] = joint.id
        new.append(replace(joint, meetings=tuple(one for m in joint.meetings for one in moved(m))))
    missing = [number for number in range(len(cuts)) if number not in marks]
    for number, name in zip(missing, unused_joint_ids(joints, len(missing)), strict=True):
        marks[number] = name
        new.append(Joint(name, pieces_at(number)))
    return tuple(new), [(cut, marks[number]) for number, cut in enumerate(cuts)]


def _part_of(curve: Curve, low: float, high: float) -> Curve:
    """Return a curve with those of its places on surfaces, and stretches, that are on a part."""

    def rows(count: int) -> Index:
        steps = max(1, round((high - low) * (count - 1)))
        at = np.rint(np.linspace(low, high, steps + 1) * (count - 1)).astype(np.intp)
        return at if high <= 1.0 else at % (count - 1)

    laid = curve.laid
    if laid is not None and len(laid.points) > 1:
        laid = _laid_taken(laid, rows(len(laid.points)))
    return replace(curve, laid=laid, stretches=stretches_within(curve.stretches, low, high))


def _laid_taken(laid: LaidPlaces, rows: Index | slice) -> LaidPlaces:
    return replace(
        laid, faces=laid.faces[rows], weights=laid.weights[rows], points=laid.points[rows]
    )


def _unused_id(state: ProductState, names: Sequence[str]) -> str:
    taken = {node.id for node in state.nodes} | set(names)
    return next(f"n{k}" for k in range(1, len(taken) + 2) if f"n{k}" not in taken)


def _boundaries(state: ProductState) -> list[Boundary]:
    return [*(patch.boundary for patch in state.of_kind(Patch)), *state.rejected]
