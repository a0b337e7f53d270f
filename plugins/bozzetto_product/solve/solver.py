"""From the recipe to surfaces."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

from bozzetto.ink import Stroke
from bozzetto.plugin import Job, remembered
from bozzetto_product.details.bodies import DetailedBodies, detailed_bodies
from bozzetto_product.details.ground import Ground
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.fill.normals import smooth_half_edges
from bozzetto_product.loops.boundaries import loop_of, mirrored_boundary
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import Detail
from bozzetto_product.model.joints import Boundary, Joint
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.cutting import net_of
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.shaping.pressure import inflated, volume_of_pressure
from bozzetto_product.shaping.pull import Pulled, pulled
from bozzetto_product.solve.bodies import walled_bodies
from bozzetto_product.solve.canvas import canvases_of, outward_at
from bozzetto_product.solve.following import followed_curves
from bozzetto_product.solve.gaps import gaps_of
from bozzetto_product.solve.groups import faired_groups
from bozzetto_product.solve.paper_surfacing import surfaced_as_in_paper
from bozzetto_product.solve.result import ProductResult, SolvedPatch

FOLDED = (
    "it folds over itself. Bend a curve round it, draw a curve across, or touch the area to leave "
    "it open."
)


NO_SURFACE: Final = (
    "no surface goes through these curves. Draw a curve across, or leave the area open."
)


def solve_product(state: ProductState, job: Job) -> ProductResult:
    """Solve a product: curves follow, are cut at their joints, and visible loops are filled.

    What did not change is remembered: the net by its curves and joints, each surface by its
    curves and what smooths it.
    """
    canvases = canvases_of(state, job.sources)
    curves = followed_curves(state.of_kind(Curve), canvases)
    net = cut_net(curves, state.joints, state.symmetry)
    job.checkpoint(0.1, "Curves")
    wanted: list[tuple[Patch, bool, Loop]] = []
    lost: list[Patch] = []
    for patch in state.shown(Patch):
        boundaries = [(False, patch.boundary)]
        if patch.mirrored:
            boundaries.append((True, mirrored_boundary(patch.boundary)))
        for mirrored, boundary in boundaries:
            loop = loop_of(net, boundary)
            if loop is None:
                lost.append(patch)
                break
            wanted.append((patch, mirrored, loop))
    outward = partial(outward_at, canvases)
    loops = orient_loops(net, [loop for _, _, loop in wanted], outward).loops
    meant = [(patch, mirrored) for patch, mirrored, _ in wanted]
    if state.surfaces == "paper":
        made = surfaced_as_in_paper(state, net, meant, loops, job)
        patches, groups, detailed = made.patches, made.groups, DetailedBodies()
    else:
        groups = faired_groups(state, net, loops, [patch for patch, _ in meant])
        job.checkpoint(0.2, "Groups")
        patches = _fair_patches(state, groups.net, meant, loops, job)
        job.checkpoint(0.95, "Details")
        detailed = _detailed(patches, state, job)
    net, curves = groups.net, groups.shown(curves)
    filled = [one for one in patches if one.surface is not None]
    walls = walled_bodies(state, filled, detailed, job)
    job.checkpoint(1.0, "Surfaces")
    result = ProductResult(
        curves,
        canvases,
        net,
        patches,
        tuple(lost),
        walls,
        groups.let_go,
        groups.kept,
        detailed,
    )
    if job.quality != "final":
        return result
    return replace(result, gaps=gaps_of(state, curves, result.size))


def _fair_patches(
    state: ProductState,
    net: Net,
    meant: Sequence[tuple[Patch, bool]],
    loops: Sequence[Loop],
    job: Job,
) -> tuple[SolvedPatch, ...]:
    """Return exact surfaces under their pressure, pulled by their strokes."""
    patches = []
    fills = _filled(net, tuple(loops), job)
    smooth = smooth_half_edges(net, tuple(loops))
    for (patch, mirrored), loop, fill, asked in zip(meant, loops, fills, smooth, strict=True):
        surface, problem, limited = _pressed(fill, patch.pressure)
        surface, unfit = _followed(surface, patch, mirrored, state.symmetry)
        patches.append(SolvedPatch(patch, mirrored, loop, surface, problem, limited, unfit, asked))
    return tuple(patches)


def _detailed(patches: Sequence[SolvedPatch], state: ProductState, job: Job) -> DetailedBodies:
    details = state.shown(Detail)
    if not details:
        return DetailedBodies()
    return detailed_bodies(
        grounds_of(patches), details, state.symmetry, lambda: job.checkpoint(0.97, "Details")
    )


def grounds_of(patches: Sequence[SolvedPatch]) -> tuple[Ground, ...]:
    """Return the surfaces of patches that have one, to lay details on."""
    return tuple(
        Ground(one.patch.id, one.mirrored, one.fill) for one in patches if one.fill is not None
    )


@remembered(limit=256)
def _pressed(fill: Fill | None, pressure: float) -> tuple[Fill | None, str, bool]:
    """Return a surface under its pressure, or why there is none, and whether it holds less."""
    if fill is None:
        return None, NO_SURFACE, False
    if fill.folded:
        return None, FOLDED, False
    if pressure == 0.0:
        return fill, "", False
    found = inflated(fill, volume_of_pressure(fill.area, pressure))
    return found.fill, "", found.limited


def _followed(
    fill: Fill | None, patch: Patch, mirrored: bool, symmetry: Plane
) -> tuple[Fill | None, str]:
    """Return a surface after all strokes that pull it, and why it does not follow one."""
    problem = ""
    for strokes, opposite in ((patch.pulls, False), (patch.pulls_mirrored, True)):
        for stroke in strokes:
            if fill is not None:
                found = _pulled(fill, stroke, symmetry if opposite != mirrored else None)
                fill, problem = found.fill, found.problem or problem
    return fill, problem


@remembered(limit=256)
def _pulled(fill: Fill, stroke: Stroke, symmetry: Plane | None) -> Pulled:
    return pulled(fill, stroke, None if symmetry is None else Reflection(symmetry))


@remembered(limit=8, key=lambda net, loops, job: (net, loops))
def _filled(net: Net, loops: tuple[Loop, ...], job: Job) -> tuple[Fill | None, ...]:
    return fill_net(net, loops, checkpoint=_counting(job, len(loops)))


def _counting(job: Job, count: int) -> Callable[[], None]:
    """Return a checkpoint that tells how many surfaces are begun; some are begun again."""
    numbers = itertools.count()

    def checkpoint() -> None:
        number = min(next(numbers), max(count - 1, 0))
        job.checkpoint(0.1 + 0.9 * number / max(count, 1), f"Surface {number + 1}")

    return checkpoint


def _network_key(
    curves: Sequence[Curve], joints: Sequence[Joint], symmetry: Plane
) -> tuple[object, ...]:
    shapes = tuple((c.id, c.spline, c.mirrored, c.edge, c.crease, c.stretches) for c in curves)
    return shapes, tuple(joints), symmetry


@remembered(limit=32, key=_network_key)
def cut_net(curves: Sequence[Curve], joints: Sequence[Joint], symmetry: Plane) -> Net:
    """Return curves cut at their joints; see `net_of`."""
    return net_of([curve for curve in curves if curve.spline is not None], joints, symmetry)


def net_of_state(state: ProductState) -> Net:
    """Return the net of a recipe, with curves where they were drawn."""
    return cut_net(state.of_kind(Curve), state.joints, state.symmetry)


def loops_of_patch(net: Net, patch: Patch) -> list[Loop]:
    """Return the loops of a patch and its mirror image that are there."""
    boundaries: list[Boundary] = [patch.boundary]
    if patch.mirrored:
        boundaries.append(mirrored_boundary(patch.boundary))
    found = (loop_of(net, boundary) for boundary in boundaries)
    return [loop for loop in found if loop is not None]
