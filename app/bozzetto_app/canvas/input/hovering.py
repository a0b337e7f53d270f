"""Hovering: what lies under a pen that is near the sheet, and what the tool in the hand wants."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from bozzetto.plugin.gesture import Tap
from bozzetto_app.canvas.input.handle_picking import HANDLE_REACH, INKING_REACH, HandleTargets

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Handle
    from bozzetto_app.canvas.input.report_pace import ReportPace
    from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
    from bozzetto_app.session.session import Session
    from bozzetto_app.session.tool_groups import ToolInfo

__all__ = ["Hovering"]


class Hovering:
    """Shows the ring and the hot handle, and tells tools that want to know where the pen is.

    Parameters
    ----------
    session : Session
    overlay : InkOverlay
        Where the ring and the hot handle are shown.
    pace : ReportPace
        How often a tool is told.
    """

    def __init__(self, session: Session, overlay: InkOverlay, pace: ReportPace) -> None:
        self._session, self._overlay, self._pace = session, overlay, pace
        self._targets: HandleTargets | None = None
        self._is_told = False

    # -- the tool in the hand --

    @property
    def takes(self) -> Literal["ink", "tap", "drag"]:
        """The kind of gesture that the active tool wants, or an underlay that is aligned."""
        if self._is_aligning:
            return "tap"
        tool = self._session.toolbox.active
        return "ink" if tool is None else tool.gesture

    @property
    def aims(self) -> bool:
        """Whether positions are wanted that are met exactly."""
        return self._is_aligning or self.tool_is(lambda tool: tool.aims)

    def tool_is(self, question: Callable[[ToolInfo], bool]) -> bool:
        """Return the answer to a question about the active tool; False while none is meant."""
        tool = self._session.toolbox.active
        return tool is not None and not self._is_aligning and question(tool)

    @property
    def _is_aligning(self) -> bool:
        return self._session.pictures.placing.is_aligning

    # -- under the pen --

    def scene_or_view_changed(self) -> None:
        """Forget the positions of handles, and the lit one: they may differ now."""
        self._targets = None
        self._overlay.set_hot_handle(None)

    def handle_under(self, x: float, y: float) -> tuple[Handle, float, float] | None:
        """Return the handle at a place of the canvas, with where it is; None if there is none."""
        if self._is_aligning:
            return None
        if self._targets is None:
            scene = self._session.scene
            self._targets = HandleTargets(
                scene.visible.under(scene.advice), self._session.view.camera
            )
        exact = self.takes == "ink" or self.aims
        return self._targets.under(x, y, INKING_REACH if exact else HANDLE_REACH)

    def move(self, x: float, y: float, *, eraser: bool) -> None:
        """Follow a pen or a mouse that is over the sheet."""
        found = None if eraser else self.handle_under(x, y)
        self._tell(None if eraser or found is not None else (x, y))  # a handle is the shell's own
        if found is None:
            self._overlay.set_hot_handle(None)
            inks = eraser or self.takes == "ink"
            self._overlay.set_hover((x, y) if inks else None, erasing=eraser)
        else:
            handle, hx, hy = found
            self._overlay.set_hover(None)
            self._overlay.set_hot_handle((hx, hy), handle.color)

    def leave(self) -> None:
        """Show nothing: the pointer has left the canvas."""
        self._tell(None)
        self._overlay.set_hover(None)
        self._overlay.set_hot_handle(None)

    def _tell(self, place: tuple[float, float] | None) -> None:
        """Tell a tool that wants to know it where the pen is near the sheet; None where it left."""
        if place is not None and self.tool_is(lambda tool: tool.hovers):
            if self._pace.is_time():
                self._pace.begin()
                self._is_told = True
                self._session.gestures.hovered(Tap(*place, self._session.view.camera))
        elif self._is_told:
            self._is_told = False
            self._session.gestures.cancel()
