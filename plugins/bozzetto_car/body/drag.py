"""Nodes and the handles of tangents dragged on the sheet.

What is dragged moves parallel to the image plane, so that its depth, which the view does not
show, stays. What is in the plane of symmetry stays in it: it goes to where the ray meets the
plane. From where the plane is seen edge-on, it follows as far as can be seen.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.ink.checked_points import places_on_sheet
from bozzetto.view import Camera
from bozzetto_car.array_types import Array
from bozzetto_car.body.chain_smoothing import smoothed
from bozzetto_car.body.edge_fit import UNSEEN, seen, seen_slopes
from bozzetto_car.template.network import HANDLE, Network, with_positions, with_tangents

SHORTEST_HANDLE: Final = 0.01
"""Least length of a handle, per chord of its edge: a tangent of no length has no direction."""

STEPS: Final = 12
"""Gauss–Newton steps to the place in a plane, or on a line, that is seen nearest to a pixel."""


def dragged_place(
    place: ArrayLike, pixel: ArrayLike, camera: Camera, free: ArrayLike = (True, True, True)
) -> Array:
    """Where a point goes that is dragged to a pixel.

    Parameters
    ----------
    place : (3,) array_like
        Where it is, mm, in front of the eye.
    pixel : (2,) array_like
    camera : Camera
    free : (3,) array_like of bool
        Coordinates that may change. If all, the point moves parallel to the image plane.

    Returns
    -------
    (3,) float
        Seen at the pixel; where some coordinates are fixed, as near to it as can be seen.
    """
    start, axes = np.asarray(place, float), np.asarray(free, bool)
    goal = np.asarray(pixel, float)
    if axes.all():
        slopes = seen_slopes(camera, start[None])[0]
        way = goal - seen(camera, start[None])[0]
        level = slopes @ camera.axes[:2].T  # diagonal: pixels per mm to the right and upward
        return np.asarray(start + (way / np.diag(level)) @ camera.axes[:2])
    best, far = start, float(np.linalg.norm(goal - seen(camera, start[None])[0]))
    for _ in range(STEPS):
        slopes = seen_slopes(camera, best[None])[0]
        rows, largest = np.where(axes, slopes, 0.0), np.linalg.norm(slopes, ord=2)
        left, sizes, ways = np.linalg.svd(rows, full_matrices=False)
        kept = sizes > UNSEEN * largest
        way = goal - seen(camera, best[None])[0]
        step = ((left[:, kept].T @ way) / sizes[kept]) @ ways[kept]
        tried = np.where(axes, best + step, start)
        distance = float(np.linalg.norm(goal - seen(camera, tried[None])[0]))
        if not distance < far:
            break
        best, far = tried, distance
    return best


def node_dragged(network: Network, node: int, pixel: ArrayLike, camera: Camera) -> Network:
    """A node dragged to a pixel; its mirror image follows, tangents stay as they are.

    Parameters
    ----------
    network : Network
    node : int
    pixel : (2,) array_like
    camera : Camera

    Raises
    ------
    UserError
        If the pixel is not on the sheet, or the node is behind the eye.
    """
    goal = places_on_sheet(pixel, "place")[0]
    template = network.template
    place = network.positions[node]
    _check_in_front(place, camera, f"node {template.names[node]}")
    free = np.array([True, bool(template.mirrored[node] != node), True])
    return with_positions(network, {node: dragged_place(place, goal, camera, free)})


def handle_dragged(
    network: Network, edge: int, end: int, pixel: ArrayLike, camera: Camera
) -> Network:
    """The handle of a tangent dragged to a pixel.

    The neighbour in a smooth chain follows, see `bent`. A handle on its own node keeps a rest of
    its length.

    Parameters
    ----------
    network : Network
    edge : int
    end : int
        0 for the handle at the start of the edge, 1 for that at its end.
    pixel : (2,) array_like
    camera : Camera

    Raises
    ------
    UserError
        If the pixel is not on the sheet, or the handle is behind the eye.
    """
    goal = places_on_sheet(pixel, "place")[0]
    template = network.template
    handle, sign = network.control_points[edge, 1 + end], 1.0 - 2.0 * end
    _check_in_front(handle, camera, f"handle of the edge {template.edge_names[edge]}")
    moved = dragged_place(handle, goal, camera, network.free_axes[edge, end])
    tangent = sign * (moved - network.ends[edge, end]) / HANDLE
    least = SHORTEST_HANDLE * float(np.linalg.norm(np.ptp(network.ends[edge], axis=0))) / HANDLE
    if np.linalg.norm(tangent) < least:
        old = network.tangents[edge, end]
        length = float(np.linalg.norm(old))
        tangent = old * (least / length) if length > 0.0 else old
    return bent(network, edge, end, tangent)


def bent(network: Network, edge: int, end: int, tangent: ArrayLike) -> Network:
    """An edge with another tangent (3,), mm, at its start (0) or end (1).

    Where a chain is smooth at the node, the tangent on its other side takes the direction and
    keeps its length. Mirror images follow.
    """
    changed = with_tangents(network, {(edge, end): tangent})
    node = int(network.template.edges[edge, end])
    return smoothed(changed, leading=(edge,), nodes=(node,))


def _check_in_front(place: Array, camera: Camera, what: str) -> None:
    if not np.isfinite(seen(camera, place[None])).all():
        raise UserError(f"The {what} is behind the eye. Step back until it is in view.")
