"""The node or the edges of the body that a touch or the eraser means."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import distances_to_polyline, resample
from bozzetto.view import Camera
from bozzetto_car.body.edge_pictures import edge_pictures, project_points
from bozzetto_car.camera.visibility import facing
from bozzetto_car.template.network import Network

NEAR_NODE: Final = 16.0
"""Farthest touch, px, that means a node. Nodes go before edges, which all end in nodes."""

NEAR_EDGE: Final = 10.0
"""Farthest touch, px, that means an edge, and half the width of the eraser."""

LOOKS: Final = 48
"""Number of places of an eraser's path, and of pieces of an edge, that are compared."""

ALONG: Final = 0.5
"""Share, of the most covered edge's places under the eraser, from which another is meant, too."""


def touched(network: Network, place: ArrayLike, camera: Camera) -> str:
    """Return the name of the node or the edge that is touched; "" if there is none.

    The side that is seen goes before the side that is not.

    Parameters
    ----------
    network : Network
        The car.
    place : (2,) array_like
        The touch on the sheet, px.
    camera : Camera
        The view.
    """
    template, at = network.template, np.asarray(place, float)
    toward = np.asarray(facing(template, network.positions, camera))
    faces = np.asarray(toward[template.edges].all(axis=1))
    away = np.linalg.norm(project_points(camera, network.positions) - at, axis=1)
    paths = edge_pictures(camera, network.control_points, LOOKS)
    beside = np.array([_distances(path, at[None])[0] for path in paths])
    for nodes, edges in ((toward, faces), (~toward, ~faces)):
        found = np.flatnonzero(nodes & (away <= NEAR_NODE))
        if len(found):
            return template.names[int(found[away[found].argmin()])]
        found = np.flatnonzero(edges & (beside <= NEAR_EDGE))
        if len(found):
            return template.edge_names[int(found[beside[found].argmin()])]
    return ""


def edges_under(network: Network, path: ArrayLike, camera: Camera) -> list[int]:
    """Return the edges that an eraser's path (k, 2), px, runs along, and not only crosses."""
    places = resample(np.asarray(path, float), count=LOOKS)
    paths = edge_pictures(camera, network.control_points, LOOKS)
    near = np.array([(_distances(own, places) <= NEAR_EDGE).sum() for own in paths])
    most = int(near.max(initial=0))
    found: list[int] = np.flatnonzero((near > 0) & (near >= ALONG * most)).tolist()
    return found


def _distances(path: Array, places: Array) -> Array:
    """Return the distances of places from the part of a picture in front of the eye."""
    front = path[np.isfinite(path).all(axis=1)]
    if not len(front):
        return np.full(len(places), np.inf)
    return distances_to_polyline(places, front)
