"""From marks to the car: the cameras of all sketches, and the shape, solved together.

First the camera of every sketch from the template as it stands, then all cameras and the shape
in one (`joint`). A mark that the rest contradicts is set aside and all is solved again: it
would take the shape along. The same marks give the same car; a solve that was made already is
remembered, and one that starts from the car before a drag is quicker, no other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.coons import coons_nets
from bozzetto.geometry.patch import extent
from bozzetto.plugin import Memory, switched_on
from bozzetto.view.calibration import Resection, resect
from bozzetto_car.deformation import Cost
from bozzetto_car.dimensions import Overlap
from bozzetto_car.edges import Network
from bozzetto_car.joint import Joint, solve
from bozzetto_car.marked_view import MOST_VIEWS, MarkedView
from bozzetto_car.soundness import Soundness
from bozzetto_car.stand import Stand, flat_stand
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.template import MIRROR, Template
from bozzetto_car.template_file import bundled, read_template

__all__ = ["Placed", "Solved", "counted_marks", "solved", "template_of"]

Array = NDArray[np.float64]

FEWEST: Final = 6
"""Marks from which the camera of a sketch can be found."""

SURPRISING: Final = 6.0
"""Standard deviations by which a mark must be off what is expected without it to be set aside."""

FAR_OFF: Final = 0.01
"""And by how much of the picture's diagonal: 14 px of 1200 × 800."""

MOST_ASIDE: Final = 3
"""Most marks of a car that are set aside; of more, none tells which are right."""

EXCHANGED: Final = 10.0
"""By how much the car seen in a mirror must fit better for its sides to be exchanged (Bayesian
information criterion; beyond doubt)."""

REMEMBERED: Final = 32
"""Solves that are remembered."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A sketch with its camera.

    Attributes
    ----------
    sketch : Sketch
    stand : Stand
        Where it stands in space; upright beside the car while its camera is not known.
    resection : Resection or None
        The camera as the template has it; None where it cannot be found.
    missed : mapping of str to float
        By node: distance of its mark from where it is seen, px.
    left_out : mapping of str to float
        By node: distance of its mark from where the others have it, px.
    disagreeing : tuple of str
        Nodes whose marks were set aside, the worst first.
    exchanged : bool
        The marks fit a car seen in a mirror: left and right are exchanged.
    problem : str
        Why its camera is not known, and what to do; "" if it is.
    """

    sketch: Sketch
    stand: Stand
    resection: Resection | None = None
    missed: Mapping[str, float] | None = None
    left_out: Mapping[str, float] | None = None
    disagreeing: tuple[str, ...] = ()
    exchanged: bool = False
    problem: str = ""

    @property
    def is_known(self) -> bool:
        """Whether its camera is."""
        return self.resection is not None


@dataclass(frozen=True, eq=False)
class Solved:
    """A car that has the shape of its sketches.

    Attributes
    ----------
    template : Template
    cost : Cost
    soundness : Soundness
    positions : (n, 3) float
        Of the nodes, mm; the template's where no sketch is solved.
    joint : Joint or None
        None where no sketch is solved.
    placed : mapping of str to Placed
        By the id of the sketch.
    solid : tuple of str
        Ids of the sketches that are solved, in the order of the joint's views.
    """

    template: Template
    cost: Cost
    soundness: Soundness
    positions: Array
    joint: Joint | None
    placed: Mapping[str, Placed]
    solid: tuple[str, ...]


_solves: Memory[Solved] = Memory(REMEMBERED)
_templates: Memory[Template] = Memory(8)


def template_of(state: CarState) -> Template:
    """The template of a car.

    Raises
    ------
    FormatError
        If its own is none.
    """
    if not state.own:
        return bundled(state.template)
    return _templates.recall(state.own, lambda: read_template(state.own.encode()))


def solved(state: CarState, before: CarState | None = None) -> Solved:
    """Cameras and shape of a car.

    Parameters
    ----------
    state : CarState
    before : CarState, optional
        The car as it was before one of its marks was dragged: where to start from. What is
        found then is not remembered.

    Raises
    ------
    UserError
        If dimensions that are to be kept contradict each other or the soundness of the car, or
        there are too many sketches.
    """
    key = _question(state)
    known = _solves.known(key)
    if known is not None:
        return known
    if before is not None:
        return _solved(state, solved(before))
    return _solves.recall(key, lambda: _solved(state, None))


def _question(state: CarState) -> tuple[object, ...]:
    """All that a solve depends on."""
    sketches = tuple(
        (s.id, s.size, s.marks, s.kind, s.cropped) for s in _taking_part(state)
    )  # fmt: skip
    locked = state.dimensions if state.lock else None
    shape = (state.own or state.template, state.trace, state.cost, state.without, locked)
    return (*shape, sketches)


def _taking_part(state: CarState) -> tuple[Sketch, ...]:
    return tuple(node for node in switched_on(state.nodes) if isinstance(node, Sketch))


def _solved(state: CarState, before: Solved | None) -> Solved:
    template = template_of(state)
    cost = Cost.paper(template) if state.cost == "paper" else Cost.balanced(state.trace)
    names = {*state.without}
    soundness = Soundness.of(template, without=names)
    placed = {s.id: _resected(s, template, before) for s in _taking_part(state)}
    solid = tuple(key for key, one in placed.items() if one.is_known)
    if len(solid) > MOST_VIEWS:
        raise UserError(
            f"A car can have {MOST_VIEWS} sketches at once. Hide the ones that help least."
        )
    nothing = Solved(template, cost, soundness, template.positions, None, placed, ())
    if not solid:
        return nothing
    start = None
    if before is not None and before.joint is not None and before.template is template:
        start = before.joint.variables
    locked = state.dimensions if state.lock and state.dimensions.given() else None
    aside: dict[str, tuple[str, ...]] = {
        key: () if before is None or key not in before.placed else before.placed[key].disagreeing
        for key in solid
    }
    while True:
        views = [_view(placed[key], template, aside[key], before) for key in solid]
        joint = solve(
            template, views, cost, soundness, start=start, locked=locked,
            overlap=_overlap(template) if locked else Overlap(),
            hold_cameras=state.cost == "paper",
        )  # fmt: skip
        worst = _contradicted(joint, views, template)
        if worst is None or sum(map(len, aside.values())) >= MOST_ASIDE:
            break
        number, name = worst
        aside[solid[number]] = (*aside[solid[number]], name)
        start = joint.variables
    positions = template.whole(joint.variables)
    for number, key in enumerate(solid):
        placed[key] = _told(placed[key], joint, number, template, positions, aside[key])
    return Solved(template, cost, soundness, positions, joint, placed, solid)


def _resected(sketch: Sketch, template: Template, before: Solved | None) -> Placed:
    """The camera of a sketch from the template as it stands."""
    nodes, places = counted_marks(Placed(sketch, flat_stand(sketch.size)), template)
    resumed = None if before is None else before.placed.get(sketch.id)
    marked = {template.names[node] for node in nodes}
    further = {
        name: place
        for name, place in zip(template.names, template.positions, strict=True)
        if name not in marked and name not in sketch.skipped
    }
    try:
        found = resect(
            template.positions[nodes], places, sketch.size, kind=sketch.kind,
            cropped=sketch.cropped, further=further,
            before=None if resumed is None else resumed.resection,
        )  # fmt: skip
    except UserError as problem:
        return Placed(sketch, flat_stand(sketch.size), problem=problem.message)
    stand = Stand.behind(found.camera, found.shift, template.positions)
    exchanged = before is None and _is_exchanged(sketch, template, nodes, places, found)
    return Placed(sketch, stand, found, exchanged=exchanged)


def _is_exchanged(
    sketch: Sketch, template: Template, nodes: NDArray[np.intp], places: Array, found: Resection
) -> bool:
    """Whether the marks fit the car as a mirror shows it."""
    if (template.mirrored[nodes] == nodes).all():
        return False
    try:
        other = resect(
            template.positions[nodes] * MIRROR, places, sketch.size, kind=sketch.kind,
            cropped=sketch.cropped,
        )  # fmt: skip
    except UserError:
        return False
    return min(other.scores.values()) < min(found.scores.values()) - EXCHANGED


def _view(
    placed: Placed, template: Template, aside: tuple[str, ...], before: Solved | None
) -> MarkedView:
    """A sketch as the solve takes it: the marks that count, and a camera to start from."""
    found = placed.resection
    assert found is not None
    camera, shift = found.camera, found.shift
    if before is not None and placed.sketch.id in before.solid:
        start = before.placed[placed.sketch.id].stand
        if start.camera.kind == camera.kind:
            camera, shift = start.camera, start.shift
    nodes, marks = counted_marks(replace(placed, disagreeing=aside), template)
    return MarkedView(camera, nodes, marks, shift, placed.sketch.cropped)


def counted_marks(placed: Placed, template: Template) -> tuple[NDArray[np.intp], Array]:
    """Nodes (k,) and marks (k, 2), px, of a sketch without those that were set aside."""
    marks = [
        mark
        for mark in placed.sketch.marks
        if mark.node in template.node and mark.node not in placed.disagreeing
    ]
    nodes = np.array([template.node[mark.node] for mark in marks], np.intp)
    return nodes, np.array([(mark.u, mark.v) for mark in marks], float).reshape(-1, 2)


def _contradicted(
    joint: Joint, views: list[MarkedView], template: Template
) -> tuple[int, str] | None:
    """The sketch and the node of the mark that surprises most, if it must be wrong."""
    worst, found = SURPRISING, None
    for number, (view, other) in enumerate(zip(views, joint.left_out, strict=True)):
        if len(view.nodes) <= FEWEST:
            continue  # so few marks fit whatever they are told
        far = FAR_OFF * np.hypot(*view.camera.viewport)
        surprise = np.where(other.missed > far, other.surprise, 0.0)
        if surprise.max() > worst:
            worst = float(surprise.max())
            found = number, template.names[view.nodes[int(surprise.argmax())]]
    return found


def _told(
    placed: Placed,
    joint: Joint,
    number: int,
    template: Template,
    positions: Array,
    aside: tuple[str, ...],
) -> Placed:
    """What a solve says of a sketch and its marks."""
    view = joint.views[number]
    stand = Stand.behind(view.camera, view.shift, positions)
    nodes, marks = counted_marks(placed, template)
    off = np.linalg.norm(stand.pixels(positions[nodes]) - marks, axis=1)
    missed = {template.names[n]: float(px) for n, px in zip(nodes, off, strict=True)}
    alone = zip(view.nodes, joint.left_out[number].missed, strict=True)
    others = {template.names[n]: float(px) for n, px in alone}
    # A mark that was set aside has no say: what it is missed by is what the others miss it by.
    others |= {name: missed[name] for name in aside}
    return replace(placed, stand=stand, missed=missed, left_out=others, disagreeing=aside)


def _overlap(template: Template) -> Overlap:
    """How far the template's surface bulges beyond its nodes; it hardly changes with the shape."""
    sides = np.array([patch.edges for patch in template.patches])
    box = extent(coons_nets(Network.of(template).control_points, sides))
    return Overlap.of(template, template.positions, box)
