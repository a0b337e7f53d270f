"""Looking: from where the sheet is seen, and in which style."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QObject, Signal

from bozzetto.view.camera import Camera

__all__ = ["Looking", "Shading"]

FIRST_VIEW = Camera(eye=(0.0, -500.0, 90.0), target=(0.0, 0.0, 90.0))
"""From the front, with the ground below the middle of the sheet."""

Shading = Literal["clay", "zebra", "curvature", "normals", "xray"]


class Looking(QObject):
    """The view and its style; the session is one of these.

    Signals
    -------
    camera_changed, view_style_changed
        The view moved; shading, grid or ghost ink were switched.
    """

    camera_changed = Signal()
    view_style_changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.camera = FIRST_VIEW
        self.shading: Shading = "clay"
        self.show_grid = True
        self.show_ghost_ink = True

    def set_camera(self, camera: Camera) -> None:
        """Look from elsewhere."""
        if camera != self.camera:
            self.camera = camera
            self.camera_changed.emit()

    def set_shading(self, shading: Shading) -> None:
        """Show surfaces differently."""
        self.shading = shading
        self.view_style_changed.emit()

    def set_show_grid(self, shown: bool) -> None:
        """Show or hide the ground."""
        self.show_grid = shown
        self.view_style_changed.emit()

    def set_show_ghost_ink(self, shown: bool) -> None:
        """Show or hide processed ink."""
        self.show_ghost_ink = shown
        self.view_style_changed.emit()
