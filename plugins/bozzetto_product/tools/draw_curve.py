"""Draw curve: strokes on a surface become a curve, joined to what its ends nearly meet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.ink import (
    Stroke,
    Strokes,
    distances_to_polyline,
    is_one_view,
    on_canvas,
    resample,
)
from bozzetto.plugin import Context, Gesture, Ink, NextStep, Preview, override
from bozzetto.scene import Layer, Points, Scene, Shaded, cast_rays
from bozzetto.view import Camera, triple
from bozzetto_product.model.curves import Curve, LaidPlaces
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.rough_shapes import DRAWN_ON, FollowedShape, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.drawing_plane import drawing_plane
from bozzetto_product.operations.own_image import as_own_image
from bozzetto_product.operations.pieces import delete_curves
from bozzetto_product.operations.proposals import proposals_of
from bozzetto_product.operations.trim import default_gap, trim
from bozzetto_product.projection.ink_curve import AT_PLANE, curve_from_ink
from bozzetto_product.projection.planes import in_plane
from bozzetto_product.projection.spline_basis import with_controls
from bozzetto_product.projection.views import pixel_size
from bozzetto_product.solve.canvas import Canvas, mesh_of_rough_shape
from bozzetto_product.solve.following import laid_on
from bozzetto_product.solve.found_patches import with_patches_found
from bozzetto_product.tools.product_tool import ProductTool, standing
from bozzetto_product.view.scene import CANVAS, JOIN_TOOL, SURFACES, canvas_layer_name

MAGNET: Final = 16.0
"""Gap on the sheet, px, over which an end is joined at once."""

FARTHEST_MAGNET: Final = 3.0
"""Largest gap in space that is joined at once, in gaps that *Trim* closes: what is seen near may be
far behind."""

OVER: Final = 10.0
"""Distance, px, from the chosen curve at which a stroke goes over it."""

OVER_SHARE: Final = 0.3
"""Share of a stroke over the chosen curve from which it is a further stroke of that curve: one
that only begins at it is a new curve."""

ON_ROUGH: Final = 0.5
"""Share of the ink over a rough shape from which it is drawn on that, whatever lies before it."""

SIDE: Final = 0.02
"""Distance from a followed surface, as share of its size, within which a curve is on it."""

LOOKS: Final = 48
"""Places of a stroke that are looked at."""


_LIES: Final = {
    "upright": "Draw from place to place of a surface: the curve stands upright on it.",
    "plane": "Draw in the plane that was set; “New curves lie” in the panel leads back.",
}
_COVERED: Final = (
    "Surfaces lie within what they were drawn on. Hide that in the list of objects to see them, "
    "and show it again to draw on it."
)
_UNCOVERED: Final = (
    "New curves lie on the surfaces now, not on what these were drawn on. Hide that object in the "
    "list to see them; H leads back."
)
_WITHIN: Final = (
    "Surfaces lie within what they were drawn on. Where an object hides them, hide it in the list "
    "of objects."
)
_GAP: Final = (
    "An end nearly meets a curve, {:.3g} mm away. Touch it with the tool “Join” to join them."
)


class DrawCurve(ProductTool):
    """Draws a curve on whatever is seen under the pen.

    A stroke that goes over the curve just drawn belongs to it; all others are new curves. Ends
    near others are joined, and areas that close get a surface.
    """

    id = "draw"
    title = "Draw curve"
    icon = "icons/draw.svg"
    hint = "Draw a feature curve on the rough shape; ends near others are joined."

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return what to draw next."""
        if not any(state.of_kind(kind) for kind in (Curve, RoughShape, FollowedShape)):
            return NextStep(
                "Add a rough shape from the menu and draw on it, or draw on any other object."
            )
        chosen = state.chosen_of(Curve)
        if chosen is not None and chosen.told:
            return NextStep(chosen.told[0])
        gaps = proposals_of(state, default_gap(state), {chosen.id}) if chosen is not None else ()
        if gaps:
            return NextStep(_GAP.format(gaps[0].distance), gaps[0].place, JOIN_TOOL)
        if state.of_kind(Curve) and not state.of_kind(Patch):
            return NextStep("Draw on until curves enclose an area: it gets a surface by itself.")
        has_surfaces = bool(state.of_kind(Patch))
        if has_surfaces and len(state.of_kind(FollowedShape)):
            return NextStep(_COVERED if state.shown(FollowedShape) else _UNCOVERED)
        if has_surfaces and _is_on_what_is_no_part(state):
            return NextStep(_WITHIN)
        return NextStep(_LIES.get(state.lay, self.hint))

    @override
    def begin(self, state: ProductState, context: Context) -> Preview[ProductState]:
        """Return the preview that shows where ends are caught."""
        return MagnetPreview(self, state, context)

    @override
    @standing
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Add the strokes as one curve.

        Raises
        ------
        UserError
            If the strokes make no curve.
        """
        older = continued_curve(state, ink.strokes)
        strokes = (*older.strokes, *ink.strokes) if older is not None else ink.strokes
        if not state.nodes and state.lay == "surface":
            state, context = _following_what_is_under(state, strokes, context)
        return with_drawn(state, strokes, context, older)


def _following_what_is_under(
    state: ProductState, strokes: Sequence[Stroke], context: Context
) -> tuple[ProductState, Context]:
    """Return an empty product that follows the object its first curve is drawn on, and the scene.

    It stays as it is where most of the ink is on no other object, or on what that object is not
    made of, such as the rough shape of another product.
    """
    scene = context.scene
    solid = Scene(tuple(each for each in scene.layers if not each.name.startswith(CANVAS)))
    camera = strokes[0].camera
    pixels = np.concatenate([on_canvas(stroke, camera).points for stroke in strokes]).astype(float)
    looks = pixels[np.linspace(0, len(pixels) - 1, LOOKS).astype(int)]
    models = Counter(cast_rays(solid, camera.rays(looks)).owners)
    model, count = models.most_common(1)[0]
    if not model or count < ON_ROUGH * LOOKS:
        return state, context
    part = FollowedShape(state.unused_id(), state.unused_name(DRAWN_ON), source=model)
    items = tuple(
        item
        for layer in solid.layers
        if layer.owner == model
        for item in layer.items
        if isinstance(item, Shaded) and item.pickable
    )
    canvas = Layer(canvas_layer_name(part.id), items)
    return state.with_node(part), replace(context, scene=scene + Scene((canvas,)))


def _is_on_what_is_no_part(state: ProductState) -> bool:
    """Whether curves were drawn on another object, or on a rough shape that is gone."""
    return not state.of_kind(RoughShape) and any(curve.strokes for curve in state.of_kind(Curve))


def with_drawn(
    state: ProductState, strokes: Sequence[Stroke], context: Context, older: Curve | None = None
) -> ProductState:
    """Return the state with one more curve, joined to what its ends nearly meet.

    Parameters
    ----------
    state : ProductState
        The product so far.
    strokes : sequence of Stroke
        All strokes of the curve, in one view.
    context : Context
        What is seen.
    older : Curve, optional
        The curve that these strokes replace.
    """
    base = state if older is None else delete_curves(state, older.id)
    context = replace(context, scene=canvas_scene(state, context.scene, strokes))
    plane = drawing_plane(state, strokes, context.scene)
    drawn = curve_from_ink(
        strokes,
        context,
        controls=state.controls,
        order=state.order,
        plane=plane,
        mirror_plane=state.symmetry if state.mirror else None,
        anchor=_last_place(base),
    )
    even = as_own_image(drawn.spline, state.symmetry) if state.mirror and plane is None else None
    curve = Curve(
        state.unused_id() if older is None else older.id,
        state.unused_name("Curve") if older is None else older.name,
        spline=drawn.spline if even is None else even,
        strokes=Strokes(strokes),
        plane=plane,
        told=drawn.warnings,
    )
    if plane is None:
        curve = replace(curve, laid=_laid(curve, base, context))
    if state.mirror and _is_along_plane(drawn.spline, state.symmetry, strokes[0].camera):
        flat = in_plane(drawn.spline.control_points, state.symmetry)
        spline = with_controls(drawn.spline, flat)
        curve = replace(curve, spline=spline, plane=state.symmetry, laid=None)
    is_whole = even is not None or _is_flat(curve, state)
    curve = replace(curve, mirrored=state.mirror and not is_whole)
    joined = trim(base.with_node(curve), gap=magnet_gap(base, strokes[0].camera), only={curve.id})
    return replace(with_patches_found(joined.state), selected=curve.id)


def _with_rough_shapes(state: ProductState, scene: Scene) -> Scene:
    """Return what is seen with the rough shapes, which are not there before the first stroke."""
    names = {layer.name for layer in scene.layers}
    layers = (layer for layer in _rough_layers(state) if layer.name not in names)
    return scene + Scene(tuple(layers))


def _rough_layers(state: ProductState) -> tuple[Layer, ...]:
    """Return the rough shapes of the product as they are drawn on."""
    return tuple(
        Layer(canvas_layer_name(part.id), (Shaded(mesh_of_rough_shape(part)),))
        for part in state.shown(RoughShape)
    )


def canvas_scene(state: ProductState, scene: Scene, strokes: Sequence[Stroke]) -> Scene:
    """Return what strokes are drawn on: where a rough shape is under them, not on own surfaces.

    Surfaces come while the network grows, some of them too early; what is drawn next on the rough
    shape is meant to lie on it. Where it is hidden, or not under most of the ink, surfaces count.

    Parameters
    ----------
    state : ProductState
        The product so far.
    scene : Scene
        All that is seen. What the product itself shows may be put off: it is not waited for while
        the ink is on a rough shape.
    strokes : sequence of Stroke
        Drawn in one view.
    """
    if not scene.is_made and not state.wall and not state.shown(FollowedShape):
        rough = scene.known + Scene(_rough_layers(state))
        canvas = _on_rough_shapes(state, rough, strokes)
        if canvas is not None:
            return canvas
    seen = _with_rough_shapes(state, scene)
    canvas = _on_rough_shapes(state, seen, strokes)
    return seen if canvas is None else canvas


def _on_rough_shapes(state: ProductState, scene: Scene, strokes: Sequence[Stroke]) -> Scene | None:
    """Return what is seen without own surfaces; None where the ink is not on rough shapes."""
    kinds = (*state.shown(RoughShape), *state.shown(FollowedShape))
    names = {canvas_layer_name(part.id) for part in kinds}
    rough = tuple(layer for layer in scene.layers if layer.name in names)
    owners = {layer.owner for layer in rough}
    camera = strokes[0].camera
    pixels = np.concatenate([on_canvas(stroke, camera).points for stroke in strokes]).astype(float)
    chosen = pixels[np.linspace(0, len(pixels) - 1, LOOKS).astype(int)]
    hits = cast_rays(Scene(rough), camera.rays(chosen))
    if hits.hit.mean() < ON_ROUGH:
        return None
    return Scene(
        tuple(
            layer for layer in scene.layers if layer.name != SURFACES or layer.owner not in owners
        )
    )


def continued_curve(state: ProductState, strokes: Sequence[Stroke]) -> Curve | None:
    """Return the chosen curve, if strokes go over it in the view in which it was drawn."""
    curve = state.chosen_of(Curve)
    if curve is None or not curve.strokes or curve.spline is None:
        return None
    camera = strokes[0].camera
    if not all(is_one_view(stroke.camera, camera) for stroke in (*curve.strokes, *strokes[1:])):
        return None
    paths = [on_canvas(each, camera).points for each in curve.strokes if len(each.points) > 1]
    for stroke in strokes:
        if len(stroke.points) < 2 or not np.ptp(stroke.points, axis=0).max() > 0.0 or not paths:
            return None
        places = resample(stroke.points, count=LOOKS)
        away = np.min([distances_to_polyline(places, path) for path in paths], axis=0)
        if (away <= OVER).mean() < OVER_SHARE:
            return None
    return curve


def magnet_gap(state: ProductState, camera: Camera) -> float:
    """Return the gap in space, mm, over which ends are joined while drawing."""
    return min(MAGNET / camera.pixels_per_mm, FARTHEST_MAGNET * (default_gap(state) or np.inf))


def _last_place(state: ProductState) -> tuple[float, float, float] | None:
    curves = [curve.spline for curve in state.of_kind(Curve) if curve.spline is not None]
    return triple(curves[-1].sampled(3)[1]) if curves else None


def _is_along_plane(spline: Spline, plane: Plane, camera: Camera) -> bool:
    """Whether a curve was drawn so near to a plane that it is meant to lie in it."""
    points = spline.sampled(33)
    off = np.abs(Reflection(plane).heights(points))
    return bool((off <= AT_PLANE * pixel_size(camera, points)).all())


def _is_flat(curve: Curve, state: ProductState) -> bool:
    """Whether a curve lies about in the symmetry plane, so that it has no image beside it."""
    assert curve.spline is not None
    heights = np.abs(Reflection(state.symmetry).heights(curve.spline.sampled(33)))
    size = float(np.linalg.norm(np.ptp(curve.spline.control_points, axis=0)))
    return bool(heights.max() <= 1e-9 * size)


def _laid(curve: Curve, state: ProductState, context: Context) -> LaidPlaces | None:
    """Return the places on the followed surface that a curve was drawn on."""
    assert curve.spline is not None
    names = {canvas_layer_name(part.id): part for part in state.of_kind(FollowedShape)}
    best: tuple[float, LaidPlaces] | None = None
    for layer, item in context.scene.items():
        if layer.name not in names or not isinstance(item, Shaded) or not len(item.mesh.faces):
            continue
        laid = laid_on(curve.spline, Canvas(names[layer.name], item.mesh))
        off = np.linalg.norm(laid.points - curve.spline.sampled(len(laid.points)), axis=1)
        size = float(np.linalg.norm(np.ptp(item.mesh.bounds, axis=0)))
        gap = float(np.median(off))
        if gap <= SIDE * size and (best is None or gap < best[0]):
            best = gap, laid
    return None if best is None else best[1]


class MagnetPreview(Preview[ProductState]):
    """Rings at the places to which the ends of the stroke will be joined."""

    _ends: tuple[Array, Array] | None = None

    @override
    def update(self, gesture: Gesture) -> Scene:
        """Return a mark where the first and the last sample are caught."""
        if not isinstance(gesture, Ink):
            return Scene()
        stroke = gesture.strokes[-1]
        if self._ends is None:
            self._ends = _free_places(self.state, stroke.camera)
        pixels, places = self._ends
        if not len(places):
            return Scene()
        caught = []
        for sample in (stroke.points[0], stroke.points[-1]):
            away = np.hypot(*(pixels - sample).T)
            if away.min() <= MAGNET:
                caught.append(places[int(np.argmin(away))])
        if not caught:
            return Scene()
        dots = np.array(caught, np.float32)
        return Scene((Layer("magnets", (Points(dots, color="accent", size=13.0, opacity=0.6),)),))


def _free_places(state: ProductState, camera: Camera) -> tuple[Array, Array]:
    """Return ends and joints, and places along curves: pixels (n, 2) and mm (n, 3); ends first."""
    mirror = Reflection(state.symmetry)
    rows: list[Array] = []
    for curve in state.shown(Curve):
        if curve.spline is None:
            continue
        points = curve.spline.sampled(65)
        rows.append(points)
        if curve.mirrored:
            rows.append(mirror.points(points))
    places = np.concatenate(rows) if rows else np.zeros((0, 3))
    pixels = camera.project(places)[0] if len(places) else np.zeros((0, 2))
    seen = np.asarray(np.isfinite(pixels).all(axis=1))
    return pixels[seen], places[seen]
