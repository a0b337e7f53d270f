"""Simulated hands that draw curves, and networks whose ends nearly meet."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh, Spline
from bozzetto.ink import Stroke, arc_length, points_along
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto.view import Camera
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.rough_shapes import RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import meeting_place, splines_of
from bozzetto_product.rough_shapes.shapes import rough_mesh

RECORDED = Path(__file__).parents[4] / "shared/data/ink/strokestrip/examples"
"""Strokes that people drew, in clusters of one curve each."""

SHEET = Camera()
"""Looks along y at the plane of x and z."""

MIRROR = np.array((1.0, -1.0, 1.0))

T = np.linspace(0.0, 1.0, 400)


def _arc(degrees: float) -> Array:
    turn = np.radians(degrees) * (T - 0.5)
    return np.column_stack((np.sin(turn), np.cos(turn))) * 300.0


COURSES: dict[str, Array] = {
    "arc 60°": _arc(60.0),
    "arc 150°": _arc(150.0),
    "S": np.column_stack((T * 600.0, 100.0 * np.sin(2.0 * np.pi * T))),
    "arc 270°": _arc(270.0),
    "hook": np.vstack((
        np.column_stack((T * 450.0, 0.0 * T)),
        np.column_stack((450.0 + 70.0 * np.sin(np.pi * T), 70.0 - 70.0 * np.cos(np.pi * T))),
        np.column_stack((450.0 - 100.0 * T, 140.0 + 0.0 * T)),
    )),
    "closed ring": np.column_stack(
        (200.0 * np.cos(2.0 * np.pi * T), 150.0 * np.sin(2.0 * np.pi * T))
    ),
}  # fmt: skip
"""What is meant, px."""


def drawn(course: Array, seed: int, camera: Camera = SHEET) -> list[Stroke]:
    """Draw a course in three to six strokes, in any order and direction, with an unsteady hand."""
    random = np.random.default_rng(seed)
    along = arc_length(course)
    cuts = np.sort(random.uniform(0.0, 1.0, random.integers(3, 7) - 1))
    strokes = []
    for low, high in zip((0.0, *cuts), (*cuts, 1.0), strict=True):
        begin, end = max(0.0, low - 0.06) * along[-1], min(1.0, high + 0.06) * along[-1]
        count = max(6, int((end - begin) / 4.0))
        ink = points_along(course, along, np.linspace(begin, end, count))
        ink = ink + random.normal(0.0, 1.5, 2)
        ink = ink + np.cumsum(random.normal(0.0, 0.15, ink.shape), axis=0)
        ink = ink[::-1] if random.random() < 0.5 else ink
        strokes.append(Stroke(500.0 + ink[:, 0], 450.0 + ink[:, 1], camera))
    return [strokes[k] for k in random.permutation(len(strokes))]


def one_stroke(points: Array, camera: Camera = SHEET) -> Stroke:
    """Return places on the sheet as a stroke."""
    return Stroke(points[:, 0], points[:, 1], camera)


def worst_distance(one: Array, other: Array) -> float:
    """Return the largest distance of either dense row of points from the other."""
    from scipy.spatial import cKDTree

    there, back = cKDTree(one).query(other)[0], cKDTree(other).query(one)[0]
    return float(max(there.max(), back.max()))


def on_canvas(mesh: Mesh) -> Scene:
    """Return a scene that shows a mesh to draw on."""
    return Scene((Layer("canvas", (Shaded(mesh),), owner="solid"),))


def rough(kind: str, size: tuple[float, float, float] = (120.0, 80.0, 60.0)) -> Mesh:
    """Return a rough shape."""
    length, width, height = size
    return rough_mesh(RoughShape(kind=kind, length=length, width=width, height=height))


def bow(start: Array, end: Array, random: np.random.Generator, bulge: float = 0.25) -> Spline:
    """Return a curve of seven control points between two places, bent at random."""
    share = np.linspace(0.0, 1.0, 7)[:, None]
    size = float(np.linalg.norm(end - start))
    points = start + share * (end - start)
    points = points + bulge * size * 4.0 * share * (1.0 - share) * random.normal(size=3)
    points[0], points[-1] = start, end
    return Spline.uniform(points)


def grid_network(
    seed: int, noise: float, size: float = 100.0, cells: int = 3
) -> tuple[ProductState, Array]:
    """Return a sheet of curves drawn edge by edge, with ends that miss by a normal error.

    Returns
    -------
    state : ProductState
    corners : (n, 3) float
        Where the ends should be, mm.
    """
    random = np.random.default_rng(seed)
    steps = np.linspace(0.0, size, cells + 1)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps, indexing="ij"))
    corners = np.column_stack((x, y, 0.2 * size * np.sin(x / size * 3.0) * np.cos(y / size * 2.0)))
    curves = []
    wide = cells + 1
    pairs = [(k, k + 1) for k in range(len(corners)) if (k + 1) % wide]
    pairs += [(k, k + wide) for k in range(len(corners) - wide)]
    for number, (one, other) in enumerate(pairs):
        ends = corners[[one, other]] + random.uniform(-noise, noise, (2, 3)) / np.sqrt(3.0)
        spline = bow(ends[0], ends[1], random, 0.05)
        spline = spline.reversed() if random.random() < 0.5 else spline
        curves.append(Curve(id=f"c{number}", name=f"Curve {number}", spline=spline))
    return ProductState(nodes=tuple(curves)), corners


def misses(state: ProductState) -> float:
    """Return the largest distance between what meets in one joint; 0 where it is equal."""
    splines = splines_of(state)
    worst = 0.0
    for joint in state.joints:
        places = [meeting_place(splines, meet, state.symmetry) for meet in joint.meetings]
        worst = max(worst, *(float(np.abs(place - places[0]).max()) for place in places))
    return worst


def largest_move(before: ProductState, after: ProductState) -> dict[str, float]:
    """Return how far any place of each curve moved, mm."""
    old, new = splines_of(before), splines_of(after)
    return {
        name: float(np.linalg.norm(old[name].sampled(200) - new[name].sampled(200), axis=1).max())
        for name in old
        if name in new
    }


def scaled(state: ProductState, change: Callable[[Array], Array]) -> ProductState:
    """Return a network with every control point changed."""
    from dataclasses import replace

    nodes = tuple(
        replace(
            node,
            spline=Spline(
                node.spline.knots, change(node.spline.control_points), node.spline.closed
            ),
        )
        for node in state.of_kind(Curve)
        if node.spline is not None
    )
    return replace(state, nodes=nodes)


def with_mirror(state: ProductState) -> ProductState:
    """Return a network of which every curve has a mirror image in y = 0."""
    from dataclasses import replace

    nodes = tuple(replace(node, mirrored=True) for node in state.of_kind(Curve))
    return replace(state, nodes=nodes, symmetry=Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))


def recorded_clusters(most: int = 200) -> list[list[Array]]:
    """Return strokes that people drew, one list for each curve; none where they are not there."""
    found: list[list[Array]] = []
    for path in sorted(RECORDED.rglob("*.scap")):
        clusters: dict[str, list[Array]] = {}
        for block in path.read_text().split("{")[1:]:
            rows = block.split("}")[0].split("\n")
            name, ink = "", []
            for row in rows:
                words = row.split()
                if row.strip().startswith("#"):
                    name = words[1] if len(words) > 1 else ""
                elif len(words) == 3:
                    ink.append((float(words[0]), float(words[1])))
            if len(ink) > 1:
                clusters.setdefault(name, []).append(np.array(ink))
        found.extend(clusters.values())
    return found[:: max(1, len(found) // most)][:most]
