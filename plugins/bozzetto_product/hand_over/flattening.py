"""Loops that lie in a plane but for the rounding of a file are put into it, exactly.

A plane loop may have any shape, where patches would fold (`fill.plane_fill`); but numbers rounded
to six digits leave a plane that leans by more than exact shapes allow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.operations.meetings import is_end, meeting_place, splines_of
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.spline_basis import free_controls, with_controls
from bozzetto_product.solve.solver import loops_of_patch, net_of_state

FLAT: Final = 1e-4
"""Distance of a loop from its plane, as share of its size, below which it is meant to lie in it: a
surface that bends so little turns by a twentieth of a degree."""

COARSE: Final = 1e-3
"""The same at most, where the numbers of a file are rounded to a coarser step."""

ROUNDED: Final = 3.0
"""Distance from its plane, in steps of the rounding, of a curve fitted to rounded points."""

EXACT: Final = 1e-10
"""Distance, as share of the size of the network, at which all planes are kept."""

ALIKE: Final = float(np.cos(np.radians(3.0)))
"""Cosine of the angle between planes of loops with a common curve from which on they are one."""

BLUNT: Final = 0.03
"""Smallest singular value of unit normals that still tells another direction: two degrees."""

ROUNDS: Final = 60
"""Most rounds from planes to places and back: where three planes meet one is enough."""


@dataclass
class _Plane:
    """A plane, the curves in it, and the numbers of the places in it."""

    curves: frozenset[str]
    normal: Array
    offset: float = 0.0
    places: Sequence[int] = ()

    def off(self, places: Array) -> float:
        """Return the greatest distance of its places from it, mm."""
        return float(np.abs(places[list(self.places)] @ self.normal - self.offset).max())


def flattened(state: ProductState, rounding: float) -> ProductState:
    """Put the loops of patches that nearly lie in planes into these.

    Joints go to where the planes of their curves meet; curves go along. Loops that are not plane
    are left alone.

    Parameters
    ----------
    state : ProductState
        A network with its patches.
    rounding : float
        Step of the coordinates of the file, mm; 0 where they are exact.
    """
    net = net_of_state(state)
    loops = [loop for patch in state.of_kind(Patch) for loop in loops_of_patch(net, patch)]
    splines = splines_of(state)
    planes = _planes(net, loops, splines, rounding)
    size = _size(np.vstack([spline.control_points for spline in splines.values()]))
    while planes:
        places, first = _places(state, splines, planes)
        if _settled(places, planes, EXACT * size):
            return _with_places(state, splines, places, first)
        planes.remove(max(planes, key=lambda plane: plane.off(places)))
    return state


def _planes(
    net: Net, loops: Sequence[Loop], splines: Mapping[str, Spline], rounding: float
) -> list[_Plane]:
    """Return the planes of loops; loops beside one another in one plane have it together."""
    found: list[tuple[_Plane, float]] = []
    for loop in loops:
        curves = frozenset(net.edges[edge].curve for edge, _ in loop)
        allowed = _allowed(curves, splines, rounding)
        normal = _normal(curves, splines, allowed)
        if normal is None:
            continue
        beside = [
            number
            for number, (plane, _) in enumerate(found)
            if plane.curves & curves and abs(float(plane.normal @ normal)) > ALIKE
        ]
        joined = curves.union(*(found[number][0].curves for number in beside))
        reach = min([allowed, *(found[number][1] for number in beside)])
        common = _normal(joined, splines, reach) if beside else normal
        if common is None:  # nearly one plane, and not quite: a surface that bends
            continue
        found = [one for number, one in enumerate(found) if number not in beside]
        found.append((_Plane(joined, common), reach))
    return [plane for plane, _ in found]


def _allowed(curves: frozenset[str], splines: Mapping[str, Spline], rounding: float) -> float:
    size = _size(_points(curves, splines))
    return max(FLAT * size, min(ROUNDED * rounding, COARSE * size))


def _normal(curves: frozenset[str], splines: Mapping[str, Spline], allowed: float) -> Array | None:
    """Return the normal of the plane of curves; None where they leave it, or are a line."""
    points = _points(curves, splines)
    points = points - points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points, full_matrices=False)
    if np.abs(points @ axes[2]).max() > allowed or not spread[1] > BLUNT * spread[0]:
        return None
    return np.asarray(axes[2])


def _points(curves: frozenset[str], splines: Mapping[str, Spline]) -> Array:
    return np.vstack([splines[name].control_points for name in sorted(curves)])


def _size(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _places(
    state: ProductState, splines: Mapping[str, Spline], planes: Sequence[_Plane]
) -> tuple[Array, dict[str, int]]:
    """Return all joints and the control points of curves in planes, and where each curve begins.

    Planes are told which of them they have.
    """
    joints = [meeting_place(splines, joint.meetings[0], state.symmetry) for joint in state.joints]
    rows, first, count = [np.reshape(joints, (-1, 3))], {}, len(joints)
    for name in sorted(frozenset[str]().union(*(plane.curves for plane in planes))):
        rows.append(free_controls(splines[name]))
        first[name] = count
        count += len(rows[-1])
    for plane in planes:
        held = [
            number
            for number, joint in enumerate(state.joints)
            if any(meet.curve in plane.curves for meet in joint.meetings)
        ]
        for name in sorted(plane.curves):
            held.extend(range(first[name], first[name] + len(free_controls(splines[name]))))
        plane.places = held
    return np.vstack(rows), first


def _settled(places: Array, planes: Sequence[_Plane], exact: float) -> bool:
    """Move places and planes to one another; return whether all places lie in their planes."""
    held: dict[int, list[int]] = {}
    for number, plane in enumerate(planes):
        for place in plane.places:
            held.setdefault(place, []).append(number)
    groups: dict[tuple[int, ...], list[int]] = {}
    for place, numbers in held.items():
        groups.setdefault(tuple(numbers), []).append(place)
    for _ in range(ROUNDS):
        for plane in planes:
            points = places[list(plane.places)]
            middle = points.mean(axis=0)
            plane.normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
            plane.offset = float(plane.normal @ middle)
        for key, members in groups.items():
            normals = np.array([planes[number].normal for number in key])
            offsets = np.array([planes[number].offset for number in key])
            off = places[members] @ normals.T - offsets
            places[members] -= off @ np.linalg.pinv(normals, rcond=BLUNT).T
        if all(plane.off(places) <= exact for plane in planes):
            return True
    return False


def _with_places(
    state: ProductState, splines: Mapping[str, Spline], places: Array, first: Mapping[str, int]
) -> ProductState:
    """Return the network with its joints and the curves in planes where they are to be."""
    controls = {
        name: places[start : start + len(free_controls(splines[name]))].copy()
        for name, start in first.items()
    }
    pins = {}
    for joint, place in zip(state.joints, places, strict=False):
        pins[joint.id] = place
        for meet in joint.meetings:
            if meet.curve in controls and is_end(splines, meet):
                controls[meet.curve][0 if meet.at == 0.0 else -1] = place
    moved = {name: with_controls(splines[name], rows) for name, rows in controls.items()}
    return settled_state(state, moved, pins)
