"""The view light: how well one can draw from here, and the way to where it goes better.

Its words are about the view while something is wrong with it; else they say what is next.

The light lets every pen stroke through; only its button is there for the hand.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QAbstractButton, QWidget

from bozzetto.scene.contrast import mixed, readable
from bozzetto.scene.palette import LIGHT, Color, Palette
from bozzetto_app.i18n import tr
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import qcolor, text_height

if TYPE_CHECKING:
    from bozzetto.plugin.view_advice import ViewAdvice

__all__ = ["ViewLight"]

MARGIN: Final = 12
"""Distance from the sheet's upper edge, pixels."""

HEIGHT: Final = 30
PADDING: Final = 12
LAMP: Final = 12.0
"""Size of the light itself, pixels."""

GAP: Final = 8
ICON: Final = 16.0
WIDEST: Final = 640
"""Most pixels that the words may take; of longer ones the first sentence is shown."""

BESIDE_THE_CENTRE: Final = 460
"""The same where they leave the centre of the sheet for the view cube."""

BESIDE: Final = 116
"""Pixels kept free at the right, where the view cube is."""

BELOW: Final = 144
"""Distance from the sheet's upper edge where there is too little room beside the cube, pixels."""

NARROW: Final = 160
"""Fewest pixels that words are set in beside the cube."""

LINES: Final = 3
"""Most lines that the first sentence takes."""

WRAPPED: Final = Qt.AlignmentFlag.AlignLeft | Qt.TextFlag.TextWordWrap

LAMPS: Final[dict[str, Color]] = {
    "good": (0x3E, 0x93, 0x4F),
    "warn": (0xD9, 0x93, 0x0D),
    "refuse": (0xC7, 0x2E, 0x2E),
}
"""Green, amber and red; a disc, a triangle and a barred square for those who see no colours."""


def _level_words(level: str) -> str:
    return {
        "good": tr("ViewLight", "A good view to draw in"),
        "warn": tr("ViewLight", "A poor view to draw in"),
        "refuse": tr("ViewLight", "No view to draw in"),
    }[level]


def words_over_sheet(advice: ViewAdvice, next_step: str) -> str:
    """Return what is wrong with the view, or with which it would be better; else what is next."""
    if advice.level != "good" or advice.better is not None or not next_step:
        return advice.message
    return next_step


class TurnButton(QAbstractButton):
    """The arrow and the word "Turn", at the light's right end."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.colors: Palette = LIGHT
        self.setText(tr("ViewLight", "Turn"))
        self.setAccessibleName(tr("ViewLight", "Turn to the better view"))
        self.setToolTip(tr("ViewLight", "Turn to the better view (T)"))
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)
        # A pen on the button must not draw on the sheet beneath.
        self.setAttribute(Qt.WidgetAttribute.WA_NoMousePropagation)
        self.hide()

    def sizeHint(self) -> QSize:
        words = QFontMetrics(self.font()).horizontalAdvance(self.text())
        return QSize(round(GAP + ICON + GAP / 2 + words + PADDING), text_height(HEIGHT) - 6)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        tones = tones_of(self.colors)
        ground = QRectF(self.rect()).adjusted(0.75, 0.75, -0.75, -0.75)
        radius = ground.height() / 2
        fill = tones.press if self.isDown() else tones.hover
        painter.setPen(Qt.PenStyle.NoPen)
        if self.isDown() or self.underMouse():
            painter.setBrush(qcolor(fill))
            painter.drawRoundedRect(ground, radius, radius)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(qcolor(tones.accent), 1.5))
            painter.drawRoundedRect(ground, radius, radius)
        place = QRectF(GAP, (self.height() - ICON) / 2, ICON, ICON)
        paint_icon(painter, "orbit", place, tones.accent_text)
        painter.setPen(qcolor(tones.accent_text))
        words = QRectF(self.rect()).adjusted(GAP + ICON + GAP / 2, 0, 0, 0)
        painter.drawText(words, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft,
                         self.text())  # fmt: skip
        painter.end()


class ViewLight(QWidget):
    """A small chip at the top of the sheet.

    Signals
    -------
    turn_chosen
        The person wants the better view.
    """

    turn_chosen = Signal()

    def __init__(self, canvas: QWidget) -> None:
        super().__init__(canvas)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.advice: ViewAdvice | None = None
        self.said = ""
        """All that is said."""
        self.words = ""
        """As much of it as there is room for."""
        self.left = 0
        """How much of the sheet's left is covered by something else, pixels."""
        self._palette: Palette = LIGHT
        self._area = QRect()
        self._line = 0
        self.button = TurnButton(canvas)  # no child of the chip, which touches pass through
        self.button.clicked.connect(self.turn_chosen)
        self.hide()

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = self.button.colors = palette
        self.button.update()
        self.update()

    def lie_on(self, area: QRect) -> None:
        """Stay at the top centre of an area of the canvas."""
        self._area = area
        self._lay_out()

    def show_advice(self, advice: ViewAdvice | None, next_step: str = "") -> None:
        """Show what is said of the view; None shows nothing.

        Parameters
        ----------
        advice : ViewAdvice or None
            What the modeler says of the view.
        next_step : str
            What to do next; "" where it stands on the sheet already.
        """
        said = "" if advice is None else words_over_sheet(advice, next_step)
        self.advice, self.said = advice if said else None, said
        self.setVisible(self.advice is not None)
        self.button.setVisible(self.advice is not None and self.advice.better is not None)
        if self.advice is not None:
            self.setAccessibleName(f"{_level_words(self.advice.level)}: {said}")
        self._lay_out()
        self.update()

    def _lay_out(self) -> None:
        """Take a line at the top; in a narrow sheet some lines, or the place below the cube."""
        if self.advice is None:
            return
        free = self._area.adjusted(self.left, 0, 0, 0)
        button = self.button.sizeHint() if self.advice.better is not None else QSize(0, 0)
        around = round(PADDING + LAMP + GAP + PADDING + button.width())
        aside = min(BESIDE_THE_CENTRE, free.width() - MARGIN - BESIDE - around)
        most = max(0, aside, min(WIDEST, free.width() - 2 * BESIDE - around))
        top, beside = MARGIN, BESIDE
        if most < NARROW:
            top, beside = BELOW, MARGIN
            most = max(0, free.width() - 2 * MARGIN - around)
        metrics = QFontMetrics(self.font())
        said = " ".join(self.said.split())
        right = Qt.TextElideMode.ElideRight
        if metrics.elidedText(said, right, most) != said:
            first, stop, _ = said.partition(". ")
            said = first + stop.strip()
        self.words, taken = self._set_in_lines(said, most, metrics)
        # Drawn in lines as they were measured: a line as wide as its words may lose the last one.
        self._line = most + 1 if taken.height() <= metrics.height() else most
        width, height = around + taken.width(), text_height(HEIGHT)
        centred = free.left() + (free.width() - width) // 2
        left = max(free.left() + MARGIN, min(centred, free.right() + 1 - beside - width))
        more = taken.height() - metrics.height()
        self.setGeometry(left, self._area.top() + top, width, height + max(0, more))
        place = self.geometry()
        self.button.setGeometry(
            place.right() + 1 - button.width() - 3,
            place.center().y() - height // 2 + 3,
            button.width(),
            height - 6,
        )
        self.button.raise_()

    @staticmethod
    def _set_in_lines(said: str, most: int, metrics: QFontMetrics) -> tuple[str, QSize]:
        """Return the words that there is room for in lines of a width, and what they take."""
        right = Qt.TextElideMode.ElideRight
        if metrics.elidedText(said, right, most) == said:
            return said, QSize(metrics.horizontalAdvance(said), metrics.height())
        said = metrics.elidedText(said, right, LINES * most)
        while True:
            place = metrics.boundingRect(QRect(0, 0, most, 10_000), WRAPPED, said)
            if place.height() <= LINES * metrics.lineSpacing() and place.width() <= most:
                return said, QSize(place.width() + 1, place.height())
            shorter, space, _ = said.rstrip("…").rpartition(" ")
            if not space:
                said = metrics.elidedText(said, right, most)
                return said, QSize(metrics.horizontalAdvance(said), metrics.height())
            said = f"{shorter}…"

    def paintEvent(self, event: QPaintEvent) -> None:
        if self.advice is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        tones = tones_of(self._palette)
        ground = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(qcolor(tones.edge), 1.0))
        painter.setBrush(qcolor(tones.raised, 0.94))
        radius = min(ground.height(), text_height(HEIGHT)) / 2
        painter.drawRoundedRect(ground, radius, radius)
        lamp = QRectF(PADDING, (self.height() - LAMP) / 2, LAMP, LAMP)
        self._paint_lamp(painter, lamp, self.advice.level)
        painter.setPen(qcolor(readable(tones.text, tones.text, tones.raised)))
        words = self.rect().adjusted(round(PADDING + LAMP + GAP), 0, 0, 0)
        words.setWidth(self._line)
        painter.drawText(words, WRAPPED | Qt.AlignmentFlag.AlignVCenter, self.words)
        painter.end()

    def _paint_lamp(self, painter: QPainter, place: QRectF, level: str) -> None:
        dark = self._palette.name == "dark"
        color = mixed((255, 255, 255), LAMPS[level], 0.2) if dark else LAMPS[level]
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(color))
        if level == "good":
            painter.drawEllipse(place)
        elif level == "warn":
            top = QPointF(place.center().x(), place.top())
            painter.drawPolygon(QPolygonF([top, place.bottomRight(), place.bottomLeft()]))
        else:
            painter.drawRoundedRect(place, 2, 2)
            painter.setBrush(qcolor(tones_of(self._palette).raised))
            painter.drawRect(
                QRectF(place.left() + 2.5, place.center().y() - 1, place.width() - 5, 2)
            )
