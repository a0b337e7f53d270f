"""The underlay that is chosen: moved, turned and scaled by handles, or brought to two places.

Its handles lie on its border, so that tools reach what lies in its middle; they go as soon as
something is drawn, and come again with its row in the list.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from PySide6.QtCore import QObject, Signal

from bozzetto.document import edit
from bozzetto.document.underlay_place import (
    UnderlayPlace,
    aligned,
    place_of,
    placed,
    places_under,
)
from bozzetto.errors import UserError
from bozzetto.scene.display_list import Handle, Layer, Lines, Points, Scene
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from bozzetto.document.model import Document, Underlay
    from bozzetto.plugin.gesture import Drag, Tap
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.object_edits import ObjectEdits
    from bozzetto_app.session.scene_model import SceneModel
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.toolbox import Toolbox

__all__ = ["UnderlayPlacing", "is_of_underlay"]

OWNER: Final = "underlay:"
"""How the ids of these handles begin; those of modelers have no colon in front."""

CORNERS: Final = ("0,0", "1,0", "1,1", "0,1")
"""Shares of the way across and down of the handles at the corners."""

MOVE, TURN = "move", "turn"

STALK: Final = 0.1
"""How far the handle that turns stands above the upper border, as a share of the height."""

ANGLE_STEP: Final = 15.0
"""Turns with Shift go in steps of so many degrees."""

LEAST: Final = 1e-3
"""The least share of its size to which one drag makes a picture smaller."""


def is_of_underlay(handle: str) -> bool:
    """Return whether a handle belongs to an underlay, and to no modeler."""
    return handle.startswith(OWNER)


class UnderlayPlacing(QObject):
    """Places the underlay whose row was chosen last.

    Signals
    -------
    changed
        Another underlay is chosen, it lies elsewhere, or another touch is expected.
    """

    changed = Signal()

    def __init__(
        self,
        drawing: DocumentModel,
        selection: Selection,
        toolbox: Toolbox,
        scene: SceneModel,
        objects: ObjectEdits,
        notices: Notices,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._drawing, self._scene = drawing, scene
        self._objects, self._notices = objects, notices
        self._id = ""
        self._touched: list[tuple[float, float, float]] | None = None
        self._before: Underlay | None = None
        drawing.changed.connect(self._refresh)
        drawing.models_changed.connect(self._refresh)
        selection.changed.connect(self.leave)
        toolbox.tool_changed.connect(self.leave)
        toolbox.modeler_changed.connect(self.leave)

    # -- the one that is chosen --

    @property
    def underlay(self) -> Underlay | None:
        """The underlay that is chosen and seen."""
        found = (one for one in self._drawing.document.underlays if one.id == self._id)
        return next((one for one in found if one.visible), None)

    @property
    def place(self) -> UnderlayPlace | None:
        """Where it lies; None where none is chosen, or it has no area."""
        underlay = self.underlay
        try:
            return None if underlay is None else place_of(underlay)
        except UserError:
            return None

    def choose(self, underlay_id: str) -> None:
        """Show the handles of an underlay; "" for none."""
        if underlay_id != self._id:
            self._id, self._touched, self._before = underlay_id, None, None
            self._refresh()

    def leave(self) -> None:
        """Take the handles away: something else is chosen, or drawn."""
        self.choose("")

    # -- placing --

    def set_place(self, place: UnderlayPlace, *, dragging: bool = False) -> None:
        """Put the chosen underlay somewhere; the drag of a field is one step."""
        underlay = self.underlay
        if underlay is not None:
            self._put(lambda: placed(underlay, place), dragging=dragging)

    def handle_moved(self, drag: Drag) -> None:
        """Follow a handle that is dragged."""
        if self._before is None:
            self._before = self.underlay
        before = self._before
        if before is not None:
            self._put(lambda: _dragged(before, drag), dragging=True)

    def handle_released(self, drag: Drag) -> None:
        """Take the last place of a handle."""
        self.handle_moved(drag)
        self._before = None
        self._objects.end_drag()

    def cancel(self) -> None:
        """Put the underlay back where the drag under way began."""
        before, self._before = self._before, None
        if before is not None:
            self._put(lambda: before, dragging=True)
            self._objects.end_drag()

    # -- two places --

    @property
    def is_aligning(self) -> bool:
        """Whether the next touches are places for the picture, and for no tool."""
        return self._touched is not None and self.place is not None

    @property
    def wish(self) -> str:
        """The touch that is expected, in words; "" while nothing is aligned."""
        if not self.is_aligning:
            return ""
        assert self._touched is not None
        return (
            tr("Underlay", "Touch a place in the picture."),
            tr("Underlay", "Touch where that place belongs."),
            tr("Underlay", "Touch a second place in the picture, far from the first."),
            tr("Underlay", "Touch where the second place belongs."),
        )[len(self._touched)]

    def begin_alignment(self) -> None:
        """Expect four touches: a place and where it belongs, twice."""
        if self.place is not None:
            self._touched = []
            self._refresh()

    def end_alignment(self) -> bool:
        """Expect no touches any more; return whether some were expected."""
        was, self._touched = self.is_aligning, None
        if was:
            self._refresh()
        return was

    def touch(self, tap: Tap) -> None:
        """Take the touch that is expected; after the fourth one the picture is brought there."""
        underlay = self.underlay
        if underlay is None or self._touched is None:
            return
        found = places_under(underlay, tap.camera.rays([(tap.x, tap.y)]))
        if found is None:
            self._notices.complain(
                UserError(
                    tr("Underlay", "The picture is seen from its edge. Turn the view to its front.")
                )
            )
            return
        x, y, z = (float(value) for value in found[0])
        touched = [*self._touched, (x, y, z)]
        if len(touched) < 4:
            self._touched = touched
        else:
            self._touched = None
            if self._put(lambda: aligned(underlay, touched[::2], touched[1::2])):
                said = tr("Underlay", "Both places lie where they belong. Ctrl+Z takes it back.")
                self._notices.tell(said)
        self._refresh()

    # -- what is shown --

    def _put(self, make: Callable[[], Underlay], *, dragging: bool = False) -> bool:
        """Put what `make` gives in the place of the chosen underlay; say why if it cannot be."""
        try:
            underlay = make()
        except UserError as problem:
            if not dragging:
                self._notices.complain(problem)
            return False
        lies = underlay.id, underlay.corner, underlay.across, underlay.down

        def is_back(before: Document) -> bool:
            known = before.underlays
            return any((one.id, one.corner, one.across, one.down) == lies for one in known)

        if any(one.id == underlay.id for one in self._drawing.document.underlays):
            key = f"underlay place {underlay.id}" if dragging else None
            self._objects.edit(edit.change_underlay, underlay, merge_key=key, is_back=is_back)
        return True

    def _refresh(self) -> None:
        underlay = self.underlay
        self._scene.show_grips(Scene() if underlay is None else self._grips(underlay))
        self.changed.emit()

    def _grips(self, underlay: Underlay) -> Scene:
        if self.place is None:
            return Scene()
        corner, across, down = _lies(underlay)
        corners = [corner, corner + across, corner + across + down, corner + down]
        top, foot = corner + 0.5 * across, corner + 0.5 * across + down
        above = top - STALK * down
        border = Lines(np.array([*corners, corner]), color="accent", hidden="show", width=1.0)
        if self._touched is not None:
            marks = Points(np.reshape(self._touched, (-1, 3)), "accent", 9.0, hidden="show")
            return Scene((Layer("underlay", (border, marks)),))
        stalk = Lines(np.array([top, above]), color="accent", hidden="show", width=1.0)
        size = tr("Underlay", "Drag to make the picture larger or smaller")
        handles = [_handle(name, place, size) for name, place in zip(CORNERS, corners, strict=True)]
        handles.append(_handle(MOVE, foot, tr("Underlay", "Drag to move the picture")))
        turn = tr("Underlay", "Drag to turn the picture; with Shift in steps of 15°")
        handles.append(_handle(TURN, above, turn))
        return Scene((Layer("underlay", (border, stalk, *handles)),))


def _handle(name: str, place: NDArray[np.float64], tip: str) -> Handle:
    x, y, z = (float(value) for value in place)
    return Handle(f"{OWNER}{name}", (x, y, z), tip=tip)


def _lies(underlay: Underlay) -> tuple[NDArray[np.float64], ...]:
    return np.array(underlay.corner), np.array(underlay.across), np.array(underlay.down)


def _dragged(underlay: Underlay, drag: Drag) -> Underlay:
    """Return an underlay as a drag of one of its handles leaves it.

    Raises
    ------
    UserError
        If the picture would get too small or large, or is seen from its edge.
    """
    path = drag.path
    ends = [(path.x[0], path.y[0]), (path.x[-1], path.y[-1])]
    found = places_under(underlay, path.camera.rays(ends))
    if found is None:
        raise UserError(tr("Underlay", "The picture is seen from its edge. Turn the view."))
    by = found[1] - found[0]
    place, name = place_of(underlay), drag.handle.removeprefix(OWNER)
    corner, across, down = _lies(underlay)
    middle = np.array(place.middle)
    if name == MOVE:
        x, y, z = (float(value) for value in middle + by)
        return placed(underlay, replace(place, middle=(x, y, z)))
    if name == TURN:
        grip = corner + 0.5 * across - STALK * down
        right, up = across / np.linalg.norm(across), -down / np.linalg.norm(down)
        before, after = grip - middle, grip + by - middle
        turned = math.degrees(
            math.atan2(float(after @ up), float(after @ right))
            - math.atan2(float(before @ up), float(before @ right))
        )
        turn = place.turn + turned
        if drag.shift:
            turn = ANGLE_STEP * round(turn / ANGLE_STEP)
        return placed(underlay, replace(place, turn=turn))
    u, v = (float(word) for word in name.split(","))
    here, fixed = corner + u * across + v * down, corner + (1 - u) * across + (1 - v) * down
    long = here - fixed
    share = max(float((long + by) @ long / (long @ long)), LEAST)
    x, y, z = (float(value) for value in fixed + share * (middle - fixed))
    return placed(underlay, replace(place, middle=(x, y, z), width=share * place.width))
