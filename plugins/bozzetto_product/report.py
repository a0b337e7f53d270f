"""The report on a product: plain values, mm, and cautions in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.geometry import Mesh
from bozzetto.plugin import Caution, Figure, Job, remembered
from bozzetto_product.details.bodies import SolvedDetail
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.fill_mesh import radius_ratios
from bozzetto_product.fill.normals import edge_normals
from bozzetto_product.hand_over.names import group_name, loop_names, piece_names
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import KINDS, Detail
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.outlines import outlines_of
from bozzetto_product.paper.paper_surface import PaperSurface
from bozzetto_product.solve.result import ProductResult, SolvedPatch

MEASURED: Final = 33
"""Places on each piece of an edge at which the surfaces on both sides are compared."""

MOST_GAPS: Final = 6
"""Gaps that are told one by one."""

KINKED: Final = 5.0
"""Angle, degrees, at which surfaces meet at the end of a smooth edge, from which on it is told."""

MOST_KINKS: Final = 3
"""Smooth edges with such an end that are told one by one."""

FIGURES: Final[Mapping[str, Figure]] = {
    "curves": Figure("Curves", "Of the network; mirror images are not counted"),
    "joints": Figure("Joints", "Places where curves meet"),
    "surfaces": Figure(
        "Surfaces", "Loops of curves that are filled; mirror images are not counted"
    ),
    "loops": Figure(""),
    "closed": Figure("Closed", "Whether the surfaces enclose a volume"),
    "open_edges": Figure(""),
    "quality_min": Figure(
        "Worst triangle", "Twice the inner over the outer radius: 1 is equilateral", digits=2
    ),
    "quality_p5": Figure(
        "Triangles", "The same, of the worst but a twentieth", digits=2, good=0.5, bad=0.2
    ),
    "boundary_error": Figure(
        "Off the curves",
        "Greatest distance of the surface's border from its curves",
        "mm",
        digits=6,
        good=1e-3,
        bad=0.1,
    ),
    "area": Figure("Area", "Of the triangles of the surface", "mm²", digits=0),
    "g1": Figure(
        "Off smooth",
        "Greatest angle between neighbours over an edge that is to be smooth",
        "°",
        digits=3,
        good=0.05,
        bad=1.0,
    ),
    "edges": Figure(""),
    "group": Figure(""),
    "gaps": Figure(""),
    "g1_vertices": Figure(
        "Triangles off smooth", "The same between triangles, as their files show it", "°", digits=2
    ),
    "holes": Figure(""),
    "kind": Figure("Kind", "What becomes of the area inside", values=dict(KINDS)),
    "carved": Figure("Carved", "Whether the surface has this detail"),
    "floor_error": Figure(
        "Off the depth",
        "Greatest distance of the floor from the true offset of the surface",
        "mm",
        digits=6,
        good=1e-2,
        bad=0.2,
    ),
    "vertices": Figure("Vertices", "Of the triangles of the surface"),
    "walls": Figure(""),
    "thinnest": Figure("Thinnest wall", "Least distance of both sides of a wall", "mm", digits=3),
    "thickest": Figure(
        "Thickest wall", "Greatest distance of a place on its far side", "mm", digits=3
    ),
    "gap": Figure("Gap", "Greatest distance of ends that are joined", "mm", digits=6),
}
"""The words of the report; `Modeler.figures`."""


def report_of(state: ProductState, result: ProductResult, job: Job) -> dict[str, Any]:
    """Report curves, joints, loops, surfaces and what is open.

    Returns
    -------
    dict
        ``"loops"``: names of the curves or pieces of curves round each surface; ``"patches"``:
        for each ``"id"``, ``"name"``, ``"group"`` (its name in OBJ files), ``"curves"``,
        ``"holes"`` (those round each hole), ``"vertices"``, ``"quality_min"`` and
        ``"quality_p5"`` (2 r / R of its triangles), ``"boundary_error_mm"``, ``"area_mm2"``,
        ``"g1_deg"`` and ``"g1_vertices_deg"``;
        ``"edges"``: for each edge between two surfaces ``"curve"``, ``"patches"``,
        ``"crease"`` (0 to 1 as asked for, None where the network decides), ``"smooth"``,
        ``"angle_deg"``, the greatest anywhere on it, and ``"angle_vertices_deg"``, the greatest at
        vertices of the triangles, where alone files of triangles show it;
        ``"joints"``, ``"surfaces"``: how many;
        ``"details"``: for each ``"id"``, ``"name"``, ``"kind"``, ``"carved"`` and
        ``"floor_error_mm"``, how far its floor is from the true offset, None where it is not
        carved; ``"walls"``: for each part with walls
        ``"thinnest_mm"`` and ``"thickest_mm"``; ``"closed"``; ``"open_edges"``: names;
        ``"gaps"``: of each end that nearly meets something ``"curve"``, ``"other"`` and
        ``"width_mm"``;
        ``"warnings"``.
    """
    names = piece_names(result.net, result.curves)
    joints = {joint for joint, _ in result.net.joints if joint}
    edges = list(_shared_edges(result, names, job))
    return {
        "curves": len([curve for curve in result.curves if curve.spline is not None]),
        "joints": len(joints),
        "surfaces": len(result.filled),
        "loops": [loop_names(one.loop, names) for one in result.patches],
        "patches": [_patch(one, result, names, edges, job) for one in result.filled],
        "edges": edges,
        "details": [_detail(one) for one in result.detailed.details],
        "closed": result.is_closed,
        "walls": [
            {"thinnest_mm": body.wall.thinnest, "thickest_mm": body.wall.thickest}
            for body in result.walls
            if body.wall is not None
        ],
        "open_edges": [names[edge] for edge in result.open_edges],
        "gaps": [
            {"curve": gap.curve, "other": gap.other, "width_mm": gap.width} for gap in result.gaps
        ],
        "warnings": [caution.message for caution in cautions_of(state, result)],
        "unit": "mm",
    }


def _patch(
    one: SolvedPatch,
    result: ProductResult,
    names: tuple[str, ...],
    edges: Sequence[Mapping[str, Any]],
    job: Job,
) -> dict[str, Any]:
    assert one.mesh is not None
    job.checkpoint(0.5, one.name)
    mesh = one.mesh
    quality = radius_ratios(mesh)
    smooth = [edge for edge in edges if edge["smooth"] and one.name in edge["patches"]]
    return {
        "id": one.patch.id,
        "name": one.name,
        "group": group_name(one.name),
        "curves": loop_names(one.loop, names),
        "holes": [loop_names(hole, names) for hole in outlines_of(result.net, one.loop)[1:]],
        "vertices": len(mesh.vertices),
        "quality_min": float(quality.min()),
        "quality_p5": float(np.quantile(quality, 0.05)),
        "boundary_error_mm": boundary_error(one, result),
        "area_mm2": float(np.linalg.norm(_across(mesh), axis=1).sum() / 2.0),
        "g1_deg": max((edge["angle_deg"] for edge in smooth), default=0.0),
        "g1_vertices_deg": max((edge["angle_vertices_deg"] for edge in smooth), default=0.0),
    }


def _detail(one: SolvedDetail) -> dict[str, Any]:
    return {
        "id": one.detail.id,
        "name": one.name,
        "kind": one.detail.kind,
        "carved": not one.problem,
        "floor_error_mm": None if one.problem else one.deviation,
    }


def _shared_edges(
    result: ProductResult, names: Sequence[str], job: Job
) -> Iterator[dict[str, Any]]:
    """Yield each edge between two surfaces, with the greatest angle at which they meet there.

    Their normals are compared: the exact ones, or those of the vertices of triangles.
    """
    at_edge: dict[int, list[tuple[SolvedPatch, int]]] = {}
    for one in result.filled:
        for place, (edge, _) in enumerate(one.loop):
            at_edge.setdefault(edge, []).append((one, place))
    for edge, uses in sorted(at_edge.items()):
        if len(uses) != 2:
            continue
        job.checkpoint(0.0, names[edge])
        (first, here), (second, there) = uses
        assert first.surface is not None
        assert second.surface is not None
        crease = result.net.edges[edge].crease
        angle, shown = meeting_angles(first.surface, here, second.surface, there)
        yield {
            "curve": names[edge],
            "patches": [first.name, second.name],
            "crease": None if np.isnan(crease) else crease,
            "smooth": first.is_smooth_at(here) and second.is_smooth_at(there),
            "angle_deg": angle,
            "angle_vertices_deg": shown,
        }


@remembered(limit=4096)
def meeting_angles(
    first: Fill | PaperSurface, here: int, second: Fill | PaperSurface, there: int
) -> tuple[float, float]:
    """Return the greatest angles between two surfaces along an edge, its ends included, degrees.

    Parameters
    ----------
    first, second : Fill or PaperSurface
        On both sides of the edge, both of one kind.
    here, there : int
        Which half edge of their loops it is.

    Returns
    -------
    anywhere, shown : float
        On the whole edge, and at the vertices of its triangles.
    """
    vertices = _largest(_normals_at_vertices(first, here), _normals_at_vertices(second, there))
    if not (isinstance(first, Fill) and isinstance(second, Fill)):
        return vertices, vertices
    even = _largest(first.normals_along(here, MEASURED), second.normals_along(there, MEASURED))
    return max(even, vertices), vertices


def _largest(a: Array, b: Array) -> float:
    sine = np.linalg.norm(cross_product(a, b), axis=1)
    return float(np.degrees(np.arctan2(sine, (a * b).sum(axis=1)).max()))


def _normals_at_vertices(surface: Fill | PaperSurface, half_edge: int) -> Array:
    if isinstance(surface, Fill):
        return surface.normals_along(half_edge)
    return surface.normals[surface.border_of(half_edge)]


@remembered(limit=1024, key=lambda mesh: mesh)
def border_of(mesh: Mesh) -> Index:
    """Return the numbers of the vertices on the border of a mesh."""
    sides = np.sort(np.concatenate([mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    pairs, times = np.unique(sides, axis=0, return_counts=True)
    return np.unique(pairs[times == 1])


def _across(mesh: Mesh) -> Array:
    a, b, c = mesh.vertices.astype(float)[mesh.faces].transpose(1, 0, 2)
    return cross_product(b - a, c - a)


@remembered(limit=1024, key=lambda one, result: (one.surface, one.loop))
def boundary_error(one: SolvedPatch, result: ProductResult) -> float:
    """Return the greatest distance of the border of a patch's mesh from its curves, mm."""
    assert one.mesh is not None
    mesh = one.mesh
    border = border_of(mesh)
    if not len(border):
        return 0.0
    points = mesh.vertices[border].astype(float)
    gaps = np.full(len(points), np.inf)
    for edge, _ in one.loop:
        spline = result.net.edges[edge].spline
        feet = spline.value(spline.foot_points(points))
        gaps = np.minimum(gaps, np.linalg.norm(feet - points, axis=1))
    return float(gaps.max())


def cautions_of(state: ProductState, result: ProductResult) -> tuple[Caution, ...]:
    """Return what of the chosen curve was guessed, surfaces that are missing, and what is open."""
    told = (
        *_of_chosen(state),
        *_sentences(result),
        *_of_kinks(result),
        *_of_paper(state, result),
        *_of_walls(state, result),
    )
    return tuple(Caution(sentence) for sentence in told)


def _of_chosen(state: ProductState) -> Iterator[str]:
    """Yield how the chosen curve was laid in space, where it may be meant otherwise."""
    curve = state.chosen_of(Curve)
    if curve is not None:
        yield from (f"{curve.name}: {sentence}" for sentence in curve.told)


def _of_paper(state: ProductState, result: ProductResult) -> Iterator[str]:
    """Yield what surfaces as in the paper are not."""
    if result.is_exact:
        return
    yield (
        "Surfaces as in the paper are triangles: print files hold them, STEP, IGES and 3DM get the "
        "curves. Set “Surfaces” to “Fair” to hand them over exactly."
    )
    if state.shown(Detail):
        yield "Surfaces as in the paper leave details out. Set “Surfaces” to “Fair” to have them."


def _of_walls(state: ProductState, result: ProductResult) -> Iterator[str]:
    bodies = [body.wall for body in result.walls]
    if None in bodies:
        yield (
            f"Walls of {state.wall:g} mm do not fit, so the product is handed over without. "
            "Make them thinner, or the product larger."
        )
    if any(body.left_out for body in result.walls):
        yield (
            "What is cut through is left out of walls that grow outward. Let them grow inward to "
            "have it."
        )
    found = [wall for wall in bodies if wall is not None]
    if any(wall.rounded for wall in found):
        yield (
            "Walls run into one another, or are thicker than the surfaces' bends: the edges of "
            "their far side are rounded off. Make them thinner to keep edges sharp."
        )
    if found:
        yield (
            "The far sides of walls are triangles: print files hold them, STEP, IGES and 3DM get "
            "the curves. Set the wall to 0 to hand the surfaces over exactly."
        )


def _of_gaps(result: ProductResult) -> Iterator[str]:
    for gap in result.gaps[:MOST_GAPS]:
        other = gap.other or "the plane of symmetry"
        yield (
            f"{gap.curve} ends {gap.width:.3g} mm beside {other}; no surface goes over that gap. "
            "Touch its end with the tool “Join”, or draw it on to there."
        )
    more = len(result.gaps) - MOST_GAPS
    if more > 0:
        yield f"{more} more ends of curves nearly meet something. Their gaps are lit on the sheet."


def _of_kinks(result: ProductResult) -> Iterator[str]:
    """Yield smooth edges at an end of which curves lie in no common plane, the worst first."""
    if not result.is_exact:
        return
    names = piece_names(result.net, result.curves)
    found = sorted(
        ((angle, names[edge]) for edge, angle in end_kinks(result).items() if angle >= KINKED),
        key=lambda one: (-one[0], one[1]),
    )
    for angle, name in found[:MOST_KINKS]:
        yield (
            f"{name} is smooth, but at its end the surfaces beside it meet at {angle:.0f}°: the "
            "curves there lie in no common plane. Turn their ends with the tool “Modify”, or make "
            f"{name} a crease."
        )
    more = len(found) - MOST_KINKS
    if more > 0:
        yield f"{more} more smooth edges end where curves lie in no common plane."


def end_kinks(result: ProductResult) -> dict[int, float]:
    """Return of each smooth edge the angle at which its surfaces are to meet at its ends, degrees.

    Both take the normals of the edge, but for those at its ends, where each keeps to the tangents
    of its own curves.
    """
    normals = edge_normals(result.net, tuple(one.loop for one in result.patches))
    ends: dict[int, list[Array]] = {}
    for one, own in zip(result.patches, normals, strict=True):
        for place, (edge, _) in enumerate(one.loop):
            field = own.fields[place]
            if one.fill is not None and field is not None and one.is_smooth_at(place):
                ends.setdefault(edge, []).append(field.normals[[0, -1]])
    return {
        edge: float(np.degrees(np.arccos(np.clip(np.abs((a * b).sum(axis=1)), 0.0, 1.0)).max()))
        for edge, (a, b) in ((edge, both) for edge, both in ends.items() if len(both) == 2)
    }


def _sentences(result: ProductResult) -> Iterator[str]:
    names = piece_names(result.net, result.curves)
    for one in result.patches:
        if one.surface is None:
            yield f"{one.name} has no surface: {one.problem}"
        elif one.limited and one.fill is not None and one.fill.has_holes:
            yield (
                f"{one.name} has holes, so it stays as it is under pressure. Draw curves from its "
                "outline to the holes to inflate what is between them."
            )
        elif one.limited:
            yield (
                f"{one.name} holds less than its pressure asks for, or it would come off its "
                "smooth edges. Lower the pressure, or make an edge a crease."
            )
        if one.creased:
            edges = ", ".join(names[one.loop[k][0]] for k in one.creased)
            yield (
                f"{one.name} has creases at {edges}: it would fold if it were smooth there. Draw a "
                "curve across to have it smooth."
            )
        if one.pull_problem:
            yield f"{one.name} stays: {one.pull_problem}"
    for group in result.kept:
        if not result.is_exact:
            yield f"The V-spring folds {group}, so it stays. Lower “V-spring” or “Let curves go”."
            continue
        yield (
            f"Not all curves of {group} were let go: its surfaces have no single outline, fold as "
            "one, or meet in creases only. Group surfaces that lie side by side."
        )
    for detail in result.detailed.details:
        if detail.problem:
            yield f"{detail.name} is not carved: {detail.problem}"
        elif detail.told:
            yield f"{detail.name}: {detail.told}"
    yield from _of_gaps(result)
    for patch in result.lost:
        yield f"{patch.name} has lost a curve or a joint. Join its curves again, or delete it."
    if result.filled and not result.is_closed:
        row = [names[edge] for edge in result.open_edges]
        shown = ", ".join(row[:6]) + (" …" if len(row) > 6 else "")
        if row:
            count = "1 edge is" if len(row) == 1 else f"{len(row)} edges are"
            yield (
                f"The surfaces do not close: {count} open ({shown}). Draw what is "
                "missing, or touch the open areas with the tool “Loop”."
            )
        elif result.one_sided:
            yield (
                "The surfaces have one side only, as a Möbius strip, so the product is no solid. "
                "Touch one of them with the tool “Loop” to leave it open."
            )
        else:
            yield "Three or more surfaces meet at an edge, so the product is no solid."
