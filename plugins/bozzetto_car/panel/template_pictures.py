"""Pictures of the templates to choose from; a thread draws them."""

from __future__ import annotations

from functools import partial
from typing import Final

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QImage, QPainter, QPaintEvent, QPalette, QPen, QShowEvent
from PySide6.QtWidgets import QAbstractButton, QButtonGroup, QHBoxLayout, QSizePolicy, QWidget

from bozzetto.plugin import override
from bozzetto.scene import Palette
from bozzetto_app.toolkit import PanelWorker, palette_of
from bozzetto_car.panel.car_picture import Pose, SmallCar, small_car
from bozzetto_car.panel.colors import role
from bozzetto_car.template.loader import TEMPLATES, bundled

SIZE: Final = (80, 44)
"""Size of a picture, px."""

LINE: Final = 18
"""Height of the name under it, px."""

POSE: Final = Pose(62.0, 14.0)
"""Nose, side and roof are seen, which tell the templates apart."""

Role = QPalette.ColorRole


class TemplatePictures(QWidget):
    """A row with a picture of each bundled template.

    Signals
    -------
    chosen : str
        A person chose this one.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("car-guide-templates")
        self.setAccessibleName("Templates")
        self._work = PanelWorker(self)
        self._drawn: tuple[Palette, float] | None = None
        self._group = QButtonGroup(self)
        self._group.setExclusive(False)  # none is on where the template is the person's own
        self.buttons: dict[str, PictureButton] = {}
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        for name in TEMPLATES:
            button = PictureButton(bundled(name).title, self)
            button.clicked.connect(partial(self._choose, name))
            self.buttons[name] = button
            row.addWidget(button, 1)

    @property
    def busy(self) -> bool:
        """Whether pictures are being drawn."""
        return self._work.busy

    def show_template(self, name: str) -> None:
        """Show which one is the car's; none is for one of the person's own."""
        for key, button in self.buttons.items():
            button.setChecked(key == name)

    def _choose(self, name: str) -> None:
        self.buttons[name].setChecked(True)
        self.chosen.emit(name)

    def _draw(self) -> None:
        """Ask for the pictures where the colours or the pixels are others."""
        palette, scale = palette_of(self), self.devicePixelRatioF()
        if (palette, scale) == self._drawn or not self.isVisible():
            return
        self._drawn = palette, scale

        def work() -> list[SmallCar]:
            return [small_car(bundled(n), "", POSE, palette, SIZE, scale) for n in TEMPLATES]

        def done(made: list[SmallCar]) -> None:
            for button, car in zip(self.buttons.values(), made, strict=True):
                button.show_car(car, scale)

        self._work.ask(work, done)

    @override
    def showEvent(self, event: QShowEvent) -> None:
        self._draw()

    @override
    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        self._draw()


class PictureButton(QAbstractButton):
    """A template to choose: its picture and its name."""

    def __init__(self, title: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setText(title)
        self.setAccessibleName(title)
        self.setToolTip(f"The car takes its shape from a {title.lower()}; marks stay")
        self.setCheckable(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(SIZE[1] + LINE + 8)
        self._image = QImage()

    def show_car(self, car: SmallCar, scale: float) -> None:
        """Show a picture of the template."""
        height, width = car.pixels.shape[:2]
        image = QImage(car.pixels.tobytes(), width, height, QImage.Format.Format_RGBA8888)
        self._image = image.copy()  # the bytes go with the call
        self._image.setDevicePixelRatio(scale)
        self.update()

    @override
    def sizeHint(self) -> QSize:
        return QSize(SIZE[0] + 4, SIZE[1] + LINE + 8)

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        ground = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(Qt.PenStyle.NoPen)
        if self.isChecked() or self.underMouse():
            painter.setBrush(role(self, Role.Accent if self.isChecked() else Role.WindowText, 0.14))
            painter.drawRoundedRect(ground, 4.0, 4.0)
        if self.isChecked() or self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(role(self, Role.Link if self.hasFocus() else Role.Accent), 1.0))
            painter.drawRoundedRect(ground, 4.0, 4.0)
        wide = min(float(SIZE[0]), self.width() - 6.0)
        high = wide * SIZE[1] / SIZE[0]
        left, top = 0.5 * (self.width() - wide), 4.0 + 0.5 * (SIZE[1] - high)
        painter.drawImage(QRectF(left, top, wide, high), self._image)
        painter.setPen(role(self, Role.WindowText))
        below = self.rect().adjusted(2, SIZE[1] + 4, -2, -2)
        words = painter.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideRight, below.width()
        )
        painter.drawText(below, Qt.AlignmentFlag.AlignCenter, words)
