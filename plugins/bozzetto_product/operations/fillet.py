"""Corners between two curves, rounded by a radius."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import Strokes
from bozzetto_product.model.joints import Boundary, Joint, Meeting, Run
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.boundaries import outlines_of_boundary, with_boundaries
from bozzetto_product.operations.meetings import (
    curve_of,
    is_end,
    joint_of,
    meeting_place,
    place_at,
    share_at,
    spline_of,
    splines_of,
)
from bozzetto_product.operations.pieces import (
    chained,
    delete_curves,
    split_curve,
    without_idle_joints,
)
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.operations.tangents import end_direction
from bozzetto_product.projection.planes import mirror_image
from bozzetto_product.projection.spline_basis import chord_length

PIECE: Final = np.pi / 6.0
"""Largest angle of an arc that is one cubic: it is off the circle by 2e-7 of the radius."""

NARROWEST: Final = 1e-3
"""Least angle, radians, between two directions that make a corner."""

EXACT: Final = 1e-9
"""Distance, as a share of the radius, between the centres over both curves that is none."""


NO_CORNER: Final = (
    "A corner of two curves that end in one place, not in the symmetry plane, can be rounded. "
    "Choose such a corner."
)

LOOKS: Final = 257
"""Places of an arc and of a curve of which the nearest are found."""


class _Side(NamedTuple):
    """A curve at a corner: its spline from the corner on, and the frame of the corner's plane."""

    spline: Spline
    origin: Array
    along: Array
    inward: Array


def fillet(
    state: ProductState, joint_id: str, first: str, second: str, radius: float
) -> tuple[ProductState, str]:
    """Round the corner between two curves that end in one joint.

    Both curves are cut where a circle of the radius touches them, seen along the
    corner's normal; an arc that joins them there is a curve of its own. What else ends in the
    joint ends on the arc from then on: one curve where it comes nearest to the arc, several where
    the arc is nearest to the corner.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    joint_id : str
        Id of the joint at the corner.
    first, second : str
        Ids of the curves.
    radius : float
        mm.

    Returns
    -------
    state : ProductState
        The network, in the frame of the model.
    name : str
        Id of the arc.

    Raises
    ------
    UserError
        If the curves make no corner there, another one runs through it, or the radius is too large.
    """
    joint, splines = joint_of(state, joint_id), splines_of(state)
    meetings = [meet for meet in joint.meetings if meet.curve in splines]
    named = {meet.curve: meet for meet in meetings}
    if first == second or not {first, second} <= named.keys() or joint.in_plane:
        raise UserError(NO_CORNER)
    ends = [named[first], named[second]]
    if any(meet.mirrored for meet in ends) or len(named) < len(meetings):
        raise UserError(NO_CORNER)
    if not all(is_end(splines, meet) for meet in meetings):
        raise UserError("A curve runs through this corner. Split it there first.")
    if not (np.isfinite(radius) and radius > 0.0):
        raise UserError("A radius is a length above 0.")
    inward = [_from_corner(splines[meet.curve], meet.at) for meet in ends]
    sides = _sides(inward[0], inward[1])
    at = _touching(sides, radius)
    arc = _arc(sides, at, radius)
    cuts = [
        share_at(side.spline, at[k]) if ends[k].at == 0.0 else 1.0 - share_at(side.spline, at[k])
        for k, side in enumerate(sides)
    ]
    for meet, cut in zip(ends, cuts, strict=True):
        if _is_met_before(state, meet, cut):
            raise UserError("Another curve meets within this radius. Choose a smaller one.")
    return _put_together(state, joint, ends, cuts, arc)


def _from_corner(spline: Spline, at: float) -> Spline:
    return spline if at == 0.0 else spline.reversed()


def _sides(one: Spline, other: Spline) -> list[_Side]:
    """Return both curves from the corner on, with the frame of the corner's plane."""
    ways = end_direction(one, 0.0), end_direction(other, 0.0)
    if np.linalg.norm(cross_product(*ways)) < np.sin(NARROWEST):
        raise UserError("These curves make no corner: they run on or back over one another.")
    sides = []
    for spline, way, toward in ((one, ways[0], ways[1]), (other, ways[1], ways[0])):
        inward = toward - (toward @ way) * way
        sides.append(_Side(spline, one.control_points[0], way, inward / np.linalg.norm(inward)))
    return sides


def _touching(sides: list[_Side], radius: float) -> Array:
    """Return the parameters at which a circle touches both curves, by least squares.

    Over each curve lies the place at the radius across it; both places are one, the centre.
    """
    from scipy.optimize import least_squares

    frame = np.stack((sides[0].along, sides[0].inward))
    start, low, high = [], [], []
    cosine = float(sides[0].along @ sides[1].along)
    reach = radius * np.sqrt((1.0 + cosine) / max(1.0 - cosine, 1e-12))
    for side in sides:
        begin, end = side.spline.range
        share = min(0.9, reach / chord_length(side.spline))
        start.append(begin + share * (end - begin))
        low.append(begin)
        high.append(end)

    def apart(at: Array) -> Array:
        one, other = (_centre(side, frame, at[k], radius) for k, side in enumerate(sides))
        return np.asarray((one - other) / radius)

    found = least_squares(
        apart, start, bounds=(low, high), x_scale=np.subtract(high, low),
        xtol=1e-15, ftol=1e-15, gtol=1e-15,
    )  # fmt: skip
    inside = (found.x > low).all() and (found.x < high).all()
    if not inside or not np.linalg.norm(found.fun) <= EXACT:
        raise UserError("The radius is too large for these curves. Choose a smaller one.")
    return np.asarray(found.x)


def _centre(side: _Side, frame: Array, at: float, radius: float) -> Array:
    """Return the place at the radius across a curve, in the corner's plane, (2,)."""
    place = frame @ (side.spline.value([at])[0] - side.origin)
    way = frame @ side.spline.derivative([at])[0]
    way = way / np.linalg.norm(way)
    across = np.array((-way[1], way[0]))
    side_of = across if across @ (frame @ side.inward) > 0.0 else -across
    return np.asarray(place + radius * side_of)


def _arc(sides: list[_Side], at: Array, radius: float) -> Spline:
    """Return the arc between two curves, with their directions at its ends."""
    frame = np.stack((sides[0].along, sides[0].inward))
    upright = cross_product(*frame)
    origin = sides[0].origin
    ends = [side.spline.value([at[k]])[0] for k, side in enumerate(sides)]
    ways = [side.spline.derivative([at[k]])[0] for k, side in enumerate(sides)]
    ways = [-ways[0] / np.linalg.norm(ways[0]), ways[1] / np.linalg.norm(ways[1])]
    centre = _centre(sides[0], frame, at[0], radius)
    spokes = [frame @ (end - origin) - centre for end in ends]
    first = np.arctan2(spokes[0][1], spokes[0][0])
    across, same = np.linalg.det(np.stack(spokes)), float(spokes[0] @ spokes[1])
    turn = float(np.arctan2(across, same))
    count = max(1, int(np.ceil(abs(turn) / PIECE)))
    angles = first + turn * np.arange(count + 1) / count
    round_ = centre + radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    tangent = np.sign(turn) * np.stack((-np.sin(angles), np.cos(angles)), axis=1)
    # Out of the corner's plane it rises steadily from one curve to the other.
    heights = np.array([float((end - origin) @ upright) for end in ends])
    slopes = np.array([float(way @ upright) / max(1e-9, np.hypot(*(frame @ way))) for way in ways])
    share = np.arange(count + 1) / count
    length = abs(turn) * radius
    height, slope = _hermite(share, heights, slopes * length)
    points = origin + round_ @ frame + height[:, None] * upright
    speeds = tangent @ frame + (slope / length)[:, None] * upright
    handle = 4.0 / 3.0 * np.tan(abs(turn) / count / 4.0) * radius
    points[0], points[-1] = ends
    pieces = [
        Spline.uniform(
            np.stack(
                (
                    points[k],
                    points[k] + handle * speeds[k],
                    points[k + 1] - handle * speeds[k + 1],
                    points[k + 1],
                )
            )
        )
        for k in range(count)
    ]
    return chained(pieces)[0]


def _hermite(share: Array, ends: Array, slopes: Array) -> tuple[Array, Array]:
    """Return values and slopes of the cubic with given ends and slopes over 0 … 1."""
    t = share
    value = (
        ends[0] * (1 + 2 * t) * (1 - t) ** 2
        + slopes[0] * t * (1 - t) ** 2
        + ends[1] * t**2 * (3 - 2 * t)
        - slopes[1] * t**2 * (1 - t)
    )
    slope = (
        6 * t * (1 - t) * (ends[1] - ends[0])
        + slopes[0] * (1 - t) * (1 - 3 * t)
        + slopes[1] * t * (3 * t - 2)
    )
    return value, slope


def _is_met_before(state: ProductState, meet: Meeting, cut: float) -> bool:
    """Whether something else meets the part of a curve that is cut off."""
    return any(
        other.curve == meet.curve
        and other.at != meet.at
        and abs(other.at - meet.at) < abs(cut - meet.at)
        for joint in state.joints
        for other in joint.meetings
    )


def _put_together(
    state: ProductState, joint: Joint, ends: list[Meeting], cuts: list[float], arc: Spline
) -> tuple[ProductState, str]:
    """Return the network with both curves cut back, and the arc between them."""
    kept, corners, waste = [], [], []
    for meet, cut in zip(ends, cuts, strict=True):
        state, names = split_curve(state, meet.curve, [cut])
        stays, goes = names if meet.at == 1.0 else names[::-1]
        if meet.at == 0.0:  # the part that stays keeps the id
            state = _exchanged(state, stays, goes)
            stays, goes = goes, stays
        kept.append(stays)
        waste.append(goes)
        corners.append(next(
            one.id for one in state.joints if {m.curve for m in one.meetings} >= {stays, goes}
        ))  # fmt: skip
    curve = curve_of(state, ends[0].curve)
    name = state.unused_id()
    points = np.array(arc.control_points)
    for end, k in ((0, 0), (-1, 1)):
        at = -1 if ends[k].at == 1.0 else 0
        points[end] = spline_of(state, kept[k]).control_points[at]
    fresh = replace(
        curve, id=name, name=state.unused_name("Curve"), spline=Spline(arc.knots, points),
        strokes=Strokes(), laid=None, plane=None, stretches=(), told=(),
    )  # fmt: skip
    others = tuple(
        meet for meet in joint.meetings if meet.curve not in (ends[0].curve, ends[1].curve)
    )
    assert fresh.spline is not None
    share = _share_for(state, joint, others, fresh.spline)
    joints = []
    for one in state.joints:
        if one.id in corners:
            meeting = Meeting(name, float(corners.index(one.id)))
            joints.append(replace(one, meetings=(*one.meetings, meeting)))
        elif one.id != joint.id:
            joints.append(one)
        elif others:
            joints.append(replace(one, meetings=(*others, Meeting(name, share))))
    state = replace(state.with_node(fresh), joints=tuple(joints))

    def change(boundary: Boundary) -> Boundary:
        return _round_the_corner(boundary, waste, corners, name)

    state = without_idle_joints(delete_curves(with_boundaries(state, change), *waste))
    pins = {joint.id: place_at(fresh.spline, share)} if others else {}
    return settled_state(state, {}, pins), name


def _share_for(
    state: ProductState, joint: Joint, others: tuple[Meeting, ...], arc: Spline
) -> float:
    """Return the share of the arc at which the other curves of a corner end from then on."""
    from scipy.spatial import cKDTree

    places = arc.sampled(LOOKS)
    if len(others) == 1:
        beside = spline_of(state, others[0].curve).sampled(LOOKS)
        beside = mirror_image(beside, state.symmetry) if others[0].mirrored else beside
    else:
        beside = meeting_place(splines_of(state), joint.meetings[0], state.symmetry)[None]
    away = cKDTree(beside).query(places[1:-1])[0]
    return float((1 + int(np.argmin(away))) / (LOOKS - 1))


def _exchanged(state: ProductState, one: str, other: str) -> ProductState:
    """Return the network with the ids and the names of two curves exchanged."""
    swap = {one: other, other: one}
    names = {curve_id: curve_of(state, curve_id).name for curve_id in swap}
    nodes: list[Any] = []
    for node in state.nodes:
        if isinstance(node, Patch):
            runs = tuple(
                replace(run, curve=swap.get(run.curve, run.curve)) for run in node.boundary
            )
            nodes.append(replace(node, boundary=runs))
        else:
            known = swap.get(node.id, node.id)
            nodes.append(replace(node, id=known, name=names.get(known, node.name)))
    joints = tuple(
        replace(
            joint,
            meetings=tuple(replace(m, curve=swap.get(m.curve, m.curve)) for m in joint.meetings),
        )
        for joint in state.joints
    )
    rejected = tuple(
        tuple(replace(run, curve=swap.get(run.curve, run.curve)) for run in boundary)
        for boundary in state.rejected
    )
    return replace(state, nodes=tuple(nodes), joints=joints, rejected=rejected)


def _round_the_corner(
    boundary: Boundary, waste: list[str], corners: list[str], arc: str
) -> Boundary:
    """Return a boundary in which the two parts at a corner are the arc, and one is its half."""
    rows = [
        (outline[number - 1], run, outline[(number + 1) % len(outline)])
        for outline in outlines_of_boundary(boundary)
        for number, run in enumerate(outline)
    ]
    runs: list[Run] = []
    for before, run, after in rows:
        if run.curve not in waste:
            runs.append(run)
        elif before.curve in waste and run.curve != before.curve:
            forward = before.curve == waste[0]
            start, end = (corners[0], corners[1]) if forward else (corners[1], corners[0])
            runs.append(Run(arc, start, end, forward, run.mirrored))
        elif after.curve not in waste or run.curve == after.curve:
            forward = (run.start == corners[0]) or (run.end == corners[1])
            runs.append(Run(arc, run.start, run.end, forward, run.mirrored))
    return tuple(runs)
