"""Common to all tools: the eraser's end, and the state after the network has changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Final, TypeAlias, TypeVar

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, distances_to_polyline, resample
from bozzetto.plugin import Context, Ink, Job, NextStep, Tool, override
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Camera
from bozzetto_product.details.bodies import SolvedDetail
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import Detail
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.pieces import delete_curves
from bozzetto_product.solve.canvas import Sources
from bozzetto_product.solve.following import where_it_stands
from bozzetto_product.solve.found_patches import with_patches_found
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.view.scene import SURFACES, polyline

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

NO_CURVE: Final = "Draw a curve first; this tool changes curves that are there."

REACH: Final = 9.0
"""Half the width of the eraser, px."""

MOST: Final = 0.4
"""Share of a curve that must be rubbed over for it to go."""

MOST_ALONG: Final = 0.6
"""Share of a path along a curve from which that curve is meant, however little of it."""

ALONG: Final = 0.5
"""Share of the path over a curve, against the curve it covers most, from which it is meant too."""

SAME_PLACE: Final = 0.01
"""Distance, as share of the size, within which what is seen is what lies there."""

LOOKS: Final = 64
"""Places of a path that are looked at."""

Self_ = TypeVar("Self_")
Given = TypeVar("Given")
Made = TypeVar("Made")
Method: TypeAlias = Callable[[Self_, ProductState, Given, Context], Made]


def standing(method: Method[Self_, Given, Made]) -> Method[Self_, Given, Made]:
    """Give a method of a tool the product where it stands on what it follows; a decorator."""

    @wraps(method)
    def with_curves_there(
        self: Self_, state: ProductState, gesture: Given, context: Context
    ) -> Made:
        return method(self, where_it_stands(state, context.sources), gesture, context)

    return with_curves_there


class ProductTool(Tool[ProductState]):
    """A tool of the modeler: the eraser does the same with all of them."""

    @override
    @standing
    def erase(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Take away the curves that the eraser's path runs along, or the details under it."""
        return erased(state, ink.strokes[-1], context.sources)


class CurveTool(ProductTool):
    """A tool for curves that are there."""

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture; where there is no curve, that one is to be drawn."""
        return NextStep(self.hint) if has_curves(state) else NextStep(NO_CURVE, tool="draw")


def own_surfaces(scene: Scene) -> Scene:
    """Return the surfaces of products in what is seen."""
    return Scene(tuple(layer for layer in scene.layers if layer.name == SURFACES))


def has_curves(state: ProductState) -> bool:
    """Whether there is a curve that was drawn."""
    return any(curve.spline is not None for curve in state.of_kind(Curve))


def erased(state: ProductState, path: Stroke, sources: Sources) -> ProductState:
    """Return the state without the curves that a path runs along, or the details that it is over.

    Parameters
    ----------
    state : ProductState
        As it stands on what it follows.
    path : Stroke
        Of the eraser.
    sources : Sources
        What it follows.

    Raises
    ------
    UserError
        If there is neither under it.
    """
    meant = curves_along(state, path)
    if meant:
        return changed(state, lambda before: delete_curves(before, *meant))
    details = {one.detail.id for one in details_under(state, path, sources)}
    if details:
        nodes = tuple(node for node in state.nodes if node.id not in details)
        selected = "" if state.selected in details else state.selected
        return replace(state, nodes=nodes, selected=selected)
    raise UserError(
        "There is no curve and no detail here. Rub along the curve, or over the detail, that is "
        "to go."
    )


def details_under(state: ProductState, path: Stroke, sources: Sources) -> list[SolvedDetail]:
    """Return the details, or mirror images, of which the outline is rubbed over or all round.

    A detail on the far side of the product is not meant.
    """
    import shapely

    if not state.shown(Detail):
        return []
    result = solve_product(state, Job("preview", sources=sources))
    meshes = [one.fill.mesh for one in result.filled if one.fill is not None]
    scene = Scene((Layer("surfaces", tuple(Shaded(mesh) for mesh in meshes)),))
    rubbed = shapely.MultiPoint(np.asarray(path.points, float)).convex_hull.buffer(REACH)
    found = []
    for one in result.detailed.details:
        for outline in one.outlines:
            pixels = path.camera.project(outline)[0]
            if not np.isfinite(pixels).all() or not _is_seen(scene, path.camera, outline, pixels):
                continue
            ring = shapely.Polygon(pixels) if one.detail.closed else shapely.LineString(pixels)
            line = shapely.LineString(pixels)
            over = line.intersection(rubbed).length >= MOST * line.length
            if over or (one.detail.closed and ring.buffer(0.0).intersects(_line(path))):
                found.append(one)
                break
    return found


def _line(path: Stroke) -> BaseGeometry:
    import shapely

    return shapely.MultiPoint(np.asarray(path.points, float))


def _is_seen(scene: Scene, camera: Camera, outline: Array, pixels: Array) -> bool:
    """Whether most of an outline on surfaces is in front of them."""
    hits = cast_rays(scene, camera.rays(pixels))
    size = float(np.linalg.norm(np.ptp(scene.points(), axis=0)))
    gaps = np.linalg.norm(np.asarray(hits.points, float) - outline, axis=1)
    return bool((~hits.hit | (gaps <= SAME_PLACE * size)).mean() > 0.5)


def changed(state: ProductState, operation: Callable[[ProductState], ProductState]) -> ProductState:
    """Return the state after an operation on its curves, with the patches of the network now."""
    after = operation(state)
    return after if after is state else with_patches_found(after)


def images_of(state: ProductState, camera: Camera) -> list[tuple[Curve, bool, Array]]:
    """Return how visible curves and mirror images are seen: places (n, 2) px, none behind."""
    mirror = Reflection(state.symmetry)
    found = []
    for curve in state.shown(Curve):
        if curve.spline is None:
            continue
        points = polyline(curve.spline)
        for mirrored in (False, True) if curve.mirrored else (False,):
            pixels = camera.project(mirror.points(points) if mirrored else points)[0]
            seen = np.asarray(pixels[np.isfinite(pixels).all(axis=1)])
            if len(seen) > 1:
                found.append((curve, mirrored, seen))
    return found


def curves_along(state: ProductState, path: Stroke) -> tuple[str, ...]:
    """Return the ids of the curves that an eraser's path runs along, and not only across."""
    if len(path.points) < 2 or not np.ptp(path.points, axis=0).max() > 0.0:
        places = np.asarray(path.points[:1], float)
    else:
        places = resample(path.points, count=LOOKS)
    best: dict[str, tuple[int, float]] = {}
    for curve, _, pixels in images_of(state, path.camera):
        near = int((distances_to_polyline(places, pixels) <= REACH).sum())
        rubbed = (distances_to_polyline(pixels, places) <= REACH).mean() if len(places) > 1 else 0.0
        if near > best.get(curve.id, (0, 0.0))[0]:
            best[curve.id] = near, float(rubbed)
    most = max((near for near, _ in best.values()), default=0)
    return tuple(
        name
        for name, (near, rubbed) in best.items()
        if near >= max(1, ALONG * most)
        and (rubbed >= MOST or len(places) == 1 or near >= MOST_ALONG * len(places))
    )
