"""Arranging: a tap chooses a part, its handles move, turn and size it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import Context, Drag, Gesture, Tap, override
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto_silhouette.appearance.surface_look import sketched
from bozzetto_silhouette.model.state import DEEPEST, Group, Part, SilhouetteState
from bozzetto_silhouette.rigging.posing import JOINT, posed, posed_scene
from bozzetto_silhouette.solids.draft import draft_of
from bozzetto_silhouette.solids.placements import carried, groups_around
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.view.drag_motion import moved, pulled, resized, settled, turned
from bozzetto_silhouette.view.handles import ARRANGE, depth_grip, grip_of, handles_layer
from bozzetto_silhouette.view.picking import TOUCHED_CELLS, touched_part

Moved = TypeVar("Moved", bound=Part | Group)

SHALLOWEST = 0.01
"""Least depth that a tool can be dragged to, as a share of the radius of its ring."""

NOTHING = "There is nothing to arrange yet. Draw a shape first."


class Arrange(ErasingTool):
    """Tap a part to choose it, drag its handles; beside all parts nothing is chosen."""

    id = ARRANGE
    title = "Arrange"
    icon = "icons/arrange.svg"
    hint = "Tap a part, then drag its handles: the middle moves it, the ring turns and sizes it."
    gesture = "drag"

    @override
    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """Show a draft of the whole shape as it would be in place of the shape shown."""
        if not isinstance(gesture, Drag):
            return Scene()
        if gesture.handle.startswith(JOINT):
            return posed_scene(state, gesture)
        arranged = self.drag(state, gesture, context)
        draft, _ = draft_of(arranged, TOUCHED_CELLS)
        held = handles_layer(arranged)
        handles = () if held is None else (held,)
        if draft is None:
            return Scene((Layer("shape"), *handles))
        shown = Shaded(sketched(arranged, draft), pickable=False)
        return Scene((Layer("shape", (shown,)), *handles))

    @override
    def tap(self, state: SilhouetteState, tap: Tap, context: Context) -> SilhouetteState:
        """Choose the part that is touched; beside all parts, none.

        Raises
        ------
        UserError
            If there is no part.
        """
        if not state.nodes:
            raise UserError(NOTHING)
        part = touched_part(state, tap.x, tap.y, tap.camera)
        return replace(state, selected="" if part is None else _chosen(state, part))

    @override
    def drag(self, state: SilhouetteState, drag: Drag, context: Context) -> SilhouetteState:
        """Move, turn or size.

        Raises
        ------
        UserError
            If there is no part, the handle's is gone, or the drag says nothing from this side.
        """
        if not state.nodes:
            raise UserError(NOTHING)
        if drag.handle.startswith(JOINT):
            return posed(state, drag)
        kind, _, node_id = drag.handle.partition(":")
        node = next((node for node in state.nodes if node.id == node_id), None)
        grip = None if node is None else grip_of(state, node)
        depth = None if node is None or kind != "depth" else depth_grip(state, node)
        known = kind in ("move", "turn", "size") or depth is not None
        if node is None or grip is None or not known:
            raise UserError("This handle holds nothing any more. Tap a part to choose it.")
        start, end = drag.path.points[0].astype(float), drag.path.points[-1].astype(float)
        camera = drag.camera
        if depth is not None and isinstance(node, Part):
            by = pulled(depth.place, depth.inwards, camera, start, end)
            return state.with_node(_deepened(node, by / depth.scale, grip.radius / depth.scale))
        if kind == "move":
            motion = moved(grip.middle, camera, start, end, along_axis=drag.shift)
        elif kind == "turn":
            motion = turned(grip.middle, camera, start, end, stepped=drag.shift)
        else:
            motion = resized(grip.middle, camera, start, end)
        return state.with_node(after_motion(state, node, motion))


def _deepened(tool: Part, by: float, radius: float) -> Part:
    """Return a tool that goes deeper, in its own mm.

    Pulled out it gets shallow and never goes through again, which would be a surprise.
    """
    least = SHALLOWEST * radius if tool.depth > 0.0 else 0.0
    return replace(tool, depth=min(max(least, tool.depth + by), DEEPEST))


def after_motion(state: SilhouetteState, node: Moved, motion: Placement) -> Moved:
    """Return a node after a motion in the model's frame.

    Raises
    ------
    UserError
        If it would be beyond all bounds.
    """
    outer = carried(state, replace(node, pose=Placement()))
    try:
        pose = settled(outer.inverse().after(motion).after(outer).after(node.pose))
    except UserError:
        raise UserError("That is too far, or too large. Drag less.") from None
    return replace(node, pose=pose)


def _chosen(state: SilhouetteState, part: Part) -> str:
    """Return what a tap on a part chooses: its outermost group, at the next tap what is in that."""
    chain = [part, *groups_around(state, part)]
    ids = [node.id for node in chain]
    deeper = ids.index(state.selected) - 1 if state.selected in ids else -1
    return ids[deeper]
