"""Settings of OpenGL that are made before the application object exists."""

from __future__ import annotations

import os
import sys
from typing import Final

from PySide6.QtCore import QCoreApplication, Qt
from PySide6.QtGui import QSurfaceFormat

__all__ = ["prepare"]

DEPTH_BITS: Final = 24
SAMPLES: Final = 4
"""Samples per pixel against jagged edges."""


def prepare() -> None:
    """Set the surface format and share contexts; call before making the QApplication.

    Contexts are shared because pyqtgraph keeps one set of shader programs for the whole
    process: without it a second viewport raises a GL error. macOS gives modern OpenGL only
    as a core profile; elsewhere the driver's default is the most compatible.
    """
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    wanted = QSurfaceFormat()
    wanted.setDepthBufferSize(DEPTH_BITS)
    wanted.setSamples(SAMPLES)
    if sys.platform == "darwin":
        wanted.setVersion(3, 3)
        wanted.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    QSurfaceFormat.setDefaultFormat(wanted)
    # A picture of hundreds of objects takes ten thousand calls: asking after each of them whether
    # it could be done takes as long as doing it. The viewport asks once a picture.
    os.environ.setdefault("PYOPENGL_ERROR_CHECKING", "0")
    if os.environ.get("WAYLAND_DISPLAY") and not os.environ.get("DISPLAY"):
        # PyOpenGL would look for GLX, which a Wayland session without X does not have.
        os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
