"""The body: the network of the solved car, the edits by hand, its dimensions and its surfaces."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import Patchwork, crease_angles, extent
from bozzetto.plugin import cached_property, override, remembered
from bozzetto.view import Camera, triple
from bozzetto.view.calibration import resect
from bozzetto_car.body.chain_smoothing import (
    anneal,
    lock_ratios,
    own_edges,
    shorten_tangents,
    smooth_chains,
    smooth_parts,
    with_one_curvature,
)
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.drag import bend_edge
from bozzetto_car.body.edges_on_mesh import network_on_mesh
from bozzetto_car.body.edits_preview import OnPicture, carried
from bozzetto_car.body.fair_lines import fair_network, with_creases_of_one_side
from bozzetto_car.body.stretch import reshaping_of, stretch, undo_stretch
from bozzetto_car.body.trace_edges import Line, trace_all
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.dimensions import Dimensions, measure_dimensions
from bozzetto_car.solver.initial_cameras import counted_marks
from bozzetto_car.solver.nodes_on_mesh import FEWEST
from bozzetto_car.solver.pipeline import Solved, solve_car
from bozzetto_car.state import BentEdge, BodyEdit, CarState, MovedNode, TracedEdges, Treatment
from bozzetto_car.template.blend import can_blend
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.line_joints import with_joints
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called, node_called, with_positions

Edit = TracedEdges | MovedNode | BentEdge | Treatment

REMEMBERED: Final = 1024
"""Number of bodies that are remembered, one after each edit; each takes some kilobytes."""

FIRST_SEEN: Final = 8
"""Number of cars that are remembered as the first with their edits."""

DRAWN: Final = 1e2
"""Firmness of an edge that was drawn or bent by hand, relative to one that came from the marks,
when the lengths of tangents are adjusted for smooth surfaces."""

IN_HAND: Final = 1e4
"""Firmness of the edge that was bent last, and of all edges that strokes hold: they stay where the
pen has put them."""

HELD: Final = 1.0
"""Standard deviation of a movement of nodes that would change a kept dimension, mm."""


@dataclass(frozen=True)
class Trouble:
    """An edit that cannot be made any more.

    Attributes
    ----------
    number : int
        Index of the edit in the state.
    message : str
    """

    number: int
    message: str


@dataclass(frozen=True, eq=False)
class Body:
    """A car as it is shown and handed over.

    Attributes
    ----------
    network : Network
    solved : Solved
        The solve that it came from.
    drawn : frozenset of int
        Edges that were drawn or bent by hand.
    traced : tuple of (int, tuple of int)
        Numbers of the edits that traced edges, and these edges.
    troubles : tuple of Trouble
        Edits that were left out.
    world : Dimensions
        Dimensions that it was brought to; none given if it is as it was drawn.
    dimensions_problem : str
        Why the body cannot have the dimensions that are wanted; "" if it can.
    is_dragged : bool
        Whether it is seen only while something is dragged: its edits were carried over from another
        body, or its dimensions are about to change; see `preview_of`.
    """

    network: Network
    solved: Solved
    drawn: frozenset[int] = frozenset()
    traced: tuple[tuple[int, tuple[int, ...]], ...] = ()
    troubles: tuple[Trouble, ...] = ()
    world: Dimensions = Dimensions()
    dimensions_problem: str = ""
    is_dragged: bool = False

    @property
    def template(self) -> Template:
        """The template that names its nodes, edges and patches."""
        return self.network.template

    @cached_property
    def sketch_cameras(self) -> Mapping[str, SketchCamera]:
        """The camera through which each sketch sees this body, by the id of the sketch."""
        sketch_cameras = {key: placed.sketch_camera for key, placed in self.solved.placed.items()}
        return sketch_cameras | _seen_again(self) if self.world.given() else sketch_cameras

    @cached_property
    def nets(self) -> Array:
        """Control nets of the patches, (k, 4, 4, 3) mm."""
        return fair_nets(self.network)

    @cached_property
    def patchwork(self) -> Patchwork:
        """The surfaces as one patchwork, with the names of the patches."""
        names = tuple(patch.name for patch in self.template.patches)
        return Patchwork(
            self.nets,
            self.network.control_points,
            self.template.sides.astype(np.int32),
            self.template.title,
            patch_names=names,
        )

    @cached_property
    def creases(self) -> Array:
        """The crease angle along each edge, (m,) degrees; NaN on the rim."""
        return crease_angles(self.nets, self.template.sides, len(self.template.edges))

    @cached_property
    def dimensions(self) -> Dimensions:
        """The dimensions as measured on the surfaces, mm."""
        front, rear = self.network.positions[self.template.wheels[:, 0], 0]
        return measure_dimensions(extent(self.nets), front, rear)


def body_of(state: CarState, before: CarState | None = None) -> Body:
    """Return the body of a car.

    Parameters
    ----------
    state : CarState
        The car.
    before : CarState, optional
        The car before one of its marks was dragged; see `solve_car`.

    Raises
    ------
    UserError
        As `solve_car` does. Edits and dimensions that are impossible are left out and reported.
    """
    body, wanted = unstretched_body_of(state, before), state.dimensions
    if not wanted.given() or body.dimensions_problem:
        return body
    return _flowing(_finished(body, wanted), state.flowing, state.smooth)


def is_shown(state: CarState, body: Body) -> bool:
    """Whether the body is shown, and not only a sketch or a mesh with too few marks."""
    if state.mesh is not None:
        return len(state.mesh.points) >= FEWEST
    return state.sketch is None or body.solved.joint is not None


def body_in_work(state: CarState) -> Body:
    """Return the body that is shown, to be worked on.

    Raises
    ------
    UserError
        If no body is shown yet.
    """
    body = body_of(state)
    if not is_shown(state, body):
        raise UserError(
            "There is no body to work on yet: the sketch or the mesh has too few marks. Mark its "
            "points first."
        )
    return body


def world_of(state: CarState, body: Body) -> Dimensions:
    """Return the dimensions in which a car is edited: those wanted, or none if it cannot have them.

    A drag on a body that is shown without them would else be carried over from a body that
    nobody has seen, ten times as far, say.
    """
    return Dimensions() if body.dimensions_problem else state.dimensions


def sketch_cameras_of(state: CarState) -> Mapping[str, SketchCamera]:
    """Return the camera of each sketch of a car by its id, without edits if they do not matter.

    Raises
    ------
    UserError
        As `body_of` does.
    """
    if state.dimensions.given():
        return body_of(state).sketch_cameras
    return {key: placed.sketch_camera for key, placed in solve_car(state).placed.items()}


def body_at_rest_of(state: CarState) -> Body:
    """Return the body of a car that nobody drags; see `preview_of`, which goes on from there.

    Raises
    ------
    UserError
        As `body_of` does.
    """
    _dimensions_at_rest.put(state.dimensions, state)
    return body_of(state)


def preview_of(state: CarState) -> Body:
    """Return the body of a car quickly, while something is dragged.

    While a dimension is dragged that is kept, the body is stretched to it and not solved for it:
    the solve without dimensions stays the same and is remembered, and stretching takes a
    hundredth of the time of another solve. While the shape is dragged, edits are not repeated:
    their effect is carried over from the first car that was seen with them; see
    `unstretched_body_of`.

    Raises
    ------
    UserError
        As `body_of` does.
    """
    is_stretched = state.dimensions != _dimensions_at_rest(state)
    shown = replace(state, lock=False) if is_stretched and state.lock else state
    if not state.edits:
        return body_of(shown)
    first = _first_seen(shown)
    body = body_of(shown, None if first is shown else first)
    return _as_dragged(body) if is_stretched else body


@remembered(limit=REMEMBERED)
def _as_dragged(body: Body) -> Body:
    return replace(body, is_dragged=True)


@remembered(limit=FIRST_SEEN, key=lambda state: _Same(state.nodes))
def _dimensions_at_rest(state: CarState) -> Dimensions:
    """Return the dimensions that a car with these very sketches had when nobody dragged it."""
    return state.dimensions


@remembered(
    limit=FIRST_SEEN,
    key=lambda state: (
        _Same(state.edits),
        state.smooth,
        state.default_shape,
        state.annealed,
        state.lock,
        state.joints,
        state.flowing,
    ),
)
def _first_seen(state: CarState) -> CarState:
    """Return the first car that was seen with the edits and the manner of deforming of a car."""
    return state


def unstretched_body_of(state: CarState, before: CarState | None = None) -> Body:
    """Return the body of a car as it is drawn, before it is stretched to its dimensions.

    While a mark is dragged, or the share of two templates, edits are not repeated: their effect on
    `before` is carried over.
    """
    return _flowing(_drawn(state, before), state.flowing, state.smooth)


@remembered(limit=REMEMBERED)
def _flowing(body: Body, names: tuple[str, ...], smooth: bool) -> Body:
    """Return a body in which the smooth lines along some edges run with one curvature."""
    edges = {edge for name in names if (edge := _edge_if_any(body.template, name)) is not None}
    if not edges:
        return body
    network = with_one_curvature(body.network, edges)
    if smooth:
        held = [
            edge
            for chain, first, last in smooth_parts(body.template)
            for edge in own_edges(body.template, chain.edges[first:last])
            if edges.intersection(own_edges(body.template, chain.edges[first:last]))
        ]
        network = lock_ratios(network, _firmness(body, _with_images(body.template, tuple(held))))
    return replace(body, network=network)


def _edge_if_any(template: Template, name: str) -> int | None:
    try:
        (edge,) = own_edges(template, (edge_called(template, name),))
    except UserError:  # another template has no such edge
        return None
    return edge


def _drawn(state: CarState, before: CarState | None) -> Body:
    """Return the body of a car with its edits, unstretched."""
    try:
        base = solve_car(state, before)
    except UserError as problem:
        if not (state.lock and state.dimensions.given()):
            raise
        loose = _drawn(replace(state, lock=False), before)
        return replace(loose, dimensions_problem=problem.message)
    is_same = before is not None and state.edits is before.edits and state.joints == before.joints
    if before is not None and state.edits and is_same:
        old = _drawn(before, None)
        if old.solved is not base and can_blend(old.template, base.template):
            start = _deformed(base, state)
            return _carried(old, _right_after(old.solved, before), start, before)
    body = _right_after(base, state)
    strokes: tuple[int, ...] = ()
    made = 0
    for number, edit in enumerate(state.edits):
        if isinstance(edit, TracedEdges):
            strokes, made = (*strokes, number), made + 1
            continue
        if made:
            body, made = _with_strokes(body, state, strokes), 0
        body = _edited(body, edit, number, state.smooth, _moved_for(edit, body, state))
        strokes = _left_alone(strokes, edit, state.edits, body.template)
    return _with_strokes(body, state, strokes) if made else body


def _left_alone(
    strokes: tuple[int, ...], edit: Edit, edits: tuple[Edit, ...], template: Template
) -> tuple[int, ...]:
    """Return the numbers of strokes whose edges another edit leaves where they were drawn.

    A later stroke does not bring the others back to theirs.
    """
    if isinstance(edit, Treatment):
        return ()
    try:
        if isinstance(edit, MovedNode):
            node = node_called(template, edit.node)
            ends = {node, int(template.mirrored[node])}
            touched = {
                edge for edge, own in enumerate(template.edges.tolist()) if ends.intersection(own)
            }
        else:
            assert isinstance(edit, BentEdge)
            touched = set(_with_images(template, (edge_called(template, edit.edge),)))
    except UserError:  # another template has no such node or edge, and the edit was left out
        return strokes
    names = {template.edge_names[edge] for edge in touched}
    names |= {"-".join(reversed(name.split("-"))) for name in names}
    traced = {number: edit for number, edit in enumerate(edits) if isinstance(edit, TracedEdges)}
    return tuple(number for number in strokes if names.isdisjoint(traced[number].edges))


class _Same:
    """A key that is equal only to a key of the very same object.

    Comparing all samples of fifty strokes would take longer than repeating one edit.
    """

    __slots__ = ("own",)

    def __init__(self, own: object) -> None:
        self.own = own

    @override
    def __hash__(self) -> int:
        return id(self.own)

    @override
    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.own is self.own


# -- deformation -----------------------------------------------------------------------------------


@remembered(
    limit=REMEMBERED,
    key=lambda base, state: (
        (base, state.default_shape, state.annealed, state.smooth, state.joints)
    ),
)
def _right_after(base: Solved, state: CarState) -> Body:
    return _deformed(base, state)


def _deformed(base: Solved, state: CarState) -> Body:
    """Return the network right after deformation, as a body without edits."""
    template = with_joints(base.template, state.joints)
    if base.mesh is not None:
        network = network_on_mesh(template, base.positions, base.mesh.mesh)
    elif state.annealed and base.joint is not None:
        network = fair_network(template, base.positions)
    else:
        network = Network.of(template, base.positions)
    if state.joints:
        network = smooth_chains(network)
    if state.default_shape and base.joint is not None:
        network = with_creases_of_one_side(pull_out_panels(network))
    return Body(lock_ratios(network) if state.smooth else network, base)


# -- edits -----------------------------------------------------------------------------------------


def in_world_of(body: Body, edit: BodyEdit) -> Network:
    """Return the network of an unstretched body in the dimensions that an edit was made in.

    Raises
    ------
    UserError
        If the network cannot have these dimensions any more.
    """
    map_ = _map_to(body.network, edit.dimensions)
    return body.network if map_ is None else stretch(body.network, map_)


def _map_to(network: Network, wanted: Dimensions) -> Reshaping | None:
    return _reshaping(network, wanted) if wanted.given() else None


@remembered(limit=REMEMBERED)
def _reshaping(network: Network, wanted: Dimensions) -> Reshaping | None:
    return reshaping_of(network, wanted)


@dataclass(frozen=True, eq=False)
class _Moved:
    """How a car that is solved for other dimensions has moved since an edit was made in space.

    Attributes
    ----------
    back : Reshaping or None
        To about the car that it was then; None if it has these dimensions.
    along : float
        How much farther along x it then stands, mm.
    """

    back: Reshaping | None
    along: float


def _car_then(edit: Edit, state: CarState) -> CarState | None:
    """Return a car that is solved for what it was solved for when an edit was made in space.

    None where it still is. A stroke on a sketch stays on its line, which the car goes to, and is
    not of space.
    """
    if isinstance(edit, TracedEdges) and edit.sketch:
        return None
    was, is_kept = edit.dimensions, state.lock and bool(state.dimensions.given())
    was_kept = bool(was.given()) and (is_kept if edit.kept is None else edit.kept)
    if was_kept == is_kept and (not is_kept or was == state.dimensions):
        return None
    return replace(
        state, lock=was_kept, length=was.length or 0.0, width=was.width or 0.0,
        height=was.height or 0.0, front_overhang=was.front_overhang or 0.0,
        wheelbase=was.wheelbase or 0.0,
    )  # fmt: skip


def _moved_for(edit: Edit, body: Body, state: CarState) -> _Moved | None:
    """Return how the car has moved since an edit was made in space; None where it has not."""
    then = _car_then(edit, state)
    return None if then is None else _moved_since(body.solved, state, then)


def _moved_since(now: Solved, state: CarState, then: CarState) -> _Moved | None:
    """Return how a solved car has moved since it was solved for other dimensions, or for none."""
    if now.joint is None:  # nothing is solved, whatever is kept
        return None
    try:
        return _moved(now, solve_car(then), state, then.dimensions)
    except UserError:  # it cannot have had them, or cannot be stretched to them any more
        return None


@remembered(
    limit=FIRST_SEEN,
    key=lambda now, then, state, wanted: (
        (now, then, wanted, state.default_shape, state.annealed, state.smooth, state.joints)
    ),
)
def _moved(now: Solved, then: Solved, state: CarState, wanted: Dimensions) -> _Moved:
    own, other = _right_after(now, state), _right_after(then, state)
    was = _finished(other, wanted) if wanted.given() else other
    back = reshaping_of(own.network, was.dimensions)
    there = own.network if back is None else stretch(own.network, back)
    return _Moved(back, float((there.positions - was.network.positions)[:, 0].mean()))


def drawn_through(body: Body, edit: TracedEdges) -> tuple[Array, Camera]:
    """Return the samples of a stroke, (k, 2) px, and the camera that it was drawn through.

    Raises
    ------
    UserError
        If the sketch that it was drawn on is gone.
    """
    stroke = edit.strokes[0]
    if not edit.sketch:
        return stroke.points, stroke.camera
    placed = body.solved.placed.get(edit.sketch)
    if placed is None or not placed.is_known:
        raise UserError(
            "The sketch on which an edge was traced is gone, or its camera is not known. Show the "
            "sketch and mark more points, or trace the edge again."
        )
    return stroke.points - placed.sketch_camera.shift, placed.sketch_camera.camera


@remembered(
    limit=REMEMBERED,
    key=lambda body, edit, number, smooth, moved: (body, _Same(edit), number, smooth, moved),
)
def _edited(body: Body, edit: Edit, number: int, smooth: bool, moved: _Moved | None) -> Body:
    """Return a body after one more edit; the same body and the reason where that is impossible."""
    try:
        map_ = _map_to(body.network, edit.dimensions) if moved is None else moved.back
        there = body.network if map_ is None else stretch(body.network, map_)
        network, edges = _changed(there, edit)
    except UserError as problem:
        return replace(body, troubles=(*body.troubles, Trouble(number, problem.message)))
    in_hand = _with_images(body.template, edges)
    if smooth:
        network = lock_ratios(network, _firmness(body, in_hand))
    if map_ is not None:
        network = undo_stretch(body.network, there, network, map_)
    return replace(body, network=network, drawn=body.drawn | in_hand)


@remembered(
    limit=REMEMBERED,
    key=lambda body, state, strokes: (
        body,
        tuple((number, _Same(state.edits[number])) for number in strokes),
        (state.smooth, state.default_shape, state.annealed, state.joints),
        state.dimensions if state.lock else None,
    ),
)
def _with_strokes(body: Body, state: CarState, strokes: tuple[int, ...]) -> Body:
    """Return a body after strokes, all of them at once; those that are impossible are left out."""
    lines: list[Line] = []
    numbers: list[int] = []
    problems: dict[int, str] = {}
    moves: dict[Hashable, _Moved | None] = {}
    for number in strokes:
        edit = state.edits[number]
        assert isinstance(edit, TracedEdges)
        world = (edit.dimensions, edit.kept, bool(edit.sketch))
        if world not in moves:
            moves[world] = _moved_for(edit, body, state)
        try:
            lines.append(_line(body, edit, moves[world]))
        except UserError as problem:
            problems[number] = problem.message
        else:
            numbers.append(number)
    made = trace_all(body.network, lines, even=state.smooth, information=_information(body.solved))
    problems |= {numbers[at]: message for at, message in made.problems.items()}
    known = {trouble.number for trouble in body.troubles}
    troubles = [Trouble(at, message) for at, message in problems.items() if at not in known]
    edges = {
        numbers[at]: tuple(max(edge, ~edge) for edge in run.edges) for at, run in made.runs.items()
    }
    in_hand = _with_images(body.template, tuple(edge for row in edges.values() for edge in row))
    network = lock_ratios(made.network, _firmness(body, in_hand)) if state.smooth else made.network
    return replace(
        body,
        network=network,
        drawn=body.drawn | in_hand,
        traced=tuple(sorted((dict(body.traced) | edges).items())),
        troubles=tuple(sorted((*body.troubles, *troubles), key=lambda trouble: trouble.number)),
    )


def _line(body: Body, edit: TracedEdges, moved: _Moved | None) -> Line:
    """Return a stroke as the network of a body is fitted to it.

    Raises
    ------
    UserError
        If its sketch is gone, or the body cannot have the dimensions that it was drawn in.
    """
    points, camera = drawn_through(body, edit)
    map_ = _map_to(body.network, edit.dimensions) if moved is None else moved.back
    if moved is not None and moved.along:
        way = (moved.along, 0.0, 0.0)
        eye, target = (triple(np.add(at, way)) for at in (camera.eye, camera.target))
        camera = replace(camera, eye=eye, target=target)
    edges = tuple(edge_called(body.template, name) for name in edit.edges)
    return Line(points, camera, edges, edit.nodes_follow, edit.sketch, map_)


@remembered(limit=FIRST_SEEN)
def _information(solved: Solved) -> Array | None:
    """Return what the marks and the template tell of the variables of a car, (q, q) mm⁻²."""
    if solved.joint is None:
        return None
    span = solved.joint.span
    told = span @ solved.joint.information @ span.T
    if span.shape[0] == span.shape[1]:
        return np.asarray(told)
    within = span @ np.linalg.solve(span.T @ span, span.T)
    return np.asarray(told + (np.eye(len(span)) - within) / HELD**2)


def _carried(old: Body, old_start: Body, start: Body, before: CarState) -> Body:
    """Return the body `start` with what the edits of a car changed from `old_start` to `old`."""
    traced = list(_on_pictures(old, start, before))
    network = carried(old.network, old_start.network, start.network, traced)
    return replace(old, network=network, solved=start.solved, is_dragged=True)


def _on_pictures(old: Body, start: Body, before: CarState) -> Iterator[OnPicture]:
    """Yield what was traced on a body as it was and as it is seen now.

    What was traced on a stretched body is seen on another one than this; it is left out.
    """
    for number, edges in old.traced:
        edit = before.edits[number]
        assert isinstance(edit, TracedEdges)
        if edit.dimensions.given() or _car_then(edit, before) is not None:
            continue
        try:
            (was, then), (is_now, now) = (drawn_through(body, edit) for body in (old, start))
        except UserError:  # its sketch has no camera any more, and is told where edits are repeated
            continue
        shift = (is_now[0] - was[0]).tolist()
        yield OnPicture(edges, edit.nodes_follow, then, now, (shift[0], shift[1]))


def _changed(network: Network, edit: Edit) -> tuple[Network, tuple[int, ...]]:
    """Return a network after an edit that is no stroke, and the edges that it has drawn."""
    template = network.template
    if isinstance(edit, MovedNode):
        node = node_called(template, edit.node)
        return with_positions(network, {node: network.positions[node] + edit.by}), ()
    if isinstance(edit, BentEdge):
        edge = edge_called(template, edit.edge)
        return bend_edge(network, edge, edit.end, edit.tangent), (edge,)
    assert isinstance(edit, Treatment)
    if edit.kind == "anneal":
        return anneal(network), ()
    return (shorten_tangents(network) if edit.kind == "reduce" else pull_out_panels(network)), ()


def _with_images(template: Template, edges: tuple[int, ...]) -> frozenset[int]:
    image = template.mirrored_edges
    return frozenset(own for edge in edges for own in (edge, max(image[edge], ~image[edge])))


def _firmness(body: Body, in_hand: frozenset[int]) -> Array:
    firm = np.ones(len(body.template.edges))
    firm[list(body.drawn)] = DRAWN
    firm[list(in_hand)] = IN_HAND
    return firm


# -- dimensions ------------------------------------------------------------------------------------


@remembered(limit=REMEMBERED)
def _finished(body: Body, wanted: Dimensions) -> Body:
    """Return the body with the dimensions that are wanted."""
    try:
        map_ = _map_to(body.network, wanted)
    except UserError as problem:
        return replace(body, dimensions_problem=problem.message)
    if map_ is None:
        return body
    return replace(body, network=stretch(body.network, map_), world=wanted)


def _seen_again(body: Body) -> dict[str, SketchCamera]:
    """Find the cameras of the sketches for a body that was stretched after it was drawn."""
    sketch_cameras: dict[str, SketchCamera] = {}
    for key in body.solved.solid:
        placed = body.solved.placed[key]
        nodes, marks = counted_marks(placed, body.template)
        assert placed.resection is not None
        try:
            found = resect(
                body.network.positions[nodes], marks, placed.sketch.size,
                kind=placed.sketch_camera.camera.kind, cropped=placed.sketch.cropped,
                before=replace(placed.resection, disagreeing=()),
            )  # fmt: skip
        except UserError:
            continue  # marks that say too little of another body: it is seen as the one before
        sketch_cameras[key] = SketchCamera.behind(found.camera, found.shift, body.network.positions)
    return sketch_cameras
