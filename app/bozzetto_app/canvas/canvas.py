"""The canvas: viewport, wet ink, view cube and hand, put together."""

from __future__ import annotations

import logging
from typing import Any

from PySide6.QtCore import QEvent, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QCloseEvent,
    QFocusEvent,
    QGuiApplication,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPaintEvent,
    QResizeEvent,
    QTabletEvent,
    QTouchEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.scene.palette import Palette
from bozzetto_app.canvas.backends import ViewportBackend
from bozzetto_app.canvas.hand import Hand
from bozzetto_app.canvas.ink_overlay import InkOverlay
from bozzetto_app.canvas.pen import ProximityWatch
from bozzetto_app.canvas.samples import PressureCurve
from bozzetto_app.canvas.software import SoftwareViewport
from bozzetto_app.settings import settings

__all__ = ["Canvas"]

log = logging.getLogger(__name__)


class Canvas(QWidget):
    """Where people draw.

    Parameters
    ----------
    session : Session
        Read, called and listened to; never changed by any other road.
    palette : Palette
        Colours of the theme.
    """

    def __init__(self, session: Any, palette: Palette, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(self.tr("Sheet"))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self.setMouseTracking(True)
        self.setTabletTracking(True)
        self.setAttribute(Qt.WidgetAttribute.WA_AcceptTouchEvents)
        self.setAcceptDrops(True)
        self.setMinimumSize(200, 160)
        self._session = session
        self._colors = palette
        self._backend: ViewportBackend = SoftwareViewport(self)
        self._overlay = InkOverlay(self)
        self.hand = Hand(session, self._overlay)
        self._proximity = ProximityWatch(self)
        self._proximity.came.connect(self.hand.pen_came)
        self._proximity.left.connect(self.hand.pen_left)
        application = QApplication.instance()
        if application is not None:
            application.installEventFilter(self._proximity)
        session.scene_changed.connect(self._show_scene)
        session.live_changed.connect(self._show_live)
        session.camera_changed.connect(self._show_camera)
        session.pending_changed.connect(self._show_pending)
        session.view_style_changed.connect(self._show_style)
        session.noticed.connect(self._notice)
        self.read_settings()
        self.set_palette(palette)
        self._show_all()

    # -- the theme and the settings -------------------------------------------------------------

    def set_palette(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._colors = palette
        self._backend.set_palette(palette)
        self._overlay.set_colors(palette)

    def read_settings(self) -> None:
        """Take over what the settings say; call it when they changed."""
        self.hand.curve = PressureCurve.from_setting(settings().value("pen/pressure_curve", 1.0))

    # -- what the session shows -----------------------------------------------------------------

    def _show_all(self) -> None:
        self._show_style()
        self._show_camera()
        self._show_scene()
        self._show_live()

    def _show_scene(self) -> None:
        self._backend.set_scene(self._session.scene)
        self.hand.scene_or_view_changed()

    def _show_live(self) -> None:
        self._backend.set_live(self._session.live_scene)

    def _show_camera(self) -> None:
        self._backend.set_camera(self._session.camera)
        self.hand.scene_or_view_changed()
        self._show_pending()

    def _show_pending(self) -> None:
        self._overlay.set_pending(self._session.pending, self._session.camera)

    def _show_style(self) -> None:
        self._backend.set_style(self._session.shading, self._session.show_grid)

    def _notice(self, notice: Any) -> None:
        self._overlay.light_up(notice.places)

    # -- events -------------------------------------------------------------------------------

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._backend.widget.setGeometry(self.rect())
        self._overlay.setGeometry(self.rect())
        camera = self._session.camera
        size = (float(max(self.width(), 1)), float(max(self.height(), 1)))
        if camera.viewport != size:
            self._session.set_camera(camera.with_viewport(*size))

    def tabletEvent(self, event: QTabletEvent) -> None:
        self.hand.tablet(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_pressed(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_moved(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_released(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_pressed(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        self.hand.wheel(event)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QTouchEvent):
            self.hand.touch(event)
            return True
        return super().event(event)

    def leaveEvent(self, event: QEvent) -> None:
        self.hand.leave()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.hand.cancel():
            return
        if event.key() == Qt.Key.Key_Space:
            self.hand.space_held = True
            return
        super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Space and not event.isAutoRepeat():
            self.hand.space_held = False
            return
        super().keyReleaseEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        self.hand.space_held = False
        super().focusOutEvent(event)
