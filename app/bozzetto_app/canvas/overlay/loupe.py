"""The loupe: what is under the pen, three times as large, while a place must be met exactly.

What is on the sheet already is magnified, which costs next to nothing. Where the pen is over a
picture, that is sampled again, for it has more to show than the sheet, and lines and points
are drawn over it as fine as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import (
    QColor,
    QImage,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QPolygonF,
    QTransform,
)
from PySide6.QtWidgets import QWidget

from bozzetto.scene.display_list import EMPTY, Handle, Image, Lines, Points, Scene
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.view.camera import Camera
from bozzetto_app.canvas.screen_limits import limited_place, pieces_within, whole_point
from bozzetto_app.style.theme import qcolor

__all__ = ["DIAMETER", "MAGNIFICATION", "Loupe", "place_beside"]

DIAMETER: Final = 150
"""Of what is seen through it, pixels."""

MAGNIFICATION: Final = 3.0

RIM: Final = 4
"""Room around it for the ring, pixels."""

AWAY: Final = 100.0
"""How far its middle is to the side of the pen and above it, pixels: the hand is below."""

CROSS: Final = (5.0, 16.0)
"""Where the arms of the crosshair begin and end, pixels from the middle."""

FINEST: Final = 2 * DIAMETER
"""Pixels of a picture across the loupe that can be distinguished, on screens of double density."""

MARK_SIZE: Final = 4.5
"""Radius of handles in the loupe, pixels: a ring, so that the place itself is seen."""


def place_beside(
    pen: tuple[float, float], size: tuple[float, float], before: tuple[int, int] = (-1, -1)
) -> tuple[int, int]:
    """On which side of the pen the loupe is.

    Parameters
    ----------
    pen : (x, y)
        Position of the pen, canvas pixels.
    size : (width, height)
        Of the sheet.
    before : (int, int)
        Where it was: it goes over only where there is no room.

    Returns
    -------
    (int, int)
        −1 for left and above, 1 for right and below.
    """
    need = AWAY + 0.5 * DIAMETER + RIM
    sides = []
    for place, extent, side in zip(pen, size, before, strict=True):
        room = {-1: place >= need, 1: extent - place >= need}
        sides.append(side if room[side] or not room[-side] else -side)
    return sides[0], sides[1]


class Loupe(QWidget):
    """A round glass beside the pen.

    Parameters
    ----------
    shown : callable
        Gives the picture that is on the sheet now.
    """

    def __init__(self, shown: Callable[[], QImage], parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self.resize(QSize(DIAMETER + 2 * RIM, DIAMETER + 2 * RIM))
        self.hide()
        self._shown = shown
        self._sheet = parent
        self._palette: Palette = LIGHT
        self._scene: Scene = EMPTY
        self._camera = Camera()
        self._pen = (0.0, 0.0)
        self._sides = (-1, -1)

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self.update()

    def show_scene(self, scene: Scene, camera: Camera) -> None:
        """Say what is on the sheet, and how it is seen."""
        self._scene, self._camera = scene, camera
        if self.isVisible():
            self.update()

    def point(self, x: float, y: float) -> None:
        """Show what is at a place of the sheet."""
        x, y = self._pen = limited_place(x, y)
        self._sides = place_beside((x, y), (self._sheet.width(), self._sheet.height()), self._sides)
        half = 0.5 * self.width()
        across, along = self._sides
        self.move(whole_point(x + across * AWAY - half, y + along * AWAY - half))
        if not self.isVisible():
            self.show()
            self.raise_()
        self.update()

    def put_away(self) -> None:
        """Hide the loupe: the aimed gesture has ended. A large picture is not held for the next."""
        self._sides = (-1, -1)
        self._scene = EMPTY
        self.hide()

    # -- painting -----------------------------------------------------------------------------

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.translate(0.5 * self.width(), 0.5 * self.height())
        glass = QPainterPath()
        glass.addEllipse(QPointF(0.0, 0.0), 0.5 * DIAMETER, 0.5 * DIAMETER)
        painter.save()
        painter.setClipPath(glass)
        painter.fillPath(glass, QColor(*self._palette.paper))
        pictures = self._pictures_under()
        if pictures:
            self._paint_scene(painter, pictures)
        else:
            self._paint_sheet(painter)
        self._paint_cross(painter)
        painter.restore()
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(*self._palette.paper), 3.5))
        painter.drawPath(glass)
        painter.setPen(QPen(qcolor(self._palette.ink, 0.6), 1.2))
        painter.drawPath(glass)
        painter.end()

    def _paint_sheet(self, painter: QPainter) -> None:
        """Draw the part of the sheet under the pen, magnified."""
        shown, sheet = self._shown(), self._sheet
        if shown.isNull() or not sheet.width() or not sheet.height():
            return
        x, y = self._pen
        # Asked in pixels of the picture, which may be coarser or finer than those of the sheet.
        painter.scale(MAGNIFICATION, MAGNIFICATION)
        painter.translate(-x, -y)
        reach = 0.5 * DIAMETER / MAGNIFICATION + 1.0
        part = QRectF(x - reach, y - reach, 2.0 * reach, 2.0 * reach)
        part = part.intersected(QRectF(sheet.rect()))
        across, down = shown.width() / sheet.width(), shown.height() / sheet.height()
        source = QRectF(
            part.x() * across, part.y() * down, part.width() * across, part.height() * down
        )
        painter.drawImage(part, shown, source)
        painter.resetTransform()
        painter.translate(0.5 * self.width(), 0.5 * self.height())

    def _pictures_under(self) -> list[tuple[Image, QPolygonF]]:
        """Return the pictures under the pen, with their corners in the loupe."""
        found = []
        for _, item in self._scene.items():
            if isinstance(item, Image) and item.pixels.size:
                corner, across, down = map(np.asarray, (item.corner, item.across, item.down))
                corners = [corner, corner + across, corner + across + down, corner + down]
                places = self._in_loupe(corners)
                if np.isfinite(places).all():
                    outline = QPolygonF([QPointF(x, y) for x, y in places.tolist()])
                    if outline.containsPoint(QPointF(0.0, 0.0), Qt.FillRule.OddEvenFill):
                        found.append((item, outline))
        return found

    def _in_loupe(self, points: object) -> NDArray[np.float64]:
        """Where points of the world are seen, pixels from the loupe's middle, (n, 2)."""
        places, _ = self._camera.project(np.asarray(points, float))
        return MAGNIFICATION * (places - self._pen)

    def _paint_scene(self, painter: QPainter, pictures: list[tuple[Image, QPolygonF]]) -> None:
        """Pictures as sharp as they are, and what is drawn over them."""
        for image, outline in pictures:
            height, width = image.pixels.shape[:2]
            whole = QPolygonF(QRectF(0.0, 0.0, width, height))
            whole.removeLast()  # the first corner once more
            seen = QTransform()
            if not QTransform.quadToQuad(whole, outline, seen):
                continue
            back, possible = seen.inverted()
            if possible:
                reach = 0.5 * DIAMETER
                glass = QRectF(-reach, -reach, DIAMETER, DIAMETER)
                painter.save()
                painter.setTransform(seen, combine=True)
                painter.setOpacity(image.opacity)
                _paint_part(painter, image.pixels, back.mapRect(glass))
                painter.restore()
        for _, item in self._scene.items():
            if isinstance(item, Lines):
                self._paint_lines(painter, item)
            elif isinstance(item, Points):
                self._paint_points(painter, item)
            elif isinstance(item, Handle):
                (place,) = self._in_loupe([item.point]).tolist()
                painter.setPen(QPen(QColor(*self._palette.color(item.color)), 1.5))
                painter.setBrush(Qt.BrushStyle.NoBrush)
                if np.isfinite(place).all() and np.abs(place).max() < DIAMETER:
                    painter.drawEllipse(QPointF(*place), MARK_SIZE, MARK_SIZE)

    def _paint_lines(self, painter: QPainter, item: Lines) -> None:
        places = self._in_loupe(item.points)
        if not len(places):
            return
        least, most = np.fmin.reduce(places), np.fmax.reduce(places)
        if not ((most > -DIAMETER) & (least < DIAMETER)).all():
            return  # most lines: the loupe shows little of a sheet
        begins, ends = places[:-1], places[1:]
        if item.starts is not None:
            joined = np.ones(len(begins), np.bool_)
            joined[np.asarray(item.starts[1:], np.intp) - 1] = False
            begins, ends = begins[joined], ends[joined]
        pieces = pieces_within(begins, ends, 0.6 * DIAMETER)
        if not len(pieces):
            return
        color = QColor(*self._palette.color(item.color))
        color.setAlphaF(item.opacity)
        width = float(np.max(item.width)) if np.size(item.width) else 1.0
        painter.setPen(QPen(color, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawLines([QLineF(*piece) for piece in pieces.tolist()])

    def _paint_points(self, painter: QPainter, item: Points) -> None:
        places = self._in_loupe(item.points)
        reach = 0.5 * (DIAMETER + item.size)
        with np.errstate(invalid="ignore"):
            near: NDArray[np.bool_] = np.abs(places).max(axis=1, initial=0.0) < reach
        color = QColor(*self._palette.color(item.color))
        color.setAlphaF(item.opacity)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(color)
        for x, y in places[near].tolist():
            painter.drawEllipse(QPointF(x, y), 0.5 * item.size, 0.5 * item.size)

    def _paint_cross(self, painter: QPainter) -> None:
        begin, end = CROSS
        for color, width in (
            (qcolor(self._palette.paper, 0.85), 3.6),
            (QColor(*self._palette.ink), 1.6),
        ):
            painter.setPen(QPen(color, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
                painter.drawLine(QPointF(begin * x, begin * y), QPointF(end * x, end * y))


def _paint_part(painter: QPainter, pixels: NDArray[np.uint8], part: QRectF) -> None:
    """Paint what is needed of a picture: Qt would convert all of it each time."""
    height, width = pixels.shape[:2]
    part = part.adjusted(-1.0, -1.0, 1.0, 1.0).intersected(QRectF(0.0, 0.0, width, height))
    left, top = int(part.left()), int(part.top())
    right, bottom = min(width, int(part.right()) + 1), min(height, int(part.bottom()) + 1)
    if right <= left or bottom <= top:
        return
    step = max(1, (right - left) // FINEST, (bottom - top) // FINEST)
    rows = np.ascontiguousarray(pixels[top:bottom:step, left:right:step])
    high, wide = rows.shape[:2]
    image = QImage(rows.data, wide, high, 4 * wide, QImage.Format.Format_RGBA8888)
    painter.drawImage(QRectF(left, top, step * wide, step * high), image)
