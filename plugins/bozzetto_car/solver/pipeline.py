"""From marks to the car: solve the cameras of all sketches and the shape together.

First the camera of every sketch is found from the template (`initial_cameras`); then how far the
car is from the template, and which marks are wrong and would distort the shape
(`hyperparameters`); then all cameras and the shape in one (`bundle_adjustment`). The same marks
give the same car, and solves are remembered. A solve that starts from the car before a drag is
quicker.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry.patches import extent
from bozzetto.plugin import remembered
from bozzetto_car.camera.marked_view import MOST_VIEWS, MarkedView
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.dimensions import Overlap
from bozzetto_car.listening import look
from bozzetto_car.solver.bundle_adjustment import JointSolution, solve
from bozzetto_car.solver.hyperparameters import Weighed, judge_marks
from bozzetto_car.solver.initial_cameras import (
    Placed,
    counted_marks,
    marks_of,
    place_sketch,
    view_of,
)
from bozzetto_car.solver.nodes_on_mesh import nodes_on_mesh
from bozzetto_car.solver.prior import Cost
from bozzetto_car.solver.stroke_ends import sharpened
from bozzetto_car.state import TRACE, CarMesh, CarState, Sketch
from bozzetto_car.template.blend import blended, can_blend
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import TEMPLATES, bundled, read_template
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network
from bozzetto_car.template.shape_constraints import Soundness

REMEMBERED: Final = 32
"""Number of solves that are remembered."""

FRAMES: Final = 4
"""Number of frames of a drag that are remembered: each is asked for more than once."""


@dataclass(frozen=True, eq=False)
class Solved:
    """A car with the shape and the cameras of its sketches.

    Attributes
    ----------
    template : Template
    cost : Cost
    soundness : Soundness
    positions : (n, 3) float
        Places of the nodes, mm; the template's where no sketch is solved.
    joint : JointSolution or None
        None where no sketch is solved.
    placed : mapping of str to Placed
        By the id of the sketch.
    solid : tuple of str
        Ids of the sketches that are solved, in the order of the joint's views.
    mesh : CarMesh or None
        The mesh whose shape the car takes, if it has a marked point.
    """

    template: Template
    cost: Cost
    soundness: Soundness
    positions: Array
    joint: JointSolution | None
    placed: Mapping[str, Placed]
    solid: tuple[str, ...]
    mesh: CarMesh | None = None


def template_of(state: CarState) -> Template:
    """Return the template of a car, which may lie between two.

    Raises
    ------
    UserError
        If the car has no template of its own where that is wanted, or none that can be read.
    """
    first = _first_template(state)
    return first if state.blend == "none" else _blended(first, state.blend, state.share)


def blend_problem(state: CarState) -> str:
    """Return why the template of a car is not blended with another one; "" if it is, or need not.

    Raises
    ------
    UserError
        As `template_of` does.
    """
    first = _first_template(state)
    if state.blend == "none" or can_blend(first, bundled(state.blend)):
        return ""
    second = bundled(state.blend)
    like = [bundled(name) for name in TEMPLATES if can_blend(first, bundled(name))]
    names = ", ".join(one.title for one in like if one is not first)
    return (
        f"{first.article.capitalize()} {first.noun} and {second.article} {second.noun} have other "
        f"points, so they are not blended. Blend with one of these: {names}."
    )


def _first_template(state: CarState) -> Template:
    if state.template != "own":
        return bundled(state.template)
    return _own_template(state.template_source)


@remembered(limit=REMEMBERED)
def _blended(first: Template, name: str, share: float) -> Template:
    second = bundled(name)
    return blended(first, second, share) if can_blend(first, second) else first


@remembered(limit=8)
def _own_template(text: str) -> Template:
    return read_template(text.encode())


def solve_car(state: CarState, before: CarState | None = None) -> Solved:
    """Solve the cameras and the shape of a car.

    Parameters
    ----------
    state : CarState
        The car.
    before : CarState, optional
        The car as it was before one of its marks was dragged. A start from it is quicker. A mark
        that was aside there comes back later than it went, so that none flickers. The answer is
        remembered for this pair of states only.

    Raises
    ------
    UserError
        If dimensions that are to be kept contradict each other or the soundness of the car, or
        there are too many sketches.
    """
    key = _question(state)
    if before is None or key == (start := _question(before)):
        return _from_nothing(key, state)
    return _from_before((key, start), state, before)


@remembered(limit=REMEMBERED, key=lambda question, state: question)
def _from_nothing(question: Hashable, state: CarState) -> Solved:
    return _as_marked(_solved(state, None), state)


@remembered(limit=FRAMES, key=lambda questions, state, before: questions)
def _from_before(questions: Hashable, state: CarState, before: CarState) -> Solved:
    return _as_marked(_solved(state, solve_car(before)), state)


def _question(state: CarState) -> tuple[object, ...]:
    """Return all that a solve depends on, as a key."""
    sketches = tuple((sketch.id, *marks_of(sketch)) for sketch in _taking_part(state))
    locked = state.dimensions if state.lock else None
    own = state.own if state.template == "own" else state.template
    blend = None if state.blend == "none" else (state.blend, state.share)
    shape = (own, blend, state.trace, state.cost, state.without, locked)
    return (*shape, sketches, state.mesh)


def _taking_part(state: CarState) -> tuple[Sketch, ...]:
    """Return the sketches with what marks and strokes tell of the nodes."""
    sketches = state.shown(Sketch)
    if state.cost == "paper" or not state.edits:
        return sketches
    return tuple(sharpened(sketch, state.edits) for sketch in sketches)


def _as_marked(solved: Solved, state: CarState) -> Solved:
    """Return a solved car whose sketches have the marks as a person has set them."""
    own = {sketch.id: sketch for sketch in state.shown(Sketch)}
    placed = {}
    for key, one in solved.placed.items():
        placed[key] = one
        if one.sketch.marks != own[key].marks:
            placed[key] = replace(one, sketch=own[key], told=one.sketch)
            if key in solved.solid:
                missed = _missed(placed[key], solved.template, solved.positions)
                placed[key] = replace(placed[key], missed=missed)
    return replace(solved, placed=placed)


def _solved(state: CarState, before: Solved | None) -> Solved:
    template = template_of(state)
    cost = Cost.paper(template) if state.cost == "paper" else Cost.balanced(state.trace)
    names = {*state.without}
    soundness = Soundness.of(template, without=names)
    if before is not None and before.template is not template:
        before = None
    last = {} if before is None else {key: one.as_told for key, one in before.placed.items()}
    placed = {
        s.id: place_sketch(template, s, last[s.id])
        if s.id in last
        else replace(_placed(template, s), sketch=s)  # what is remembered may have another name
        for s in _taking_part(state)
    }
    solid = tuple(key for key, one in placed.items() if one.is_known)
    if len(solid) > MOST_VIEWS:
        raise UserError(
            f"A car can have {MOST_VIEWS} sketches at once. Hide the ones that help least."
        )
    if not solid:
        mesh = state.mesh if state.mesh is not None and state.mesh.points else None
        nodes = template.positions if mesh is None else nodes_on_mesh(template, mesh)
        return Solved(template, cost, soundness, nodes, None, placed, (), mesh)
    if before is None and state.cost != "paper":
        usual = _put_in_perspective(state, template, soundness, placed)
        if usual is not None and state.trace == TRACE:
            return usual
    return _solved_as_placed(state, template, cost, soundness, placed, before)


def _put_in_perspective(
    state: CarState, template: Template, soundness: Soundness, placed: dict[str, Placed]
) -> Solved | None:
    """Place sketches in perspective that the template's camera has taken for orthographic.

    Returns the car with the slider where it stands at first; None if no sketch was in doubt.

    What the car differs by from the template hides a perspective from the template's camera, and
    not from the car's. It is worth its parameter by the Bayesian information criterion, in which
    the cost stands for twice the logarithm of the probability; the slider has no say. A sketch in
    perspective that is solved as an orthographic one loses half of the shape, and next to nothing
    is lost the other way round.
    """
    usual = Cost.balanced()
    flat: Solved | None = None
    for key, one in list(placed.items()):
        if not one.is_known or one.sketch.kind != "auto" or not _is_flat(one):
            continue
        other = _placed(template, replace(one.sketch, kind="perspective"))
        if not other.is_known or other.disagreeing or _is_flat(other):
            continue
        changed = placed | {key: replace(other, sketch=one.sketch)}
        state = replace(state, trace=TRACE)
        try:
            flat = flat or _solved_as_placed(state, template, usual, soundness, {**placed}, None)
            deep = _solved_as_placed(state, template, usual, soundness, {**changed}, None)
        except UserError:  # it is told where the car itself is solved
            continue
        assert flat.joint is not None
        assert deep.joint is not None
        if deep.joint.cost + np.log(2 * len(one.sketch.marks)) < flat.joint.cost:
            placed[key], flat = changed[key], deep
    return flat


def _is_flat(placed: Placed) -> bool:
    """Whether the camera that the template has for a sketch is orthographic."""
    return placed.resection is not None and placed.resection.camera.kind == "orthographic"


def _solved_as_placed(
    state: CarState,
    template: Template,
    cost: Cost,
    soundness: Soundness,
    placed: dict[str, Placed],
    before: Solved | None,
) -> Solved:
    """Return the car of sketches with the kinds of cameras with which they are placed."""
    last = {} if before is None else before.placed
    solid = tuple(key for key, one in placed.items() if one.is_known)
    start = None
    if before is not None and before.joint is not None:
        start = before.joint.variables
    locked = state.dimensions if state.lock and state.dimensions.given() else None
    views = [_view(placed[key], template) for key in solid]
    were_aside = tuple(last[key].disagreeing if key in last else () for key in solid)
    judged = _judged(template, tuple(placed[key] for key in solid), were_aside)
    views = [view.only(flags) for view, flags in zip(views, judged.counted, strict=True)]
    if state.cost != "paper":
        pairs = zip(solid, views, strict=True)
        views = [_resumed(placed[key], view, before) for key, view in pairs]
        # Who wants the marks traced more exactly than by default wants their noise, too.
        exact = min(1.0, (1.0 - state.trace) / (1.0 - TRACE))
        cost = cost.toward(judged.cost, exact).unsteady(judged.hand**exact)
    joint = solve(
        template, views, cost, soundness, start=start, locked=locked,
        overlap=_overlap(template) if locked else Overlap(),
        hold_cameras=state.cost == "paper", rough=start is not None,
    )  # fmt: skip
    positions = template.whole(joint.variables)
    for number, (key, flags) in enumerate(zip(solid, judged.counted, strict=True)):
        nodes = counted_marks(placed[key], template)[0][~flags].tolist()
        aside = (*placed[key].disagreeing, *(template.names[node] for node in nodes))
        placed[key] = _with_residuals(placed[key], joint, number, template, positions, aside)
    return Solved(template, cost, soundness, positions, joint, placed, solid)


@remembered(
    limit=REMEMBERED,
    key=lambda template, sketch: (template, sketch.id, *marks_of(sketch), sketch.skipped),
)
def _placed(template: Template, sketch: Sketch) -> Placed:
    """Return a sketch with the camera that the template gives it; dimensions have no say in it."""
    look()
    return place_sketch(template, sketch)


@remembered(
    limit=REMEMBERED,
    key=lambda template, sketches, aside: (template, *(one.resection for one in sketches), aside),
)
def _judged(
    template: Template, sketches: tuple[Placed, ...], aside: tuple[tuple[str, ...], ...]
) -> Weighed:
    """Weigh the marks of sketches, of which some were aside before one of them was dragged.

    Neither the balance of marks and template nor dimensions have a say in it.
    """
    views = [_view(placed, template) for placed in sketches]
    return judge_marks(template, views, [
        _among(view, template, names) for view, names in zip(views, aside, strict=True)
    ])  # fmt: skip


@remembered(limit=REMEMBERED, key=lambda placed, template: (template, placed.resection))
def _view(placed: Placed, template: Template) -> MarkedView:
    """Return a sketch as it was placed; the very same as long as none of its marks moves."""
    return view_of(placed, template)


def _resumed(placed: Placed, view: MarkedView, before: Solved | None) -> MarkedView:
    """Return a sketch with the camera of the last solve, which is nearer than the template's."""
    if before is None or placed.sketch.id not in before.solid:
        return view
    start = before.placed[placed.sketch.id].sketch_camera
    return view.turned(start.camera, start.shift) if start.camera.kind == view.camera.kind else view


def _among(view: MarkedView, template: Template, names: tuple[str, ...]) -> Flags:
    """Which marks of a sketch, (k,), are those of the nodes that are named."""
    return np.array([template.names[node] in names for node in view.nodes.tolist()], bool)


def _with_residuals(
    placed: Placed,
    joint: JointSolution,
    number: int,
    template: Template,
    positions: Array,
    aside: tuple[str, ...],
) -> Placed:
    """Return a sketch with its camera, and with the residuals of its marks, after a solve."""
    view = joint.views[number]
    sketch_camera = SketchCamera.behind(view.camera, view.shift, positions)
    missed = _missed(replace(placed, sketch_camera=sketch_camera), template, positions)
    alone = zip(view.nodes, joint.left_out[number].missed, strict=True)
    others = {template.names[n]: float(px) for n, px in alone}
    # A mark that was set aside does not count, so its residual is that of the others' place.
    others |= {name: missed[name] for name in aside if name in missed}
    aside = tuple(sorted(aside, key=lambda name: -missed.get(name, np.inf)))
    return replace(
        placed, sketch_camera=sketch_camera, missed=missed, left_out=others, disagreeing=aside
    )


def _missed(placed: Placed, template: Template, positions: Array) -> dict[str, float]:
    """Return the distance of each mark of a sketch from where its camera sees the node, px."""
    nodes, marks = counted_marks(replace(placed, disagreeing=()), template)
    off = np.linalg.norm(placed.sketch_camera.pixels(positions[nodes]) - marks, axis=1)
    # A node behind the eye is seen nowhere, so its mark has no distance.
    named = [(template.names[n], float(px)) for n, px in zip(nodes, off, strict=True)]
    return {name: px for name, px in named if np.isfinite(px)}


def _overlap(template: Template) -> Overlap:
    """Return how far the template's surface bulges beyond its nodes, which hardly changes."""
    box = extent(fair_nets(Network.of(template)))
    return Overlap.of(template, template.positions, box)
