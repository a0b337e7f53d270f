"""Surfaces as in the paper beside fair ones: ``python -m tests.plugins.product.figures_paper``.

The same loops are filled both ways. Places of paper surfaces are the centres of their triangles,
and of fair ones places of their patches.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from bozzetto.plugin import Job
from bozzetto_product.fill.fill_mesh import corner_ratios, radius_ratios
from bozzetto_product.fill.network_fills import fill_net, mesh_spacing
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.state import ProductState, SurfaceKind
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.paper.group_spring import evened_group
from bozzetto_product.paper.membrane import pressed
from bozzetto_product.paper.network_surfaces import paper_surfaces
from bozzetto_product.paper.triangulation import triangulated
from bozzetto_product.report import meeting_angles
from bozzetto_product.shaping.group_fairing import faired
from bozzetto_product.shaping.pressure import inflated
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.figures_product import SAMPLE
from tests.plugins.product.held_out_networks import HELD_OUT
from tests.plugins.product.known_surfaces import (
    KnownLoop,
    KnownSurface,
    analytic_loops,
    error_percent,
    estimated_normals,
    filled,
    fitted,
    net_of_splines,
    random_loop,
)
from tests.plugins.product.noisy_sheets import sheets
from tests.plugins.product.shaver import shaver

FIRST_SEED = 5000
RANDOM_LOOPS = 60
HEIGHTS = {"1/3": 1 / 3, "1": 1.0, "1.4": 1.4}


def row(*cells: object) -> None:
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def spent(work: Callable[[], object]) -> tuple[float, object]:
    start = time.process_time()
    answer = work()
    return 1e3 * (time.process_time() - start), answer


def off(surface: KnownSurface, points, faces, diagonal: float) -> float:
    """Mean distance of the centres of triangles from a known surface, %."""
    return 100 * float(surface.distance(points[faces].mean(axis=1)).mean()) / diagonal


def three(values: Sequence[float]) -> str:
    return f"{np.median(values):.3f}, {np.percentile(values, 95):.3f}, {max(values):.3f} %"


def single_loops(name: str, loops: Sequence[KnownLoop]) -> None:
    fair, paper, flat, times, quality, folds = [], [], [], [], [], [0, 0]
    for known in loops:
        first, fill = spent(lambda known=known: _meshed(filled(known, estimated_normals(known))))
        second, found = spent(lambda known=known: paper_surfaces(known.net, [known.loop])[0])
        mesh, size = found.triangles, known.diagonal
        plain = triangulated(mesh.points[: mesh.border], mesh_spacing(known.net, [known.loop]))
        fair.append(error_percent(known, fill))
        paper.append(off(known.surface, mesh.points, mesh.faces, size))
        flat.append(off(known.surface, plain.points, plain.faces, size))
        times.append((first, second))
        ratios = corner_ratios(mesh.points[mesh.faces])
        other = radius_ratios(fill.mesh)
        quality.append(
            (other.min(), np.percentile(other, 5), ratios.min(), np.percentile(ratios, 5))
        )
        folds[0] += fill.folded
        folds[1] += found.folded
    row(f"{name}: off the known surface, median, p95, worst", three(fair), three(paper))
    row(f"{name}: before the V-spring", "", three(flat))
    worst, few, least, fifth = np.median(quality, axis=0)
    row(f"{name}: 2 r / R, least", f"{worst:.2f}", f"{least:.2f}")
    row(f"{name}: 2 r / R, 5th percentile", f"{few:.2f}", f"{fifth:.2f}")
    both = np.median(times, axis=0)
    row(f"{name}: time of a surface, median", f"{both[0]:.0f} ms", f"{both[1]:.0f} ms")
    row(f"{name}: folded", *folds)


def _meshed(fill):
    """Make the triangles, too, for the time."""
    assert len(fill.mesh.faces)
    return fill


def caps() -> None:
    """Heights under pressure of a disc, which are those of a ball's cap."""
    turns = np.linspace(0, 2 * np.pi, 4 * 128 + 1)
    circle = np.column_stack((np.cos(turns), np.sin(turns), 0 * turns))
    net, loop = net_of_splines([fitted(circle[128 * k : 128 * k + 129]) for k in range(4)])
    fill = fill_net(net, [loop])[0]
    mesh = paper_surfaces(net, [loop])[0].triangles
    assert fill is not None
    for name, height in HEIGHTS.items():
        volume = np.pi * height * (3 + height**2) / 6
        up = 1.0 if _upward(mesh) else -1.0
        first, fair = spent(lambda volume=up * volume: inflated(fill, volume).fill)
        second, film = spent(lambda volume=up * volume: pressed(mesh, volume).points)
        tops = (float(fair.mesh.vertices[:, 2].max()), float(film[:, 2].max()))
        row(
            f"disc, pressed to a cap of {name} radius: height off",
            *(
                f"{100 * abs(top / height - 1):.2f} %, {t:.0f} ms"
                for top, t in zip(tops, (first, second), strict=True)
            ),
        )


def _upward(mesh) -> bool:
    a, b, c = (mesh.points[mesh.faces[:, k]] for k in range(3))
    return bool(np.cross(b - a, c - a)[:, 2].sum() > 0)


def groups() -> None:
    """Sheets of which the middle curves have the noise of a hand."""
    plane = Reflection(ProductState().symmetry)
    for noise in (0.02, 0.05):
        rows: dict[str, list[tuple[float, float]]] = {}
        for seed in range(3):
            for sheet in sheets(noise, FIRST_SEED + seed):
                inner = _inner(sheet)
                start = paper_surfaces(sheet.net, sheet.loops)
                for share in (0.0, 1.0):
                    net = faired(sheet.net, sheet.loops, sheet.members, share, plane).net
                    fills = fill_net(net, sheet.loops)
                    rows.setdefault(f"fair {share}", []).append(judged(sheet, fills, inner))
                    made = evened_group(sheet.net, start, sheet.members, 1.0, share, plane).surfaces
                    rows.setdefault(f"paper {share}", []).append(judged(sheet, made, inner))
                rows.setdefault("paper alone", []).append(judged(sheet, start, inner))
        name = f"groups of 4, noise {100 * noise:.0f} %"
        for what, fair, paper in (
            ("each surface alone", None, "paper alone"),
            ("curves held", "fair 0.0", "paper 0.0"),
            ("curves let go", "fair 1.0", "paper 1.0"),
        ):
            cells = [
                "" if key is None else "{:.3f} %, {:.3f}°".format(*np.median(rows[key], axis=0))
                for key in (fair, paper)
            ]
            row(f"{name}, {what}: off the true surface, worst angle (medians)", *cells)


def error_of(sheet, fill) -> float:
    centres = fill.mesh.vertices.astype(float)[fill.mesh.faces].mean(axis=1)
    return 100 * float(sheet.surface.distance(centres).mean()) / sheet.diagonal


def judged(sheet, surfaces, inner) -> tuple[float, float]:
    """Mean error in percent, and the worst angle over the edges between the surfaces, degrees."""
    errors = [error_of(sheet, surfaces[k]) for k in sorted(sheet.members)]
    worst = 0.0
    for edge in inner:
        (one, here), (other, there) = (
            (surfaces[k], place)
            for k in sorted(sheet.members)
            for place, (number, _) in enumerate(sheet.loops[k])
            if number == edge
        )
        worst = max(worst, meeting_angles(one, here, other, there)[0])
    return float(np.mean(errors)), worst


def _inner(sheet) -> set[int]:
    uses = [edge for k in sheet.members for edge, _ in sheet.loops[k]]
    return {edge for edge in uses if uses.count(edge) == 2}


def products() -> None:
    """The sample, a product of the chapter's size, and networks drawn by hand."""
    product = ProductModeler()
    for name, state in (
        ("mouse", product_of_network(json.loads(SAMPLE.read_text()))),
        ("shaver, 50 surfaces", shaver()),
    ):
        cells: dict[str, list[str]] = {}
        for kind in _kinds():
            whole = replace(state, surfaces=kind)
            ms, result = spent(lambda whole=whole: product.solve(whole, Job()))
            told = product.report(whole, result, Job())
            angles = [edge["angle_deg"] for edge in told["edges"] if edge["smooth"]]
            body = product.shapes(whole, result).solids
            exact = "exact faces" if body and body[0].exact is not None else "triangles, curves"
            for what, value in (
                ("closed", told["closed"]),
                ("angle over smooth edges, median, p95", _pair(angles)),
                ("2 r / R, 5th percentile, median", f"{_quality(told):.2f}"),
                ("first solve", f"{ms / 1e3:.2f} s"),
                ("STEP holds", exact if kind == "fair" else "curves"),
            ):
                cells.setdefault(what, []).append(str(value))
        for what, values in cells.items():
            row(f"{name}: {what}", *values)
        evened = _grouped(state)
        result = product.solve(evened, Job())
        told = product.report(evened, result, Job())
        angles = [edge["angle_deg"] for edge in told["edges"] if edge["smooth"]]
        row(f"{name}, all one group, V-spring 1: angle, median, p95", "", _pair(angles))
    folded, count = [0, 0], 0
    for make in (*DRAWN.values(), *HELD_OUT.values()):
        net = make().net()
        loops = orient_loops(net, find_loops(net).loops).loops
        count += len(loops)
        folded[0] += sum(fill is None or fill.folded for fill in fill_net(net, loops))
        folded[1] += sum(one.folded for one in paper_surfaces(net, loops))
    row(
        f"32 drawn networks: of {count} surfaces folded",
        *(f"{100 * number / count:.1f} %" for number in folded),
    )


def _kinds() -> Iterator[SurfaceKind]:
    yield "fair"
    yield "paper"


def _grouped(state: ProductState) -> ProductState:
    nodes = tuple(
        replace(node, within="all") if isinstance(node, Patch) else node for node in state.nodes
    )
    group = CurveGroup("all", "All", v_spring=1.0)
    return replace(state, surfaces="paper", nodes=(*nodes, group))


def _pair(angles: Sequence[float]) -> str:
    return f"{np.median(angles):.3f}°, {np.percentile(angles, 95):.3f}°"


def _quality(told) -> float:
    return float(np.median([patch["quality_p5"] for patch in told["patches"]]))


if __name__ == "__main__":
    print("| figure | fair | as in the paper |\n|---|---|---|")
    single_loops("15 analytic loops", analytic_loops())
    single_loops(
        f"{RANDOM_LOOPS} random loops", [random_loop(FIRST_SEED + k) for k in range(RANDOM_LOOPS)]
    )
    caps()
    groups()
    products()
