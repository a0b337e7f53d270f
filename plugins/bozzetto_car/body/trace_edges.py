"""Trace edges: bend them to a stroke along the picture of the car, from any side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry.patches import bernstein
from bozzetto.ink import FARTHEST, arc_length, distances_to_polyline
from bozzetto.plugin import cached_property
from bozzetto.view import Camera
from bozzetto_car.body.chain_smoothing import smooth_chains
from bozzetto_car.body.drag import drag_place
from bozzetto_car.body.edge_fit import (
    UNSEEN,
    Sighting,
    fit_edge,
    paper_cubic,
    project_points,
)
from bozzetto_car.body.edge_runs import Run, find_run
from bozzetto_car.camera.rational_projection import (
    Pictured,
    camera_matrix,
    largest_scale,
    slopes_at,
)
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import (
    Network,
    as_hermite,
    junctions,
    with_positions,
    with_tangents,
)

Directions = tuple[Array, Array]

NEAR_END: Final = 0.25
"""Distance of the end of a stroke from a node, per length of the edge in the view, within which the
stroke is taken to end in the node."""

PIECES: Final = 20
"""Pieces of an edge for the decision whether it is seen."""

IN_PIECES: Final = bernstein(np.linspace(0.0, 1.0, PIECES + 1))

PLACES: Final = 100
"""Pieces of an edge where lengths and distances on the sheet are measured."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A network after a stroke.

    Attributes
    ----------
    network : Network
    run : Run
        The edges that the stroke was taken to trace.
    camera : Camera
    """

    network: Network
    run: Run
    camera: Camera

    @cached_property
    def deviations(self) -> tuple[float, ...]:
        """The largest distance on the sheet of each edge from its part of the stroke, px.

        It is measured on the stretch of the edge that the stroke runs beside.
        """
        return _deviations(self.network, self.run, self.camera)


def trace(
    network: Network,
    stroke: ArrayLike,
    camera: Camera,
    *,
    edges: Sequence[int] = (),
    nodes_follow: bool = False,
) -> Traced:
    """Bend the edges that a stroke runs along until they are seen where it is.

    Neighbours in smooth chains take the new directions and keep the lengths of their tangents.
    The other side of the car follows. A stroke that crosses the middle shows the same edge from
    two sides, which also gives its depth.

    Parameters
    ----------
    network : Network
        The network to change.
    stroke : (k, 2) array_like
        Samples of the stroke, px, in either direction.
    camera : Camera
        The view that the stroke was drawn in.
    edges : sequence of int, optional
        The edges that are meant, in the order of the row that they make; by default the
        nearest ones.
    nodes_follow : bool
        Nodes that the stroke passes, or reaches with an end, go to it, parallel to the image
        plane. Otherwise no node moves.

    Raises
    ------
    UserError
        If the stroke runs along no edge, or along nothing but edges that are seen end-on.
    """
    run = find_run(network, stroke, camera, edges, directed=nodes_follow)
    shown = [edge for edge in run.edges if _is_seen(network, max(edge, ~edge), camera)]
    if not shown:
        names = ", ".join(network.template.edge_names[max(edge, ~edge)] for edge in run.edges)
        raise UserError(
            f"The stroke runs along {names}, seen end-on from here: it cannot tell the shape. "
            "Turn the view and trace it again."
        )
    if nodes_follow:
        network = _with_nodes_on_stroke(network, run, camera)
    own = {_own(network, edge) for edge in shown}
    free = {edge: _free_directions(network, edge) for edge in own}
    bent = smooth_chains(_bent(network, run, camera, free), leading=own, nodes=run.nodes)
    # Where two traced edges meet smoothly, both have changed their direction. The common one is
    # kept now, and everything else is fitted again.
    held = _held_directions(bent, own)
    if held:
        bent = _bent(bent, run, camera, {edge: held.get(edge, free[edge]) for edge in own})
        bent = smooth_chains(bent, leading=own, nodes=run.nodes)  # rounding, no more
    return Traced(bent, run, camera)


def _own(network: Network, signed: int) -> int:
    """Return the index of an edge or of its mirror image, whichever comes first."""
    edge = max(signed, ~signed)
    image = int(network.template.mirrored_edges[edge])
    return min(edge, max(image, ~image))


def _is_seen(network: Network, edge: int, camera: Camera) -> bool:
    """Whether an edge is long enough in the view for its picture to tell its shape."""
    matrix, points = camera_matrix(camera), network.control_points[edge]
    curve = IN_PIECES @ points
    scale = float(largest_scale(slopes_at(matrix, curve[PIECES // 2])))
    length = float(arc_length(Pictured.of(matrix, points).laid_out(PIECES))[-1])
    return length >= UNSEEN * scale * float(arc_length(curve)[-1])


def _with_nodes_on_stroke(network: Network, run: Run, camera: Camera) -> Network:
    """Move the nodes of a run to the places of the stroke that belong to them."""
    pixels = [run.parts[0][0], *(part[-1] for part in run.parts)]
    old = project_points(camera, network.positions[list(run.nodes)])
    image = network.template.mirrored
    lengths = [float(arc_length(_path(network, edge, camera))[-1]) for edge in run.edges]
    goals: dict[int, list[Array]] = {}
    for number, (node, pixel) in enumerate(zip(run.nodes, pixels, strict=True)):
        beside = lengths[max(number - 1, 0) : number + 1]
        if np.linalg.norm(pixel - old[number]) > NEAR_END * min(beside):
            continue
        free = np.array([True, bool(image[node] != node), True])
        place = drag_place(network.positions[node], pixel, camera, free)
        right = min(node, int(image[node]), key=lambda k: -float(network.positions[k, 1]))
        goals.setdefault(right, []).append(place if right == node else place * MIRROR)
    return with_positions(
        network, {node: np.mean(places, axis=0) for node, places in goals.items()}
    )


def _free_directions(network: Network, edge: int) -> Directions:
    """Return the directions, as columns, in which the two handles of an edge may move."""
    first, last = (np.eye(3)[:, axes] for axes in network.free_axes[edge])
    return first, last


def _held_directions(network: Network, edges: set[int]) -> dict[int, Directions]:
    """Return the free directions of edges at a junction of two of them: there only the tangent."""
    held: dict[int, Directions] = {}
    for joint in junctions(network.template):
        places = (joint.before, joint.after)
        if joint.crosses or not all(edge in edges for edge, _ in places):
            continue
        for edge, end in places:
            tangent = network.tangents[edge, end]
            length = float(np.linalg.norm(tangent))
            ways = list(held.get(edge, _free_directions(network, edge)))
            ways[end] = tangent[:, None] / length if length > 0.0 else np.zeros((3, 0))
            held[edge] = ways[0], ways[1]
    return held


def _bent(
    network: Network, run: Run, camera: Camera, directions: Mapping[int, Directions]
) -> Network:
    """Fit each edge in `directions` to its parts of the stroke."""
    changed = {}
    for edge, ways in directions.items():
        old = network.control_points[edge]
        sightings, start = [], None
        for signed, part in zip(run.edges, run.parts, strict=True):
            if _own(network, signed) != edge:
                continue
            flip = np.ones(3) if max(signed, ~signed) == edge else MIRROR
            sightings.append(Sighting(part, camera, flip))
            start = _paper_start(old, sightings[-1])
        points = fit_edge(old, sightings, ways, start)
        for end, tangent in enumerate(as_hermite(points)[1]):
            if not np.array_equal(points[1 + end], old[1 + end]):
                changed[edge, end] = tangent
    return with_tangents(network, changed)


def _paper_start(old: Array, sighting: Sighting) -> Array | None:
    """Return the paper's cubic if the stroke goes all the way from one node to the other."""
    own, stroke = old * sighting.flip, sighting.points
    ends = project_points(sighting.camera, own[[0, 3]])
    if np.linalg.norm(stroke[[0, -1]] - ends) > np.linalg.norm(stroke[[-1, 0]] - ends):
        stroke = stroke[::-1]
    away = np.linalg.norm(stroke[[0, -1]] - ends, axis=1)
    if away.max() > NEAR_END * arc_length(stroke)[-1]:
        return None
    return paper_cubic(own, stroke, sighting.camera) * sighting.flip


def _path(network: Network, signed: int, camera: Camera) -> Array:
    """Return the picture of an edge in the direction of the run, (k, 2) px.

    Both nodes are in view; what lies between them behind the eye is left out.
    """
    points = network.control_points[max(signed, ~signed)]
    pictured = Pictured.of(camera_matrix(camera), points if signed >= 0 else points[::-1])
    pixels = pictured.laid_out(PLACES)
    return np.asarray(pixels[(np.abs(pixels) <= FARTHEST).all(axis=1)])


def _deviations(network: Network, run: Run, camera: Camera) -> tuple[float, ...]:
    found = []
    for signed, part in zip(run.edges, run.parts, strict=True):
        path = _path(network, signed, camera)
        first, last = (
            int(np.argmin(np.linalg.norm(path - end, axis=1))) for end in (part[0], part[-1])
        )
        beside = path[min(first, last) : max(first, last) + 1]
        there = distances_to_polyline(beside, part).max()
        inside = distances_to_polyline(part, path)
        back = inside[_beside(part, path)].max(initial=0.0)
        found.append(float(max(there, back)))
    return tuple(found)


def _beside(part: Array, path: Array) -> Flags:
    """Whether samples are nearer to the inside of a polyline than to either of its ends, (k,)."""
    away = np.linalg.norm(part[:, None] - path, axis=2).argmin(axis=1)
    return np.asarray((away > 0) & (away < len(path) - 1))
