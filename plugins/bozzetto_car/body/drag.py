"""Drag nodes and the handles of tangents on the sheet.

What is dragged moves parallel to the image plane, so that its depth, which the view does not
show, stays. A point in the plane of symmetry stays in that plane and goes to where the ray of the
pixel meets it. Where the plane is seen edge-on, the point follows as far as the view shows.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.ink import places_on_sheet
from bozzetto.view import Camera
from bozzetto_car.body.chain_smoothing import smooth_chains
from bozzetto_car.body.edge_pictures import UNSEEN, project_points
from bozzetto_car.camera.rational_projection import (
    camera_matrix,
    largest_scale,
    places_of,
    slopes_at,
)
from bozzetto_car.template.network import HANDLE, Network, with_positions, with_tangents

SHORTEST_HANDLE: Final = 0.01
"""Least length of a handle, per chord of its edge: a tangent of no length has no direction."""

STEPS: Final = 12
"""Gauss–Newton steps to the place in a plane, or on a line, that is seen nearest to the pixel."""


def drag_place(
    place: ArrayLike, pixel: ArrayLike, camera: Camera, free: ArrayLike = (True, True, True)
) -> Array:
    """Return where a point (3,) goes that is dragged to a pixel (2,); see `drag_places`."""
    one, goal, axes = np.asarray(place, float), np.asarray(pixel, float), np.asarray(free, bool)
    return np.asarray(drag_places(one[None], goal[None], camera, axes[None])[0])


def drag_places(places: ArrayLike, pixels: ArrayLike, camera: Camera, free: ArrayLike) -> Array:
    """Return where points go that are dragged to pixels.

    Parameters
    ----------
    places : (n, 3) array_like
        Places of the points, mm, in front of the eye.
    pixels : (n, 2) array_like
        Their goals on the sheet, px.
    camera : Camera
        The view.
    free : (n, 3) array_like of bool
        Coordinates that may change. If all, a point moves parallel to the image plane.

    Returns
    -------
    (n, 3) float
        Places seen at the pixels, or as near to them as the fixed coordinates allow, mm.
    """
    starts, goals = np.asarray(places, float), np.asarray(pixels, float)
    axes, matrix = np.asarray(free, bool), camera_matrix(camera)
    made = starts.copy()
    whole = axes.all(axis=1)
    if whole.any():
        start = starts[whole]
        way = goals[whole] - places_of(start @ matrix[:, :3].T + matrix[:, 3])
        slopes = slopes_at(matrix, start)
        right, up = camera.axes[:2]  # px/mm of a step to the right, and of one upward
        along = way / np.stack((slopes[:, 0] @ right, slopes[:, 1] @ up), axis=1)
        made[whole] = start + along @ camera.axes[:2]
    if not whole.all():
        made[~whole] = _within_axes(starts[~whole], goals[~whole], matrix, axes[~whole])
    return made


def _within_axes(starts: Array, goals: Array, matrix: Array, axes: Flags) -> Array:
    """Return places (n, 3) that differ from others in some axes, seen as near to goals as can be.

    Each search ends by itself, when a step brings it no nearer.
    """
    best = starts.copy()
    way = goals - places_of(best @ matrix[:, :3].T + matrix[:, 3])
    far = np.hypot(way[:, 0], way[:, 1])
    going = np.arange(len(best))
    for _ in range(STEPS):
        slopes, allowed = slopes_at(matrix, best[going]), axes[going]
        left, sizes, ways = np.linalg.svd(
            np.where(allowed[:, None], slopes, 0.0), full_matrices=False
        )
        seen = sizes > UNSEEN * largest_scale(slopes)[:, None]
        along = (way[going, None] @ left)[:, 0]
        along = np.divide(along, sizes, out=np.zeros_like(along), where=seen)
        tried = np.where(allowed, best[going] + (along[:, None] @ ways)[:, 0], starts[going])
        missed = goals[going] - places_of(tried @ matrix[:, :3].T + matrix[:, 3])
        distance = np.hypot(missed[:, 0], missed[:, 1])
        nearer = distance < far[going]
        going = going[nearer]
        if not len(going):
            break
        best[going], way[going], far[going] = tried[nearer], missed[nearer], distance[nearer]
    return best


def drag_node(network: Network, node: int, pixel: ArrayLike, camera: Camera) -> Network:
    """Drag a node to a pixel; its mirror image follows, tangents stay as they are.

    Parameters
    ----------
    network : Network
        The network to change.
    node : int
        Index of the node.
    pixel : (2,) array_like
        The goal on the sheet, px.
    camera : Camera
        The view.

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
    return with_positions(network, {node: drag_place(place, goal, camera, free)})


def drag_handle(network: Network, edge: int, end: int, pixel: ArrayLike, camera: Camera) -> Network:
    """Drag the handle of a tangent to a pixel.

    The neighbour in a smooth chain follows; see `bend_edge`. A handle that is dragged onto its own
    node keeps a small part of its length.

    Parameters
    ----------
    network : Network
        The network to change.
    edge : int
        Index of the edge.
    end : int
        0 for the handle at the start of the edge, 1 for that at its end.
    pixel : (2,) array_like
        The goal on the sheet, px.
    camera : Camera
        The view.

    Raises
    ------
    UserError
        If the pixel is not on the sheet, or the handle is behind the eye.
    """
    goal = places_on_sheet(pixel, "place")[0]
    template = network.template
    handle, sign = network.control_points[edge, 1 + end], 1.0 - 2.0 * end
    _check_in_front(handle, camera, f"handle of the edge {template.edge_names[edge]}")
    moved = drag_place(handle, goal, camera, network.free_axes[edge, end])
    tangent = sign * (moved - network.ends[edge, end]) / HANDLE
    least = SHORTEST_HANDLE * float(np.linalg.norm(np.ptp(network.ends[edge], axis=0))) / HANDLE
    if np.linalg.norm(tangent) < least:
        old = network.tangents[edge, end]
        length = float(np.linalg.norm(old))
        tangent = old * (least / length) if length > 0.0 else old
    return bend_edge(network, edge, end, tangent)


def bend_edge(network: Network, edge: int, end: int, tangent: ArrayLike) -> Network:
    """Give an edge another tangent (3,), mm, at its start (0) or end (1).

    Where a chain is smooth at the node, the tangent on its other side takes the same
    direction and keeps its length. Mirror images follow.
    """
    changed = with_tangents(network, {(edge, end): tangent})
    node = int(network.template.edges[edge, end])
    return smooth_chains(changed, leading=(edge,), nodes=(node,))


def _check_in_front(place: Array, camera: Camera, what: str) -> None:
    if not np.isfinite(project_points(camera, place[None])).all():
        raise UserError(f"The {what} is behind the eye. Step back until it is in view.")
