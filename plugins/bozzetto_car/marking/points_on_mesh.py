"""Mark the nodes of a template on the surface of a mesh, from any side.

A touch meets the mesh where its ray does. Of a pair both nodes are marked by either one, and a node
in the middle of the car lies where the surface meets the plane of symmetry, which a view from the
side shows at its outline. Wheel centres lie within the car, on the plane of the template's wheels.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto.geometry.patches import extent
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Camera
from bozzetto_car.solver.nodes_on_mesh import in_the_middle
from bozzetto_car.state import CarMesh, SurfacePoint
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network

NEAR_MIDDLE: Final = 0.1
"""Farthest place of a touch on the middle of the car from it, in widths of the mesh. A touch
farther off meant the outline of a view from the side, and met what lies before or behind it."""

FROM_THE_SIDE: Final = 0.9
"""Least part of a ray across the car through a wheel: what is touched of a wheel is its face, and
its centre lies some 10 cm behind."""

RINGS: Final = (1.0, 2.0, 4.0, 8.0)
"""Radii of rings about a touch, px, in which the surface is sought where the touch missed it: a
node at an outline or a rim is easily passed by a hair."""

WITHOUT_WHEELS: Final = 0.7
"""Height of a wheel's centre above the lowest place of a mesh, relative to that of the template,
below which that place is no tyre."""

EDGEWISE: Final = 0.05
"""Least sine of the angle of a ray to a plane that it is met with."""

MISSED: Final = (
    "There is no surface of the mesh there. Touch the mesh, or look at it from another side."
)


def right_name(template: Template, node: str) -> str:
    """Return the name of a node, or that of its image on the right.

    Raises
    ------
    UserError
        If the template has no such node.
    """
    half = node.partition(".")[0]
    for name in (half, f"{half}.R"):
        if name in template.node:
            return name
    raise UserError(f"The {template.noun} has no node “{node[:40]}”.")


def nodes_to_mark(template: Template) -> tuple[str, ...]:
    """Return the nodes of the middle and of the right in the order in which they are asked for."""
    names = (right_name(template, word) for word in template.order)
    return tuple(dict.fromkeys(names))


def touched_place(car: CarMesh, template: Template, node: str, camera: Camera, at: Array) -> Array:
    """Return the place of a node, (3,) mm, that is touched in a view of the mesh.

    Parameters
    ----------
    car : CarMesh
        The mesh.
    template : Template
        The template whose node it is.
    node : str
        On whichever side.
    camera : Camera
        The view.
    at : (2,) float
        Where it is touched, px of the view.

    Raises
    ------
    UserError
        If there is no surface.
    """
    number = template.node[right_name(template, node)]
    half = 0.5 * float(np.ptp(car.mesh.vertices[:, 1]))
    ray = camera.rays(at)
    origin, way = ray.origins[0], ray.directions[0] / np.linalg.norm(ray.directions[0])
    if number in template.wheels:
        if abs(way[1]) < FROM_THE_SIDE:
            raise UserError("Look at the car from the side to touch the middle of a wheel.")
        plane = wheel_plane(template, number, half)
        through = _met(origin, way, -np.sign(way[1]) * plane)
        return np.array([through[0], plane, through[2]])
    hit = _first_hit(car.mesh, camera, at)
    if number in template.centre:
        if hit is None or abs(hit[1]) > 2.0 * NEAR_MIDDLE * half:
            hit = _met(origin, way, 0.0)
        return in_the_middle(car.mesh, hit)
    if hit is None:
        raise UserError(MISSED)
    return np.array([hit[0], abs(hit[1]), hit[2]])


def _first_hit(mesh: Mesh, camera: Camera, at: Array) -> Array | None:
    """Return where a mesh is seen at a place of a view, or next to it, (3,) mm; None if nowhere."""
    turns = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ring = np.stack((np.cos(turns), np.sin(turns)), axis=1)
    places = np.concatenate([at[None], *(at + radius * ring for radius in RINGS)])
    hits = cast_rays(Scene((Layer("mesh", (Shaded(mesh),)),)), camera.rays(places)).points
    there = np.flatnonzero(np.isfinite(hits).all(axis=1))
    return np.asarray(hits[there[0]]) if len(there) else None


def wheel_plane(template: Template, number: int, half: float) -> float:
    """Return how far the centre of a wheel is from the middle of a car of a half width, mm."""
    own = extent(fair_nets(Network.of(template)))[1, 1]
    return float(abs(template.positions[number, 1]) / own * half)


def _met(origin: Array, way: Array, y: float) -> Array:
    """Return where a ray meets a plane along the car.

    Raises
    ------
    UserError
        If it runs along it.
    """
    if abs(way[1]) < EDGEWISE:
        raise UserError(MISSED)
    return np.asarray(origin + (y - origin[1]) / way[1] * way)


def with_point(car: CarMesh, template: Template, node: str, place: Array) -> CarMesh:
    """Return the mesh with a node marked.

    Parameters
    ----------
    car : CarMesh
        The mesh.
    template : Template
        The template whose node it is.
    node : str
        On whichever side; its image is marked with it.
    place : (3,) array_like
        mm. A node in the middle is put there.
    """
    name = right_name(template, node)
    x, y, z = (float(v) for v in place)
    y = 0.0 if template.node[name] in template.centre else abs(y)
    rest = tuple(point for point in car.points if point.node != name)
    return replace(car, points=(*rest, SurfacePoint(name, x, y, z)))


def without_points(car: CarMesh, nodes: set[str]) -> CarMesh:
    """Return the mesh without the marks of some nodes."""
    return replace(car, points=tuple(point for point in car.points if point.node not in nodes))


def on_its_wheels(car: CarMesh, template: Template) -> CarMesh:
    """Return the mesh as its marked wheels say: nose at 0, and the ground below the wheels.

    A mesh that looks rearward is turned about the vertical. One without wheels, whose lowest place
    is its sill, is raised to where the wheels are as high as those of the template.
    """
    names = [template.names[node] for node in template.wheels[:, 0]]
    front, rear = map(car.point_of, names)
    if front is None or rear is None:
        return car
    high = float(template.positions[template.wheels[0, 0], 2])
    if front.z < WITHOUT_WHEELS * high:
        car = _raised(car, high - front.z)
    return _turned_about(car) if front.x > rear.x else car


def _raised(car: CarMesh, by: float) -> CarMesh:
    vertices = (car.mesh.vertices + np.array([0.0, 0.0, by])).astype(np.float32)
    points = tuple(replace(point, z=point.z + by) for point in car.points)
    return replace(car, mesh=replace(car.mesh, vertices=vertices), points=points)


def _turned_about(car: CarMesh) -> CarMesh:
    end = float(car.mesh.vertices[:, 0].max())
    vertices = np.array([end, 0.0, 0.0]) + [-1.0, -1.0, 1.0] * car.mesh.vertices
    mesh = replace(car.mesh, vertices=vertices.astype(np.float32), normals=None)
    points = tuple(replace(point, x=end - point.x) for point in car.points)
    return replace(car, mesh=mesh, points=points)
