"""Products of networks in files, and of the curves of other models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.geometry import Shapes, Spline
from bozzetto.ink import Drawing
from bozzetto.plugin import Job
from bozzetto_product.hand_over.detail_file import with_details
from bozzetto_product.hand_over.equal_curves import equal_curves
from bozzetto_product.hand_over.flattening import flattened
from bozzetto_product.hand_over.names import loop_names, piece_names
from bozzetto_product.hand_over.network_file import FIT, Network, OfSurfaces, network_of
from bozzetto_product.hand_over.point_fit import closed_spline_through, spline_through
from bozzetto_product.hand_over.point_joints import joints_of
from bozzetto_product.hand_over.tangent_planes import with_common_tangents
from bozzetto_product.loops.boundaries import boundary_of
from bozzetto_product.loops.holes import ROUGH, with_clockwise_holes
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.model.curves import FARTHEST, Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.flat_places import plane_through
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.operations.boundaries import outlines_of_boundary
from bozzetto_product.solve.found_patches import with_patches_found
from bozzetto_product.solve.solver import loops_of_patch, net_of_state

MOST_STEPS: Final = 200_000
"""Steps of the search for a loop of given curves: far more than any sound one takes."""

SAMPLES: Final = 16
"""Points on each span of another model's curve."""


def product_of_network(
    facts: Mapping[str, Any],
    drawings: Mapping[str, Drawing] | None = None,
    job: Job | None = None,
) -> ProductState:
    """Return the product of a file with the key “network”; see `network_of`.

    `drawings` are those that its details name, by the names of their files. `job` can be cancelled
    between curves, and between the steps after these.

    Raises
    ------
    UserError
        If the network makes no sense, or named curves make no loop.
    """
    job = Job() if job is None else job
    network = network_of(facts, job)
    state = network.state
    job.checkpoint(1.0, "loops")
    if network.loops is None:
        state = with_patches_found(state, ROUGH)
    else:
        state = _with_named_loops(state, network)
    job.checkpoint(1.0, "tangents")
    state = with_common_tangents(flattened(state, network.rounding), network.tolerance)
    if network.loops is None and not _has_flat_faces(state):
        state = with_patches_found(state)
    state = _with_values(state, network.pressure, "pressure")
    state = _with_values(state, network.paint, "paint")
    return replace(with_details(state, network.details, network.scale, drawings or {}), selected="")


def _has_flat_faces(state: ProductState) -> bool:
    """Whether all surfaces with holes that nearly lie in planes do so exactly."""
    net = net_of_state(state)
    rows = [
        np.vstack([net.edges[edge].spline.control_points for edge, _ in loop])
        for patch in state.of_kind(Patch)
        if len(outlines_of_boundary(patch.boundary)) > 1
        for loop in loops_of_patch(net, patch)
    ]
    return all(plane_through(row) or not plane_through(row, ROUGH) for row in rows)


def _with_named_loops(state: ProductState, network: Network) -> ProductState:
    net = net_of_state(state)
    names = piece_names(net, state.of_kind(Curve))
    found = []
    for number, wanted in enumerate(network.loops or ()):
        loop = named_loop(net, names, wanted)
        if loop is None:
            row = " ".join(wanted)[:80]
            raise UserError(
                f"“network.loops[{number}]”: the curves {row} make no closed loop. Check that "
                "their ends meet."
            )
        found.append(loop)
    for number, loop in enumerate(orient_loops(net, found).loops, 1):
        patch = Patch(
            state.unused_id(), f"Surface {number}", boundary=boundary_of(net, loop), confirmed=True
        )
        state = state.with_node(patch)
    return state


def named_loop(net: Net, names: Sequence[str], wanted: Sequence[str]) -> Loop | None:
    """Find the loop through all of the named curves or pieces, and no others.

    Of a curve that is cut at joints it may take some pieces only. The least number of edges is
    taken; None where there is no such loop. Curves that do not hang together are the outline of the
    surface, which is the largest of them, and those of its holes.
    """
    allowed: dict[int, int] = {}
    for place, name in enumerate(dict.fromkeys(wanted)):
        for edge, own in enumerate(names):
            if own == name or own.rpartition("/")[0] == name:
                allowed.setdefault(edge, place)
    if set(allowed.values()) != set(range(len(dict.fromkeys(wanted)))):
        return None
    outlines = []
    for part in _hanging_together(net, list(allowed)):
        places = sorted({allowed[edge] for edge in part})
        known = {edge: places.index(allowed[edge]) for edge in part}
        outline = min(_closed_walks(net, known, len(places)), key=len, default=None)
        if outline is None:
            return None
        outlines.append(outline)
    return with_clockwise_holes(SampledNet.of(net), outlines)


def _hanging_together(net: Net, edges: Sequence[int]) -> list[list[int]]:
    """Return the edges that hang together by nodes, in the order given."""
    from scipy.cluster.hierarchy import DisjointSet

    sets = DisjointSet(edges)
    first: dict[int, int] = {}
    for edge in edges:
        for node in {net.edges[edge].start, net.edges[edge].end} - {-1}:
            sets.merge(edge, first.setdefault(node, edge))
    return [sorted(part, key=edges.index) for part in sets.subsets()]


def _closed_walks(net: Net, allowed: Mapping[int, int], count: int) -> Iterator[Loop]:
    """Yield closed walks without repeated nodes over allowed edges that take all curves."""
    at_node: dict[int, list[tuple[int, bool, int]]] = {}
    for edge in allowed:
        start, end = net.edges[edge].start, net.edges[edge].end
        if start == end:
            if count == 1:
                yield ((edge, True),)
            continue
        at_node.setdefault(start, []).append((edge, True, end))
        at_node.setdefault(end, []).append((edge, False, start))
    steps = 0
    for first in (edge for edge, place in allowed.items() if place == 0):
        start, end = net.edges[first].start, net.edges[first].end
        if start == end:
            continue
        stack: list[tuple[tuple[tuple[int, bool], ...], int, frozenset[int]]] = [
            (((first, True),), end, frozenset((end,)))
        ]
        while stack and steps < MOST_STEPS:
            steps += 1
            walk, node, passed = stack.pop()
            if node == start:
                if len({allowed[edge] for edge, _ in walk}) == count:
                    yield walk
                continue
            for edge, forward, there in at_node.get(node, ()):
                if there not in passed and all(edge != other for other, _ in walk):
                    stack.append(((*walk, (edge, forward)), there, passed | {there}))


def _with_values(state: ProductState, values: OfSurfaces, title: str) -> ProductState:
    """Return the state with the values that a file gives surfaces by the curves round them."""
    if not values:
        return state
    net = net_of_state(state)
    curves = state.of_kind(Curve)
    names = piece_names(net, curves)
    left = dict(values)
    nodes = list(state.nodes)
    for place, node in enumerate(nodes):
        if isinstance(node, Patch):
            for loop in loops_of_patch(net, node):
                pieces = frozenset(loop_names(loop, names))
                whole = frozenset(name.partition("/")[0] for name in pieces)
                for key in (whole, pieces):
                    if key in left:
                        node = replace(node, **left.pop(key))
            nodes[place] = node
    if left:
        row = " ".join(sorted(next(iter(left))))[:80]
        raise UserError(f"“network.{title}”: no surface has exactly the curves {row}.")
    return replace(state, nodes=tuple(nodes))


def product_of_shapes(shapes: Shapes) -> ProductState:
    """Return a product of the curves of other shapes, joined where they meet.

    Raises
    ------
    UserError
        If there is no curve, or one is too far away.
    """
    named = [(curve.name or "Curve", spline) for curve in shapes.curves
             if (spline := _spline_of(curve)) is not None]  # fmt: skip
    if not named:
        raise UserError("There are no curves in it. Choose an object with curves.")
    points = np.vstack([spline.control_points for _, spline in named])
    if not np.abs(points).max() <= FARTHEST:
        raise UserError("The curves are too far from the origin. Move or scale them first.")
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    again = equal_curves([spline for _, spline in named], FIT * size)
    named = [each for number, each in enumerate(named) if number not in again]
    curves = tuple(
        Curve(f"n{number}", name, spline=spline) for number, (name, spline) in enumerate(named, 1)
    )
    joints = joints_of([spline for _, spline in named], size)
    return with_patches_found(ProductState(nodes=curves, joints=joints))


def _spline_of(curve: ShapeCurve) -> Spline | None:
    """Return a curve as a cubic spline: exactly where it is one, else within a tolerance."""
    clamped = curve.clamped()
    if clamped.degree == 3 and clamped.weights is None and not curve.closed:
        return Spline(clamped.knots, clamped.control_points)
    spans = np.unique(clamped.knots)
    if clamped.degree == 1:
        points = np.asarray(clamped.control_points)
    else:
        shares = np.arange(SAMPLES) / SAMPLES
        at = np.append((spans[:-1, None] + np.diff(spans)[:, None] * shares).ravel(), spans[-1])
        points = clamped.value(at)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate(([True], steps > 1e-9 * size))]
    if len(points) < 2 or not size > 0.0:
        return None
    if np.linalg.norm(points[-1] - points[0]) <= 1e-9 * size and len(points) > 7:
        return closed_spline_through(points[:-1], FIT * size)
    return spline_through(points, FIT * size)
