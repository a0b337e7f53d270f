"""The small car of the guide panel, which turns to the point that is asked for."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QCoreApplication, QElapsedTimer, QEvent, QPointF, QRectF, QSize, QTimer
from PySide6.QtGui import (
    QColor,
    QImage,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QResizeEvent,
    QShowEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from bozzetto.plugin import override
from bozzetto_app.toolkit import PanelWorker, palette_of
from bozzetto_car.panel.car_picture import Pose, SmallCar, between, pose_of, small_car
from bozzetto_car.panel.colors import role
from bozzetto_car.template.model import Template

SHAPE: Final = 0.5
"""Height of the picture per width."""

TURN: Final = 700.0
"""Duration of a turn to another point, ms."""

PULSES: Final = 3
"""Number of times that the dot swells at a new point; then it rests."""

PULSE: Final = 900.0
"""Length of one swell, ms."""

BEAT: Final = 40
"""Time between two pictures of the dot, ms."""

DOT: Final = 4.5
"""Radius of the dot, px."""

STILL: Final = "reducedMotion"
"""Property of the application: whether the person wants no animation."""


class TurningCar(QWidget):
    """The widget with the template and one node marked; a thread draws its pictures."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("car-guide-picture")
        self.setAccessibleName("The point on a small car")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._template: Template | None = None
        self._node = ""
        self._start = self._pose = Pose(40.0, 15.0)
        self._shown: SmallCar | None = None
        self._image = QImage()
        self._asked: object = None
        self._work = PanelWorker(self)
        self._clock = QElapsedTimer()
        self._pulse = QTimer(self, interval=BEAT)
        self._pulse.timeout.connect(self._beat)

    @property
    def busy(self) -> bool:
        """Whether the car still turns, or a picture is being drawn."""
        return self._work.busy

    @property
    def node(self) -> str:
        """The node that is shown."""
        return self._node

    def show_node(self, template: Template, node: str) -> None:
        """Turn to another node; "" for none."""
        if template is self._template and node == self._node:
            return
        first = self._template is None
        self._template, self._node = template, node
        self._start = self._pose
        if first or self._is_still():
            self._start = pose_of(template, node)
        self._clock.start()
        self._turn()

    def _is_still(self) -> bool:
        application = QCoreApplication.instance()
        return application is not None and bool(application.property(STILL))

    # -- turning -----------------------------------------------------------------------------------

    def _turn(self) -> None:
        """Ask for the picture of this moment, as long as the widget is visible."""
        template, node = self._template, self._node
        if template is None or not self.isVisible() or self.width() < 2:
            return
        end = pose_of(template, node)
        share = min(self._clock.elapsed() / TURN, 1.0) if self._start != end else 1.0
        pose = between(self._start, end, share)
        # While it turns a coarser picture is enough: the eye follows the car, not its edges.
        scale = self.devicePixelRatioF() if share == 1.0 else 1.0
        palette, size = palette_of(self), (self.width(), self.height())
        key = (template, node, pose, palette, size, scale)
        if key == self._asked:  # and not what is shown: another picture may be on its way
            return
        self._asked = key

        def done(made: SmallCar) -> None:
            self._take(pose, made, scale)
            if share < 1.0:
                self._turn()

        self._work.ask(lambda: small_car(template, node, pose, palette, size, scale), done)

    def _take(self, pose: Pose, made: SmallCar, scale: float) -> None:
        self._pose, self._shown = pose, made
        height, width = made.pixels.shape[:2]
        image = QImage(made.pixels.tobytes(), width, height, QImage.Format.Format_RGBA8888)
        self._image = image.copy()  # the bytes go with the call
        self._image.setDevicePixelRatio(scale)
        if pose == self._start or not self._pulse.isActive():
            self._pulse.start()
        self.update()

    def _beat(self) -> None:
        quiet = self._clock.elapsed() > TURN + PULSES * PULSE or self._is_still()
        if quiet or not self.isVisible():
            self._pulse.stop()
        self.update()

    # -- Qt ----------------------------------------------------------------------------------------

    @override
    def sizeHint(self) -> QSize:
        return QSize(260, round(260 * SHAPE))

    @override
    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.setFixedHeight(round(SHAPE * self.width()))
        self._turn()

    @override
    def showEvent(self, event: QShowEvent) -> None:
        self._turn()

    @override
    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        self._turn()

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        if self._shown is None:
            return
        painter.drawImage(QRectF(self.rect()), self._image)
        if not self._node:
            return
        at = QPointF(*self._shown.place)
        accent, ground = self._accent(), role(self, QPalette.ColorRole.Window)
        if self._pulse.isActive():
            part = (self._clock.elapsed() % PULSE) / PULSE
            accent.setAlphaF(1.0 - part)
            painter.setPen(QPen(accent, 1.5))
            painter.drawEllipse(at, DOT + 12.0 * part, DOT + 12.0 * part)
        painter.setPen(QPen(ground, 2.0))
        painter.setBrush(self._accent())
        painter.drawEllipse(at, DOT, DOT)

    def _accent(self) -> QColor:
        return QColor(*palette_of(self).accent)
