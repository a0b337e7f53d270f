"""The view of the sheet and the style in which it is drawn."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QObject, Signal

from bozzetto.view.camera import Camera

__all__ = ["Shading", "ViewState"]

FIRST_VIEW = Camera(eye=(0.0, -500.0, 90.0), target=(0.0, 0.0, 90.0))
"""From the front, with the ground below the middle of the sheet."""

Shading = Literal["clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"]


class ViewState(QObject):
    """The camera and the drawing style.

    Attributes
    ----------
    camera : Camera
    shading : {"clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"}
    covered : int
        Pixels at the left of the sheet that something lies over.
    show_grid, show_ghost_ink : bool
        Whether the ground and the ink that models were made from are drawn.

    Signals
    -------
    camera_changed
        The camera moved.
    style_changed
        The shading, the grid or the ghost ink was switched.
    """

    camera_changed = Signal()
    style_changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.camera = FIRST_VIEW
        self.shading: Shading = "clay"
        self.covered = 0
        self.show_grid = True
        self.show_ghost_ink = True

    def set_camera(self, camera: Camera) -> None:
        """Move the camera."""
        if camera != self.camera:
            self.camera = camera
            self.camera_changed.emit()

    def set_shading(self, shading: Shading) -> None:
        """Draw surfaces in another way."""
        self.shading = shading
        self.style_changed.emit()

    def set_show_grid(self, shown: bool) -> None:
        """Show or hide the grid on the ground."""
        self.show_grid = shown
        self.style_changed.emit()

    def set_show_ghost_ink(self, shown: bool) -> None:
        """Show or hide the ink that models were made from."""
        self.show_ghost_ink = shown
        self.style_changed.emit()
