"""How lines join, as scene items: bars where they run on, corners where they do not.

They are there while lines are joined; see `JoinLines`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import remembered
from bozzetto.scene import Item, Label, Layer, Lines
from bozzetto.view import triple
from bozzetto_car.body.body import Body
from bozzetto_car.body.chain_smoothing import own_edges, smooth_parts
from bozzetto_car.state import CarState
from bozzetto_car.template.line_joints import Line, is_smooth, lines_at
from bozzetto_car.template.model import MIRROR
from bozzetto_car.view.edge_items import network_lines

JOIN_TOOL: Final = "join"

LEG: Final = 0.14
"""Length of half a bar, per handle of the edge."""

WIDTH: Final = 4.0
"""Width of bars and corners, px."""

LINE_WIDTH: Final = 3.0
"""Width of lines that are kept even in curvature, px."""

REMEMBERED: Final = 16
"""Number of layers that are remembered."""


def joint_layer(state: CarState, body: Body) -> Layer:
    """Return the layer that shows where lines are sharp and smooth, and which bend evenly."""
    return _layer(body, state.flowing)


@remembered(limit=REMEMBERED)
def _layer(body: Body, flowing: tuple[str, ...]) -> Layer:
    return Layer("joints", tuple(_items(body, flowing)), tool=JOIN_TOOL)


def _items(body: Body, flowing: tuple[str, ...]) -> Iterator[Item]:
    template = body.template
    shown: dict[bool, list[Array]] = {True: [], False: []}
    right = {*template.centre.tolist(), *template.pairs[:, 0].tolist()}
    for node in sorted(right):
        for line in lines_at(template, node):
            shown[is_smooth(template, line)].append(_legs(body, line))
    for smooth, color in ((True, "accent"), (False, "warning")):
        if shown[smooth]:
            rows = np.stack(shown[smooth])
            points = np.concatenate((rows, rows * MIRROR)).astype(np.float32)
            starts = np.arange(0, points.shape[0] * 3, 3, dtype=np.int32)
            yield Lines(points.reshape(-1, 3), starts, color=color, width=WIDTH)
    for chain, first, last in smooth_parts(template):
        own = own_edges(template, chain.edges[first:last])
        names = {template.edge_names[edge] for edge in own}
        if names.intersection(flowing):
            edges = sorted(own)
            curves = body.network.control_points[edges]
            both = np.concatenate((curves, curves * MIRROR))
            yield network_lines(both, "second", LINE_WIDTH, hidden="show")
            middle = curves[len(curves) // 2]
            at = (middle[0] + 3.0 * middle[1] + 3.0 * middle[2] + middle[3]) / 8.0
            yield Label(triple(at), "G2", color="second")


def _legs(body: Body, line: Line) -> Array:
    """Return a mark along a line at its node: from one side over the node to the other, (3, 3)."""
    template, points = body.template, body.network.control_points
    before, node, after = line
    places = [body.network.positions[node]]
    for other in (before, after):
        edge = template.edge_between[node, other]
        leg = points[edge, 1] - points[edge, 0] if edge >= 0 else (
            points[~edge, 2] - points[~edge, 3]
        )  # fmt: skip
        places.append(places[0] + LEG * 3.0 * leg)
    return np.stack((places[1], places[0], places[2]))
