"""Tangents of curves that are to be smooth where they meet are put into common planes.

Where the tangents at a joint lie in no common plane, surfaces cannot be smooth there
(`fill.normals`). The points of a file tell a tangent to some hundredths of a degree only: what is
missing is less than the curves may be from their points.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.ink import spline_weights
from bozzetto_product.fill.normals import planes_of_ends
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.operations.meetings import splines_of, with_splines
from bozzetto_product.projection.spline_basis import free_controls, with_controls
from bozzetto_product.solve.solver import loops_of_patch, net_of_state

WIDEST: Final = float(np.sin(np.radians(5.0)))
"""Sine of the largest angle by which a tangent is turned."""

ALIKE: Final = 0.05
"""Smallest singular value of unit normals that still tells another direction: three degrees."""

FLAT: Final = 1e-8
"""Distance of a loop from a plane, as share of its size, at which it lies in it."""

SAMPLES: Final = 65
"""Places of a curve at which it is measured how far it moved."""

LEFT: Final = 0.05
"""Share of what tangents are off that may be left over."""

_Plane = tuple[float, list[Array]]
"""Parameter of a curve, and normals of planes in which its tangent is to lie there."""


def with_common_tangents(state: ProductState, tolerance: float) -> ProductState:
    """Turn the tangents of curves into the planes of the fans of smooth surfaces at their joints.

    Joints stay where they are, and so do curves that lie in a plane surface, in that plane. A curve
    that would move by more than the tolerance stays as it is.

    Parameters
    ----------
    state : ProductState
        A network with its patches.
    tolerance : float
        mm.
    """
    net = net_of_state(state)
    loops = [loop for patch in state.of_kind(Patch) for loop in loops_of_patch(net, patch)]
    loops = list(orient_loops(net, loops).loops)
    wanted: dict[str, list[_Plane]] = {}
    for (number, end), normals in planes_of_ends(net, loops).items():
        edge = net.edges[number]
        if not edge.mirrored:
            at = edge.spline.range[end]
            wanted.setdefault(edge.curve, []).append((float(at), normals))
    flat = _flat_normals(net, loops)
    splines = splines_of(state)
    places = _joined_places(state, splines)
    moved = {
        name: _turned(splines[name], planes, flat.get(name, []), places[name], tolerance)
        for name, planes in wanted.items()
    }
    return with_splines(state, moved)


def _flat_normals(net: Net, loops: Sequence[Loop]) -> dict[str, list[Array]]:
    """Return for each curve the normals of the plane loops that it bounds."""
    found: dict[str, list[Array]] = {}
    for loop in loops:
        points = np.vstack([net.edges[edge].spline.control_points for edge, _ in loop])
        points = points - points.mean(axis=0)
        normal = np.linalg.svd(points, full_matrices=False)[2][2]
        if np.abs(points @ normal).max() <= FLAT * np.linalg.norm(np.ptp(points, axis=0)):
            for name in {net.edges[edge].curve for edge, _ in loop}:
                found.setdefault(name, []).append(normal)
    return found


def _joined_places(state: ProductState, splines: dict[str, Spline]) -> dict[str, list[float]]:
    """Return the parameters at which each curve is to stay where it is."""
    places: dict[str, list[float]] = {
        name: [] if spline.closed else list(spline.range) for name, spline in splines.items()
    }
    for joint in state.joints:
        for meet in joint.meetings:
            if meet.curve in splines and (splines[meet.curve].closed or 0.0 < meet.at < 1.0):
                begin, end = splines[meet.curve].range
                places[meet.curve].append(begin + meet.at * (end - begin))
    return places


def _along_planes(step: Array, normals: Sequence[Array]) -> Array:
    """Return the part of a step, (3,), that leaves none of the planes of some normals."""
    if not normals:
        return step
    _, sizes, axes = np.linalg.svd(np.array(normals), full_matrices=False)
    held = axes[sizes > ALIKE * np.sqrt(len(normals))]
    return np.asarray(step - (held @ step) @ held)


def _turned(
    spline: Spline,
    planes: Sequence[_Plane],
    flat: Sequence[Array],
    held: Sequence[float],
    tolerance: float,
) -> Spline:
    """Return a curve with its tangents in planes; the same where it would have to move too far."""
    begin, end = spline.range
    rows: dict[float, list[Array]] = {}
    for told, row in planes:
        # Both sides of a joint inside a curve, and of the seam of a closed one, are one place.
        own = begin + (told - begin) % (end - begin) if spline.closed else told
        known = next((one for one in rows if abs(one - own) < 1e-9 * (end - begin)), own)
        rows.setdefault(known, []).extend(row)
    at = np.array(sorted(rows))
    slopes = spline.derivative(at)
    changes = np.zeros_like(slopes)
    for number, place in enumerate(at.tolist()):
        normals = np.array([*rows[place], *flat])
        rank = int((np.linalg.svd(normals)[1] > ALIKE * np.sqrt(len(normals))).sum())
        if rank > 2:
            return spline
        off = -np.linalg.pinv(normals, rcond=ALIKE) @ (normals @ slopes[number])
        if np.linalg.norm(off) > WIDEST * np.linalg.norm(slopes[number]):
            return spline
        changes[number] = _along_planes(off, flat)
    if not changes.any():
        return spline
    system = np.vstack((spline_weights(spline, held), spline_weights(spline, at, 1)))
    goal = np.vstack((np.zeros((len(held), 3)), changes))
    scale = np.linalg.norm(system, axis=1, keepdims=True)
    change, *_ = np.linalg.lstsq(system / scale, goal / scale, rcond=1e-9)
    if np.linalg.norm(system @ change - goal) > LEFT * np.linalg.norm(goal):
        return spline
    if not spline.closed:
        change[[0, -1]] = 0.0
    made = with_controls(spline, free_controls(spline) + change)
    moved = np.linalg.norm(made.sampled(SAMPLES) - spline.sampled(SAMPLES), axis=1).max()
    return made if moved <= tolerance else spline
