"""The content of the guide panel as plain values, so that widgets compute nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.geometry.patches import bernstein
from bozzetto.plugin import remembered
from bozzetto.view import Camera, triple
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.camera.visibility import facing
from bozzetto_car.marking.next_mark import (
    asked_of,
    in_work,
    neighbour_of,
    next_mark_in_words,
    node_title,
    shown_nodes,
)
from bozzetto_car.solver.initial_cameras import Placed
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.uncertainty import further_views
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.template.model import Template, ViewHint
from bozzetto_car.template.shape_constraints import soundness_names

Status = Literal["asked", "set", "wrong", "skipped", "open", "hidden"]

CHART_POSE: Final = ViewHint(69.0, 20.0)
"""Direction of the view in the chart of all nodes, where it shows them apart."""

CHART_TURNS: Final = [
    ViewHint(CHART_POSE.azimuth + turn, CHART_POSE.elevation + rise)
    for turn, rise in sorted(
        ((turn, rise) for turn in range(-24, 13, 3) for rise in range(-8, 17, 2)),
        key=lambda aside: aside[0] ** 2 + aside[1] ** 2,
    )
]
"""Directions for the chart, the usual one first."""

APART: Final = 0.02
"""Least distance of two nodes in the chart, per width of the chart: 5 px in a narrow panel."""

CHART_SIZE: Final = (1000.0, 1000.0)
"""Canvas of the chart's camera, px; only its shape counts."""

PIECES: Final = 10
"""Pieces of an edge in the chart."""


@dataclass(frozen=True)
class NodeRow:
    """A node in the sketch in work.

    Attributes
    ----------
    node, title : str
    status : {"asked", "set", "wrong", "skipped", "open", "hidden"}
        ``wrong``: its mark was set aside; ``skipped``: noted as not visible; ``hidden``: still
        open, and on a side that the sketch does not show.
    off : float or None
        Distance of its mark from its node on the car, or, of a wrong mark, from where the other
        marks expect it, px.
    """

    node: str
    title: str
    status: Status
    off: float | None = None


@dataclass(frozen=True)
class SketchRow:
    """A sketch, with its camera, marks and residual in a few words."""

    id: str
    name: str
    summary: str
    in_work: bool
    wrong: bool = False


@dataclass(frozen=True)
class Rule:
    """A soundness constraint: its name, whether it is on, and whether the car breaks it."""

    name: str
    is_on: bool
    is_broken: bool = False


@dataclass(frozen=True, eq=False)
class Chart:
    """The template as a drawing to click on; places in a box 1 wide, y down.

    Attributes
    ----------
    places : (n, 2) float
        Places of the nodes.
    edges : (m, k, 2) float
    front : (m,) bool
        Edges on the side that is seen.
    height : float
        Height of the box, per width.
    """

    places: Array
    edges: Array
    front: Flags
    height: float


@dataclass(frozen=True, eq=False)
class Guide:
    """The content of the panel.

    Attributes
    ----------
    template : Template
    near : {"L", "R"}
        The side that the sketch in work shows.
    asked, title : str
        The node that is asked for and its name; "" for none.
    words : str
        What to do on the sketch in work, whatever tool is in use; "" without a sketch.
    before, after : str
        The nodes that *Back* and *Skip* lead to; "" for none.
    count : int
        Number of nodes that are marked.
    rows : tuple of NodeRow
        All nodes, in the order in which they are asked for.
    sketches : tuple of SketchRow
    advice : str
        Which further sketch would help most; "" while that is not known.
    dimensions : tuple of (str, float)
        Names, and values as measured on the body, mm.
    rules : tuple of Rule
    """

    template: Template
    near: str
    asked: str
    title: str
    words: str
    before: str
    after: str
    count: int
    rows: tuple[NodeRow, ...]
    sketches: tuple[SketchRow, ...]
    advice: str
    dimensions: tuple[tuple[str, float], ...]
    rules: tuple[Rule, ...]


def guide_of(state: CarState) -> Guide:
    """Return the content of the panel for a car.

    Raises
    ------
    UserError
        As `solve_car` does.
    """
    body = body_of(state)
    solved, template = body.solved, body.template
    placed, asked = in_work(state, solved), asked_of(state, solved)
    sketch = None if placed is None else placed.sketch
    node = "" if asked is None else asked.node
    title = node_title(node, sketch, template) if sketch is not None and node else ""
    before, after = _neighbours(node, placed, solved)
    return Guide(
        template,
        "L" if sketch is None else sketch.shows,
        node,
        title,
        "" if sketch is None else next_mark_in_words(state, solved),
        before,
        after,
        _count(state, sketch, template),
        () if placed is None else tuple(_rows(placed, solved, node)),
        tuple(_sketches(state, solved)),
        _advice(solved),
        tuple(_dimensions(body)),
        tuple(_rules(state, body)),
    )


def _count(state: CarState, sketch: Sketch | None, template: Template) -> int:
    """Return how many nodes are marked on the sketch in work, or on the mesh: of a pair both."""
    if sketch is not None:
        return sum(mark.node in template.node for mark in sketch.marks)
    points = () if state.mesh is None else state.mesh.points
    return sum(node in template.node for point in points for node, _ in point.on_both_sides())


def _neighbours(asked: str, placed: Placed | None, solved: Solved) -> tuple[str, str]:
    if placed is None:
        return "", ""
    if not asked:
        marks = placed.sketch.marks
        return (marks[-1].node if marks else ""), ""
    after = neighbour_of(asked, 1, placed, solved)
    return neighbour_of(asked, -1, placed, solved), "" if after == asked else after


def _rows(placed: Placed, solved: Solved, asked: str) -> Iterator[NodeRow]:
    template, sketch = solved.template, placed.sketch
    shown = shown_nodes(placed, solved)
    missed, others = placed.missed or {}, placed.left_out or {}
    for number in template.asked(sketch.shows):
        node = template.names[number]
        title, off = node_title(node, sketch, template), missed.get(node)
        status: Status = "open"
        if node in placed.disagreeing:
            status, off = "wrong", others.get(node, off)
        elif sketch.mark_of(node) is not None:
            status = "set"
        elif node in sketch.skipped:
            status = "skipped"
        elif shown is not None and not shown[number]:
            status = "hidden"
        if node == asked:
            status = "asked"
        yield NodeRow(node, title, status, off)


def _sketches(state: CarState, solved: Solved) -> Iterator[SketchRow]:
    for sketch in state.sketches:
        placed = solved.placed.get(sketch.id)
        summary = "hidden" if placed is None else _summary(sketch, placed)
        wrong = placed is not None and bool(
            placed.disagreeing or placed.exchanged or placed.misfit is not None
        )
        yield SketchRow(sketch.id, sketch.name, summary, sketch is state.sketch, wrong)


def _summary(sketch: Sketch, placed: Placed) -> str:
    count, wrong = len(sketch.marks), len(placed.disagreeing)
    words = [f"{count} mark" if count == 1 else f"{count} marks"]
    if wrong:
        words.insert(0, "1 mark disagrees" if wrong == 1 else f"{wrong} marks disagree")
    elif placed.is_known:
        words.insert(0, placed.sketch_camera.camera.kind)
    if placed.mean_miss is not None:
        words.append(f"{placed.mean_miss:.1f} px")
    return " · ".join(words)


def _advice(solved: Solved) -> str:
    if solved.joint is None:
        return ""
    views = further_views(solved.template, solved.cost, solved.joint)
    if not views:
        return ""
    best = views[0]
    article = "from the" if best.name in ("front", "side", "rear") else "from"
    name = f"{best.name} view" if "quarter" in best.name else f"view {article} {best.name}"
    digits = 0 if best.after >= 10.0 else 1
    return f"Would help most: a {name}, {best.before:.{digits}f} → {best.after:.{digits}f} mm."


def _dimensions(body: Body) -> Iterator[tuple[str, float]]:
    for name, value in asdict(body.dimensions).items():
        yield name.replace("_", " ").capitalize(), float(value)


def _rules(state: CarState, body: Body) -> Iterator[Rule]:
    slacks = body.solved.soundness.least(body.template.reduced(body.network.positions))
    for name in soundness_names(body.template):
        yield Rule(name, name not in state.without, slacks.get(name, 0.0) < -1e-9)


# -- the chart of all nodes ------------------------------------------------------------------------


def chart_of(template: Template, near: str) -> Chart:
    """Return the template drawn from above the corner of its nose, on the near side."""
    camera = _chart_camera(template, near)
    curves = bernstein(np.linspace(0.0, 1.0, PIECES + 1)) @ template.control_points
    drawn = camera.project(curves.reshape(-1, 3))[0]
    places = camera.project(template.positions)[0]
    every = np.vstack((drawn, places))
    low, high = every.min(axis=0), every.max(axis=0)
    width = float(high[0] - low[0])
    seen = facing(template, template.positions, camera)
    return Chart(
        (places - low) / width,
        ((drawn - low) / width).reshape(*curves.shape[:2], 2),
        np.asarray(seen[template.edges].all(axis=1)),
        float(high[1] - low[1]) / width,
    )


@remembered(limit=16)
def _chart_camera(template: Template, near: str) -> Camera:
    """Return the view next to the usual one in which no two nodes overlap; else the best."""
    side = 1.0 if near == "R" else -1.0
    middle = template.positions.mean(axis=0)
    best, widest = None, -1.0
    for turn in CHART_TURNS:
        eye = middle + 20_000.0 * ViewHint(side * turn.azimuth, turn.elevation).toward_eye
        camera = Camera(
            "orthographic", triple(eye), triple(middle), height=6000.0, viewport=CHART_SIZE
        )
        places = camera.project(template.positions)[0]
        gaps = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]
        least = float(gaps.min() / np.ptp(places[:, 0]))
        if least >= APART:
            return camera
        if least > widest:
            best, widest = camera, least
    assert best is not None
    return best
