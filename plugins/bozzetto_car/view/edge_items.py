"""Edges and nodes of a body as scene items: lines, creases, dots, and handles to drag."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry.patches import SMOOTH, bernstein
from bozzetto.plugin import remembered
from bozzetto.scene import Handle, Hidden, Item, Label, Layer, Lines, Paint, Points
from bozzetto.view import Camera, triple
from bozzetto_car.body.body import Body
from bozzetto_car.camera.visibility import facing
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.uncertainty import Source, certainty
from bozzetto_car.state import CarState
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import junctions
from bozzetto_car.view.surface_colors import SOURCE_COLORS

SHAPE_TOOL: Final = "shape"

NODE: Final = "node "
"""Prefix of the ids of nodes' handles; the name of the node follows."""

TANGENT: Final = "tangent "
"""Prefix of the ids of tangents' handles; the name of the edge and the number of its end follow."""

ALONG: Final = 24
"""Pieces of the polyline that shows an edge."""

EDGE_WIDTH: Final = 1.4
"""Width of the lines of edges, px."""

ON_PAPER: Final = (52, 49, 46)
"""Colour of edges over a drawing: its paper is light in the dark theme, too."""

HELD_WIDTH: Final = 2.6
"""Width of an edge that is being drawn, px."""

CREASE_COLORS: Final[dict[str, tuple[int, int, int]]] = {
    "smooth": (74, 148, 96),
    "creased": (214, 138, 30),
    "corner": (104, 118, 140),
}
"""Colours of edges with a smooth surface across them; of those that smooth lines cross, but with a
crease; and of those that are meant to be corners."""

CREASE_WIDTHS: Final = {"smooth": 1.4, "creased": 3.0, "corner": 2.0}
"""Widths of these lines, px."""

REMEMBERED: Final = 16
"""Number of solved cars whose certainty is remembered."""

LABEL_SIZE: Final = 11.0
"""Size of the letters of an angle, px."""

LABEL_ROOM: Final = (46.0, 16.0)
"""Width and height, px, of the space that such a label keeps free."""


def network_lines(
    control_points: Array,
    color: Paint,
    width: float,
    opacity: float = 1.0,
    hidden: Hidden = "faint",
) -> Lines:
    """Return cubic Bézier curves (m, 4, 3) as one item."""
    points = bernstein(np.linspace(0.0, 1.0, ALONG + 1)) @ control_points
    starts = np.arange(0, points.shape[0] * points.shape[1], points.shape[1], dtype=np.int32)
    return Lines(
        points.reshape(-1, 3).astype(np.float32), starts, color=color, width=width,
        opacity=opacity, hidden=hidden,
    )  # fmt: skip


# -- edges -----------------------------------------------------------------------------------------


def edge_items(state: CarState, body: Body, held: Collection[int] = ()) -> Iterator[Item]:
    """Yield the edges as lines; edges that are held, as by the pen that traces them, stand out."""
    points = body.network.control_points
    if state.creases:
        for kind, edges in _creases(body).items():
            if edges:
                yield network_lines(points[edges], CREASE_COLORS[kind], CREASE_WIDTHS[kind])
    elif state.network:
        color: Paint = ON_PAPER if state.shading == "draft" else "ink"
        yield network_lines(points, color, EDGE_WIDTH, 0.75)
    if held:
        yield network_lines(points[list(held)], "accent", HELD_WIDTH, hidden="show")


@remembered(
    limit=REMEMBERED,
    key=lambda state, body: (body, state.creases, state.network, state.shading == "draft"),
)
def network_layer(state: CarState, body: Body) -> Layer:
    """Return the layer of the edges; the same one as long as it looks the same."""
    return Layer("network", tuple(edge_items(state, body)))


def crease_labels(body: Body, camera: Camera) -> Iterator[Label]:
    """Yield the angles of creases that face a view, the sharpest first, without overlaps."""
    template, angles = body.template, np.nan_to_num(body.creases)
    shown = np.asarray(facing(template, body.network.positions, camera))
    toward = np.asarray(shown[template.edges].all(axis=1))
    middles = (bernstein([0.5]) @ body.network.control_points)[:, 0]
    pixels = camera.project(middles)[0]
    taken: list[Array] = []
    for edge in np.argsort(-angles).tolist():
        if angles[edge] < SMOOTH:
            return
        if not toward[edge] or not np.isfinite(pixels[edge]).all():
            continue
        if any((np.abs(pixels[edge] - other) < LABEL_ROOM).all() for other in taken):
            continue
        taken.append(pixels[edge])
        yield Label(triple(middles[edge]), f"{angles[edge]:.1f}°", size=LABEL_SIZE)


def _creases(body: Body) -> dict[str, list[int]]:
    """Return edges by how the surface crosses them; the rim counts as a corner."""
    angles = body.creases
    crossed = _crossed_smoothly(body)
    found: dict[str, list[int]] = {kind: [] for kind in CREASE_COLORS}
    for edge, angle in enumerate(angles.tolist()):
        smooth = angle < SMOOTH
        found["smooth" if smooth else "creased" if edge in crossed else "corner"].append(edge)
    return found


def _crossed_smoothly(body: Body) -> set[int]:
    """Return edges that smooth lines cross at both ends: they should have no crease."""
    template = body.template
    crossings: dict[int, set[int]] = {}
    for joint in junctions(template):
        taken = {joint.before[0], joint.after[0]}
        for edge, ends in enumerate(template.edges.tolist()):
            if joint.node in ends and edge not in taken:
                crossings.setdefault(edge, set()).add(joint.node)
    return {edge for edge, nodes in crossings.items() if len(nodes) == 2}


# -- nodes -----------------------------------------------------------------------------------------


def sources_of(body: Body) -> tuple[Source, ...]:
    """Return whether each node is seen in a sketch, mirrored, or guessed."""
    return _found(body.solved)


@remembered(limit=REMEMBERED)
def _found(solved: Solved) -> tuple[Source, ...]:
    if solved.joint is None:
        nothing: Source = "guessed"
        return (nothing,) * len(solved.template.names)
    return certainty(solved.template, solved.cost, solved.joint).sources


def node_items(state: CarState, body: Body) -> Iterator[Points]:
    """Yield the nodes as dots in the colours of how well they are known."""
    if not state.network:
        return
    sources = sources_of(body)
    for source, color in SOURCE_COLORS.items():
        chosen = [node for node, found in enumerate(sources) if found == source]
        if chosen:
            points = body.network.positions[chosen].astype(np.float32)
            yield Points(points, color=color, size=6.0)


# -- handles ---------------------------------------------------------------------------------------


def handle_layer(state: CarState, body: Body, camera: Camera | None = None) -> Layer:
    """Return the handles of nodes, in the nodes' colours, and of the revealed tangents.

    Parameters
    ----------
    state : CarState
        The car.
    body : Body
        Its body.
    camera : Camera, optional
        The view; nodes on a side that it does not see have no handle.
    """
    template = body.template
    shown = np.ones(len(template.names), bool)
    if camera is not None:
        shown = np.asarray(facing(template, body.network.positions, camera))
    return _handle_layer(body, state.revealed, tuple(np.flatnonzero(shown).tolist()))


@remembered(limit=REMEMBERED)
def _handle_layer(body: Body, revealed: str, nodes: tuple[int, ...]) -> Layer:
    """Return the layer of the handles of some nodes, and of the tangents that are revealed."""
    template, network, sources = body.template, body.network, sources_of(body)
    items: list[Item] = []
    for edge, end in revealed_ends(revealed, template):
        pair = network.control_points[edge, [3 * end, 1 + end]]
        items.append(Lines(pair.astype(np.float32), color="second", width=1.4, hidden="show"))
        name = template.edge_names[edge]
        items.append(Handle(f"{TANGENT}{name} {end}", triple(pair[1]), color="second", tip=name))
    for node in nodes:
        name = template.names[node]
        color: Paint = "accent" if name == revealed else SOURCE_COLORS[sources[node]]
        tip = template.titles.get(name, name)
        items.append(Handle(f"{NODE}{name}", triple(network.positions[node]), color=color, tip=tip))
    return Layer("handles", tuple(items), tool=SHAPE_TOOL)


def revealed_ends(revealed: str, template: Template) -> list[tuple[int, int]]:
    """Return the ends of edges (edge, 0 or 1) whose tangents a node or an edge reveals."""
    if revealed in template.node:
        node = template.node[revealed]
        found = np.argwhere(template.edges == node).tolist()
        return [(edge, end) for edge, end in found]
    if revealed in template.edge_names:
        edge = template.edge_names.index(revealed)
        return [(edge, 0), (edge, 1)]
    return []
