"""Curves brought to where their joints are, so that what is joined follows.

A joint is held where it is said to be; or it is carried by a curve that it is on the inside of; or
it stays. Every curve whose ends are to be elsewhere is moved as a whole from where it was. As a
curve that is moved may carry further joints, this is repeated until nothing changes any more; it
always starts from the curves as they were, so the outcome does not depend on any order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.ink import spline_weights
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.end_moves import moved_to_ends
from bozzetto_product.operations.meetings import (
    is_end,
    meeting_place,
    parameter_at,
    splines_of,
    with_splines,
)
from bozzetto_product.projection.planes import in_plane, mirror_image
from bozzetto_product.projection.spline_basis import free_controls, with_controls

ROUNDS: Final = 60
"""Most rounds. Chains of curves that carry one another need as many as they are long; two that
carry each other come nearer by their bend in each."""

TOUCHING: Final = 1e-12
"""Distance from a place, as a share of the size of the curves, at which it is reached."""

FARTHEST: Final = 4.0
"""Most that a control point moves to pass places, in the longest way that a place asks for: places
beside one another that ask for opposite ways would throw a curve far off."""

SPREADS: Final = (1e-9, 1e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Shares of the largest singular value below which wishes are left out, tried in this order."""


def settled(
    splines: Mapping[str, Spline],
    joints: Sequence[Joint],
    symmetry: Plane,
    *,
    pinned: Mapping[str, Array] | None = None,
    planes: Mapping[str, Plane] | None = None,
) -> dict[str, Spline]:
    """Return all curves with their ends where their joints are.

    Parameters
    ----------
    splines : mapping of str to Spline
        Curves as they are, by id, mm.
    joints : sequence of Joint
        Meetings with curves that are not there count for nothing.
    symmetry : Plane
        In which mirror images are.
    pinned : mapping of str to (3,) array, optional
        Where joints are to be, by id.
    planes : mapping of str to Plane, optional
        In which curves stay.

    Returns
    -------
    dict of str to Spline
    """
    pins = dict(pinned or {})
    held = dict(planes or {})
    known = [
        (joint, tuple(meet for meet in joint.meetings if meet.curve in splines)) for joint in joints
    ]
    now = dict(splines)
    before: Mapping[str, Sequence[_Goal]] | None = None
    for _ in range(ROUNDS):
        goals = _goals(now, splines, known, symmetry, pins)
        new = {
            name: now[name]  # it was brought to these very places in the round before
            if before is not None and _same_goals(goals.get(name, ()), before.get(name, ()))
            else _brought(name, spline, goals.get(name, ()), held.get(name))
            for name, spline in splines.items()
        }
        before = goals
        if all(_same(new[name], now[name]) for name in new):
            return new
        now = new
    return now


def settled_state(
    state: ProductState,
    splines: Mapping[str, Spline],
    pinned: Mapping[str, Array] | None = None,
) -> ProductState:
    """Return a state in which some curves are exchanged, and what is joined follows.

    Joints at the ends of the curves that are exchanged go where these ends are.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    splines : mapping of str to Spline
        New courses of curves, by id.
    pinned : mapping of str to (3,) array, optional
        Where joints are to be, by id.
    """
    whole = {**splines_of(state), **splines}
    pins = dict(pinned or {})
    for joint in state.joints:
        ends = [meet for meet in joint.meetings if meet.curve in splines and is_end(whole, meet)]
        if ends and joint.id not in pins:
            place = meeting_place(whole, ends[0], state.symmetry)
            pins[joint.id] = in_plane(place, state.symmetry) if joint.in_plane else place
    new = settled(whole, state.joints, state.symmetry, pinned=pins, planes=planes_of(state))
    return with_splines(state, new)


def planes_of(state: ProductState) -> dict[str, Plane]:
    """Return the planes that curves stay in, by the ids of the curves."""
    return {curve.id: curve.plane for curve in state.of_kind(Curve) if curve.plane is not None}


_Goal = tuple[Meeting, Array]
"""A place of a curve, and where it is to be, mm; the mirror image is resolved."""


def _same_goals(one: Sequence[_Goal], other: Sequence[_Goal]) -> bool:
    return len(one) == len(other) and all(
        a == b and np.array_equal(p, q) for (a, p), (b, q) in zip(one, other, strict=True)
    )


def _goals(
    now: Mapping[str, Spline],
    before: Mapping[str, Spline],
    joints: Sequence[tuple[Joint, tuple[Meeting, ...]]],
    symmetry: Plane,
    pins: Mapping[str, Array],
) -> dict[str, list[_Goal]]:
    """Return what every curve has to reach, by its id."""
    goals: dict[str, list[_Goal]] = {}
    for joint, meetings in joints:
        if not meetings:
            continue
        inner = [meet for meet in meetings if not is_end(before, meet)]
        carrier = inner[0] if inner and joint.id not in pins else None
        if carrier is not None:
            place = meeting_place(now, carrier, symmetry)
        elif joint.id in pins:
            place = pins[joint.id]
        else:
            place = meeting_place(before, meetings[0], symmetry)
        if joint.in_plane:
            place = in_plane(place, symmetry)
        for meet in meetings:
            if meet is carrier and not joint.in_plane:
                continue
            here = mirror_image(place, symmetry) if meet.mirrored else place
            goals.setdefault(meet.curve, []).append((meet, here))
    return goals


def _brought(name: str, spline: Spline, goals: Sequence[_Goal], plane: Plane | None) -> Spline:
    """Return a curve with all its meetings where they are to be."""
    if not goals:
        return spline
    made = spline
    ends: dict[float, Array] = {}
    if not spline.closed:
        ends = {meet.at: place for meet, place in goals if meet.at in (0.0, 1.0)}
        first = ends.get(0.0, spline.control_points[0])
        last = ends.get(1.0, spline.control_points[-1])
        made = moved_to_ends(spline, first, last)
        if plane is not None and made is not spline:
            flat = in_plane(made.control_points, plane)
            flat[0], flat[-1] = first, last
            made = Spline(made.knots, flat)
    inner = [(meet.at, place) for meet, place in goals if spline.closed or 0.0 < meet.at < 1.0]
    return passing(made, inner, tuple(ends)) if inner else made


def passing(
    spline: Spline, places: Sequence[tuple[float, Array]], held: Sequence[float] = (0.0, 1.0)
) -> Spline:
    """Return a curve that passes places, with the least change of its control points.

    Ends that are not held go along with places close to them: of a short tail one end held and the
    other moved would be a corner. Places that contradict one another, so that the curve would have
    to leave them by more than `FARTHEST` times the longest way, are met half-way: what tells them
    apart is left out.

    Parameters
    ----------
    spline : Spline
        In space, mm.
    places : sequence of (float, (3,) array)
        Shares of the range, and where the curve is to be there.
    held : sequence of float
        Shares, 0 or 1, of the ends of an open curve that stay.
    """
    at = np.array([parameter_at(spline, share) for share, _ in places])
    wanted = np.array([place for _, place in places])
    way = wanted - spline.value(at)
    size = max(1e-300, float(np.ptp(spline.control_points, axis=0).max()))
    if np.abs(way).max() <= TOUCHING * size:
        return spline
    rows = spline_weights(spline, at)
    if not spline.closed:
        rows[:, [-int(share) for share in held]] = 0.0
    left, values, right = np.linalg.svd(rows, full_matrices=False)
    shares = left.T @ way
    change = np.zeros((rows.shape[1], 3))
    for spread in SPREADS:
        kept = values > spread * values[0]
        change = right[kept].T @ (shares[kept] / values[kept, None])
        if _longest(change) <= FARTHEST * _longest(way):
            break
    return with_controls(spline, free_controls(spline) + change)


def _longest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())


def _same(one: Spline, other: Spline) -> bool:
    return one is other or bool((one.control_points == other.control_points).all())
