"""From the software viewport, which is there at once, to OpenGL, and back if it fails."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, QRect, Qt, QTimer, Signal
from PySide6.QtWidgets import QWidget

from bozzetto_app.canvas.viewport.protocol import (
    Shading,
    ViewportBackend,
    choose_backend,
    may_use_gl,
)
from bozzetto_app.canvas.viewport.software import SoftwareViewport
from bozzetto_app.canvas.viewport.thickness_channel import ThicknessChannel
from bozzetto_app.workers.channel import Channel, Request
from bozzetto_app.workers.qt_classes import QtClasses

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job
    from bozzetto.scene.display_list import Scene
    from bozzetto.scene.palette import Palette
    from bozzetto_app.canvas.viewport.opengl import GLViewport
    from bozzetto_app.session.session import Session

__all__ = ["GL_PATIENCE", "Viewports"]

log = logging.getLogger(__name__)

GL_PATIENCE: Final = 12_000
"""How long the first OpenGL picture may take before the software one stays, milliseconds."""


def _import_gl(job: Job) -> type[GLViewport]:
    """Import pyqtgraph and OpenGL, which take half a second, beside the window."""
    from bozzetto_app.canvas.viewport.opengl import GLViewport

    return GLViewport


class Viewports(QObject):
    """Keeps the viewport that is shown, and the OpenGL one while it has to prove itself.

    Parameters
    ----------
    session : Session
        Whose scene and view are shown.
    canvas : QWidget
        Parent of the viewports, which lie below its other children.
    palette : Palette

    Signals
    -------
    first_painted
        The window has been painted once.
    """

    first_painted = Signal()

    def __init__(self, session: Session, canvas: QWidget, palette: Palette) -> None:
        super().__init__(canvas)
        self._session = session
        self._canvas = canvas
        self._colors = palette
        self._style: tuple[Shading, bool] = ("clay", True)
        self._rising: GLViewport | None = None
        self._imports = Channel("import-gl", parent=self)
        self._classes = QtClasses(self)
        self._classes.made.connect(self._import)
        self.thickness = ThicknessChannel(self)
        """Measures the scene while it is shown in the colours of its thickness."""
        self.thickness.changed.connect(self._show_measured)
        if may_use_gl():
            from PySide6.QtOpenGLWidgets import QOpenGLWidget

            # A window that gets its first OpenGL child later is rebuilt: it would vanish
            # and come back under the person's eyes. A hidden child from the start avoids it.
            QOpenGLWidget(canvas).hide()
        software = SoftwareViewport(canvas)
        software.first_painted.connect(self._painted_first, Qt.ConnectionType.QueuedConnection)
        software.painted.connect(session.solver.frame_painted)
        self.current: ViewportBackend = software
        """The viewport that is shown."""

    @property
    def is_proving(self) -> bool:
        """Whether an OpenGL viewport still has to prove itself."""
        return self._rising is not None

    # -- what they show -------------------------------------------------------------------------

    def show_all(self) -> None:
        """Show everything as it is now."""
        self.set_palette(self._colors)
        self.show_style()
        self.show_camera()
        self.show_scene()
        self.show_live()

    def show_scene(self) -> None:
        """Show the session's scene."""
        self._session.solver.expect_paint(self._canvas.isVisible())
        self._show(self._session.scene.visible)

    def _show(self, scene: Scene) -> None:
        moving = self._session.drawing.is_dragging
        if self._session.view.shading == "thickness":
            scene = self.thickness.shown(scene, self._colors, moving=moving)
        for viewport in self._both():
            viewport.set_scene(scene, moving=moving)

    def _show_measured(self) -> None:
        if self.thickness.view is not None:
            self._show(self._session.scene.visible)

    def show_live(self) -> None:
        """Show what is there only while the pen is down."""
        for viewport in self._both():
            viewport.set_live(self._session.scene.live)

    def show_camera(self) -> None:
        """Look through the session's camera."""
        for viewport in self._both():
            viewport.set_camera(self._session.view.camera)

    def show_style(self) -> None:
        """Shade and show the ground as the session says.

        Where a picture was drawn from, its own ground is what is seen.
        """
        session = self._session
        grid = session.view.show_grid and not session.advice.holds_eye(session.view.camera)
        shading_before, _ = self._style
        self._style = session.view.shading, grid
        for viewport in self._both():
            viewport.set_style(*self._style)
        if session.view.shading != shading_before and "thickness" in (
            shading_before,
            session.view.shading,
        ):
            self.thickness.forget()
            self._show(session.scene.visible)

    def show_advice(self) -> None:
        """See whether the view stands where a picture was drawn from."""
        session = self._session
        held = session.advice.holds_eye(session.view.camera)
        if self._style != (session.view.shading, session.view.show_grid and not held):
            self.show_style()

    def set_palette(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._colors = palette
        for viewport in self._both():
            viewport.set_palette(palette)
        if self._session.view.shading == "thickness":
            self._show(self._session.scene.visible)

    def set_geometry(self, area: QRect) -> None:
        """Fill a part of the canvas."""
        for viewport in self._both():
            viewport.widget.setGeometry(area)

    def release(self) -> None:
        """Give back what would outlive the window."""
        for viewport in self._both():
            viewport.release()

    def _both(self) -> list[ViewportBackend]:
        return [self.current] if self._rising is None else [self.current, self._rising]

    # -- the change -----------------------------------------------------------------------------

    def _painted_first(self) -> None:
        """Look whether OpenGL works, now that the window is on the screen."""
        self.first_painted.emit()
        if choose_backend() == "gl":
            self._classes.start()

    def _import(self) -> None:
        self._imports.submit(Request(_import_gl, self._raise_gl, self._missing))

    def _missing(self, problem: BaseException) -> None:
        # PyOpenGL raises AttributeError where the system has no GL library at all.
        if not isinstance(problem, ImportError | OSError | AttributeError):
            raise problem
        log.warning("no OpenGL viewport: %s", problem)

    def _raise_gl(self, viewport: type[GLViewport]) -> None:
        """Make the OpenGL viewport below the software one, which stays until it is proved."""
        rising = self._rising = viewport(self._canvas)
        rising.painted.connect(self._session.solver.frame_painted)
        rising.proved.connect(self._proved, Qt.ConnectionType.QueuedConnection)
        rising.failed.connect(self.give_up_gl, Qt.ConnectionType.QueuedConnection)
        self.show_all()
        rising.setGeometry(self.current.widget.geometry())
        rising.stackUnder(self.current.widget)
        rising.show()
        QTimer.singleShot(GL_PATIENCE, self, self._late)

    def _proved(self) -> None:
        if self._rising is not None:
            software, self.current, self._rising = self.current, self._rising, None
            _remove(software.widget)

    def _late(self) -> None:
        if self._rising is not None:
            self.give_up_gl("no picture in time")

    def give_up_gl(self, reason: str) -> None:
        """Go (back) to the software viewport."""
        log.warning("the OpenGL viewport failed: %s", reason)
        if self._rising is not None:
            self._rising.release()
            failed: QWidget = self._rising
            self._rising = None
        elif isinstance(self.current, SoftwareViewport):
            return
        else:
            self.current.release()
            failed = self.current.widget
            software = SoftwareViewport(self._canvas)
            software.painted.connect(self._session.solver.frame_painted)
            software.setGeometry(failed.geometry())
            software.lower()
            software.show()
            self.current = software
            self.show_all()
        _remove(failed)


def _remove(widget: QWidget) -> None:
    widget.hide()
    widget.deleteLater()
