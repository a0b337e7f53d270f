"""The body: the network of the solved car, what was done to it by hand, dimensions, and skin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.crease import crease_angles
from bozzetto.geometry.patches.patch import extent
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.plugin import Memory
from bozzetto.view import Camera
from bozzetto.view.calibration import resect
from bozzetto_car.array_types import Array
from bozzetto_car.body.chain_smoothing import annealed, ratio_locked, reduced
from bozzetto_car.body.default_shape import pulled_out
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.drag import bent
from bozzetto_car.body.stretch import brought_back, reshaping_of, stretched
from bozzetto_car.body.trace_edges import traced
from bozzetto_car.camera.sketch_camera import Stand
from bozzetto_car.dimensions import Dimensions, measured
from bozzetto_car.solver.initial_cameras import counted_marks
from bozzetto_car.solver.pipeline import Solved, solved
from bozzetto_car.state import BentEdge, BodyEdit, CarState, MovedNode, TracedEdges, Treatment
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called, node_called, with_positions

Edit = TracedEdges | MovedNode | BentEdge | Treatment

REMEMBERED: Final = 1024
"""Bodies that are remembered: the last ones, each after every edit; some kilobytes each."""

FIRST_SEEN: Final = 8
"""Cars that are remembered as the first with their edits."""

DRAWN: Final = 1e2
"""How much firmer an edge is that was drawn or bent by hand, when lengths of tangents are evened
out for smooth surfaces, than one that is as it came from the marks."""

IN_HAND: Final = 1e4
"""The same of the edge that was drawn last: it stays where the pen has put it."""


@dataclass(frozen=True)
class Trouble:
    """An edit that cannot be made any more.

    Attributes
    ----------
    number : int
        Of the edit.
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
        What it came from.
    drawn : frozenset of int
        Edges that were drawn or bent by hand.
    troubles : tuple of Trouble
        Edits that were left out.
    world : Dimensions
        Those that it was brought to; none if it is as it was drawn.
    dimensions_problem : str
        Why the dimensions that are wanted cannot be had; "" if they can.
    """

    network: Network
    solved: Solved
    drawn: frozenset[int] = frozenset()
    troubles: tuple[Trouble, ...] = ()
    world: Dimensions = Dimensions()
    dimensions_problem: str = ""

    @property
    def template(self) -> Template:
        """Whose names its nodes, edges and patches have."""
        return self.network.template

    @cached_property
    def stands(self) -> Mapping[str, Stand]:
        """By the id of the sketch, as this body is seen through its camera."""
        stands = {key: placed.stand for key, placed in self.solved.placed.items()}
        return stands | _seen_again(self) if self.world.given() else stands

    @cached_property
    def nets(self) -> Array:
        """Control nets of the patches, (k, 4, 4, 3) mm."""
        return coons_nets(self.network.control_points, self.template.sides)

    @cached_property
    def patchwork(self) -> Patchwork:
        """The skin, with the names of the patches."""
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
        """Degrees along each edge, (m,); NaN on the rim."""
        return crease_angles(self.nets, self.template.sides, len(self.template.edges))

    @cached_property
    def dimensions(self) -> Dimensions:
        """As measured on the surface, mm."""
        front, rear = self.network.positions[self.template.wheels[:, 0], 0]
        return measured(extent(self.nets), front, rear)


_bodies: Memory[Body] = Memory(REMEMBERED)
_maps: Memory[Reshaping | None] = Memory(REMEMBERED)
_first_seen: Memory[CarState] = Memory(FIRST_SEEN)


def body_of(state: CarState, before: CarState | None = None) -> Body:
    """The body of a car.

    Parameters
    ----------
    state : CarState
    before : CarState, optional
        See `solved`.

    Raises
    ------
    UserError
        As of `solved`. An edit or dimensions that cannot be are left out, and told.
    """
    body, wanted = unstretched_body_of(state, before), state.dimensions
    if not wanted.given() or body.dimensions_problem:
        return body
    return _bodies.recall((body, wanted), partial(_finished, body, wanted))


def preview_of(state: CarState) -> Body:
    """The body of a car, quickly: brought to its dimensions, not solved for them.

    While a dimension is dragged the solve without dimensions stays the same and is remembered;
    to stretch its body takes a hundredth of what another solve does. While the shape is dragged,
    edits are not made again; see `unstretched_body_of`. They are carried along from the first
    car that was seen with them.

    Raises
    ------
    UserError
        As of `body_of`.
    """
    loose = replace(state, lock=False) if state.dimensions.given() else state
    if not state.edits:
        return body_of(loose)
    edited = (_Same(state.edits), state.smooth, state.default_shape, state.annealed)
    return body_of(loose, _first_seen.recall(edited, lambda: loose))


def unstretched_body_of(state: CarState, before: CarState | None = None) -> Body:
    """The body of a car as it is drawn, before it is brought to its dimensions.

    While a mark is dragged edits are not made again: what they have changed is carried along.
    """
    try:
        base = solved(state, before)
    except UserError as problem:
        if not (state.lock and state.dimensions.given()):
            raise
        loose = unstretched_body_of(replace(state, lock=False), before)
        return replace(loose, dimensions_problem=problem.message)
    if before is not None and state.edits and state.edits is before.edits:
        old = unstretched_body_of(before)
        if old.template is base.template and old.solved is not base:
            return _carried(old, _right_after(old.solved, before), _deformed(base, state))
    body = _right_after(base, state)
    for number, edit in enumerate(state.edits):
        work = partial(_edited, body, edit, number, state.smooth)
        body = _bodies.recall((body, _Same(edit), number, state.smooth), work)
    return body


class _Same:
    """Something that is equal to itself alone.

    To compare all samples of fifty strokes with those of the last time would take longer than
    to make one more edit.
    """

    __slots__ = ("own",)

    def __init__(self, own: object) -> None:
        self.own = own

    def __hash__(self) -> int:
        return id(self.own)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.own is self.own


# -- deformation -----------------------------------------------------------------------------------


def _right_after(base: Solved, state: CarState) -> Body:
    shape = (base, state.default_shape, state.annealed, state.smooth)
    return _bodies.recall(shape, lambda: _deformed(base, state))


def _deformed(base: Solved, state: CarState) -> Body:
    """The network right after deformation."""
    network = Network.of(base.template, base.positions)
    if state.annealed:
        network = annealed(network)
    if state.default_shape and base.joint is not None:
        network = pulled_out(network)
    return Body(ratio_locked(network) if state.smooth else network, base)


# -- edits -----------------------------------------------------------------------------------------


def in_world_of(body: Body, edit: BodyEdit) -> Network:
    """The network of a body, as it was drawn, in the dimensions of the time of an edit.

    Raises
    ------
    UserError
        If it cannot have them any more.
    """
    map_ = _map_to(body.network, edit.dimensions)
    return body.network if map_ is None else stretched(body.network, map_)


def _map_to(network: Network, wanted: Dimensions) -> Reshaping | None:
    if not wanted.given():
        return None
    return _maps.recall((network, wanted), partial(reshaping_of, network, wanted))


def drawn_through(body: Body, edit: TracedEdges) -> tuple[Array, Camera]:
    """The samples of a stroke (k, 2), px, and the camera through which they are seen.

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
    return stroke.points - placed.stand.shift, placed.stand.camera


def _edited(body: Body, edit: Edit, number: int, smooth: bool) -> Body:
    """A body after one more edit; the same, and why, where it cannot be made."""
    try:
        map_ = _map_to(body.network, edit.dimensions)
        there = body.network if map_ is None else stretched(body.network, map_)
        network, edges = _changed(there, edit, body)
    except UserError as problem:
        return replace(body, troubles=(*body.troubles, Trouble(number, problem.message)))
    in_hand = _with_images(body.template, edges)
    if smooth:
        network = ratio_locked(network, _firmness(body, in_hand))
    if map_ is not None:
        network = brought_back(body.network, there, network, map_)
    return replace(body, network=network, drawn=body.drawn | in_hand)


def _carried(old: Body, old_start: Body, start: Body) -> Body:
    """A body with the change that edits have made to another one of the same template."""
    positions, tangents = (
        getattr(start.network, what)
        + (getattr(old.network, what) - getattr(old_start.network, what))
        for what in ("positions", "tangents")
    )
    network = Network(start.template, positions, tangents)
    return replace(old, network=network, solved=start.solved)


def _changed(network: Network, edit: Edit, body: Body) -> tuple[Network, tuple[int, ...]]:
    """A network after an edit, and the edges that were drawn with it."""
    template = network.template
    if isinstance(edit, TracedEdges):
        points, camera = drawn_through(body, edit)
        edges = tuple(edge_called(template, name) for name in edit.edges)
        made = traced(network, points, camera, edges=edges, nodes_follow=edit.nodes_follow)
        return made.network, tuple(max(edge, ~edge) for edge in made.run.edges)
    if isinstance(edit, MovedNode):
        node = node_called(template, edit.node)
        return with_positions(network, {node: network.positions[node] + edit.by}), ()
    if isinstance(edit, BentEdge):
        edge = edge_called(template, edit.edge)
        return bent(network, edge, edit.end, edit.tangent), (edge,)
    if edit.kind == "anneal":
        return annealed(network), ()
    return (reduced(network) if edit.kind == "reduce" else pulled_out(network)), ()


def _with_images(template: Template, edges: tuple[int, ...]) -> frozenset[int]:
    image = template.mirrored_edges
    return frozenset(own for edge in edges for own in (edge, max(image[edge], ~image[edge])))


def _firmness(body: Body, in_hand: frozenset[int]) -> Array:
    firm = np.ones(len(body.template.edges))
    firm[list(body.drawn)] = DRAWN
    firm[list(in_hand)] = IN_HAND
    return firm


# -- dimensions ------------------------------------------------------------------------------------


def _finished(body: Body, wanted: Dimensions) -> Body:
    """The body with the dimensions that are wanted."""
    try:
        map_ = _map_to(body.network, wanted)
    except UserError as problem:
        return replace(body, dimensions_problem=problem.message)
    if map_ is None:
        return body
    return replace(body, network=stretched(body.network, map_), world=wanted)


def _seen_again(body: Body) -> dict[str, Stand]:
    """Where sketches stand that were drawn of this body before it was stretched."""
    stands: dict[str, Stand] = {}
    for key in body.solved.solid:
        placed = body.solved.placed[key]
        nodes, marks = counted_marks(placed, body.template)
        assert placed.resection is not None
        try:
            found = resect(
                body.network.positions[nodes], marks, placed.sketch.size,
                kind=placed.stand.camera.kind, cropped=placed.sketch.cropped,
                before=replace(placed.resection, disagreeing=()),
            )  # fmt: skip
        except UserError:
            continue  # marks that say too little of another body: it is seen as the one before
        stands[key] = Stand.behind(found.camera, found.shift, body.network.positions)
    return stands
