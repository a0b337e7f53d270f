"""Free ends of curves and joints, as what may be joined."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.clusters import End
from bozzetto_product.operations.meetings import (
    meeting_place,
    splines_of,
)
from bozzetto_product.operations.plane_crossings import lies_in
from bozzetto_product.projection.spline_basis import chord_length

SHORT: Final = 0.25
"""Largest gap as a share of the length of the curve, or of its stretch up to the next joint:
details are smaller than the model, and the tail of a curve drawn too far ends where it does."""

TAIL: Final = 0.5
"""Share of a curve beyond its last joint below which that is the tail of one drawn too far."""

ASKED: Final = 3.0
"""Largest gap, in gaps that are closed, that is proposed."""


def network_ends(state: ProductState, gap: float) -> list[End]:
    """Return the free ends of all curves and the joints, in an order that names do not change."""
    splines = splines_of(state)
    curves = {curve.id: curve for curve in state.of_kind(Curve)}
    symmetric = is_symmetric(state)
    found: list[End] = []
    joined = {(meet.curve, meet.at) for joint in state.joints for meet in joint.meetings}
    for name, spline in splines.items():
        if spline.closed:
            continue
        length = chord_length(spline)
        inner = [share for curve, share in joined if curve == name]
        for at in (0.0, 1.0):
            if (name, at) in joined:
                continue
            free = min((abs(share - at) for share in inner), default=1.0) * length
            place = np.array(spline.control_points[0 if at == 0.0 else -1])
            flat = symmetric and lies_in(curves[name], state.symmetry)
            image = curves[name].mirrored
            found.append(End(place, min(gap, SHORT * free), length, image, flat, name, at))
    for joint in state.joints:
        meetings = [meet for meet in joint.meetings if meet.curve in splines]
        if meetings:
            place = meeting_place(splines, meetings[0], state.symmetry)
            lengths = [chord_length(splines[meet.curve]) for meet in meetings]
            image = all(curves[meet.curve].mirrored for meet in meetings) and not joint.in_plane
            width = min(gap, SHORT * min(lengths))
            weight = float(np.sum(lengths))
            held = tuple((meet.curve, meet.at) for meet in meetings)
            flat = joint.in_plane
            found.append(End(place, width, weight, image, flat, joint=joint.id, held=held))
    return sorted(found, key=lambda end: (*end.place.tolist(), end.weight, end.at))


def is_symmetric(state: ProductState) -> bool:
    """Whether the symmetry plane counts: without mirror images it is a plane like any other."""
    return state.mirror or any(curve.mirrored for curve in state.of_kind(Curve))


def beside_tail(state: ProductState, end: End) -> set[str]:
    """Return the curves that meet in the joint behind which a free end is the tail of a curve.

    A tail may run along one of them for a while; joined to it, it would bound a sliver.
    """
    behind = [
        (abs(meet.at - end.at), joint)
        for joint in state.joints
        for meet in joint.meetings
        if meet.curve == end.curve and 0.0 < meet.at < 1.0 and abs(meet.at - end.at) < TAIL
    ]
    if not behind:
        return set()
    _, nearest = min(behind, key=lambda one: (one[0], one[1].id))
    return {meet.curve for meet in nearest.meetings}
