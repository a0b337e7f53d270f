"""Handles and labels, painted over the GL picture in crisp pixels of the screen."""

from __future__ import annotations

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QFont, QFontMetricsF, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from bozzetto.scene.display_list import EMPTY, Handle, Label, Scene
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.scene.renderer.labels import HALO, OFFSET, beginning
from bozzetto.scene.renderer.renderer import HANDLE_RADIUS, HANDLE_RIM
from bozzetto.view.camera import Camera
from bozzetto_app.canvas.screen_limits import is_inside, point_at
from bozzetto_app.style.theme import qcolor

__all__ = ["MarksSheet", "paint_marks"]


def paint_marks(painter: QPainter, scene: Scene, camera: Camera, palette: Palette) -> None:
    """Paint the handles and labels of a scene."""
    marks = [mark for layer in scene.layers for mark in layer.marks]
    if not marks:
        return
    places, _ = camera.project([mark.point for mark in marks])
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for mark, (x, y) in zip(marks, places.tolist(), strict=True):
        if not is_inside(x, y):
            continue
        if isinstance(mark, Handle):
            painter.setPen(QPen(qcolor(min(palette.ink, palette.paper, key=sum)), HANDLE_RIM))
            painter.setBrush(qcolor(palette.color(mark.color)))
            radius = HANDLE_RADIUS - 0.5 * HANDLE_RIM
            painter.drawEllipse(point_at(x, y), radius, radius)
        else:
            _paint_label(painter, mark, point_at(x, y), palette)


def _paint_label(painter: QPainter, label: Label, place: QPointF, palette: Palette) -> None:
    font = QFont(painter.font())
    font.setPixelSize(max(1, round(label.size)))
    letters = QPainterPath()
    wide = QFontMetricsF(font).horizontalAdvance(label.text)
    sheet = painter.device().width()
    begin = beginning(place.x(), wide, sheet, OFFSET[0])
    letters.addText(QPointF(begin, place.y() + OFFSET[1]), font, label.text)
    halo = QPen(qcolor(palette.paper), 2.0 * HALO)
    halo.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.strokePath(letters, halo)
    painter.fillPath(letters, qcolor(palette.letters(label.color)))


class MarksSheet(QWidget):
    """A transparent widget for the handles and labels of a scene."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self._scene: Scene = EMPTY
        self._camera = Camera()
        self._palette: Palette = LIGHT

    def show_marks(self, scene: Scene, camera: Camera, palette: Palette) -> None:
        """Paint these from now on."""
        self._scene, self._camera, self._palette = scene, camera, palette
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        paint_marks(painter, self._scene, self._camera, self._palette)
        painter.end()
