"""Move: joints and the sizes of rough shapes, by their handles."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, Gesture, Job, NextStep, Tap, override
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import triple
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.rough_shapes import RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.curve_edits import move_joint
from bozzetto_product.operations.curve_meant import place_under
from bozzetto_product.operations.meetings import meeting_place, splines_of
from bozzetto_product.solve.canvas import Sources, mesh_of_rough_shape
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.product_tool import ProductTool, own_surfaces, standing
from bozzetto_product.view.scene import (
    CHOSEN_WIDTH,
    JOINT,
    MOVE_TOOL,
    SIZE,
    lines,
    polyline,
)

SMALLEST: Final = 1.0
"""Size to which a rough shape can be dragged, mm; smaller ones can be typed."""

REACH: Final = 14.0
"""Distance from a curve within which a touch means it, px."""

NEAR_CURVE: Final = 6.0
"""The same on a surface, which may be narrow."""

_GONE: Final = "This handle is not there any more. Drag a joint or a handle of the rough shape."


class Move(ProductTool):
    """Drags joints in the plane of the screen, and rough shapes by their sizes and their centre."""

    id = MOVE_TOOL
    title = "Move joint"
    icon = "icons/move.svg"
    group = "Reshape"
    hint = "Drag a joint; the curves that meet there come along. Touch a surface to choose it."
    gesture = "drag"

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return what can be dragged."""
        if state.chosen_of(RoughShape) is not None:
            return NextStep("Drag a face of the rough shape to size it, its middle to move it.")
        return NextStep(self.hint)

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Choose the curve under the pen, or the surface, or the rough shape.

        Raises
        ------
        UserError
            If there is none of them.
        """
        surfaces = own_surfaces(context.scene)
        surface = _surface_under(state, tap, surfaces, context.sources)
        reach = NEAR_CURVE if surface else REACH
        found = place_under(state, tap.camera, (tap.x, tap.y), surfaces, reach=reach)
        if found is not None:
            return replace(state, selected=found.curve)
        if surface:
            return replace(state, selected=surface)
        hits = context.surface_hit(tap.camera.rays(np.array([[tap.x, tap.y]])))
        shapes = state.shown(RoughShape)
        if bool(hits.hit[0]) and shapes:
            middle = [np.linalg.norm(hits.points[0] - np.array(one.centre)) for one in shapes]
            return replace(state, selected=shapes[int(np.argmin(middle))].id)
        raise UserError(
            "There is nothing here. Touch a curve, a surface or the rough shape to choose it."
        )

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curves, or the rough shape, after the drag."""
        if not isinstance(gesture, Drag):
            return Scene()
        after = self.drag(state, gesture, context)
        before = {node.id: node for node in state.nodes}
        items: list[object] = []
        for node in after.nodes:
            if node is before.get(node.id):
                continue
            if isinstance(node, RoughShape):
                items.append(Shaded(mesh_of_rough_shape(node), "accent", 0.3))
            elif isinstance(node, Curve) and node.spline is not None:
                items.append(lines([polyline(node.spline)], "accent", CHOSEN_WIDTH))
        return Scene((Layer("moved", tuple(items)),))  # type: ignore[arg-type]

    @override
    @standing
    def drag(self, state: ProductState, drag: Drag, context: Context) -> ProductState:
        """Move a joint, or size a rough shape.

        Raises
        ------
        UserError
            If the handle is not of this product, or leaves the view.
        """
        if drag.handle.startswith(JOINT):
            return _with_joint_moved(state, drag)
        if drag.handle.startswith(SIZE):
            return _with_shape_sized(state, drag)
        raise UserError(_GONE)


def _surface_under(state: ProductState, tap: Tap, scene: Scene, sources: Sources) -> str:
    """Return the id of the patch whose surface, or its mirror image, is seen there, or ""."""
    hits = cast_rays(scene, tap.camera.rays(np.array([[tap.x, tap.y]])))
    if not hits.hit[0]:
        return ""
    met = hits.surfaces[int(hits.on[0])]
    filled = solve_product(state, Job(sources=sources)).filled
    if met.number >= len(filled):
        return ""
    one = filled[met.number]
    # Another product may have surfaces, too.
    same = one.mesh is not None and np.array_equal(one.mesh.vertices, met.item.mesh.vertices)
    return one.patch.id if same else ""


def _with_joint_moved(state: ProductState, drag: Drag) -> ProductState:
    joint = next((one for one in state.joints if one.id == drag.handle.removeprefix(JOINT)), None)
    splines = splines_of(state)
    if joint is None or any(meeting.curve not in splines for meeting in joint.meetings):
        raise UserError(_GONE)
    place = meeting_place(splines, joint.meetings[0], state.symmetry)
    goal = dragged_to(drag, place)
    return move_joint(state, joint.id, goal)


def _with_shape_sized(state: ProductState, drag: Drag) -> ProductState:
    axis, _, name = drag.handle.removeprefix(SIZE).partition(" ")
    part = next((one for one in state.of_kind(RoughShape) if one.id == name), None)
    if part is None or axis not in ("c", "x", "y", "z"):
        raise UserError(_GONE)
    centre = np.array(part.centre)
    if axis == "c":
        moved = dragged_to(drag, centre)
        return state.with_node(replace(part, centre=triple(moved)))
    number = "xyz".index(axis)
    half = 0.5 * (part.length, part.width, part.height)[number]
    direction = np.eye(3)[number]
    goal = _along(drag, centre + half * direction, direction)
    size = float(np.clip(2.0 * (goal - centre[number]), SMALLEST, 1e6))
    sized = (
        replace(part, length=size),
        replace(part, width=size),
        replace(part, height=size),
    )
    return state.with_node(sized[number])


def dragged_to(drag: Drag, place: Array) -> Array:
    """Return where a place goes, parallel to the screen: the pen may hold it a little beside."""
    seen, _ = drag.camera.project(place[None])
    pixel = seen[0] + drag.path.points[-1] - drag.path.points[0]
    goal = drag.camera.on_plane(pixel[None], triple(place), drag.camera.axes[2])[0]
    if not np.isfinite(goal).all() or np.abs(goal).max() > 1e6:
        raise UserError("It cannot go there. Turn the view, and drag it again.")
    return np.asarray(goal)


def _along(drag: Drag, place: Array, direction: Array) -> float:
    """Return the coordinate along an axis that is seen nearest to where the pen is."""
    ends = np.stack((place, place + direction / drag.camera.pixels_per_mm))
    (start, step), _ = drag.camera.project(ends)
    way = step - start
    if not np.isfinite(way).all() or way @ way < 0.01:
        raise UserError("The size is seen end on here. Turn the view, and drag again.")
    moved = drag.path.points[-1] - drag.path.points[0]
    share = float(moved @ way / (way @ way)) / drag.camera.pixels_per_mm
    return float(place @ direction) + share
