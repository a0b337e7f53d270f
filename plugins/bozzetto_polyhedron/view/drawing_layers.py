"""The drawing on the sheet: ink, lines, corners, and findings where the lines look wrong."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.scene import Hidden, Item, Label, Lines, Points
from bozzetto_polyhedron.graph.line_graph import Finding, LineGraph
from bozzetto_polyhedron.model.same_view import camera_of, on_sheet
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.rounds.ellipses import TURN
from bozzetto_polyhedron.rounds.rims import tangent_lines
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solve.pipeline import Solved
from bozzetto_polyhedron.solve.round_lines import is_column
from bozzetto_polyhedron.solve.spots import places_of_findings

LINE_WIDTH, LIGHT_WIDTH = 1.6, 0.9
"""Widths of lines as they were understood, px: drawn firmly, and drawn lightly as hidden ones."""

INK_OPACITY: Final = 0.45
"""Of ink under the lines that it was understood as."""

UNDER_OPACITY: Final = 0.25
"""Of ink on the edges of a solid: the edges are what counts then."""

ROUND_SAMPLES: Final = 73
"""Points of an ellipse that is shown."""

CORNER_SIZE, FINDING_SIZE = 6.0, 13.0
"""Diameters of corners and of findings, px."""

MARKED: Final = 0.5
"""Likelihood from which on a line counts as drawn lightly."""

MOST_FINDINGS: Final = 12
"""Findings that get words: a scribble has hundreds, and nobody reads those."""

WORDS: Final = {
    "loose end": "loose end",
    "corner of two lines": "only two lines",
    "crossing": "crossing",
    "tick": "stray mark",
    "close corners": "two corners",
    "gap": "gap",
    "second reading": "or otherwise",
    "open faces": "does not close",
}
"""What stands beside a finding; its sentence is the next step."""


def ink_items(body: Body) -> list[Item]:
    """Return the ink as it was drawn."""
    return [_ink(on_sheet(body, stroke.points)) for stroke in body.strokes if len(stroke.x) > 1]


def line_items(body: Body, graph: LineGraph) -> list[Item]:
    """Return lines and corners as they were understood."""
    if not len(graph.lines):
        return []
    if is_column(body):
        return _round_items(body)
    places = on_sheet(body, graph.places)
    light = (graph.light >= MARKED) | np.array([not own for own in graph.strokes])
    items = [
        segments(places[lines], "ink", width)
        for lines, width in (
            (graph.lines[~light], LINE_WIDTH),
            (graph.lines[light], LIGHT_WIDTH),
        )
        if len(lines)
    ]
    return [
        *items,
        *_round_items(body),
        Points(places.astype(np.float32), color="accent", size=CORNER_SIZE, hidden="show"),
    ]


def _round_items(body: Body) -> list[Item]:
    """Return the ellipses and arcs that were understood as round, and the sides of cylinders."""
    reading = straightened(body.strokes, body.evidence).reading
    if reading is None:
        return []
    turn = np.linspace(0.0, TURN, ROUND_SAMPLES)
    curves = [(rim.ellipse.at(turn), rim.light) for rim in reading.rims]
    for barrel in reading.barrels:
        near, far = (reading.rims[number] for number in (barrel.near, barrel.far))
        sides = tangent_lines(near.ellipse, far.ellipse.center - near.ellipse.center)
        curves += [(side, not barrel.outside) for side in sides if barrel.tangents]
    curves += [
        each
        for bend in reading.bends
        for each in zip((bend.arc, bend.arc + bend.shift), bend.light, strict=True)
    ]
    return [
        Lines(
            on_sheet(body, curve).astype(np.float32),
            color="ink",
            width=LIGHT_WIDTH if light else LINE_WIDTH,
            hidden="show",
        )
        for curve, light in curves
    ]


def finding_items(body: Body, found: Solved) -> list[Item]:
    """Return marks where lines look wrong, each with a word or two; see `places_of_findings`."""
    shown = found.graph.health[:MOST_FINDINGS]
    if not shown:
        return []
    places = places_of_findings(body, found, shown)
    marks = Points(
        places.astype(np.float32), color="warning", size=FINDING_SIZE, opacity=0.8, hidden="show"
    )
    return [marks, *(_word(place, finding) for place, finding in zip(places, shown, strict=True))]


def ink_on_edges(body: Body, graph: LineGraph, answer: Answer) -> list[Item]:
    """Return the ink of every line laid over its edge in space, in the model's frame.

    It lies in the plane through the edge that faces the eye most: seen as it was drawn, it is
    where it was drawn, wobbles and all.
    """
    camera = camera_of(body)
    items: list[Item] = []
    for (first, second), numbers in zip(graph.lines, graph.strokes, strict=True):
        begin, end = answer.vertices[first], answer.vertices[second]
        normal = _facing(end - begin, camera.axes[2])
        if normal is None:
            continue
        for number in numbers:
            points = camera.on_plane(body.strokes[number].points, begin, normal)
            if len(points) > 1 and np.isfinite(points).all():
                items.append(_ink(body.placement.points(points), "hide", UNDER_OPACITY))
    return items


def segments(ends: Array, color: str, width: float, hidden: Hidden = "show") -> Lines:
    """Return straight pieces (k, 2, 3) as one item."""
    return Lines(
        ends.reshape(-1, 3).astype(np.float32),
        starts=np.arange(0, 2 * len(ends), 2, dtype=np.int32),
        color=color,
        width=width,
        hidden=hidden,
    )


def _ink(points: Array, hidden: Hidden = "show", opacity: float = INK_OPACITY) -> Lines:
    return Lines(
        points.astype(np.float32), color="ghost", width=1.2, opacity=opacity, hidden=hidden
    )


def _word(place: Array, finding: Finding) -> Label:
    x, y, z = (float(value) for value in place)
    return Label((x, y, z), WORDS.get(finding.what, finding.what), color="warning")


def _facing(along: Array, forward: Array) -> Array | None:
    """Return the normal of the plane along a direction that faces the eye most."""
    length = float(np.linalg.norm(along))
    if length == 0.0:
        return None
    unit = along / length
    normal = forward - (forward @ unit) * unit
    steep = float(np.linalg.norm(normal))
    return None if steep < 1e-6 else np.asarray(normal / steep)
