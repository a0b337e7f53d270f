"""What is seen of a car from a place: surfaces in front, lines that nothing hides, outlines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.geometry import Patchwork
from bozzetto.geometry.patches.patch import points_at
from bozzetto.geometry.patches.ray_intersections import ray_hits
from bozzetto.geometry.patches.tessellation import shaded
from bozzetto.scene.renderer.zbuffer import blank_buffer, rasterize
from bozzetto.view import Camera
from bozzetto_car.template.network import Network

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DIVISIONS = 40
"""Steps along each side of a patch where surfaces are told from what they hide."""

BEHIND = 30.0
"""How far a line may be behind the surface that is seen, mm: it lies on it, as a rule."""

HOUSING = 350.0
"""Depth of the dark behind a wheel arch, mm."""

TYRE = 40.0
"""How far the side of a tyre stands out from the centre of its wheel, mm."""

TREAD = 220.0
"""Width of a tyre, mm."""


@dataclass(frozen=True, eq=False)
class Car:
    """A body with its wheels.

    Attributes
    ----------
    network : Network
    body : Patchwork
    """

    network: Network
    body: Patchwork

    @classmethod
    def of(cls, network: Network) -> Car:
        template = network.template
        names = tuple(patch.name for patch in template.patches)
        sides = [patch.edges for patch in template.patches]
        return cls(network, Patchwork.of_edges(network.control_points, sides, patch_names=names))

    def node(self, name: str) -> Array:
        return np.asarray(self.network.positions[self.network.template.node[name]])

    @property
    def wheels(self) -> Array:
        """Centres, (4, 3) mm; the heights are the tyres' radii."""
        return np.asarray(self.network.positions[self.network.template.wheels.ravel()])

    def arch(self, wheel: Array) -> float:
        """Radius of the wheel arch, mm."""
        return 1.09 * float(wheel[2]) + 8.0

    def in_arch(self, points: Array) -> Mask:
        """Which places on the body's sides are cut out for the wheels."""
        found = np.zeros(points.shape[:-1], bool)
        for wheel in self.wheels:
            off = np.hypot(points[..., 0] - wheel[0], points[..., 2] - wheel[2])
            beside = points[..., 1] * np.sign(wheel[1]) > 0.6 * abs(wheel[1])
            found |= beside & (off < self.arch(wheel))
        return found

    def laid(self, points: ArrayLike, direction: ArrayLike) -> Array:
        """Places moved along a direction onto the body, first hit; NaN where there is none."""
        points, way = np.asarray(points, float), np.asarray(direction, float)
        way = way / np.linalg.norm(way)
        origins = points - 6000.0 * way
        places, distances = ray_hits(self.body.nets, origins, np.broadcast_to(way, points.shape))
        found = np.full(points.shape, np.nan)
        hit = np.isfinite(distances)
        found[hit] = points_at(self.body.nets, places)[hit]
        return found


@dataclass(frozen=True)
class Line:
    """A line on a car.

    Attributes
    ----------
    points : (k, 3) float
        mm; NaN where it leaves the body.
    role : str
        How it is drawn.
    on_body : bool
        Whether it ends where a wheel arch is cut out.
    """

    points: Array
    role: str
    on_body: bool = True


@dataclass(frozen=True, eq=False)
class Seen:
    """A picture of a car, pixel by pixel, (height, width) each.

    Attributes
    ----------
    car : Car
    camera : Camera
    depth : float
        Along the line of sight, mm; inf where there is nothing.
    patch : int
        Of the body; -1 elsewhere.
    normal : (height, width, 3) float
        Of the body.
    wheel : int
        -1 where no wheel is seen.
    housing : bool
        The dark behind the wheels.
    """

    car: Car
    camera: Camera
    depth: Array
    patch: NDArray[np.intp]
    normal: Array
    wheel: NDArray[np.intp]
    housing: Mask

    @classmethod
    def of(cls, car: Car, camera: Camera) -> Seen:
        mesh = shaded(car.body, DIVISIONS)
        vertices = np.asarray(mesh.vertices, float)
        depth, triangle = _rastered(camera, vertices, mesh.faces)
        normals = np.asarray(mesh.normals, float)[mesh.faces].mean(axis=1)[triangle]
        patch = np.where(triangle >= 0, triangle // (2 * DIVISIONS**2), -1)
        tyres = [_tyre(wheel) for wheel in car.wheels]
        starts = np.cumsum([0] + [len(points) for points, _ in tyres])
        points = np.concatenate([points for points, _ in tyres])
        faces = np.concatenate([f + s for (_, f), s in zip(tyres, starts, strict=False)])
        near, which = _rastered(camera, points, faces.astype(np.int32))
        wheel = np.where(which >= 0, which // len(tyres[0][1]), -1)
        width, height = map(int, camera.viewport)
        pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1) + 0.5
        origins, ways = camera.rays(pixels.reshape(-1, 2))
        reach = depth.ravel() / (ways @ camera.axes[2])
        seen = np.isfinite(reach)
        places = np.full((width * height, 3), np.nan)
        places[seen] = origins[seen] + reach[seen, None] * ways[seen]
        holes = car.in_arch(places.reshape(height, width, 3)) & np.isfinite(depth)
        rolled = (near < depth + np.where(holes, HOUSING, 0.0)) & (wheel >= 0)
        return cls(
            car,
            camera,
            np.where(rolled, near, np.where(holes, depth + HOUSING, depth)),
            np.where(rolled | holes, -1, patch),
            normals,
            np.where(rolled, wheel, -1),
            holes & ~rolled,
        )

    def on_patches(self, names: list[str]) -> Mask:
        """Pixels that show one of some patches."""
        every = self.car.body.patch_names
        return np.isin(self.patch, [every.index(name) for name in names if name in every])

    def shows(self, points: Array, *, slack: float = BEHIND) -> Mask:
        """Which places are not hidden, (k,)."""
        places, depth = self.camera.project(np.nan_to_num(points))
        height, width = self.depth.shape
        seen = np.zeros(len(points), bool)
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                at = np.floor(places).astype(int) + np.array([dx, dy])
                inside = ((at >= 0) & (at < (width, height))).all(axis=1)
                at = np.where(inside[:, None], at, 0)
                front = np.where(inside, self.depth[at[:, 1], at[:, 0]], np.inf)
                seen |= depth <= front + slack
        return seen & np.isfinite(points).all(axis=1)

    def drawn(self, points: Array, *, on_body: bool = True) -> list[Array]:
        """The runs of a line in space that are seen, each (k, 2) px."""
        points = np.asarray(points, float)
        seen = self.shows(points, slack=BEHIND if on_body else 2.0 * TYRE)
        if on_body:
            seen &= ~self.car.in_arch(np.nan_to_num(points))
        places = self.camera.project(np.nan_to_num(points))[0]
        cuts = np.flatnonzero(np.diff(seen.astype(int))) + 1
        runs = np.split(np.arange(len(points)), cuts)
        return [places[run] for run in runs if seen[run[0]] and len(run) > 2]


def _rastered(
    camera: Camera, vertices: Array, faces: NDArray[np.int32]
) -> tuple[Array, NDArray[np.int32]]:
    """Depth, mm, and triangle of each pixel."""
    places, depth = camera.project(vertices)
    flat = camera.kind == "orthographic"
    buffer = blank_buffer(int(camera.viewport[0]), int(camera.viewport[1]))
    rasterize(buffer, np.column_stack((places, -depth if flat else 1e4 / depth)), faces)
    shape = (buffer.height, buffer.width)
    near = buffer.nearness.reshape(shape).astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(np.isfinite(near), -near if flat else 1e4 / near, np.inf)
    return far, buffer.triangle.reshape(shape)


def circle(wheel: Array, radius: float, out: float, count: int = 121) -> Array:
    """A circle about a wheel's axis, so far outside its centre, (count, 3) mm."""
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    y = wheel[1] + np.sign(wheel[1]) * out
    return np.column_stack(
        (wheel[0] + radius * np.cos(turn), np.full(count, y), wheel[2] + radius * np.sin(turn))
    )


def _tyre(wheel: Array) -> tuple[Array, NDArray[np.intp]]:
    """A drum in the place of a tyre."""
    count = 72
    outer = circle(wheel, wheel[2], TYRE, count + 1)[:-1]
    inner = circle(wheel, wheel[2], TYRE - TREAD, count + 1)[:-1]
    hubs = [outer.mean(axis=0), inner.mean(axis=0)]
    a = np.arange(count)
    b = (a + 1) % count
    faces = [
        np.column_stack((a, b, a + count)),
        np.column_stack((b, b + count, a + count)),
        np.column_stack((a, b, np.full(count, 2 * count))),
        np.column_stack((a + count, b + count, np.full(count, 2 * count + 1))),
    ]
    return np.vstack((outer, inner, hubs)), np.concatenate(faces)
