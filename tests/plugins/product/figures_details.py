"""Figures of details: random outlines of every kind on random bodies that nothing was tuned on.

Run ``python -m tests.plugins.product.figures_details``; it prints a table. Where the variable
``BOZZETTO_CAD_READERS`` names a Python with Open CASCADE, the exact bodies are read by it.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import manifold3d
import numpy as np

from bozzetto.errors import UserError
from bozzetto.exchange.export import export
from bozzetto.geometry import Shapes
from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto.view import Camera
from bozzetto_product.details.ground import located
from bozzetto_product.details.shell import Shell
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.model.details import Detail
from bozzetto_product.model.state import ProductState
from bozzetto_product.tools.detail import with_detail_drawn
from tests.plugins.product.detail_kit import (
    ball_curves,
    grounds,
    loop_around,
    manifold,
    mouse,
    polygon_around,
    solved,
    with_detail,
)

SEED = 5000
COUNT = 72
DRAWN = 24
KINDS = ("in", "raised", "cut", "button", "split")

Row = tuple[str, str, str, bool]

OPENCASCADE = """
import json, sys
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
found = {}
for path in sys.argv[1:]:
    reader = STEPControl_Reader()
    reader.ReadFile(path)
    reader.TransferRoots()
    shape = reader.OneShape()
    counts = []
    for kind in (TopAbs_SOLID, TopAbs_SHELL):
        explorer, count = TopExp_Explorer(shape, kind), 0
        while explorer.More():
            count += 1
            explorer.Next()
        counts.append(count)
    found[path] = [bool(BRepCheck_Analyzer(shape).IsValid()), *counts]
print()
print(json.dumps(found))
"""


@dataclass
class Measured:
    """What came of all details."""

    carved: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    watertight: list[bool] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)
    depth: list[float] = field(default_factory=list)
    draft: list[float] = field(default_factory=list)
    apart: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    files: list[str] = field(default_factory=list)


def random_body(rng: np.random.Generator) -> ProductState:
    """An ellipsoid, sheared, of eight surfaces; every fourth body is the mouse."""
    if rng.integers(4) == 0:
        return mouse()
    matrix = np.diag(rng.uniform(0.55, 1.4, 3)) + 0.12 * rng.normal(size=(3, 3))
    curves = [{**c, "points": (np.array(c["points"]) @ matrix.T).tolist()} for c in ball_curves()]
    return product_of_network({"network": {"curves": curves}})


def random_detail(rng: np.random.Generator, number: int, body: ProductState) -> ProductState:
    """The body with one detail of random place, outline and sizes."""
    lands = grounds(body)
    boxes = np.array([ground.fill.mesh.bounds for ground in lands], float)
    size = float(np.linalg.norm(boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)))
    mesh = lands[int(rng.integers(len(lands)))].fill.mesh
    corners = mesh.vertices.astype(float)[mesh.faces[int(rng.integers(len(mesh.faces)))]]
    place = tuple(rng.dirichlet(np.ones(3)) @ corners)
    radius = size * rng.uniform(0.02, 0.08)
    kind = KINDS[number % len(KINDS)]
    turn = rng.uniform(0.0, 2.0 * np.pi)
    if rng.random() < 0.3:
        count = int(rng.integers(3, 7))
        angles = turn + (np.arange(count) + rng.uniform(-0.2, 0.2, count)) * 2.0 * np.pi / count
        polygon = radius * np.column_stack((np.cos(angles), np.sin(angles)))
        points, marks = polygon_around(body, place, polygon)
    else:
        points = loop_around(body, place, radius, tuple(rng.uniform(-0.12, 0.12, 2)), turn=turn)
        marks = np.zeros(len(points), bool)
    return with_detail(
        body,
        [points],
        [marks],
        kind=kind,
        depth=size * rng.uniform(0.004, 0.018),
        # Walls through a whole body would meet at the angles that suit a shallow one.
        draft=float(rng.uniform(0.0, 1.0 if kind == "cut" else 10.0)),
        gap=radius * rng.uniform(0.06, 0.15),
    )


def measured(folder: Path) -> Measured:
    """Carve all details and look at what came of them."""
    made = Measured()
    for number in range(COUNT):
        rng = np.random.default_rng(SEED + number)
        body = random_body(rng)
        state = random_detail(rng, number, body)
        solved(replace(state, nodes=body.nodes))
        start = time.process_time()
        result = solved(state)
        made.seconds.append(time.process_time() - start)
        (one,) = result.detailed.details
        if one.problem:
            made.refused[one.problem] += 1
            continue
        made.carved += 1
        (shell,) = result.detailed.changed
        shapes = shapes_of(state, result)
        made.watertight.append(
            len(shapes.solids) == 1
            and manifold(shapes.solids[0].mesh).status() == manifold3d.Error.NoError
        )
        path = folder / f"{number}.step"
        export(Shapes(solids=shapes.solids, surfaces=shapes.surfaces), path)
        made.files.append(str(path))
        look(made, shell, one.detail, body)
    return made


def look(made: Measured, shell: Shell, detail: Detail, body: ProductState) -> None:
    """Measure depth, draft angle and gap, all against the surfaces without the detail."""
    own = [f for f, o in zip(shell.faces, shell.owners, strict=True) if o.made]
    walls = [face for face in own if face.surface.degrees[1] == 1]
    floors = [face for face in own if face.surface.degrees[1] != 1]
    lands = grounds(body)
    for floor in floors:
        rows = [trim.curve.value(np.linspace(*trim.curve.range, 9)) for trim in floor.loops[0]]
        border = np.concatenate(rows)
        at = np.concatenate([border.mean(axis=0) + s * (border - border.mean(axis=0))
                             for s in (0.35, 0.7, 0.95)])  # fmt: skip
        places = floor.surface.value(*at.T)
        foot = located(lands, places)
        made.depth.append(
            float(np.abs(np.linalg.norm(foot.points - places, axis=1) - detail.depth).max())
            / detail.depth
        )
    if detail.kind in ("in", "raised"):
        for wall in walls:
            t = np.linspace(*wall.surface.ranges[0], 9)
            top, end = wall.surface.value(t, 0.0 * t), wall.surface.value(t, 0.0 * t + 1.0)
            out = located(lands, top).normals * (1.0 if detail.kind == "raised" else -1.0)
            normal = np.cross(wall.surface.derivative(t, 0.0 * t, 1, 0), end - top)
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            found = np.degrees(np.arcsin(np.abs((normal * out).sum(axis=1))))
            made.draft.append(float(np.abs(found - detail.draft).max()))
    if detail.kind == "button":
        tops = [w.surface.value(np.linspace(*w.surface.ranges[0], 65), np.zeros(65)) for w in walls]
        middle = np.concatenate(tops).mean(axis=0)
        reach = np.array([np.linalg.norm(top - middle, axis=1).max() for top in tops])
        outer = max(_rings(walls), key=lambda row: max(reach[k] for k in row))
        rest = [k for k in range(len(walls)) if k not in outer]
        inner = np.concatenate([tops[k][8:-8] for k in rest])
        gaps = np.min([_nearest(inner, tops[k]) for k in outer], axis=0)
        made.apart.append(float(np.abs(gaps - detail.gap).max()) / detail.gap)


def _rings(walls: list) -> list[list[int]]:
    """Numbers of walls that follow one another."""
    rows: list[list[int]] = []
    ends: list[np.ndarray] = []
    for number, wall in enumerate(walls):
        (low, high), _ = wall.surface.ranges
        first, last = wall.surface.value([low, high], [0.0, 0.0])
        home = next((k for k, end in enumerate(ends) if np.linalg.norm(end - first) < 1e-5), None)
        if home is None:
            rows.append([number])
            ends.append(last)
        else:
            rows[home].append(number)
            ends[home] = last
    return rows


def _nearest(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances of points from the segments of a chain in space."""
    a, b = line[:-1], line[1:]
    way = b - a
    length = np.maximum((way * way).sum(axis=1), 1e-12)
    share = np.clip(((points[:, None] - a) * way).sum(axis=2) / length, 0.0, 1.0)
    off = np.linalg.norm(points[:, None] - (a + share[..., None] * way), axis=2)
    return np.asarray(off.min(axis=1))


def drawn_deviations() -> list[tuple[float, float]]:
    """Distances of borders from the round that a trembling hand meant, px: p95 and largest."""
    found = []
    for number in range(DRAWN):
        rng = np.random.default_rng(SEED + 1000 + number)
        body = random_body(rng)
        lands = grounds(body)
        bounds = np.array([ground.fill.mesh.bounds for ground in lands], float)
        low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
        way = rng.normal(size=3)
        eye = 0.5 * (low + high) + 2.4 * np.linalg.norm(high - low) * way / np.linalg.norm(way)
        camera = Camera(eye=tuple(eye), target=tuple(0.5 * (low + high)))
        middle = camera.project(0.5 * (low + high)[None])[0][0]
        a = np.linspace(0.0, 2.0 * np.pi, 160)
        reach = 45.0 * (1.0 + rng.uniform(-0.15, 0.15) * np.cos(2 * a)
                        + rng.uniform(-0.1, 0.1) * np.cos(3 * a))  # fmt: skip
        meant = middle + np.column_stack((reach * np.cos(a), reach * np.sin(a)))
        ink = meant + 0.4 * rng.normal(size=meant.shape)
        try:
            state = with_detail_drawn(body, [Stroke(ink[:, 0], ink[:, 1], camera)])
        except UserError:
            continue
        detail = state.of_kind(Detail)[0]
        result = solved(state.with_node(replace(detail, kind="split")))
        if result.detailed.details[0].problem:
            continue
        (shell,) = result.detailed.changed
        inside = {k for k, owner in enumerate(shell.owners) if owner.detail >= 0}
        border = [
            shell.edges[edge].value(np.linspace(*shell.edges[edge].range, 40))
            for edge, users in shell.users.items()
            if len({face in inside for face, _ in users}) == 2
        ]
        seen = camera.project(np.concatenate(border))[0]
        off = distances_to_polyline(seen, meant)
        found.append((float(np.quantile(off, 0.95)), float(off.max())))
    return found


def rows() -> Iterator[Row]:
    """Yield what is measured, the value, what is asked, and whether it is kept."""
    with tempfile.TemporaryDirectory() as folder:
        made = measured(Path(folder))
        yield "Details, all kinds", str(COUNT), "≥ 60", COUNT >= 60
        share = made.carved / COUNT
        yield "carved", f"{made.carved}, {share:.0%}", "≥ 80 %", share >= 0.8
        for sentence, count in made.refused.most_common():
            yield f"told: {sentence}", str(count), "", True
        tight = float(np.mean(made.watertight))
        yield "of these watertight (manifold3d)", f"{tight:.1%}", "100 %", tight == 1.0
        python = os.environ.get("BOZZETTO_CAD_READERS")
        if python:
            valid = _valid(python, made.files)
            yield "one valid closed solid in Open CASCADE", f"{valid:.1%}", "100 %", valid == 1.0
        for name, values, worst in (
            ("depth of the floor: error", made.depth, 0.02),
            ("gap of a button: error", made.apart, 0.1),
        ):
            yield f"{name}, median", f"{np.median(values):.2%}", "≤ 1 %", np.median(values) <= 0.01
            top = max(values)
            yield f"{name}, worst", f"{top:.2%}", f"≤ {worst:.0%}", top <= worst
        middle, top = float(np.median(made.draft)), max(made.draft)
        yield "draft angle: error, median", f"{middle:.3f}°", "≤ 0.1°", middle <= 0.1
        yield "draft angle: error, worst", f"{top:.3f}°", "≤ 0.5°", top <= 0.5
        yield "carving, processor, median", f"{np.median(made.seconds):.2f} s", "", True
    drawn = np.array(drawn_deviations())
    p95, top = float(np.median(drawn[:, 0])), float(drawn[:, 1].max())
    yield (
        f"border from the round meant, {len(drawn)} drawn, p95",
        f"{p95:.2f} px",
        "≤ 1 px",
        p95 <= 1.0,
    )
    yield "the same, largest of all", f"{top:.2f} px", "≤ 2 px", top <= 2.0


def _valid(python: str, files: list[str]) -> float:
    """Share of files that hold one solid of one shell, valid in Open CASCADE."""
    done = subprocess.run(
        [python, "-c", OPENCASCADE, *files], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout.strip().splitlines()[-1])
    return float(np.mean([row == [True, 1, 1] for row in found.values()]))


def main() -> None:
    """Print the table."""
    print("| Figure | Measured | Asked | Kept |\n|---|---|---|---|")
    for what, value, asked, kept in rows():
        verdict = ("yes" if kept else "no") if asked else ""
        print(f"| {what} | {value} | {asked} | {verdict} |")


if __name__ == "__main__":
    main()
