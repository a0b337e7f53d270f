"""Wet ink: what is painted while the pen is down, and until it is understood.

The stroke under the pen is painted into a backing picture piece by piece: adding a sample
touches a rectangle around the newest few samples, however long the stroke has become. Only
the last few pixels of the line, which the next sample may still bend, and one predicted
segment are painted afresh every time and never kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, QRect, QRectF, Qt, QTimer
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QWidget

from bozzetto.cached_properties import cached_property
from bozzetto.ink.checked_points import is_seen, seen_through
from bozzetto.scene.palette import LIGHT, Color, Palette
from bozzetto_app.canvas.overlay.lit_places import LitPlaces
from bozzetto_app.canvas.overlay.next_step import NextPlace
from bozzetto_app.canvas.overlay.ribbon import InkPoint, Smoother, ribbon_path, smoothed
from bozzetto_app.canvas.screen_limits import (
    inside_runs,
    limited_place,
    rect_about,
    rect_around,
)
from bozzetto_app.style.theme import qcolor

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke
    from bozzetto.scene.display_list import Paint
    from bozzetto.view.camera import Camera
    from bozzetto_app.canvas.overlay.waiting_ink import MarkedLine

__all__ = ["InkOverlay", "Tip"]

LOOSE_POINTS: Final = 12
"""Fine points painted afresh with every sample before they go into the backing picture."""

FARTHEST_PREDICTION: Final = 20.0
"""Longest predicted segment, pixels."""

PREDICTION_LIFE: Final = 40
"""How long a prediction may stand without a new sample, milliseconds."""

PREDICTION_OPACITY: Final = 0.35
ERASER_OPACITY: Final = 0.30
RING_MARGIN: Final = 3

HOT_RADIUS: Final = 13.0
"""Radius of the ring around the handle that a press would take, pixels."""


class Tip(NamedTuple):
    """How wide the pen draws.

    Parameters
    ----------
    size : float
        Width at full pressure, pixels.
    least : float
        Fraction of it at no pressure at all.
    """

    size: float = 4.2
    least: float = 0.28

    def width(self, pressure: float) -> float:
        """Return the width at a pressure (0 … 1), pixels."""
        return self.size * (self.least + (1.0 - self.least) * pressure)


PEN_TIP: Final = Tip()
ERASER_TIP: Final = Tip(36.0, 0.3)


@dataclass(frozen=True, eq=False)
class PendingInk:
    """A stroke that waits, as a camera sees it.

    Parameters
    ----------
    stroke : Stroke
    camera : Camera
    lines : list of lists of (x, y, width)
        What of it is near the sheet, pixels.
    """

    stroke: Stroke
    camera: Camera
    lines: list[list[InkPoint]]

    @classmethod
    def of(cls, stroke: Stroke, camera: Camera) -> PendingInk:
        """Return a stroke as a camera sees it."""
        places = seen_through(stroke.points, stroke.camera, camera)
        seen = is_seen(places)
        widths = PEN_TIP.width(1.0) * (
            PEN_TIP.least + (1.0 - PEN_TIP.least) * stroke.pressure[seen].astype(float)
        )
        line = np.column_stack((places[seen], widths)).tolist()
        runs = inside_runs(line)
        return cls(stroke, camera, [smoothed((x, y, wide) for x, y, wide in run) for run in runs])

    @cached_property
    def paths(self) -> list[QPainterPath]:
        """Its ribbons."""
        return [ribbon_path(line) for line in self.lines]


class InkOverlay(QWidget):
    """A transparent sheet over the viewport for wet ink, the hover ring and lit places.

    Attributes
    ----------
    lit : LitPlaces
        What is lit for a moment, with words beside it.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self._palette: Palette = LIGHT
        self._wet = QImage()
        self._pending = QImage()
        self._pending_ink: list[PendingInk] = []
        self._marked: tuple[MarkedLine, ...] = ()
        self._smoother = Smoother()
        self._loose: list[InkPoint] = []
        self._settled = False
        self._samples: list[InkPoint] = []
        self._prediction: InkPoint | None = None
        self._area = QRect()
        self._loose_area = QRect()
        self._erasing = False
        self._tip = PEN_TIP
        self._ring: tuple[float, float, float] | None = None
        self._hot: tuple[float, float, Color] | None = None
        self.lit = LitPlaces(self)
        self._next = NextPlace()
        self._stale = QTimer(self, singleShot=True, interval=PREDICTION_LIFE)
        self._stale.timeout.connect(self._drop_prediction)

    # -- the stroke under the pen -------------------------------------------------------------

    @property
    def has_wet_ink(self) -> bool:
        """Whether a stroke is being painted."""
        return bool(self._samples)

    @property
    def prediction(self) -> tuple[float, float] | None:
        """Where the predicted segment ends, if there is one."""
        return None if self._prediction is None else self._prediction[:2]

    def begin(self, *, erasing: bool = False) -> None:
        """Start a stroke."""
        self.clear_wet()
        self.lit.light_up(())
        self._erasing = erasing
        self._tip = ERASER_TIP if erasing else PEN_TIP

    def extend(self, samples: Iterable[tuple[float, float, float]]) -> QRect:
        """Add samples (x, y, pressure) to the stroke.

        Returns
        -------
        QRect
            The part of the sheet that must be painted again.
        """
        for x, y, pressure in samples:
            point = (*limited_place(x, y), self._tip.width(pressure))
            self._samples.append(point)
            self._loose += self._smoother.push(point)
        if len(self._loose) > LOOSE_POINTS:
            self._settle()
        self._predict()
        dirty = self._loose_area
        self._loose_area = self._bounds(self._moving_line())
        dirty = dirty.united(self._loose_area)
        self._area = self._area.united(dirty)
        self.update(dirty)
        self._stale.start()
        return dirty

    def clear_wet(self) -> None:
        """Take the stroke away, whether it was finished or cancelled."""
        if not self._samples:
            return
        if not self._wet.isNull():
            painter = QPainter(self._wet)
            painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_Clear)
            painter.fillRect(self._area, Qt.GlobalColor.transparent)
            painter.end()
        self.update(self._area)
        self._smoother = Smoother()
        self._loose, self._samples, self._prediction = [], [], None
        self._settled = False
        self._area, self._loose_area = QRect(), QRect()
        self._stale.stop()

    # -- ink that waits -----------------------------------------------------------------------

    def set_pending(
        self, strokes: Sequence[Stroke], camera: Camera, marked: Sequence[MarkedLine] = ()
    ) -> None:
        """Show ink that no modeler has taken yet: what is good so far, and what is marked.

        Every lift of the pen asks for it: only ink that is new, or seen from elsewhere, costs time.
        """
        before, marks = self._pending_ink, self._marked
        known = {id(one.stroke): one for one in before if one.camera == camera}
        ink = [
            known.get(id(stroke)) or PendingInk.of(stroke, camera)
            for stroke in strokes
            if stroke.tool != "eraser"
        ]
        self._pending_ink, self._marked = ink, tuple(marked)
        if not ink and not before and not self._marked and not marks:
            return
        kept = len(before)
        if (
            self._marked
            or marks
            or any(one is not other for one, other in zip_longest(before, ink[:kept]))
        ):
            kept = 0
        if kept < len(ink) or not kept:
            self._paint_pending(kept)
            self.update()

    # -- marks beside the ink -----------------------------------------------------------------

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self._paint_all()

    def set_hover(self, place: tuple[float, float] | None, *, erasing: bool = False) -> None:
        """Show the ring of the tip's size at a place, or take it away."""
        before = self._ring_area()
        if place is None:
            self._ring = None
        else:
            radius = 0.5 * (ERASER_TIP.size if erasing else max(PEN_TIP.size, 7.0))
            self._ring = (*limited_place(*place), radius)
        self.update(before.united(self._ring_area()))

    def set_hot_handle(self, place: tuple[float, float] | None, paint: Paint = "accent") -> None:
        """Show which handle a press would take."""
        hot = None if place is None else (*limited_place(*place), self._palette.color(paint))
        if hot != self._hot:
            for mark in (self._hot, hot):
                if mark is not None:
                    self.update(rect_around(mark[0], mark[1], HOT_RADIUS + RING_MARGIN))
            self._hot = hot

    def light_up(self, places: Sequence[tuple[float, float]], words: str = "") -> None:
        """Light rings at places for a moment, with words beside the first."""
        self.lit.light_up(places, words)

    def mark_next(self, place: tuple[float, float] | None) -> None:
        """Show where the next step is to be done; None takes the mark away."""
        if place != self._next.place:
            self.update(self._next.move(place))

    @property
    def next_place(self) -> tuple[float, float] | None:
        """Where the next step is marked."""
        return self._next.place

    # -- painting -----------------------------------------------------------------------------

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        scale = self.devicePixelRatioF()
        area = event.rect()
        source = QRectF(
            area.x() * scale, area.y() * scale, area.width() * scale, area.height() * scale
        )
        if self._pending_ink or self._marked:
            painter.drawImage(QRectF(area), self._pending, source)
        if self._samples:
            self._paint_wet(painter, area, source)
        self._paint_marks(painter)
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._paint_all()

    def _paint_wet(self, painter: QPainter, area: QRect, source: QRectF) -> None:
        painter.setOpacity(ERASER_OPACITY if self._erasing else 1.0)
        painter.drawImage(QRectF(area), self._wet, source)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self._ink_color())
        line = self._moving_line()
        if self._prediction is not None:
            painter.drawPath(ribbon_path(line[:-1], open_start=self._settled))
            painter.setOpacity(PREDICTION_OPACITY * painter.opacity())
            painter.drawPath(ribbon_path(line[-2:], open_start=True))
        else:
            painter.drawPath(ribbon_path(line, open_start=self._settled))
        painter.setOpacity(1.0)

    def _paint_marks(self, painter: QPainter) -> None:
        self._next.paint(painter, self._palette)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        if self._hot is not None:
            x, y, rim = self._hot
            painter.setPen(QPen(QColor(*rim), 2.0))
            painter.drawEllipse(QPointF(x, y), HOT_RADIUS, HOT_RADIUS)
        if self._ring is not None:
            x, y, radius = self._ring
            painter.setPen(QPen(qcolor(self._palette.ink, 0.55), 1.2))
            painter.drawEllipse(QPointF(x, y), radius, radius)
        self.lit.paint(painter, self._palette)

    # -- how the backing pictures come about ----------------------------------------------------

    def _ink_color(self) -> QColor:
        return QColor(*(self._palette.accent if self._erasing else self._palette.ink))

    def _settle(self) -> None:
        """Paint the loose part into the backing picture; its last point stays the joint."""
        joint = ribbon_path(self._loose, open_start=self._settled, open_end=True)
        self._paint_into(self._wet, [joint])
        self._settled = True
        self._area = self._area.united(self._bounds(self._loose))
        self._loose = self._loose[-1:]

    def _moving_line(self) -> list[InkPoint]:
        """Return the part that is repainted: loose points, the newest sample, the prediction."""
        line = list(self._loose)
        if self._smoother.tip is not None:
            line.append(self._smoother.tip)
        if self._prediction is not None:
            line.append(self._prediction)
        return line

    def _predict(self) -> None:
        """One segment ahead, as long as the last one: the pen keeps its speed for a moment."""
        self._prediction = None
        if len(self._samples) < 3 or self._erasing:
            return
        (x0, y0, _), (x1, y1, width) = self._samples[-2:]
        dx, dy = x1 - x0, y1 - y0
        length = math.hypot(dx, dy)
        if length < 0.5:
            return
        reach = min(1.0, FARTHEST_PREDICTION / length)
        self._prediction = (x1 + reach * dx, y1 + reach * dy, width)

    def _drop_prediction(self) -> None:
        self._prediction = None
        self.update(self._loose_area)

    def _ring_area(self) -> QRect:
        if self._ring is None:
            return QRect()
        x, y, radius = self._ring
        return rect_around(x, y, radius + RING_MARGIN)

    def _blank(self) -> QImage:
        scale = self.devicePixelRatioF()
        image = QImage(
            math.ceil(self.width() * scale),
            math.ceil(self.height() * scale),
            QImage.Format.Format_ARGB32_Premultiplied,
        )
        image.setDevicePixelRatio(scale)
        image.fill(Qt.GlobalColor.transparent)
        return image

    def _paint_all(self) -> None:
        """Make the backing pictures again: for another size, scale or theme."""
        self._wet = self._blank()
        if self._samples:
            samples, self._smoother, self._loose = self._samples, Smoother(), []
            for point in samples:
                self._loose += self._smoother.push(point)
            self._settled = False
            self._settle()
        self._paint_pending()
        self.update()

    def _paint_pending(self, kept: int = 0) -> None:
        """Paint the ink that waits; the first strokes are in the picture already."""
        if not kept:
            some = self._pending_ink or self._marked
            self._pending = self._blank() if some else QImage()
        new = self._pending_ink[kept:]
        self._paint_into(self._pending, (path for one in new for path in one.paths))
        if self._marked and not self._pending.isNull():
            painter = QPainter(self._pending)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            for line in self._marked:
                line.paint(painter, self._palette)
            painter.end()

    def _paint_into(self, image: QImage, paths: Iterable[QPainterPath]) -> None:
        if image.isNull():
            return
        painter = QPainter(image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self._ink_color())
        for path in paths:
            painter.drawPath(path)
        painter.end()

    @staticmethod
    def _bounds(line: Sequence[InkPoint]) -> QRect:
        if not line:
            return QRect()
        margin = 0.5 * max(point[2] for point in line) + 2.0
        return rect_about([point[0] for point in line], [point[1] for point in line], margin)
