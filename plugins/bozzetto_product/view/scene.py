"""The scene of a product: rough shapes, surfaces, curves, joints and open edges."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Mesh, Spline, flattened
from bozzetto.plugin import remembered
from bozzetto.scene import Handle, Layer, Lines, Paint, Points, Scene, Shaded
from bozzetto.view import triple
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint
from bozzetto_product.model.rough_shapes import FollowedShape, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Edge
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.corners import corners_of
from bozzetto_product.projection.planes import plane_through
from bozzetto_product.solve.canvas import Canvas, canvases_of
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.view.colors import colors_of
from bozzetto_product.view.detail_view import (
    EMBLEM_TOOL,
    chosen_outline,
    emblem_handles,
    problem_outlines,
    surface_items,
    wall_meshes,
)

ROUGH_OPACITY: Final = 0.34
"""Of a rough shape: the back of it is seen, and that it is no part of the product."""

UNSEEN: Final = 1e-3
"""Opacity of what is not to be seen: nothing is drawn on a surface of none."""

SMALLER: Final = 0.97
"""Size of the image of a rough shape: surfaces between curves on it dip below it a little."""

WIDTH: Final = 2.2
"""Width of a curve, px."""

DRAWN_WIDTH: Final = 1.2
"""Width of a curve as drawn, where it was let go, px."""

CHOSEN_WIDTH: Final = 3.4
"""Width of the chosen curve or of the boundary of the chosen surface, px."""

MARGIN: Final = 1.3
"""Width of the margin on each side of a curve, px: ink is seen on a dark paint by it, and light
ink on a light one."""

MARGIN_OPACITY: Final = 0.7

OPEN_WIDTH: Final = 4.5
"""Width of the light on an open edge, px: it shows on both sides of the curve."""

OPEN_OPACITY: Final = 0.55

FLAT: Final = 2e-5
"""Distance of a polyline from its curve, as share of the curve's size: a twentieth of a pixel on
a curve as large as the sheet."""

SURFACES: Final = "surfaces"
"""Name of the layer of the surfaces."""

CANVAS: Final = "rough "
"""How the name of a layer begins that shows a surface to draw on; the id of its part follows."""

LIT_OPACITY: Final = 0.5
"""Opacity of a surface that would come."""

LOOP_TOOL: Final = "loop"
MOVE_TOOL: Final = "move"
PLANE_TOOL: Final = "plane"
FILLET_TOOL: Final = "fillet"
CREASE_TOOL: Final = "crease"
"""Ids of the tools that show a layer of their own."""

JOIN_TOOL: Final = "join"
"""Id of the tool that closes wide gaps."""

DOT: Final = 11.0
"""Size of a dot at a place that is meant, px."""

AROUND: Final = 1.0
"""Half the side of the square that shows a plane, in distances of its places from their middle."""

JOINT: Final = "joint "
"""How the handle of a joint begins; its id follows."""

SIZE: Final = "size "
"""How the handle of a rough shape begins; an axis and the id of the part follow."""


def scene_of(state: ProductState, result: ProductResult | None) -> Scene:
    """Return what is shown; while nothing is solved yet, rough shapes and curves."""
    curves = state.of_kind(Curve) if result is None else result.curves
    canvases = canvases_of(state, {}) if result is None else result.canvases
    layers = [_canvas_layer(state, canvas) for canvas in _shown(state, canvases)]
    if result is not None:
        layers += [
            _surfaces(result),
            _walls(result),
            Layer("open edges", tuple(_open(result)), tool=LOOP_TOOL),
        ]
        layers.append(Layer("let go", tuple(_as_drawn(state, result))))
        layers.append(Layer("margins of curves", tuple(_margins(state, curves))))
    layers.append(Layer("curves", tuple(_curves(state, curves))))
    layers.append(Layer("chosen curve", tuple(_chosen_curve(state, curves)), chosen=True))
    layers.append(Layer("plane", tuple(_plane(state)), tool="" if _lies_so(state) else PLANE_TOOL))
    if result is not None:
        layers += [
            Layer("chosen surface", tuple(_chosen(state, result)), chosen=True),
            Layer("outlines", tuple(problem_outlines(result))),
            Layer("chosen outline", tuple(chosen_outline(result, state.selected)), chosen=True),
            Layer("joints", tuple(_joints(result))),
            Layer("gaps", tuple(_gaps(result))),
            Layer("handles", tuple(_handles(state, result)), tool=MOVE_TOOL),
            Layer("creases", tuple(_creases(result)), tool=CREASE_TOOL),
            Layer("corners", tuple(_corners(state, result)), tool=FILLET_TOOL),
            Layer("text handles", tuple(emblem_handles(state, result)), tool=EMBLEM_TOOL),
        ]
    return Scene(tuple(layer for layer in layers if layer.items))


def _shown(state: ProductState, canvases: Iterable[Canvas]) -> Iterator[Canvas]:
    parts = {part.id for kind in (RoughShape, FollowedShape) for part in state.shown(kind)}
    for canvas in canvases:
        if canvas.part.id in parts and len(canvas.mesh.faces):
            yield canvas


def canvas_layer_name(part_id: str) -> str:
    """Return the name of the layer that shows a surface to draw on."""
    return CANVAS + part_id


def _canvas_layer(state: ProductState, canvas: Canvas) -> Layer:
    """Return what is drawn on, unseen, and of a rough shape a slightly smaller image.

    Curves and surfaces lie on the former; an image of the very same depth would flicker with them.
    Another model shows its surface itself.
    """
    items = [Shaded(canvas.mesh, opacity=UNSEEN)]
    if isinstance(canvas.part, RoughShape):
        color = "ghost" if canvas.part.id == state.selected else "faint"
        smaller = _smaller(canvas.mesh)
        items.append(Shaded(smaller, color=color, opacity=ROUGH_OPACITY, pickable=False))
    return Layer(canvas_layer_name(canvas.part.id), tuple(items))


@remembered(limit=16, key=lambda mesh: mesh)
def _smaller(mesh: Mesh) -> Mesh:
    centre = mesh.bounds.mean(axis=0)
    vertices = centre + SMALLER * (mesh.vertices - centre)
    return replace(mesh, vertices=vertices.astype(np.float32))


@remembered(limit=4, key=lambda result: result)
def _surfaces(result: ProductResult) -> Layer:
    items = surface_items(result, colors_of(result.filled))
    return Layer(SURFACES, tuple(items))


@remembered(limit=4, key=lambda result: result)
def _walls(result: ProductResult) -> Layer:
    """Return the far sides of walls, their rims, and what is cut through them."""
    items = [Shaded(mesh) for body in result.walls for mesh in wall_meshes(body, result)]
    return Layer("walls", tuple(items))


def _margins(state: ProductState, curves: Iterable[Curve]) -> Iterator[Lines]:
    """Yield what parts curves from the paint of the surfaces on both sides."""
    for _, points, _ in _seen(state, curves):
        yield Lines(
            points.astype(np.float32),
            color="paper",
            width=WIDTH + 2.0 * MARGIN,
            opacity=MARGIN_OPACITY,
            hidden="hide",
        )


def _curves(state: ProductState, curves: Iterable[Curve]) -> Iterator[Lines]:
    for curve, points, mirrored in _seen(state, curves):
        yield lines([points], "second" if mirrored else curve.color or "ink", WIDTH)


def _chosen_curve(state: ProductState, curves: Iterable[Curve]) -> Iterator[Lines]:
    """Yield the chosen curve and its mirror image, over those that are there always."""
    chosen = (curve for curve in curves if curve.id == state.selected)
    for _, points, mirrored in _seen(state, chosen):
        yield lines([points], "second" if mirrored else "accent", CHOSEN_WIDTH)


def _seen(state: ProductState, curves: Iterable[Curve]) -> Iterator[tuple[Curve, Array, bool]]:
    """Yield the curves that are shown as chains, and whether they are mirror images."""
    shown = {curve.id for curve in state.shown(Curve)}
    mirror = Reflection(state.symmetry)
    for curve in curves:
        if curve.spline is None or curve.id not in shown:
            continue
        points = polyline(curve.spline)
        yield curve, points, False
        if curve.mirrored:
            yield curve, mirror.points(points), True


def _as_drawn(state: ProductState, result: ProductResult) -> Iterator[Lines]:
    """Yield curves that were let go where they were drawn: there they are drawn over."""
    mirror = Reflection(state.symmetry)
    for curve in state.shown(Curve):
        if curve.spline is not None and curve.id in result.let_go:
            points = polyline(curve.spline)
            yield lines([points], "ghost", DRAWN_WIDTH)
            if curve.mirrored:
                yield lines([mirror.points(points)], "ghost", DRAWN_WIDTH)


def _lies_so(state: ProductState) -> bool:
    """Whether new curves lie in the plane that was set."""
    return state.lay == "plane" and len(state.plane_places) == 3


def _plane(state: ProductState) -> Iterator[Points | Lines]:
    """Yield the places of the plane of new curves, and a square in it."""
    if not state.plane_places:
        return
    places = np.array(state.plane_places)
    yield dots(places)
    if len(places) < 3:
        return
    middle = places.mean(axis=0)
    reach = float(np.linalg.norm(places - middle, axis=1).max())
    normal = np.asarray(plane_through(places).normal)
    along = (places[1] - places[0]) / np.linalg.norm(places[1] - places[0])
    across = cross_product(normal, along)
    corners = np.array(((1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1)))
    square = middle + AROUND * reach * (corners @ np.stack((along, across)))
    yield lines([square], "second", DRAWN_WIDTH)


def dots(places: ArrayLike, *, opacity: float = 0.8) -> Points:
    """Return dots at places that are meant."""
    points = np.asarray(places, np.float32).reshape(-1, 3)
    return Points(points, color="accent", size=DOT, opacity=opacity)


@remembered(limit=2048, key=lambda spline: spline)
def polyline(spline: Spline) -> Array:
    """Return a curve as a chain that nobody tells from it, (n, 3) mm."""
    size = float(np.linalg.norm(np.ptp(spline.control_points, axis=0)))
    return np.asarray(flattened(spline.beziers(), max(FLAT * size, 1e-12))[0])


def lines(pieces: Iterable[Array], color: Paint, width: float, *, opacity: float = 1.0) -> Lines:
    """Return polylines as one item; what is behind surfaces shows faintly."""
    row = list(pieces)
    starts = np.cumsum([0, *(len(piece) for piece in row[:-1])]).astype(np.int32)
    points = np.concatenate(row).astype(np.float32)
    return Lines(points, starts, color=color, width=width, opacity=opacity)


def edge_lines(edges: Iterable[Edge], color: Paint, width: float, opacity: float = 1.0) -> Lines:
    """Return edges of a net as one item."""
    return lines([polyline(edge.spline) for edge in edges], color, width, opacity=opacity)


def _open(result: ProductResult) -> Iterator[Lines]:
    edges = [result.net.edges[number] for number in result.open_edges]
    if edges:
        yield edge_lines(edges, "warning", OPEN_WIDTH, OPEN_OPACITY)


def _gaps(result: ProductResult) -> Iterator[Lines]:
    if result.gaps:
        yield lines([np.array(gap.ends) for gap in result.gaps], "warning", OPEN_WIDTH)


def _chosen(state: ProductState, result: ProductResult) -> Iterator[Lines]:
    for one in result.patches:
        if one.patch.id == state.selected:
            edges = [result.net.edges[edge] for edge, _ in one.loop]
            yield edge_lines(edges, "accent", CHOSEN_WIDTH)


def _joints(result: ProductResult) -> Iterator[Points]:
    net = result.net
    met = np.zeros(len(net.nodes), int)
    for edge in net.edges:
        for node in (edge.start, edge.end):
            if node >= 0:
                met[node] += 1
    for chosen, color, size in ((met > 1, "ink", 6.0), (met == 1, "warning", 5.0)):
        if chosen.any():
            yield Points(net.nodes[chosen].astype(np.float32), color=color, size=size)


def _handles(state: ProductState, result: ProductResult) -> Iterator[Handle]:
    net = result.net
    known: dict[str, Joint] = {joint.id: joint for joint in state.joints}
    for place, (joint, mirrored) in zip(net.nodes, net.joints, strict=True):
        if joint in known and not mirrored:
            yield Handle(f"{JOINT}{joint}", triple(place), tip="Joint: drag it")
    for part in state.shown(RoughShape):
        if part.id == state.selected:
            yield from size_handles(part)


def _creases(result: ProductResult) -> Iterator[Lines]:
    """Yield the edges of which was said how surfaces meet there: creases, and the others."""
    for is_crease, color in ((True, "accent"), (False, "second")):
        edges = [edge for edge in result.net.edges
                 if np.isfinite(edge.crease) and (edge.crease >= 1.0) == is_crease]  # fmt: skip
        if edges:
            yield edge_lines(edges, color, OPEN_WIDTH, OPEN_OPACITY)


def _corners(state: ProductState, result: ProductResult) -> Iterator[Handle]:
    """Yield a handle in each corner that can be rounded."""
    splines = {curve.id: curve.spline for curve in result.curves if curve.spline is not None}
    for corner in corners_of(state.joints, splines, state.symmetry):
        yield Handle(corner.name, corner.handle, tip="Corner: drag the arc")


def size_handles(part: RoughShape) -> Iterator[Handle]:
    """Yield the handles at the ends of a rough shape along its axes, and at its centre."""
    half = 0.5 * np.array((part.length, part.width, part.height))
    centre = np.array(part.centre)
    yield Handle(f"{SIZE}c {part.id}", triple(centre), "second", tip="Move the rough shape")
    for axis, letter in enumerate("xyz"):
        place = centre + half[axis] * np.eye(3)[axis]
        yield Handle(f"{SIZE}{letter} {part.id}", triple(place), "second", tip="Size")
