"""The body: the network of the solved car, what was done to it by hand, dimensions, and skin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.coons import coons_nets
from bozzetto.geometry.crease import crease_angles, locked
from bozzetto.geometry.patch import extent
from bozzetto.geometry.patchwork import Patchwork
from bozzetto.plugin import Memory
from bozzetto.view.calibration import resect
from bozzetto_car.chains import annealed, reduced
from bozzetto_car.default_shape import pulled_out
from bozzetto_car.dimensions import Dimensions, measured
from bozzetto_car.edges import (
    Network,
    edge_called,
    joints,
    node_called,
    with_positions,
    with_tangents,
)
from bozzetto_car.reshaping import Reshaping, reshaped
from bozzetto_car.solving import Solved, counted_marks, solved
from bozzetto_car.stand import Stand
from bozzetto_car.state import BentEdge, CarState, MovedNode, TracedEdges, Treatment
from bozzetto_car.template import Template
from bozzetto_car.tracing import traced

__all__ = ["Body", "Trouble", "body_of", "sides_of_patches"]

Array = NDArray[np.float64]
Edit = TracedEdges | MovedNode | BentEdge | Treatment

REMEMBERED: Final = 64
"""Bodies that are remembered: the last few, each after every edit."""


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
    stands : dict of str to Stand
        By the id of the sketch, as this body is seen through its camera.
    world, as_drawn : Dimensions
        Those that it was brought to, and those that it had before; none if it was not.
    troubles : tuple of Trouble
        Edits that were left out.
    dimensions_problem : str
        Why the dimensions that are wanted cannot be had; "" if they can.
    """

    network: Network
    solved: Solved
    stands: Mapping[str, Stand]
    world: Dimensions = Dimensions()
    as_drawn: Dimensions = Dimensions()
    troubles: tuple[Trouble, ...] = ()
    dimensions_problem: str = ""

    @property
    def template(self) -> Template:
        """Whose names its nodes, edges and patches have."""
        return self.network.template

    @cached_property
    def nets(self) -> Array:
        """Control nets of the patches, (k, 4, 4, 3) mm."""
        return coons_nets(self.network.control_points, sides_of_patches(self.template))

    @cached_property
    def patchwork(self) -> Patchwork:
        """The skin, with the names of the patches."""
        names = tuple(patch.name for patch in self.template.patches)
        return Patchwork(
            self.nets,
            self.network.control_points,
            sides_of_patches(self.template),
            self.template.title,
            patch_names=names,
        )

    @cached_property
    def creases(self) -> Array:
        """Degrees along each edge, (m,); NaN on the rim."""
        sides = sides_of_patches(self.template)
        return crease_angles(self.nets, sides, len(self.template.edges))

    @cached_property
    def dimensions(self) -> Dimensions:
        """As measured on the surface, mm."""
        return measured(extent(self.nets), *_wheels(self.network)[:, 0])


def sides_of_patches(template: Template) -> NDArray[np.int32]:
    """The signed edges round each patch, (k, 4)."""
    return np.array([patch.edges for patch in template.patches], np.int32)


_bodies: Memory[Body] = Memory(REMEMBERED)


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
        As of `solved`. An edit or a dimension that cannot be is left out, and told.
    """
    base = solved(state, before)
    key = (base, state.default_shape, state.annealed, state.smooth)
    body = _bodies.recall(key, lambda: _deformed(base, state))
    for number, edit in enumerate(state.edits):
        body = _bodies.recall(
            (*key, state.edits[: number + 1]), partial(_edited, body, edit, number, state.smooth)
        )
    return _bodies.recall(
        (*key, state.edits, state.dimensions), partial(_finished, body, state.dimensions)
    )


# -- deformation -----------------------------------------------------------------------------------


def _deformed(base: Solved, state: CarState) -> Body:
    """The network right after deformation."""
    network = Network.of(base.template, base.positions)
    if state.annealed:
        network = annealed(network)
    if state.default_shape and base.joint is not None:
        network = pulled_out(network)
    stands = {key: placed.stand for key, placed in base.placed.items()}
    return Body(_smooth(network) if state.smooth else network, base, stands)


def _smooth(network: Network) -> Network:
    """With tangents as long as smooth surfaces need them; see `crease.locked`."""
    template = network.template
    # Of each joint the two edges, each as it leaves the node.
    row = tuple(
        (_leaving(*joint.before), _leaving(*joint.after)) for joint in joints(template)
    )  # fmt: skip
    points = locked(network.control_points, sides_of_patches(template), row)
    return Network.from_control_points(template, network.positions, points)


def _leaving(edge: int, end: int) -> int:
    return ~edge if end else edge


# -- edits -----------------------------------------------------------------------------------------


def _edited(body: Body, edit: Edit, number: int, smooth: bool) -> Body:
    """A body after one more edit; the same, and why, where it cannot be made."""
    try:
        there = _brought(body, edit.dimensions)
        network = _changed(there, edit)
    except UserError as problem:
        return replace(body, troubles=(*body.troubles, Trouble(number, problem.message)))
    return replace(there, network=_smooth(network) if smooth else network)


def _changed(body: Body, edit: Edit) -> Network:
    network, template = body.network, body.template
    if isinstance(edit, TracedEdges):
        stroke = edit.strokes[0]
        camera, points = stroke.camera, stroke.points
        if edit.sketch:
            stand = body.stands.get(edit.sketch)
            if stand is None:
                raise UserError("The sketch on which an edge was traced is gone.")
            camera, points = stand.camera, points - stand.shift
        return traced(network, points, camera, nodes_follow=edit.nodes_follow).network
    if isinstance(edit, MovedNode):
        node = node_called(template, edit.node)
        return with_positions(network, {node: network.positions[node] + edit.by})
    if isinstance(edit, BentEdge):
        return with_tangents(network, {(edge_called(template, edit.edge), edit.end): edit.tangent})
    if edit.kind == "anneal":
        return annealed(network)
    return reduced(network) if edit.kind == "reduce" else pulled_out(network)


# -- dimensions ------------------------------------------------------------------------------------


def _finished(body: Body, wanted: Dimensions) -> Body:
    """The body with the dimensions that are wanted, and where its sketches stand then."""
    try:
        made = _brought(body, wanted)
    except UserError as problem:
        return replace(body, dimensions_problem=problem.message)
    return made if made is body else replace(made, stands=_seen_again(made))


def _brought(body: Body, wanted: Dimensions) -> Body:
    """A body brought to dimensions, or back to those as drawn if none are given."""
    if not wanted.given():
        if not body.world.given():
            return body
        return replace(body, network=_stretched(body, body.as_drawn), world=Dimensions())
    as_drawn = body.as_drawn if body.world.given() else body.dimensions
    return replace(body, network=_stretched(body, wanted), world=wanted, as_drawn=as_drawn)


def _stretched(body: Body, wanted: Dimensions) -> Network:
    """Its network with other dimensions."""
    network, template = body.network, body.template
    sides = sides_of_patches(template)

    def box_after(map_: Reshaping) -> Array:
        return extent(coons_nets(map_.points(network.control_points), sides))

    made = reshaped(wanted, extent(body.nets), _wheels(network)[:, 0], box_after)
    if made is None:
        return network
    positions = made.nodes(template, network.positions)
    points = made.points(network.control_points)
    return Network.from_control_points(template, positions, points)


def _seen_again(body: Body) -> dict[str, Stand]:
    """Where sketches stand that were drawn of this body before it was stretched."""
    stands, solved_ = dict(body.stands), body.solved
    for key in solved_.solid:
        placed = solved_.placed[key]
        nodes, marks = counted_marks(placed, body.template)
        try:
            found = resect(
                body.network.positions[nodes], marks, placed.sketch.size,
                kind=placed.stand.camera.kind, cropped=placed.sketch.cropped,
            )  # fmt: skip
        except UserError:
            continue  # marks that say too little of another body: it is seen as the one before
        stands[key] = Stand.behind(found.camera, found.shift, body.network.positions)
    return stands


def _wheels(network: Network) -> Array:
    """Centres of the right wheels, front and rear, (2, 3) mm."""
    return np.asarray(network.positions[network.template.wheels[:, 0]])
