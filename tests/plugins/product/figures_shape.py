"""Figures of shaping: pressure, groups faired together, pulls, walls.

Run ``python -m tests.plugins.product.figures_shape``; it prints a table. Seeds are from 5000 on,
those of walls from 6000.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh

from bozzetto.geometry import Mesh
from bozzetto.plugin import Job
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Rays
from bozzetto_product import modeler
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.report import border_of
from bozzetto_product.shaping.group_fairing import faired
from bozzetto_product.shaping.pressure import inflated, volume_of_pressure
from bozzetto_product.shaping.pull import pulled
from bozzetto_product.shaping.volume import volume_of
from bozzetto_product.shaping.wall import walled
from tests.plugins.product.known_surfaces import points_of
from tests.plugins.product.noisy_sheets import sheets
from tests.plugins.product.random_networks import cells, quilt, tube
from tests.plugins.product.sketch_fills import fills_of_sketch
from tests.plugins.product.test_group_fairing import MIRROR
from tests.plugins.product.test_pressure import disc, middle_of_a_sheet, places
from tests.plugins.product.test_pull import bump, over, profile, side

SEED = 5000

WALL_SEED = 6000
"""Walls were mended by tubes of the seeds before."""

Row = tuple[str, str, str, bool]


def rows() -> Iterator[Row]:
    """Yield what is measured, the value, what is asked, and whether it is kept."""
    yield from _pressure()
    yield from _groups()
    yield from _pulls()
    yield from _walls()


def _pressure() -> Iterator[Row]:
    for name, share in (("1/3", 1 / 3), ("1", 1.0), ("1.4", 1.4)):
        volume = np.pi * share * (3 + share**2) / 6
        top = float(places(inflated(disc(), volume).fill)[:, 2].max())
        off = 100 * abs(top / share - 1)
        yield f"cap of {name} radius: height", f"{off:.3f} %", "≤ 0.1 %", off <= 0.1
    off = turned = mirror = 0.0
    flat = middle_of_a_sheet(lambda x, y: 0.0 * x)
    for made in (disc(), middle_of_a_sheet(), flat):
        start = made.bent
        assert start is not None
        origin = start.solution.loop.origin
        for pressure in (0.05, 0.2):
            wanted = volume_of_pressure(start.area, pressure)
            found = inflated(start, wanted)
            held = volume_of(found.fill.patches, origin) - volume_of(start.patches, origin)
            off = max(off, abs(held - found.volume) / start.size**3)
            if pressure == 0.05:
                more = np.nanmax([0.0, *found.fill.g1_degrees])
                turned = max(turned, float(more - np.nanmax([0.0, *start.g1_degrees])))
    for start in (disc(), flat):
        volume = volume_of_pressure(start.area, 0.2)
        out, back = (places(inflated(start, s * volume).fill) for s in (1, -1))
        away = np.abs(out * (1, 1, -1) - back).max() / start.size
        mirror = max(mirror, float(away))
    yield "pressure: volume, of size³", f"{off:.1e}", "≤ 1e-9", off <= 1e-9
    yield "pressure: out against in, of size", f"{mirror:.1e}", "≤ 1e-9", mirror <= 1e-9
    yield "pressure: tangent planes turn", f"{turned:.3f}°", "≤ 0.1°", turned <= 0.1


def _groups() -> Iterator[Row]:
    for noise in (0.02, 0.05):
        kept, gone, folds = [], [], 0
        for seed in range(SEED, SEED + 3):
            for sheet in sheets(noise, seed):
                for share, found in ((0.0, kept), (1.0, gone)):
                    net = faired(sheet.net, sheet.loops, sheet.members, share, MIRROR).net
                    every = fill_net(net, sheet.loops)
                    fills = [every[k] for k in sorted(sheet.members)]
                    sound = [one for one in fills if one is not None and not one.folded]
                    folds += (len(fills) - len(sound)) * (share == 1.0)
                    points = np.concatenate([points_of(one) for one in sound])
                    off = sheet.surface.distance(points).mean() / sheet.diagonal
                    found.append(100 * float(off))
        name = f"groups of 4, noise {100 * noise:.0f} % of a patch, 12 sheets"
        yield f"{name}: curves kept, median error", f"{np.median(kept):.3f} %", "", True
        yield (
            f"{name}: let go, median",
            f"{np.median(gone):.3f} %",
            "≤ 0.1 %",
            bool(np.median(gone) <= 0.1),
        )
        yield f"{name}: let go, worst", f"{max(gone):.3f} %", "≤ 0.1 %", max(gone) <= 0.1
        yield f"{name}: let go, folded of 48", f"{folds}", "≤ 0", folds == 0


def _pulls() -> Iterator[Row]:
    worst = turned = 0.0
    for height in (0.06, 0.12, -0.12, 0.2):
        camera, start = side(), middle_of_a_sheet(lambda x, y: -0.05 * ((x - 1.6) ** 2 + y * 0))
        stroke = over(lambda x, h=height: -0.05 * (x - 1.6) ** 2 + h * bump(x), camera)
        found = pulled(start, stroke)
        columns, tops = profile(found.fill, camera, np.sign(height))
        inside = (columns > stroke.x[8]) & (columns < stroke.x[-8])
        wanted = np.interp(columns[inside], stroke.x, stroke.y)
        size = start.size * camera.pixels_per_mm
        worst = max(worst, 100 * float(np.abs(tops[inside] - wanted).max() / size))
        turned = max(turned, float(np.nanmax([0.0, *found.fill.g1_degrees])))
    yield "pull: contour off the stroke, of the size", f"{worst:.2f} %", "≤ 1 %", worst <= 1.0
    yield "pull: tangent planes turn", f"{turned:.3f}°", "≤ 0.1°", turned <= 0.1


# -- walls -----------------------------------------------------------------------------------


def products() -> Iterator[tuple[str, tuple[Fill, ...]]]:
    """Yield the sample, and random products: closed bodies, tubes, sheets."""
    path = Path(modeler.__file__).parent / "samples" / "mouse.json"
    state = product_of_network(json.loads(path.read_text()))
    result = modeler.ProductModeler().solve(state, Job())
    yield "mouse", tuple(one.fill for one in result.filled if one.fill is not None)
    for kind, make, count in (("cells", cells, 14), ("tube", tube, 8), ("quilt", quilt, 8)):
        for seed in range(WALL_SEED, WALL_SEED + count):
            yield kind, fills_of_sketch(make(seed))


def thickness(fills: tuple[Fill, ...], mesh: Mesh, asked: float) -> np.ndarray:
    """By rays from the middles of triangles off the borders, across them, per asked."""
    points, normals = [], []
    for fill in fills:
        inside = ~np.isin(fill.mesh.faces, border_of(fill.mesh)).any(axis=1)
        corners = fill.mesh.vertices.astype(float)[fill.mesh.faces[inside]]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        points.append(corners.mean(axis=1))
        normals.append(across / np.linalg.norm(across, axis=1, keepdims=True))
    rays = Rays(np.concatenate(points), -np.concatenate(normals))
    hits = cast_rays(Scene((Layer("wall", (Shaded(mesh),)),)), rays)
    return np.where(hits.hit, hits.distance, np.inf) / asked


def _walls() -> Iterator[Row]:
    tight = made = count = rounded = 0
    errors: list[float] = []
    for name, fills in products():
        meshes = [fill.mesh for fill in fills]
        size = np.linalg.norm(np.ptp(np.concatenate([m.vertices for m in meshes]), axis=0))
        asked = float((0.012 if name == "mouse" else 0.01) * size)
        wall = walled(meshes, asked)
        count += 1
        if wall is None:
            continue
        made += 1
        rounded += wall.rounded
        solid = trimesh.Trimesh(wall.mesh.vertices, wall.mesh.faces, process=True)
        tight += bool(solid.is_watertight and solid.volume > 0.0)
        found = thickness(fills, wall.offset, asked)
        errors.append(100 * float(np.quantile(np.abs(found - 1.0), 0.9)))
    yield f"walls of 1 % of {count} unseen products: made", f"{made}", f"{count}", made == count
    yield "walls: watertight, corners by their places", f"{tight}", f"{count}", tight == count
    yield "walls: far side rounded", f"{rounded}", "", True
    middle, worst = float(np.median(errors)), max(errors)
    title = "walls: thickness by rays across triangles, 90th percentile of each product"
    yield f"{title}, median", f"{middle:.2f} %", "≤ 2 %", middle <= 2.0
    yield f"{title}, worst", f"{worst:.2f} %", "≤ 2 %", worst <= 2.0


def main() -> None:
    """Print the table."""
    print("| Figure | Measured | Asked | Kept |\n|---|---|---|---|")
    for what, value, asked, kept in rows():
        verdict = ("yes" if kept else "no") if asked else ""
        print(f"| {what} | {value} | {asked} | {verdict} |", flush=True)


if __name__ == "__main__":
    main()
