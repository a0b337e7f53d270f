"""Strokes to lines, lines to answers, answers to exact planes: each step remembered."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Placement
from bozzetto.ink import Strokes
from bozzetto.plugin import remembered
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.live import LiveGraph, continued, searched
from bozzetto_polyhedron.model.changes import Change, Join
from bozzetto_polyhedron.model.state import MOST_ANSWERS, Body, Dimension, PolyhedronState
from bozzetto_polyhedron.reconstruction.answer import Answer, Rings
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.flaps import without_findings_at_flaps
from bozzetto_polyhedron.reconstruction.ranking import SURE
from bozzetto_polyhedron.rounds.ink_left import Evidence
from bozzetto_polyhedron.rounds.on_bodies import Rounded, shows_column, with_rounds
from bozzetto_polyhedron.rounds.round_things import PlacedRound
from bozzetto_polyhedron.rounds.straightened import Straightened, straightened
from bozzetto_polyhedron.solid.equal_lengths import with_equal_lengths
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.hand_over import mesh_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody, evened, on_axis_planes
from bozzetto_polyhedron.solid.sheet import sheet_solid
from bozzetto_polyhedron.solve.changes import after, changed_body
from bozzetto_polyhedron.solve.choice import chosen_number
from bozzetto_polyhedron.solve.corner_order import in_order
from bozzetto_polyhedron.solve.line_readings import decided
from bozzetto_polyhedron.solve.measured_edges import dimensions_of
from bozzetto_polyhedron.solve.open_faces import opened
from bozzetto_polyhedron.solve.round_sizes import sizes_of
from bozzetto_polyhedron.solve.slanted_faces import slanted_faces

Checkpoint = Callable[[float, str], None]


UP: Final = (0.0, 0.0, 1.0)
"""Where the ground is not, in a drawing that was not moved."""

ROUNDED: Final = 1e-13
"""Differences below this share of the size are rounding, where a body that was turned has planes
square to an axis of the world."""

ON_AXIS: Final = 1e-12
"""Cosine from 1 within which a plane that was turned is meant square to an axis of the world."""


CHECK: Final = "Erase those that you did not mean, and draw them as they are."
OTHERWISE: Final = (
    "They may well be others: “Draw hidden edges” once more shows the next guess, or draw them "
    "lightly yourself."
)
"""What is said of guessed edges: where they are likely, and where they are not."""


def never(fraction: float = 0.0, doing: str = "") -> None:
    """Go on: the checkpoint of who cannot be asked to stop."""


@dataclass(frozen=True, eq=False)
class Solved:
    """One body with all that was found on the way.

    Parameters
    ----------
    graph : LineGraph
        In px of the drawing's canvas.
    answers : tuple of Answer
        The likeliest first, in the frame of the drawing; empty in previews of a drawing that was
        not turned yet.
    number : int
        Which of them the body is made from; -1 for none.
    base : PlanarBody or None
        The answer with exact planes, in the frame of the model: vertices are those of the graph.
    changed : Changed or None
        The same with all that was drawn on it, without the faces that are open.
    mesh : Mesh or None
        Its triangles; with the thickness of a sheet.
    rounds : mapping of int to PlacedRound
        What was drawn round, in the frame of the drawing, by the numbers of `rounds.round_curves`.
    problem : str
        Why there is no body, for a person; "" where there is one, or where nobody asked yet.
    """

    graph: LineGraph
    answers: tuple[Answer, ...] = ()
    number: int = -1
    base: PlanarBody | None = None
    changed: Changed | None = None
    mesh: Mesh | None = None
    rounds: Mapping[int, PlacedRound] = field(default_factory=dict)
    problem: str = ""

    @property
    def body(self) -> PlanarBody | None:
        """The body with all that was drawn on it."""
        return None if self.changed is None else self.changed.body

    @property
    def base_faces(self) -> tuple[Rings, ...]:
        """The faces before anything was drawn on them."""
        return () if self.base is None else self.base.faces

    @property
    def answer(self) -> Answer | None:
        """The answer that the body is made from."""
        return self.answers[self.number] if self.number >= 0 else None


def solved(
    body: Body, state: PolyhedronState, quality: str = "final", checkpoint: Checkpoint = never
) -> Solved:
    """Solve one body.

    A drawing that nobody turned yet ends with its lines as long as they look wrong, and in a
    preview: they are what a person who draws has to see at once.
    """
    if body.choice is None and quality == "preview":
        return Solved(graph_while_drawn(body.strokes, body.evidence, checkpoint))
    graph = graph_of_ink(body.strokes, body.evidence, checkpoint)
    if body.choice is None and graph.health:
        return Solved(graph)
    answers = answers_of_ink(body.strokes, body.evidence, body.hidden, checkpoint)
    if not answers:
        return Solved(graph, problem="These lines make no shape yet. Draw on.")
    answers = _less_sure(answers, body)
    number = chosen_number(answers, body.choice, body.answer)
    checkpoint(0.9, "Exact planes")
    try:
        base = _base(body, state, graph, answers, number, checkpoint)
        drawn = _rounded(base, body, state, graph)
        made = changed_body(
            drawn.made, state.changes_of(body), _others(body, state), body.placement
        )
        left, told = opened(made.body, body, state)
        made = replace(made, body=left, told=(*made.told, *told))
        placed = placed_changes(made, body.placement)
        mesh = (
            mesh_of(placed.body) if body.wall == 0.0 else sheet_solid(placed.body, body.wall).mesh
        )
    except UserError as problem:
        return Solved(graph, answers, number, problem=str(problem))
    base = placed_body(base, body.placement)
    return Solved(graph, answers, number, base, placed, mesh, drawn.placed)


def _less_sure(answers: tuple[Answer, ...], body: Body) -> tuple[Answer, ...]:
    """Return answers as much less likely as edges are that were guessed, which is told."""
    count = len(body.strokes) - len(body.drawn)
    if not count:
        return answers
    edges = "One edge is guessed" if count == 1 else f"{count} edges are guessed"
    told = f"{edges}, drawn lightly. {CHECK if body.guess_certainty >= SURE else OTHERWISE}"
    return tuple(
        replace(
            each,
            confidence=body.guess_certainty * each.confidence,
            warnings=(*each.warnings, told),
        )
        for each in answers
    )


def joined_bodies(results: Mapping[str, Solved]) -> dict[str, str]:
    """Return the bodies that have become part of another one, by their ids, and which that is."""
    return {
        part: body_id
        for body_id, found in results.items()
        if found.changed is not None
        for part in found.changed.joined
    }


def changed_until(body: Body, state: PolyhedronState, change: Change | None = None) -> Changed:
    """Return a body, in the frame of its drawing, as it was before one of its changes.

    Parameters
    ----------
    body : Body
        A drawing.
    state : PolyhedronState
        That it is part of.
    change : Change, optional
        Default after all of them.

    Raises
    ------
    UserError
        If the drawing is no solid yet.
    """
    made = _drawn(body, state)
    if made is None:
        raise UserError("This drawing is no solid yet. Draw the edges that are missing first.")
    changes = state.changes_of(body)
    if change is not None:
        numbers = [each.id for each in changes]
        if change.id in numbers:
            changes = changes[: numbers.index(change.id)]
    return changed_body(made, changes, _others(body, state), body.placement)


def with_change(state: PolyhedronState, body: Body, change: Change) -> PolyhedronState:
    """Return the state with one more change of a body, or another one in its place; chosen.

    Raises
    ------
    UserError
        If it cannot be done.
    """
    made = state.with_node(change)
    after(changed_until(body, made, change), change, _others(body, made), body.placement)
    return made


def placed_changes(made: Changed, placement: Placement) -> Changed:
    """Return a body and all that belongs to it where a placement takes it."""
    if placement.is_identity:
        return made
    return made.mapped(lambda body: placed_body(body, placement), placement.points, placement.scale)


def answered(body: Body, state: PolyhedronState, number: int) -> Changed | None:
    """Return an answer as an exact body with what was drawn round; None where it makes none."""
    graph = graph_of_ink(body.strokes, body.evidence, never)
    answers = answers_of_ink(body.strokes, body.evidence, body.hidden, never)
    try:
        return _rounded(_base(body, state, graph, answers, number, never), body, state, graph).made
    except UserError:
        return None


def _rounded(base: PlanarBody, body: Body, state: PolyhedronState, graph: LineGraph) -> Rounded:
    """Return the exact body of straight lines with what was drawn round in it."""
    found = straightened(body.strokes, body.evidence)
    if found.reading is None:
        return Rounded(Changed(base))
    sizes = sizes_of(state.round_sizes_of(body), found.reading)
    return with_rounds(base, graph, found, body.strokes[0].camera, sizes)


def _drawn(body: Body, state: PolyhedronState) -> Changed | None:
    """Return the exact body of a drawing, in the frame of the drawing; None where there is none."""
    answers = answers_of_ink(body.strokes, body.evidence, body.hidden, never)
    if not answers:
        return None
    return answered(body, state, chosen_number(answers, body.choice, body.answer))


def _base(
    body: Body,
    state: PolyhedronState,
    graph: LineGraph,
    answers: tuple[Answer, ...],
    number: int,
    checkpoint: Checkpoint,
) -> PlanarBody:
    dimensions = dimensions_of(state.measures_of(body), graph, answers[number])
    slanted = slanted_faces(state.slants_of(body), graph, answers[number])
    turned = body.placement.rotation
    up = turned[6:9] if dimensions else UP
    return exact_body_of_ink(
        body.strokes,
        body.evidence,
        body.hidden,
        number,
        state.exact,
        state.equal,
        dimensions,
        slanted,
        up,
        checkpoint,
    )


def _others(
    body: Body, state: PolyhedronState, passed: frozenset[str] = frozenset()
) -> Mapping[str, Changed]:
    """Return the bodies that are joined to one, by their ids, in the frame of its drawing."""
    passed = passed | {body.id}
    found: dict[str, Changed] = {}
    shown = {each.id: each for each in state.shown(Body)}
    for join in state.changes_of(body):
        if not isinstance(join, Join) or join.other in passed or join.other not in shown:
            continue
        other = shown[join.other]
        if other.choice is None or (drawn := _drawn(other, state)) is None:
            continue
        made = changed_body(
            drawn,
            state.changes_of(other),
            _others(other, state, passed),
            other.placement,
        )
        way = body.placement.inverse().after(other.placement)
        found[other.id] = placed_changes(made, way)
    return found


def _without_checkpoint(*asked: Any) -> Hashable:
    return asked[:-1]


@remembered(limit=64, key=_without_checkpoint)
def graph_of_ink(strokes: Strokes, rounds: Evidence, checkpoint: Checkpoint) -> LineGraph:
    """Return the lines of a drawing and the corners in which they meet.

    What is round is left out of it; `rounds` says how much evidence that needs. Lines have the
    numbers of the strokes that were drawn.
    """
    found = straightened(strokes, rounds)
    graph = without_findings_at_flaps(in_order(_searched(found.strokes, checkpoint).graph))
    return _as_drawn(graph, found)


@remembered(limit=16, key=_without_checkpoint)
def graph_of_visible_ink(strokes: Strokes, rounds: Evidence, checkpoint: Checkpoint) -> LineGraph:
    """Return the lines of a drawing in which hidden ones are left out."""
    found = straightened(strokes, rounds)
    graph = in_order(searched(found.strokes, checkpoint=checkpoint, only_visible=True).graph)
    return _as_drawn(graph, found)


@remembered(limit=64, key=_without_checkpoint)
def graph_while_drawn(strokes: Strokes, rounds: Evidence, checkpoint: Checkpoint) -> LineGraph:
    """Return the lines of a drawing soon after its last stroke.

    It continues what was found, by the whole search, before that stroke; nobody waits for that, for
    it was shown then. So it is the same whatever was asked before.
    """
    if len(strokes) < 2:
        return graph_of_ink(strokes, rounds, checkpoint)
    earlier = straightened(strokes[:-1], rounds).strokes
    found = straightened(strokes, rounds)
    before = replace(_searched(earlier, checkpoint), strokes=tuple(earlier))
    graph = in_order(continued(before, found.strokes, checkpoint=checkpoint).graph)
    return _as_drawn(graph, found)


def _as_drawn(graph: LineGraph, found: Straightened) -> LineGraph:
    """Return a graph with the numbers of strokes as they were drawn."""
    if found.reading is None:
        return graph
    return replace(
        graph,
        strokes=tuple(found.drawn(numbers) for numbers in graph.strokes),
        dropped=found.drawn(graph.dropped),
    )


@remembered(limit=64, key=_without_checkpoint)
def _searched(strokes: Strokes, checkpoint: Checkpoint) -> LiveGraph:
    found = searched(strokes, checkpoint=checkpoint)
    return decided(found, strokes[0].camera, checkpoint) if len(strokes) else found


@remembered(limit=64, key=_without_checkpoint)
def answers_of_ink(
    strokes: Strokes, rounds: Evidence, hidden: str, checkpoint: Checkpoint
) -> tuple[Answer, ...]:
    """Return the answers of a drawing, the likeliest first."""
    graph = graph_of_ink(strokes, rounds, checkpoint)
    if not len(graph.lines):
        return ()
    if hidden == "unmarked":
        graph = replace(graph, light=0.0 * graph.light)
    found = answers_of(graph, strokes[0].camera, checkpoint=checkpoint, most=MOST_ANSWERS)
    column = straightened(strokes, rounds).column
    if column is None:
        return found
    round_ones = (each for each in found if shows_column(each.vertices, graph, column))
    return tuple(round_ones) or found


@remembered(limit=64, key=_without_checkpoint)
def exact_body_of_ink(
    strokes: Strokes,
    rounds: Evidence,
    hidden: str,
    number: int,
    right_angles: bool,
    equal: bool,
    dimensions: tuple[Dimension, ...],
    slanted: tuple[int, ...],
    up: tuple[float, ...],
    checkpoint: Checkpoint,
) -> PlanarBody:
    """Return an answer of a drawing with exact planes, in the frame of the drawing."""
    answer = answers_of_ink(strokes, rounds, hidden, checkpoint)[number]
    camera = strokes[0].camera
    noise = graph_of_ink(strokes, rounds, checkpoint).noise / camera.pixels_per_mm
    fit = partial(
        exact_body,
        answer,
        noise=noise,
        right_angles=right_angles,
        dimensions=dimensions,
        slanted=slanted,
        camera=camera,
        up=up,
    )
    return with_equal_lengths(fit, noise) if equal else fit()


def placed_body(body: PlanarBody, placement: Placement) -> PlanarBody:
    """Return a body where a placement takes it; planes that are square to an axis become so.

    A plane that comes on the origin but for rounding lies on it: a body stands on the ground.
    """
    if placement.is_identity:
        return body
    normals = placement.directions(body.normals)
    near = np.abs(normals) > 1.0 - ON_AXIS
    normals = np.where(near.any(axis=1, keepdims=True), near * np.sign(normals), normals)
    vertices = placement.points(body.vertices)
    offsets = placement.scale * body.offsets + normals @ np.asarray(placement.offset)
    if near.any():
        least = ROUNDED * float(np.ptp(vertices, axis=0).max())
        vertices = evened(vertices, least)
        offsets = np.where(near.any(axis=1) & (np.abs(offsets) < least), 0.0, offsets)
    moved = replace(
        body,
        vertices=vertices,
        normals=normals,
        offsets=offsets,
        frame=None if body.frame is None else placement.directions(body.frame),
    )
    return on_axis_planes(moved)
