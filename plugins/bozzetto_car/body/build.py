"""Build the body: the network of the solved car, the edits by hand, its dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_car.body.body import REMEMBERED, Body
from bozzetto_car.body.chain_smoothing import (
    lock_ratios,
    own_edges,
    smooth_parts,
    with_one_curvature,
)
from bozzetto_car.body.deformed import deformed, right_after
from bozzetto_car.body.edit_row import edited, firmness, left_alone, with_images, with_strokes
from bozzetto_car.body.edits_preview import carried_body
from bozzetto_car.body.reshaped import brought_to
from bozzetto_car.body.space_edits import moved_for
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.solver.nodes_on_mesh import FEWEST
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.state import CarState, TracedEdges
from bozzetto_car.template.blend import can_blend
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import edge_called


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
    return _flowing(brought_to(body, wanted), state.flowing, state.smooth)


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
        network = lock_ratios(network, firmness(body, with_images(body.template, tuple(held))))
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
            start = deformed(base, state)
            return carried_body(old, right_after(old.solved, before), start, before)
    body = right_after(base, state)
    strokes: tuple[int, ...] = ()
    made = 0
    for number, edit in enumerate(state.edits):
        if isinstance(edit, TracedEdges):
            strokes, made = (*strokes, number), made + 1
            continue
        if made:
            body, made = with_strokes(body, state, strokes), 0
        body = edited(body, edit, number, state.smooth, moved_for(edit, body, state))
        strokes = left_alone(strokes, edit, state.edits, body.template)
    return with_strokes(body, state, strokes) if made else body
