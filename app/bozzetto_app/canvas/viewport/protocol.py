"""The interface of a viewport, and the choice of the one that this machine can have."""

from __future__ import annotations

import logging
import os
from functools import cache
from typing import TYPE_CHECKING, Final, Literal, Protocol

from PySide6.QtGui import QGuiApplication, QImage, QOffscreenSurface, QOpenGLContext
from PySide6.QtWidgets import QWidget

from bozzetto_app.session.view_state import Shading

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Scene
    from bozzetto.scene.palette import Palette
    from bozzetto.view.camera import Camera

__all__ = [
    "BACKEND_VARIABLE",
    "BackendName",
    "Shading",
    "ViewportBackend",
    "choose_backend",
    "may_use_gl",
]

log = logging.getLogger(__name__)

BackendName = Literal["software", "gl"]
BACKEND_VARIABLE: Final = "BOZZETTO_VIEWPORT"
"""Environment variable that overrides the choice: "software" or "gl"."""

LEAST_GL: Final = (2, 1)
"""Oldest OpenGL version that will do."""

SCREENLESS: Final = ("offscreen", "minimal", "vnc", "linuxfb")
"""Qt platforms that show no OpenGL widget, whatever context they can make."""


class ViewportBackend(Protocol):
    """Draws a scene through a camera into a widget."""

    @property
    def widget(self) -> QWidget:
        """The widget that shows the picture."""
        ...

    def set_scene(self, scene: Scene, *, moving: bool = False) -> None:
        """Show this scene.

        Parameters
        ----------
        scene : Scene
            In world coordinates.
        moving : bool
            Whether the next scene comes in a moment, so that speed matters more than quality.
        """
        ...

    def set_live(self, scene: Scene) -> None:
        """Show this on top, or in place of layers, for as long as the pen is down.

        See `Scene.under`.
        """
        ...

    def set_camera(self, camera: Camera) -> None:
        """Look through this camera; its viewport is the widget in logical pixels."""
        ...

    def set_palette(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        ...

    def set_style(self, shading: Shading, grid: bool) -> None:
        """Say how surfaces are shaded and whether the ground is shown."""
        ...

    def grab(self) -> QImage:
        """Return the picture as it is now, at full resolution; wait for it."""
        ...

    def shown(self) -> QImage:
        """Return the picture on the screen at once; it may lag a moment behind."""
        ...

    def describe(self) -> str:
        """Return the name of the renderer, for the About dialog."""
        ...

    def release(self) -> None:
        """Free what would outlive the widget; if it paints again, it makes that again."""
        ...


def may_use_gl() -> bool:
    """Whether OpenGL is worth a try, judged without making a context."""
    if os.environ.get(BACKEND_VARIABLE, "").strip().lower() == "software":
        return False
    return QGuiApplication.platformName() not in SCREENLESS


def choose_backend() -> BackendName:
    """Return the viewport for this machine, by really making an OpenGL context.

    Needs a QGuiApplication. Contexts can also fail later, at the first paint; the canvas
    watches for that and goes back to the software viewport.
    """
    asked = os.environ.get(BACKEND_VARIABLE, "").strip().lower()
    if asked in ("software", "gl"):
        return "software" if asked == "software" else "gl"
    if asked:
        log.warning("%s=%s is neither software nor gl", BACKEND_VARIABLE, asked)
    if QGuiApplication.platformName() in SCREENLESS:
        return "software"
    return "gl" if _has_context() else "software"


@cache
def _has_context() -> bool:
    """Whether a context of a version that will do can be made; asked once in a process."""
    context = QOpenGLContext()
    if not context.create():
        return False
    surface = QOffscreenSurface()
    surface.setFormat(context.format())
    surface.create()
    if not context.makeCurrent(surface):
        return False
    version = context.format().version()
    is_usable = tuple(version) >= LEAST_GL and not context.isOpenGLES()
    context.doneCurrent()
    return is_usable
