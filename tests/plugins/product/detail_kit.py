"""Bodies to lay details on, and ways to look at what became of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.resources import files
from json import loads

import manifold3d
import numpy as np

from bozzetto.geometry import Mesh
from bozzetto.plugin import Job
from bozzetto_product.details.ground import Ground, kept_places, located
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.model.details import Detail
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import grounds_of, solve_product

RADIUS = 40.0


def ball_curves() -> list[dict[str, object]]:
    """Twelve quarter circles, as a file has them."""
    a = np.linspace(0.0, 0.5 * np.pi, 25)[:, None]
    ends = RADIUS * np.vstack((np.eye(3), -np.eye(3)))
    pairs = [(i, j) for i in range(6) for j in range(i) if i != j + 3]
    rows = [np.cos(a) * ends[i] + np.sin(a) * ends[j] for i, j in pairs]
    for row, (i, j) in zip(rows, pairs, strict=True):
        row[0], row[-1] = ends[i], ends[j]
    return [{"name": f"c{k}", "points": row.tolist()} for k, row in enumerate(rows)]


@cache
def ball() -> ProductState:
    """A ball of twelve quarter circles, smooth all over: eight surfaces."""
    return product_of_network({"network": {"curves": ball_curves()}})


@cache
def mouse() -> ProductState:
    """The computer mouse of the samples."""
    text = files("bozzetto_product").joinpath("samples/mouse.json").read_text("utf-8")
    return product_of_network(loads(text))


@cache
def grounds(state: ProductState) -> tuple[Ground, ...]:
    """The surfaces of a product, to lay details on."""
    return grounds_of(solve_product(state, Job()).patches)


def loop_around(
    state: ProductState,
    place: tuple[float, float, float],
    radius: float,
    shape: tuple[float, ...] = (),
    count: int = 64,
    turn: float = 0.0,
) -> np.ndarray:
    """Points of a smooth round on the surface nearest to a place, waved by harmonics from 2 on."""
    at = located(grounds(state), np.array([place], float))
    normal, middle = at.normals[0], at.points[0]
    x = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    a = np.arange(count) / count * 2.0 * np.pi
    reach = np.full(count, radius)
    for order, share in enumerate(shape, 2):
        reach = reach + radius * share * np.cos(order * a + turn * order)
    flat = middle + reach[:, None] * (np.cos(a + turn)[:, None] * x + np.sin(a + turn)[:, None] * y)
    return np.asarray(located(grounds(state), flat).points)


def polygon_around(
    state: ProductState, place: tuple[float, float, float], corners: np.ndarray, steps: int = 12
) -> tuple[np.ndarray, np.ndarray]:
    """Points and corners of a polygon in the tangent plane at a place, let down on to it."""
    at = located(grounds(state), np.array([place], float))
    normal, middle = at.normals[0], at.points[0]
    x = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    share = np.arange(steps)[:, None] / steps
    after = np.roll(corners, -1, axis=0)
    flat = np.concatenate([a + share * (b - a) for a, b in zip(corners, after, strict=True)])
    marks = np.zeros(len(flat), bool)
    marks[::steps] = True
    points = middle + flat[:, :1] * x + flat[:, 1:] * y
    return np.asarray(located(grounds(state), points).points), marks


def with_detail(
    state: ProductState,
    rows: list[np.ndarray],
    marks: list[np.ndarray] | None = None,
    **values: object,
) -> ProductState:
    """The state with one more detail, given by outlines in space."""
    corners = marks or [np.zeros(len(row), bool) for row in rows]
    starts = np.cumsum([0, *(len(row) for row in rows[:-1])]).tolist()
    places = kept_places(
        grounds(replace(state, nodes=tuple(n for n in state.nodes if not isinstance(n, Detail)))),
        np.concatenate(rows),
        np.concatenate(corners),
        starts,
    )
    detail = Detail(state.unused_id(), state.unused_name("Detail"), places=places)
    return state.with_node(replace(detail, **values))


def solved(state: ProductState) -> ProductResult:
    return solve_product(state, Job())


def body(state: ProductState):
    """The one solid that a state hands over."""
    (solid,) = shapes_of(state, solved(state)).solids
    return solid


def manifold(mesh: Mesh) -> manifold3d.Manifold:
    return manifold3d.Manifold(
        manifold3d.Mesh(
            vert_properties=np.array(mesh.vertices, np.float32),
            tri_verts=np.array(mesh.faces, np.uint32),
        )
    )
