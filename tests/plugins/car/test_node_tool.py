"""Nodes and tangents dragged through the tool: what follows, what adds up, what is revealed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Tap
from bozzetto.scene import Handle
from bozzetto.view import Camera
from bozzetto_car.body.build import body_of
from bozzetto_car.modeler import Car
from bozzetto_car.state import BentEdge, CarState, Mark, MovedNode, Treatment
from bozzetto_car.template.network import edge_called, junctions
from bozzetto_car.tools.shape_nodes import ShapeNodes
from bozzetto_car.view.scene import scene_of
from tests.plugins.car.marked_car import locked_creases, marked
from tests.plugins.car.traced_car import symmetric, view
from tests.previews import preview_of

TOOL, CONTEXT = ShapeNodes(), Context()
CAMERA = view(50.0, 12.0)


def place_of(state: CarState, handle: str) -> np.ndarray:
    """Where a handle of the scene is, mm."""
    (found,) = (
        item
        for layer in scene_of(state, body_of(state)).layers
        for item in layer.items
        if isinstance(item, Handle) and item.id == handle
    )
    return np.array(found.point)


def drag(
    state: CarState,
    handle: str,
    way: tuple[float, float],
    camera: Camera = CAMERA,
    grip: tuple[float, float] = (0.0, 0.0),
) -> Drag:
    """A handle dragged by so many pixels, taken hold of beside its middle."""
    start = camera.project(place_of(state, handle))[0][0] + grip
    path = start + np.linspace(0.0, 1.0, 9)[:, None] * way
    return Drag(handle, Stroke(path[:, 0], path[:, 1], camera))


def dragged(state: CarState, handle: str, way: tuple[float, float], **how: object) -> CarState:
    return TOOL.apply(state, drag(state, handle, way, **how), CONTEXT)  # type: ignore[arg-type]


@pytest.mark.parametrize("node", ["S3.R", "R2.R", "B3.R", "WF.R", "C3", "S3.L"])
@pytest.mark.parametrize("state", [CarState(), marked()], ids=["template", "sketch"])
def test_a_node_goes_with_the_pen_and_takes_its_image_along(state: CarState, node: str) -> None:
    before = body_of(state)
    old = place_of(state, f"node {node}")
    made = dragged(state, f"node {node}", (21.0, -9.0), grip=(8.0, -5.0))
    after, new = body_of(made), place_of(made, f"node {node}")
    moved = CAMERA.project(np.stack((old, new)))[0]
    assert np.abs(moved[1] - moved[0] - (21.0, -9.0)).max() < 0.01
    if node != "C3":  # parallel to the picture
        assert abs((new - old) @ CAMERA.axes[2]) < 1e-6
    else:
        assert new[1] == 0.0
    assert np.array_equal(after.network.tangents, before.network.tangents)
    assert symmetric(after.network)
    still = np.delete(
        np.arange(len(before.template.names)),
        [before.template.node[node], before.template.mirrored[before.template.node[node]]],
    )
    assert np.array_equal(after.network.positions[still], before.network.positions[still])


@pytest.mark.parametrize("handle", ["S3.R-S2.R 1", "R2.R-R1.R 0", "S3.R-B3.R 0", "C1-C2 1"])
@pytest.mark.parametrize("state", [CarState(), marked()], ids=["template", "sketch"])
def test_a_handle_bends_its_edge_and_smooth_neighbours_follow(state: CarState, handle: str) -> None:
    name, end = handle.split()
    state = replace(state, revealed=name)
    before = body_of(state)
    made = dragged(state, f"tangent {handle}", (-12.0, -15.0))
    after = body_of(made)
    old, new = place_of(state, f"tangent {handle}"), place_of(made, f"tangent {handle}")
    moved = CAMERA.project(np.stack((old, new)))[0]
    assert np.abs(moved[1] - moved[0] - (-12.0, -15.0)).max() < 0.1
    assert np.array_equal(after.network.positions, before.network.positions)
    assert symmetric(after.network)
    assert locked_creases(after).max() <= 0.1
    edge, tangents = edge_called(after.template, name), after.network.tangents
    for joint in junctions(after.template):
        if joint.crosses or (edge, int(end)) not in (joint.before, joint.after):
            continue
        one, other = (
            sense * tangents[place]
            for sense, place in zip(joint.senses, (joint.before, joint.after), strict=True)
        )
        assert np.linalg.norm(np.cross(one, other)) < 1e-9 * np.linalg.norm(one) ** 2
        assert one @ other > 0.0


def test_drags_of_the_same_handles_add_up() -> None:
    state = replace(CarState(), revealed="S3.R-S2.R")
    steps = ["node S3.R", "tangent S3.R-S2.R 0", "node S3.L", "node C3", "tangent S3.R-S2.R 0"]
    for number in range(20):
        state = dragged(state, steps[number % 5], (6.0, 4.0 if number % 2 else -5.0))
    nodes = [edit.node for edit in state.edits if isinstance(edit, MovedNode)]
    assert sorted(nodes) == ["C3", "S3.R"]
    assert sum(isinstance(edit, BentEdge) for edit in state.edits) == 1
    assert not body_of(state).troubles


def test_to_and_fro_is_nothing() -> None:
    state = CarState()
    there = dragged(state, "node S4.R", (25.0, 11.0))
    back = dragged(there, "node S4.R", (-25.0, -11.0))
    assert len(back.edits) == 1
    away = body_of(back).network.positions - body_of(state).network.positions
    assert np.abs(away).max() < 0.01


def test_before_a_treatment_or_in_other_dimensions_a_drag_is_another_one() -> None:
    state = dragged(CarState(), "node S4.R", (25.0, 11.0))
    treated = replace(state, edits=(*state.edits, Treatment(kind="anneal")))
    assert len(dragged(treated, "node S4.R", (5.0, 5.0)).edits) == 3
    longer = replace(state, length=5000.0)
    assert len(dragged(longer, "node S4.R", (5.0, 5.0)).edits) == 2


def test_under_dimensions_that_no_car_has_a_drag_goes_with_the_pen_all_the_same() -> None:
    """The body is shown without them then, and so it is dragged; it went eight times as far."""
    state = replace(marked(), height=200.0, lock=True)
    before = body_of(state)
    assert before.dimensions_problem
    after = body_of(dragged(state, "node R2.R", (10.0, -20.0)))
    node = before.template.node["R2.R"]
    seen = [CAMERA.project(body.network.positions[node])[0][0] for body in (before, after)]
    assert seen[1] - seen[0] == pytest.approx([10.0, -20.0], abs=0.5)
    others = np.arange(len(before.template.names)) != node
    others[before.template.mirrored[node]] = False
    assert after.network.positions[others] == pytest.approx(before.network.positions[others])


def test_a_touch_reveals_the_tangents_of_a_node_or_an_edge() -> None:
    state = CarState()
    network = body_of(state).network

    def touch(place: np.ndarray, beside: float = 4.0) -> CarState:
        x, y = CAMERA.project(place)[0][0] + beside
        return TOOL.apply(state, Tap(float(x), float(y), CAMERA), CONTEXT)

    node = touch(network.positions[network.template.node["S3.R"]])
    assert node.revealed == "S3.R"
    points = network.control_points[edge_called(network.template, "S3.R-B3.R")]
    middle = (points[0] + 3 * points[1] + 3 * points[2] + points[3]) / 8
    assert touch(middle).revealed == "S3.R-B3.R"
    assert TOOL.apply(node, Tap(3.0, 3.0, CAMERA), CONTEXT).revealed == ""
    ends = np.flatnonzero((network.template.edges == network.template.node["S3.R"]).any(axis=1))
    layers = {layer.name: layer for layer in scene_of(node, body_of(node)).layers}
    shown = [i.id for i in layers["handles"].items if isinstance(i, Handle)]
    assert layers["handles"].tool == TOOL.id
    assert sum(id.startswith("tangent ") for id in shown) == len(ends)
    assert sum(id.startswith("node ") for id in shown) == len(network.template.names)


def test_a_handle_that_is_only_touched_moves_nothing_and_is_a_choice() -> None:
    state = CarState()
    still = dragged(state, "node S2.R", (1.0, -1.0))
    assert still.edits == ()
    assert still.revealed == "S2.R"
    car = Car()
    assert car.with_parts(still, still.nodes, "") == car.with_parts(state, state.nodes, "")


def test_the_preview_is_the_body_that_comes() -> None:
    state = replace(marked(), revealed="S3.R-S2.R")
    for handle in ("node S3.R", "tangent S3.R-S2.R 1"):
        gesture = drag(state, handle, (15.0, -12.0))
        shown = {layer.name: layer for layer in preview_of(TOOL, state, gesture, CONTEXT).layers}
        made = TOOL.apply(state, gesture, CONTEXT)
        whole = {layer.name: layer for layer in scene_of(made, body_of(made)).layers}
        for name in ("body", "network", "handles"):
            one, other = shown[name].items[0], whole[name].items[0]
            what = "mesh" if name == "body" else "points"
            a, b = getattr(one, what), getattr(other, what)
            a, b = (a.vertices, b.vertices) if name == "body" else (a, b)
            assert np.array_equal(a, b)


@pytest.mark.parametrize("handle", ["node Z9", "tangent S3.R-S2.R 7", "tangent 0", "mark C1", ""])
def test_handles_that_are_none_of_the_body_are_told(handle: str) -> None:
    gesture = Drag(handle, Stroke([10.0, 90.0], [10.0, 40.0], CAMERA))
    with pytest.raises(UserError):
        TOOL.apply(CarState(), gesture, CONTEXT)
    assert not preview_of(TOOL, CarState(), gesture, CONTEXT).layers


def test_there_is_no_body_to_work_on_while_the_camera_is_unknown() -> None:
    sketch = replace(marked().sketches[0], marks=(Mark("C1", 300.0, 400.0),))
    with pytest.raises(UserError, match="Mark its points first"):
        TOOL.apply(CarState().with_node(sketch), Tap(600.0, 400.0, CAMERA), CONTEXT)


def test_wild_drags_give_a_finite_car_or_a_message() -> None:
    rng, state = np.random.default_rng(5), CarState()
    handles = ["node S3.R", "node C5", "node WR.L", "tangent S3.R-S2.R 0", "tangent S3.R-S2.R 1"]
    for trial in range(60):
        camera = view(rng.uniform(-180, 180), rng.uniform(-80, 80))
        state = replace(state, revealed="S3.R-S2.R")
        way = rng.normal(0.0, 10.0 ** rng.uniform(0, 5), 2)
        try:
            state = dragged(state, handles[trial % 5], (way[0], way[1]), camera=camera)
        except UserError:
            continue
        body = body_of(state)
        assert np.isfinite(body.network.control_points).all()
        assert symmetric(body.network)
