"""How good meshes of quads are: ``python -m tests.core.exchange.figures_quads SET``.

The set is ``outlines``, every fifth one of `tests.fidelity` and all with limbs, 2,000 and 5,000
quads each, ``rough``, the same outlines with noise as scans have it, 500 each, or ``gallery``,
5,000 each; at 64 cells. Closedness, genus, angles and directions are
measured by means that share no code with what lays the quads.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from bozzetto.cli.output import workbench
from bozzetto.exchange.import_file import read_drawing
from bozzetto.exchange.quad_budget import within_quads
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.mesh_places import closest_on_mesh
from bozzetto.geometry.meshed_shapes import meshed
from bozzetto.geometry.shapes import Shapes, Solid, Surface
from bozzetto.plugin import Job
from tests.core.exchange.figures_uvs import outlines
from tests.fidelity import ROOT

ANIMALS: Final = (
    "crow", "dove", "fish", "frog", "hand-paper", "hand-spock", "horse-head", "mosquito",
    "spider", "horse_skimage", "creature", "bacterium",
)  # fmt: skip
"""Drawings with limbs."""

SURE: Final = 0.9
"""Weight of a vertex for its bone from which it counts as part of the limb."""

NOISE: Final = (0.1, 0.2, 0.3)
"""Standard deviation of the noise of rough drawings, in mean lengths of edges."""

SEED: Final = 20261130
"""Of that noise."""

LONG: Final = 2.0
"""A limb is so many times as long as it is thick from its axis, at least."""


class Found(NamedTuple):
    """What was measured of the quads of one drawing.

    `joined` is the number of parts whose triangles were joined in pairs.
    """

    asked: int
    faces: int
    area: float
    regular: float
    angle: float
    distance: float
    sound: bool
    joined: int
    limbs: float
    seconds: float


def some_outlines() -> Iterator[tuple[str, Path]]:
    """Yield every fifth outline, and those with limbs."""
    for number, (modeler, path) in enumerate(outlines()):
        if number % 5 == 0 or path.stem in ANIMALS:
            yield modeler, path


def gallery() -> Iterator[tuple[str, Path]]:
    """Yield the drawings of the gallery."""
    for path in sorted((ROOT / "docs" / "gallery").glob("*.json")):
        yield "silhouette", path


def rings_of(part: Solid | Surface) -> list[list[int]]:
    """Return the corners of all faces of a part."""
    faces, found, at = part.mesh.faces.tolist(), [], 0
    for size in part.polygons.tolist() if part.polygons is not None else [1] * len(faces):
        ring = list(faces[at])
        if size == 2:
            ring += [v for v in faces[at + 1] if v not in ring]
        found.append(ring)
        at += size
    return found


def euler(rings: Sequence[Sequence[int]]) -> tuple[int, bool]:
    """Return Euler's number of faces, and whether they are closed and wound one way."""
    sides = Counter((a, b) for r in rings for a, b in zip(r, [*r[1:], r[0]], strict=True))
    closed = all(n == 1 and sides.get((b, a)) == 1 for (a, b), n in sides.items())
    corners = {v for r in rings for v in r}
    return len(corners) - len(sides) // 2 + len(rings), closed


def measured(shapes: Shapes, count: int) -> Found:
    """Lay quads over shapes, and measure them."""
    start = time.process_time()
    made = within_quads(shapes, count, lambda *_: None)
    seconds = time.process_time() - start
    regular, corners, area, distance, limbs, sound = [], [], [], 0.0, [], True
    for before, part in zip(shapes.meshes(), made.shapes.meshes(), strict=True):
        rings, points = rings_of(part), part.mesh.vertices.astype(float)
        ends = {
            (min(a, b), max(a, b)) for r in rings for a, b in zip(r, r[1:] + r[:1], strict=True)
        }
        edges = np.array(sorted(ends))
        regular.append(np.bincount(edges.ravel(), minlength=len(points)) == 4)
        quads = np.array([r for r in rings if len(r) == 4]).reshape(-1, 4)
        place = points[quads]
        one, other = np.roll(place, -1, axis=1) - place, np.roll(place, 1, axis=1) - place
        size = np.linalg.norm(one, axis=2) * np.linalg.norm(other, axis=2)
        cosine = (one * other).sum(axis=2) / np.where(size > 0, size, 1)
        corners.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))).ravel())
        for ring in rings:
            p = points[ring]
            size_of = sum(
                np.linalg.norm(np.cross(p[k] - p[0], p[k + 1] - p[0])) / 2
                for k in range(1, len(p) - 1)
            )
            area.append((size_of, len(ring) == 4))
        diagonal = np.linalg.norm(np.ptp(before.mesh.vertices, axis=0))
        if part.skin is None or part.skin.rest is None:
            there = closest_on_mesh(part.mesh, before.mesh.vertices).distances.max()
            back = closest_on_mesh(before.mesh, points).distances.max()
            distance = max(distance, there / diagonal, back / diagonal)
        if isinstance(before, Solid):
            sound &= euler(rings) == euler(before.mesh.faces.tolist()) and euler(rings)[1]
        limbs.append(_against_limbs(part, points, edges))
    sizes, quad = np.array(area).T
    turned = np.concatenate(limbs)
    return Found(
        count, made.quads + made.triangles, float(sizes[quad > 0].sum() / sizes.sum()),
        float(np.concatenate(regular).mean()), float(np.percentile(np.concatenate(corners), 5)),
        float(distance), bool(sound), len(made.joined),
        float(turned.mean()) if len(turned) else float("nan"), seconds,
    )  # fmt: skip


def _against_limbs(part: Solid | Surface, points: Any, edges: Any) -> Any:
    """Return angles, degrees, by which edges on limbs are neither along nor across their axes."""
    skin, found = part.skin, [np.zeros(0)]
    if skin is None:
        return found[0]
    rig = skin.rig
    strongest = skin.weights.argmax(axis=1)
    every = np.arange(len(points))
    bone = np.where(skin.weights[every, strongest] >= SURE, skin.joints[every, strongest], -1)
    middle = points[edges].mean(axis=1)
    along = points[edges[:, 1]] - points[edges[:, 0]]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    for joint in range(len(rig.joints)):
        ends = [k for k, parent in enumerate(rig.parents.tolist()) if parent == joint]
        if len(ends) != 1:
            continue
        begin, axis = rig.joints[joint], rig.joints[ends[0]] - rig.joints[joint]
        length = float(np.linalg.norm(axis))
        own = (bone[edges] == joint).all(axis=1)
        share = (middle - begin) @ axis / max(length, 1e-12) ** 2
        own &= (share > 0.2) & (share < 0.8)
        if not own.any():
            continue
        away = np.linalg.norm(middle[own] - begin - share[own, None] * axis, axis=1)
        if length < LONG * away.mean():
            continue
        angle = np.degrees(np.arccos(np.clip(np.abs(along[own] @ axis) / length, 0, 1)))
        found.append(np.minimum(angle, 90.0 - angle))
    return np.concatenate(found)


def row(name: str, found: Sequence[Found]) -> str:
    """Return a row of the table."""
    faces = np.array([one.faces / one.asked for one in found])
    area, regular, angle, distance, seconds = (
        np.array([getattr(one, key) for one in found])
        for key in ("area", "regular", "angle", "distance", "seconds")
    )
    limbs = [one.limbs for one in found if np.isfinite(one.limbs)]
    return (
        f"| {name} | {len(found)} | {sum(one.sound for one in found)} | "
        f"{sum(one.joined > 0 for one in found)} | "
        f"{100 * area.min():.0f} / {100 * np.median(area):.0f} % | {(area >= 0.9).sum()} | "
        f"{100 * np.median(regular):.0f} % | {np.median(angle):.0f}° | "
        f"{100 * np.median(distance):.2f} / {100 * distance.max():.2f} % | "
        f"{100 * faces.min():.0f} … {100 * faces.max():.0f} % | "
        + (f"{np.mean(limbs):.1f}° / {max(limbs):.1f}° | " if limbs else "– | ")
        + f"{np.median(seconds):.1f} / {seconds.max():.1f} s |"
    )


def rough(shapes: Shapes, noise: float) -> Shapes:
    """Return the solids of shapes with vertices moved at random, in mean lengths of edges."""
    made = []
    for part in shapes.solids:
        places = part.mesh.vertices[part.mesh.faces].astype(float)
        length = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).mean()
        moves = np.random.default_rng(SEED).normal(0.0, noise * length, part.mesh.vertices.shape)
        vertices = (part.mesh.vertices + moves).astype(np.float32)
        made.append(Solid(Mesh(vertices, part.mesh.faces), part.name))
    return Shapes(tuple(made))


def main(chosen: str) -> None:
    """Print the table of a set."""
    print(
        "| Drawings | How many | Closed, same genus | Only pairs of triangles "
        "| Quads by area, least / median | From 90 % | Vertices with four edges, median "
        "| Angles: 95 % are above, median | Hausdorff distance by the diagonal, median / most "
        "| Faces to those asked for | Against limbs, mean / most | Processor time, median / most |"
    )
    print("|" + " --- |" * 12)
    bench: Any = workbench()
    rows: dict[str, list[Found]] = {}
    sets: dict[str, tuple[Iterable[tuple[str, Path]], tuple[int, ...]]] = {
        "outlines": (some_outlines(), (2000, 5000)),
        "rough": (some_outlines(), (500,)),
        "gallery": (gallery(), (5000,)),
    }
    drawings, counts = sets[chosen]
    for modeler, path in drawings:
        model = bench.sources.from_drawing(
            bench.registry.resolve(modeler),
            read_drawing(path, trusted=True),
            {"resolution": 64},
        )
        shapes = meshed(bench.shapes((model,), Job()))
        for count, noise in product(counts, NOISE if chosen == "rough" else (0.0,)):
            found = measured(rough(shapes, noise) if noise else shapes, count)
            name = f"{chosen}, {count:,} quads" + (f", noise {100 * noise:.0f} %" if noise else "")
            rows.setdefault(name, []).append(found)
            if path.stem in ANIMALS and chosen == "outlines":
                rows.setdefault(f"{name}, with limbs", []).append(found)
            print(path.stem, found, file=sys.stderr, flush=True)
    for name, found_all in rows.items():
        print(row(name, found_all), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
