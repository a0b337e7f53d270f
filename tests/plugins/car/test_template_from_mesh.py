"""A template from the mesh of a car whose points are marked, by pen and by names in its file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Surface, closest_on_mesh
from bozzetto.geometry.patches import bernstein, shaded
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto.scene import Handle
from bozzetto.view import Camera, triple
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.body.edges_on_mesh import network_on_mesh
from bozzetto_car.commands import car_as_template
from bozzetto_car.marking.points_on_mesh import nodes_to_mark
from bozzetto_car.marking.standing_mesh import standing_mesh
from bozzetto_car.modeler import Car
from bozzetto_car.panel.view_model import guide_of
from bozzetto_car.solver.pipeline import template_of
from bozzetto_car.state import CarState
from bozzetto_car.template.loader import bundled, read_template
from bozzetto_car.tools.mark_points import MarkPoints
from bozzetto_car.view.scene import scene_of

Array = NDArray[np.float64]

VIEWS = {
    "side": (90.0, 4.0),
    "front": (25.0, 20.0),
    "rear": (150.0, 20.0),
}
"""Azimuth (0 looks at the nose, 90 at the right side) and elevation, degrees."""


def mesh_of(body: Body, fineness: int = 24) -> Mesh:
    made = shaded(body.patchwork, fineness)
    return Mesh(made.vertices, made.faces)


def looking_from(azimuth: float, elevation: float, middle: Array) -> Camera:
    turn, rise = np.radians(azimuth), np.radians(elevation)
    way = np.array([-np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])
    return Camera(
        "perspective", triple(middle + 9000.0 * way), triple(middle), fov_y=35.0,
        viewport=(1200.0, 800.0),
    )  # fmt: skip


def true_places(state: CarState, body: Body, mesh: Mesh) -> dict[str, Array]:
    """Where the nodes of a body are on its mesh, as it stands now."""
    assert state.mesh is not None
    shift = state.mesh.mesh.vertices[0].astype(float) - mesh.vertices[0]
    names = nodes_to_mark(template_of(state))
    return {name: body.network.positions[body.template.node[name]] + shift for name in names}


def marked_by_pen(state: CarState, body: Body, mesh: Mesh) -> CarState:
    """Touch every point that is asked for, in the first of three views that shows it there."""
    tool = MarkPoints()
    for node in nodes_to_mark(template_of(state)):
        place = true_places(state, body, mesh)[node]
        assert state.mesh is not None
        middle = state.mesh.mesh.bounds.mean(axis=0)
        for view in VIEWS.values():
            camera = looking_from(*view, middle)
            ((u, v),) = camera.project(place[None])[0].tolist()
            try:
                there = tool.tap(replace(state, asked=node), Tap(u, v, camera), Context())
            except UserError:
                continue
            assert there.mesh is not None
            point = there.mesh.point_of(node)
            assert point is not None
            # Otherwise something that lies before it was touched: a person looks from elsewhere.
            far = np.linalg.norm(point.place - true_places(there, body, mesh)[node])
            if node.startswith("W") or far < 15.0:
                state = there
                break
    return state


@pytest.mark.parametrize(
    ("kind", "template"), [("coupe", "sedan"), ("suv", "hatchback"), ("limousine", "pickup")]
)
def test_a_body_of_another_kind_marked_in_three_views(kind: str, template: str) -> None:
    """Nodes are within a few mm, edges and surfaces lie on the mesh, and it becomes a template.

    How far within the car wheels stand is the template's, and 4 cm are its difference here.
    """
    body = body_of(CarState(template=kind))  # type: ignore[arg-type]
    mesh = mesh_of(body)
    state = Car().read_shapes(Shapes(surfaces=(Surface(mesh),)))
    state = CarState(nodes=state.nodes, template=template)  # type: ignore[arg-type]
    state = marked_by_pen(state, body, mesh)
    true = true_places(state, body, mesh)
    made = body_of(state)
    assert state.mesh is not None
    # The mesh has no wheels, so it stands where those of the template do.
    front = made.template.wheels[0, 0]
    assert made.network.positions[front, 2] == pytest.approx(made.template.positions[front, 2])
    off = {
        name: float(np.linalg.norm(made.network.positions[made.template.node[name]] - place))
        for name, place in true.items()
    }
    on_body = [far for name, far in off.items() if not name.startswith("W")]
    assert np.median(on_body) < 1.0
    assert max(on_body) < 15.0
    assert max(far for name, far in off.items() if name.startswith("W")) < 45.0
    along = (bernstein(np.linspace(0.0, 1.0, 17)) @ made.network.control_points).reshape(-1, 3)
    assert np.percentile(closest_on_mesh(state.mesh.mesh, along).distances, 95) < 5.0
    places = shaded(made.patchwork, 12).vertices
    far = closest_on_mesh(state.mesh.mesh, places).distances
    assert np.median(far) < 2.0
    assert np.percentile(far, 95) < 25.0
    again = read_template(car_as_template(state, "Found car"))
    assert again.title == "Found car"
    assert np.abs(again.positions - made.network.positions).max() < 1e-9


def boxes_at(places: dict[str, Array]) -> tuple[Surface, ...]:
    """A small tetrahedron about each place, called like the node."""
    corners = np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], float)
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], np.int32)
    return tuple(
        Surface(Mesh((place + 5.0 * corners).astype(np.float32), faces), name)
        for name, place in places.items()
    )


def test_points_that_the_file_names_on_a_mesh_that_lies_anywhere() -> None:
    """Whichever way nose and roof look, as cars lie in other programs."""
    body = body_of(CarState(template="coupe"))
    template = bundled("sedan")
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    origin = np.array([400.0, -9000.0, 120.0])
    mesh = mesh_of(body)
    moved = Mesh((mesh.vertices @ turn.T + origin).astype(np.float32), mesh.faces)
    names = [*nodes_to_mark(template)]
    true = {name: body.network.positions[body.template.node[name]] for name in names}
    named = {name.removesuffix(".R"): turn @ place + origin for name, place in true.items()}
    about, side = np.diag([-1.0, -1.0, 1.0]), np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    for further in (np.eye(3), about, side, -side @ about, side @ turn):
        further = further * np.linalg.det(further)
        parts = boxes_at({name: further @ place for name, place in named.items()})
        whole = Mesh((moved.vertices @ further.T).astype(np.float32), moved.faces)
        car = standing_mesh(Shapes(surfaces=(Surface(whole, "body"), *parts)), "n1", "Mesh")
        assert len(car.points) == len(names)
        state = CarState(nodes=(car,))
        made = body_of(state).network
        found = made.positions - made.positions[template.node["C1"]]
        wanted = body.network.positions - true["C1"]
        assert np.abs(found - wanted).max() < 0.05


def test_the_window_marks_moves_and_erases_points() -> None:
    body = body_of(CarState(template="coupe"))
    state = Car().read_shapes(Shapes(surfaces=(Surface(mesh_of(body, 8)),)))
    tool, car = MarkPoints(), Car()
    assert state.mesh is not None
    camera = looking_from(90.0, 4.0, state.mesh.mesh.bounds.mean(axis=0))
    context = Context(camera=camera)
    step = tool.next_step(state)
    assert "Touch on the mesh" in step.sentence
    assert "6 more" in step.sentence
    with pytest.raises(UserError, match="no surface"):
        tool.tap(CarState(nodes=state.nodes, asked="S3.R"), Tap(1.0, 1.0, camera), context)
    state = tool.tap(CarState(nodes=state.nodes, asked="S3.L"), Tap(600.0, 400.0, camera), context)
    assert state.mesh is not None
    (point,) = state.mesh.points
    assert point.node == "S3.R"
    assert point.y > 0.0
    handles = [item for layer in scene_of(state, car.solve(state, Job())).layers
               for item in layer.items if isinstance(item, Handle)]  # fmt: skip
    assert {handle.id for handle in handles} == {"mark S3.R", "mark S3.L"}
    mine = min(
        handles, key=lambda one: np.ptp([camera.project(one.point)[0][0], (600, 400)], 0).max()
    )
    start = camera.project(np.array([mine.point]))[0][0]
    path = Stroke(start[0] + np.array([0.0, 12.0]), start[1] + np.array([0.0, 12.0]), camera=camera)
    moved = tool.drag(state, Drag(mine.id, path), context)
    assert moved.mesh is not None
    assert moved.mesh.points != state.mesh.points
    assert guide_of(moved).count == 2, "both of a pair"
    for off, count in ((2.0, 1), (10.0, 2)):
        still = Stroke(start[0] + np.array([off, off]), start[1] + np.zeros(2), camera=camera)
        touched = tool.drag(state, Drag(mine.id, still), context)
        assert touched.mesh is not None
        assert len(touched.mesh.points) == count, "the next one is set beside another one"
    rubbed = tool.erase(moved, Ink((path,)), context)
    assert rubbed.mesh is not None
    assert rubbed.mesh.points == ()


def test_edges_pass_over_the_windows_and_arches_of_a_real_body() -> None:
    """A mesh of a body that is built has openings; edges were drawn to their borders."""
    body = body_of(CarState(template="suv"))
    template, places, whole = body.template, body.network.positions, mesh_of(body)
    middles = whole.vertices[whole.faces].astype(float).mean(axis=1)
    wheels = places[template.wheels[:, 0]]
    gone = np.zeros(len(middles), bool)
    for wheel in wheels:
        gone |= np.hypot(*(middles - wheel)[:, [0, 2]].T) < 420.0
    belt, roof = places[template.node["S3.R"]], places[template.node["R2.R"]]
    gone |= (
        (np.abs(middles[:, 1]) > 0.9 * roof[1])
        & (np.abs(middles[:, 2] - 0.5 * (belt[2] + roof[2])) < 0.6 * (roof[2] - belt[2]))
        & (np.abs(np.abs(middles[:, 0] - belt[0]) - 550.0) < 450.0)
    )
    cut = Mesh(whole.vertices, whole.faces[~gone])
    along = bernstein(np.linspace(0.0, 1.0, 17))
    lines = [
        along @ network_on_mesh(template, places, mesh).control_points for mesh in (whole, cut)
    ]
    assert np.linalg.norm(lines[0] - lines[1], axis=2).max() < 80.0


def test_the_body_is_thin_as_long_as_points_of_the_mesh_are_asked_for() -> None:
    """It lies in the surface on which they are touched."""
    body = body_of(CarState(template="coupe"))
    names = nodes_to_mark(bundled("sedan"))
    places = {
        name.removesuffix(".R"): body.network.positions[body.template.node[name]] for name in names
    }
    for count, is_thin in ((len(names) - 1, True), (len(names), False), (5, False)):
        parts = boxes_at(dict([*places.items()][:count]))
        car = standing_mesh(
            Shapes(surfaces=(Surface(mesh_of(body, 8), "body"), *parts)), "n1", "Mesh"
        )
        state = CarState(nodes=(car,))
        made = body_of(state)
        advice = Car().advice_on_result(state, made, Camera(), ())
        assert any(layer.name == "body" for layer in advice.scene.layers) is is_thin


def test_meshes_that_are_no_cars_are_refused() -> None:
    tiny = boxes_at({"body": np.zeros(3)})
    with pytest.raises(UserError, match="own unit"):
        Car().read_shapes(Shapes(surfaces=tiny))
    with pytest.raises(UserError, match="no faces"):
        Car().read_shapes(Shapes(surfaces=boxes_at({"C1": np.zeros(3)})))
