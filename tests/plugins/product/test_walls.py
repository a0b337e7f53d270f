"""Walls against closed forms: boxes, balls and plates, inward and outward, too thick."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Error, Manifold
from manifold3d import Mesh as Triangles

from bozzetto.geometry import Mesh, Solid, Surface
from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.shaping.wall import walled
from tests.plugins.product.random_networks import tube
from tests.plugins.product.sketch_fills import fills_of_sketch

PRODUCT = ProductModeler()


def box(x: float, y: float, z: float, *, sides: tuple[int, ...] = range(6)) -> list[Mesh]:
    """Sides of a box as meshes of their own, outward."""
    corners = np.array([(i, j, k) for i in (0, x) for j in (0, y) for k in (0, z)], float)
    rings = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    made = []
    for number in sides:
        points = corners[list(rings[number])]
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        normals = np.tile(normal / np.linalg.norm(normal), (4, 1))
        made.append(Mesh(points, [(0, 1, 2), (0, 2, 3)], normals))
    return made


def ball(radius: float) -> Mesh:
    whole = mesh_of(Manifold.sphere(radius, 64))
    return Mesh(whole.vertices, whole.faces, whole.vertices / radius)


def mesh_of(solid: Manifold) -> Mesh:
    """Triangles with the normals of their corners, weighted by area."""
    triangles = solid.to_mesh()
    points, faces = np.asarray(triangles.vert_properties, float), triangles.tri_verts
    a, b, c = points[faces].transpose(1, 0, 2)
    normals = np.zeros_like(points)
    for corner in faces.T:
        np.add.at(normals, corner, np.cross(b - a, c - a))
    return Mesh(points, faces, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def solid_of(mesh: Mesh) -> Manifold:
    """As a reader of triangles without numbers has it: corners by their places.

    It refuses what is open or turned inside out in places.
    """
    points, corner = np.unique(mesh.vertices, axis=0, return_inverse=True)
    faces = corner.reshape(-1)[mesh.faces]
    made = Manifold(Triangles(points.astype(np.float32), faces.astype(np.uint32)))
    assert made.status() == Error.NoError
    return made


@pytest.mark.parametrize("thickness", [0.5, 2.0, 9.0])
def test_a_box_has_a_sharp_hollow(thickness: float) -> None:
    wall = walled(box(40, 30, 20), thickness)
    assert wall is not None
    assert not wall.rounded
    hollow = np.prod(np.array((40, 30, 20)) - 2 * thickness)
    assert solid_of(wall.mesh).volume() == pytest.approx(40 * 30 * 20 - hollow, rel=1e-6)
    assert wall.thinnest == pytest.approx(thickness, rel=2e-3)


def test_a_coat_about_a_box_has_round_edges() -> None:
    """Steiner's formula: faces, quarter cylinders over edges, and one ball at the corners."""
    a, b, c, t = 40.0, 30.0, 20.0, 3.0
    wall = walled(box(a, b, c), t, outward=True)
    assert wall is not None
    coat = 2 * t * (a * b + b * c + c * a) + np.pi * t**2 * (a + b + c) + 4 / 3 * np.pi * t**3
    assert solid_of(wall.mesh).volume() == pytest.approx(coat, rel=5e-3)
    assert np.ptp(wall.mesh.vertices, axis=0) == pytest.approx((46, 36, 26), rel=1e-5)


@pytest.mark.parametrize("outward", [False, True])
def test_a_ball_keeps_its_distance_everywhere(outward: bool) -> None:
    wall = walled([ball(50.0)], 4.0, outward)
    assert wall is not None
    radii = np.linalg.norm(wall.offset.vertices[np.unique(wall.offset.faces)], axis=1)
    np.testing.assert_allclose(radii, 54.0 if outward else 46.0, rtol=1e-6)
    solid_of(wall.mesh)


def test_a_wall_as_thick_as_the_body_is_none() -> None:
    assert walled(box(40, 30, 20), 10.0) is None
    assert walled([ball(50.0)], 60.0) is None


def test_walls_that_run_into_one_another_leave_what_is_far_from_both() -> None:
    """A dumbbell whose handle is full: two hollows at the asked distance."""
    balls = [Manifold.sphere(20.0, 40).translate((x, 0, 0)) for x in (-30.0, 30.0)]
    bar = Manifold.cylinder(60.0, 4.0, circular_segments=32, center=True).rotate((0, 90, 0))
    whole = balls[0] + balls[1] + bar
    wall = walled([mesh_of(whole)], 5.0)
    assert wall is not None
    made = solid_of(wall.mesh)
    assert len(made.decompose()) == 3
    assert wall.thinnest > 0.97 * 5.0
    hollow = whole.volume() - made.volume()
    assert hollow == pytest.approx(2 * 4 / 3 * np.pi * 15.0**3, rel=0.03)


@pytest.mark.parametrize("outward", [False, True])
def test_an_open_corner_becomes_a_plate(outward: bool) -> None:
    """Three sides at a corner: outward with quarter cylinders and an eighth of a ball."""
    a, t = 20.0, 2.0
    wall = walled(box(a, a, a, sides=(0, 2, 4)), t, outward)
    assert wall is not None
    inside = a**3 - (a - t) ** 3
    outside = 3 * a * a * t + 3 * a * np.pi * t**2 / 4 + np.pi * t**3 / 6
    wanted = outside if outward else inside
    assert solid_of(wall.mesh).volume() == pytest.approx(wanted, rel=5e-3)


def test_a_wall_turned_and_moved_is_the_same() -> None:
    turn = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
    plain = walled(box(40, 30, 20), 2.0)
    moved = walled(
        [
            Mesh(m.vertices @ turn.T + (100, -50, 7), m.faces, m.normals @ turn.T)
            for m in box(40, 30, 20)
        ],
        2.0,
    )
    assert plain is not None
    assert moved is not None
    assert solid_of(moved.mesh).volume() == pytest.approx(solid_of(plain.mesh).volume(), rel=1e-4)


def product_box(*, open_top: bool = False) -> ProductState:
    """A box of twelve straight curves."""
    corners = {
        f"{i}{j}{k}": (40 * i, 30 * j, 20 * k) for i in (0, 1) for j in (0, 1) for k in (0, 1)
    }
    rows = []
    for name, place in corners.items():
        for axis in range(3):
            if name[axis] == "0":
                other = name[:axis] + "1" + name[axis + 1 :]
                ends = np.array((place, corners[other]), float)
                rows.append({"name": f"{name}-{other}", "points": np.linspace(*ends, 5).tolist()})
    rings = [
        ("000", "010", "110", "100"), ("001", "101", "111", "011"), ("000", "100", "101", "001"),
        ("010", "011", "111", "110"), ("000", "001", "011", "010"), ("100", "110", "111", "101"),
    ]  # fmt: skip
    names = {frozenset(row["name"].split("-")): row["name"] for row in rows}
    loops = [
        [names[frozenset((one, two))] for one, two in zip(ring, (*ring[1:], ring[0]), strict=True)]
        for ring in rings
        if not (open_top and set(ring) == {"001", "101", "111", "011"})
    ]
    return product_of_network({"network": {"curves": rows, "loops": loops}, "unit": "mm"})


def test_the_recipe_makes_a_housing_of_a_closed_product() -> None:
    state = replace(product_box(), wall=2.0)
    result = PRODUCT.solve(state, Job())
    (part,) = PRODUCT.shapes(state, result).solids
    assert isinstance(part, Solid)
    volume = 40 * 30 * 20 - 36 * 26 * 16
    assert solid_of(part.mesh).volume() == pytest.approx(volume, rel=1e-4)
    assert sum(group.count for group in part.groups) == len(part.mesh.faces)
    assert {group.name for group in part.groups} >= {f"Surface {k} wall" for k in range(1, 7)}
    assert any("STEP" in caution.message for caution in PRODUCT.cautions(state, result))
    assert PRODUCT.report(state, result, Job())["walls"][0]["thinnest_mm"] == pytest.approx(
        2.0, rel=0.01
    )


def test_the_recipe_makes_a_tray_of_an_open_product() -> None:
    state = replace(product_box(open_top=True), wall=2.0)
    shapes = PRODUCT.shapes(state, PRODUCT.solve(state, Job()))
    assert not shapes.surfaces
    (part,) = shapes.solids
    assert solid_of(part.mesh).volume() == pytest.approx(40 * 30 * 20 - 36 * 26 * 18, rel=1e-4)


def test_a_wall_that_is_too_thick_is_told_and_the_product_stays() -> None:
    state = replace(product_box(), wall=10.0)
    result = PRODUCT.solve(state, Job())
    (part,) = PRODUCT.shapes(state, result).solids
    assert solid_of(part.mesh).volume() == pytest.approx(24000, rel=1e-5)
    assert part.exact is not None
    assert any("do not fit" in caution.message for caution in PRODUCT.cautions(state, result))


def test_without_a_wall_nothing_changes_and_a_preview_has_none() -> None:
    state = product_box(open_top=True)
    walls = replace(state, wall=2.0)
    assert PRODUCT.solve(state, Job()).walls == ()
    assert PRODUCT.solve(walls, Job("preview")).walls == ()
    (part,) = PRODUCT.shapes(state, PRODUCT.solve(state, Job())).surfaces
    assert isinstance(part, Surface)


@pytest.mark.parametrize("seed", [6001, 6003, 7103])
def test_tubes_that_bend_more_than_the_wall_is_thick_are_closed_by_places(seed: int) -> None:
    """Prisms over single triangles leave slivers, and specks, that single precision cannot tell."""
    meshes = [fill.mesh for fill in fills_of_sketch(tube(seed))]
    size = np.linalg.norm(np.ptp(np.concatenate([mesh.vertices for mesh in meshes]), axis=0))
    wall = walled(meshes, float(0.01 * size))
    assert wall is not None
    assert solid_of(wall.mesh).volume() > 0.0
    assert len(np.unique(wall.mesh.vertices, axis=0)) == len(wall.mesh.vertices)
    assert sum(count for *_, count in wall.groups) == len(wall.mesh.faces)


def test_a_plate_over_a_sharp_crease_stays_within_its_surfaces() -> None:
    """Two rectangles at 60°: nothing stands out beyond them, and the far side is a mitre."""
    t, long, deep = 2.0, 20.0, 30.0
    up = np.array((-np.cos(np.pi / 3), 0.0, np.sin(np.pi / 3)))
    flat = np.array([(0, 0, 0), (0, deep, 0), (-long, deep, 0), (-long, 0, 0)], float)
    steep = np.array([(0, 0, 0), long * up, long * up + (0, deep, 0), (0, deep, 0)])
    meshes = []
    for points, outward in ((flat, (0, 0, -1)), (steep, (np.sin(np.pi / 3), 0, 0.5))):
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        ring = [(0, 1, 2), (0, 2, 3)] if normal @ outward > 0 else [(0, 2, 1), (0, 3, 2)]
        meshes.append(Mesh(points, ring, np.tile(np.array(outward, float), (4, 1))))
    wall = walled(meshes, t)
    assert wall is not None
    places = wall.mesh.vertices.astype(float)
    assert (places @ (0, 0, -1)).max() <= 1e-4
    assert (places @ (np.sin(np.pi / 3), 0, 0.5)).max() <= 1e-4
    mitre = t / np.tan(np.pi / 6)
    volume = deep * (2 * long * t - t * mitre)
    assert solid_of(wall.mesh).volume() == pytest.approx(volume, rel=2e-3)
