"""Creases under blends: ``python -m tests.plugins.silhouette.solids.figures_creases``.

A crease is where the sharp operation makes edges of more than 45°. It stays sharp where the
blended mesh has such an edge within half a step of it; that is read off the meshes alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from bozzetto.geometry import Placement
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import combined
from tests.plugins.silhouette import bodies as b
from tests.plugins.silhouette import outlines as o

SEED, PAIRS, CELLS = 2026, 60, 48
OPERATIONS = ("add", "merge", "carve", "intersect")
SHARP = np.deg2rad(45.0)
SHORTEST = 4.0
"""Creases shorter than so many steps are not counted."""


@dataclass(frozen=True)
class Crease:
    """One crease: its length, the share that stayed sharp, and its blend's reach in steps."""

    length: float
    left: float
    reach: float


def sharp_edges(body: Body) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Edges (e, 2) with more than 45° between their faces, and their lengths."""
    corners = body.vertices[body.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    ends = np.stack([body.faces, np.roll(body.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    face = np.repeat(np.arange(len(body.faces)), 3)
    order = np.lexsort(np.sort(ends, axis=1).T)
    one, other = order[0::2], order[1::2]
    cosine = (normal[face[one]] * normal[face[other]]).sum(axis=1)
    edges = ends[one][cosine < np.cos(SHARP)].astype(np.intp)
    return edges, np.linalg.norm(np.diff(body.vertices[edges], axis=1)[:, 0], axis=1)


def creases(first: Body, second: Body, operation: str, blend: float) -> list[Crease]:
    """All creases of a pair; none where there is no crease."""
    sharp = combined(first, second, operation, 0.0)  # type: ignore[arg-type]
    soft = combined(first, second, operation, blend)  # type: ignore[arg-type]
    if sharp is None or soft is None:
        return []
    edges, length = sharp_edges(sharp)
    new = np.isin(edges, sharp.creases).all(axis=1)
    edges, length = edges[new], length[new]
    rest, _ = sharp_edges(soft)
    _, piece = connected_pieces(edges[:, 0], edges[:, 1], len(sharp.vertices))
    left = np.zeros(len(edges), dtype=bool)
    if len(rest) and len(edges):
        middles = soft.vertices[rest].mean(axis=1)
        gap, _ = cKDTree(middles).query(sharp.vertices[edges].mean(axis=1))
        left = np.asarray(gap) < 0.5 * sharp.step
    number = piece[edges[:, 0]]
    reach = blend * min(first.radius, second.radius)
    solid = Composite(first.implicit, second.implicit, operation, blend, reach)  # type: ignore[arg-type]
    local = solid.sides(sharp.vertices[edges[:, 0]]).reach / sharp.step
    found = []
    for k in np.unique(number):
        mine = number == k
        total = float(length[mine].sum())
        if total > SHORTEST * sharp.step:
            found.append(Crease(total, float(length[mine & left].sum()) / total,
                                float(np.median(local[mine]))))  # fmt: skip
    return found


def pairs(seed: int, count: int) -> list[tuple[Body, Body, str, float]]:
    """Random pairs of real outlines of size 100, turned, sized and moved."""
    random = np.random.default_rng(seed)
    bodies = []
    for path in sorted(o.COMMITTED.glob("*.svg")):
        body = b.body(o.outline(path.stem), CELLS, path.stem)
        scale = 100.0 / np.ptp(body.bounds, axis=0).max()
        x, y, z = (float(-v) for v in scale * body.bounds.mean(axis=0))
        bodies.append(body.placed(Placement(scale=float(scale), offset=(x, y, z))))
    result = []
    for _ in range(count):
        one, other = (bodies[k] for k in random.integers(0, len(bodies), 2))
        turn = tuple(float(v) for v in Rotation.random(rng=random).as_matrix().ravel())
        x, y, z = (float(v) for v in random.normal(0.0, 20.0, 3))
        placed = other.placed(Placement(turn, float(np.exp(random.uniform(-0.8, 0.2))), (x, y, z)))
        blend = float(random.uniform(0.2, 1.5))
        result.append((one, placed, OPERATIONS[random.integers(4)], blend))
    return result


def main() -> None:
    """Print the table."""
    made: list[Crease] = []
    sound: list[bool] = []
    for first, second, operation, blend in pairs(SEED, PAIRS):
        made += creases(first, second, operation, blend)
        body = combined(first, second, operation, blend)  # type: ignore[arg-type]
        if body is not None:
            sound.append(topology_of(body.vertices, body.faces).watertight)
    print("| Reach of the blend | Creases | Left sharp | Length left sharp |")
    print("| --- | --- | --- | --- |")
    for words, found in (
        ("a step of the mesh or more", [crease for crease in made if crease.reach >= 1.0]),
        ("less than a step", [crease for crease in made if crease.reach < 1.0]),
    ):
        total = sum(crease.length for crease in found)
        left = sum(crease.length * crease.left for crease in found)
        half = sum(crease.left > 0.5 for crease in found)
        print(
            f"| {words} | {len(found)} | {100 * half / len(found):.1f} % | "
            f"{100 * left / total:.1f} % |"
        )
    print(f"\nClosed solids: {sum(sound)} of {len(sound)}.")


if __name__ == "__main__":
    main()
