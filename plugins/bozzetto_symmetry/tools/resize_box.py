"""Size the box by dragging its faces, and move it along the centre plane by its middle."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, Gesture, Tap, override
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_symmetry.model.axes import AXES, along
from bozzetto_symmetry.model.box_grid import grid_step
from bozzetto_symmetry.model.facts import FARTHEST, SIZE_LIMITS, SYMMETRIES
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.tools.erase import ErasingTool
from bozzetto_symmetry.view.box import BOX_TOOL, CENTRE, FACES, box_layers
from bozzetto_symmetry.view.vanishing_lines import view_dependent_scene

FLAT: Final = float(np.sin(np.radians(8.0)))
"""Sine of the angle between the centre plane and the line of sight below which a drag along
the plane says nothing about depth."""

ROUNDING: Final = 3
"""Decimals of a millimetre that are kept of what is dragged freely."""


class ResizeBox(ErasingTool):
    """Makes the box longer, wider or higher by a dragged face, and moves it by its middle.

    The face opposite stays where it is. A face that is parallel to the centre plane takes
    its twin along, so that the plane stays; with Ctrl every face does. Sizes are whole steps
    of the grid, with Shift any. The middle moves only along the centre plane, for a plane
    that moved would make other curves of the ink that was drawn.
    """

    id = BOX_TOOL
    title = "Box"
    icon = "icons/box.svg"
    hint = "Drag a face of the box to size it, its middle to move it. Shift: any size."
    gesture = "drag"

    @override
    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return the box as it would be."""
        if not isinstance(gesture, Drag):
            return Scene()
        shaped = self.drag(state, gesture, context)
        return Scene(box_layers(shaped)) + view_dependent_scene(shaped, gesture.camera)

    @override
    def tap(self, state: SymmetryState, tap: Tap, context: Context) -> SymmetryState:
        """Change nothing: beside all handles there is nothing of the box."""
        return state

    @override
    def drag(self, state: SymmetryState, drag: Drag, context: Context) -> SymmetryState:
        """Size or move the box.

        Raises
        ------
        UserError
            If the handle does not belong to the box, or the drag means nothing in this view.
        """
        if drag.handle == CENTRE:
            return _moved(state, drag)
        if drag.handle in FACES:
            return _sized(state, drag)
        raise UserError("This handle does not belong to the box. Drag one of the box's faces.")


def _sized(state: SymmetryState, drag: Drag) -> SymmetryState:
    """Return the state with the dragged face where the pen is."""
    axis, sense = FACES[drag.handle]
    size, centre = list(state.size), np.array(state.centre)
    outwards = sense * AXES[axis]
    face = centre + 0.5 * size[axis] * outwards
    way = along(drag.camera, _pen(drag, face), face, outwards)
    if way is None:
        raise UserError("From here this edge of the box is seen end-on. Turn the view, then drag.")
    both = drag.ctrl or state.symmetry == list(SYMMETRIES.values())[axis]
    wanted = size[axis] + way * (2.0 if both else 1.0)
    step = grid_step(max(size))
    if drag.shift:
        wanted = round(wanted, ROUNDING)
    else:
        wanted = max(step, step * round(wanted / step))
    wanted = float(np.clip(wanted, *SIZE_LIMITS))
    if not both:
        centre += 0.5 * (wanted - size[axis]) * outwards
    size[axis] = wanted
    length, width, height = size
    return replace(_at(state, centre), length=length, width=width, height=height)


def _moved(state: SymmetryState, drag: Drag) -> SymmetryState:
    """Return the state with the middle under the pen, in the plane in which it may move."""
    centre = np.array(state.centre)
    normal = _pinned(state, drag.camera)
    pixel = _pen(drag, centre)
    (place,) = drag.camera.on_plane(pixel, centre, normal)
    _, (sight,) = drag.camera.rays(pixel)
    if not np.isfinite(place).all() or abs(float(sight @ normal)) < FLAT:
        raise UserError(
            "From here the plane is seen edge-on. Turn the view, then move the box along it."
        )
    way = place - centre
    if not drag.shift:
        step = grid_step(max(state.size))
        way = step * np.round(way / step)
    way[np.abs(normal) == 1.0] = 0.0
    return _at(state, centre + way)


def _pinned(state: SymmetryState, camera: Camera) -> Array:
    """Return the axis along which the middle does not move.

    It is square to the centre plane. Where the plane is not one of the box, it is the axis that
    points most at the eye.
    """
    if state.symmetry == "free":
        return np.asarray(AXES[int(np.argmax(np.abs(camera.axes[2])))])
    return np.asarray(AXES[list(SYMMETRIES.values()).index(state.symmetry)])


def _pen(drag: Drag, held: Array) -> Array:
    """Return where on the sheet the held place goes: the pen need not have met it exactly."""
    seen, _ = drag.camera.project(held)
    points = drag.path.points
    return np.asarray(seen[0] + points[-1] - points[0])


def _at(state: SymmetryState, centre: Array) -> SymmetryState:
    if np.abs(centre).max() > FARTHEST:
        raise UserError("That is too far away. Drag less.")
    x, y, z = (round(float(v), ROUNDING) + 0.0 for v in centre)
    return replace(state, centre=(x, y, z))
