"""The row of modelers at the top: a quiet name with an icon for each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QHBoxLayout, QSizePolicy, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import GRID, paint_icon
from bozzetto_app.style.theme import fill, qcolor, strong_font, text_height, tones
from bozzetto_app.widgets.icon_button import RADIUS, paint_focus

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["ModelerBar"]

HEIGHT = 40


class _ModelerButton(QAbstractButton):
    def __init__(self, icon: Path, title: str, hint: str) -> None:
        super().__init__()
        self._icon = icon
        self.compact = False
        self.setText(title)
        self.setAccessibleName(title)
        self.setAccessibleDescription(hint)
        self.setToolTip(f"{title}\n{hint}" if hint else title)
        self.setCheckable(True)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)

    def full_width(self) -> int:
        metrics = QFontMetrics(strong_font(self.font()))
        return GRID + metrics.horizontalAdvance(self.text()) + 32

    def sizeHint(self) -> QSize:
        return QSize(GRID + 24 if self.compact else self.full_width(), text_height(HEIGHT))

    def minimumSizeHint(self) -> QSize:
        return QSize(GRID + 24, text_height(HEIGHT))

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        place = QRectF(self.rect()).adjusted(2, 4, -2, -4)
        painter.setPen(Qt.PenStyle.NoPen)
        if self.isDown() or self.underMouse():
            painter.setBrush(qcolor(colors.press if self.isDown() else colors.hover))
            painter.drawRoundedRect(place, RADIUS, RADIUS)
        on = self.isChecked()
        color = colors.text if on or self.underMouse() else colors.quiet
        glyph = QRectF(12, (self.height() - GRID) / 2, GRID, GRID)
        painter.setPen(qcolor(color))
        painter.setFont(strong_font(self.font()) if on else self.font())
        if not paint_icon(painter, self._icon, glyph, color):
            painter.drawText(glyph, Qt.AlignmentFlag.AlignCenter, self.text()[:1])
        if not self.compact:
            room = self.rect().adjusted(12 + GRID + 8, 0, 0, 0)
            painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, self.text())
        if on:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.accent))
            painter.drawRoundedRect(QRectF(12, self.height() - 3, self.width() - 24, 3), 1.5, 1.5)
        if self.hasFocus():
            paint_focus(painter, place)


class ModelerBar(QWidget):
    """All modelers that can be drawn with; only icons where the names do not fit."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self.setObjectName("modelers")
        self.setWindowTitle(tr("ModelerBar", "Modelers"))
        self.setAccessibleName(self.windowTitle())
        self.setFixedHeight(text_height(HEIGHT))
        # It takes what the menus beside it leave, and not a share of their room.
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(4, 0, 4, 0)
        self._row.setSpacing(0)
        self._row.addStretch(1)
        self._buttons: dict[str, _ModelerButton] = {}
        session.toolbox.modeler_changed.connect(self._mark)
        self.refresh()

    def refresh(self) -> None:
        """Show the modelers there are now."""
        for button in self._buttons.values():
            button.hide()
            button.deleteLater()
        self._buttons = {}
        for place, info in enumerate(self._session.toolbox.modelers, start=1):
            button = _ModelerButton(info.icon, info.title, info.hint)
            button.clicked.connect(lambda _, name=info.id: self._take(name))
            self._row.insertWidget(place, button)
            self._buttons[info.id] = button
        self._mark()
        self._fit()

    def sizeHint(self) -> QSize:
        return QSize(sum(b.full_width() for b in self._buttons.values()) + 8, text_height(HEIGHT))

    def _take(self, modeler: str) -> None:
        if modeler == self._session.toolbox.modeler:
            title = self._session.registry.info(modeler).title
            self._session.notices.tell(
                tr("ModelerBar", "You are drawing with {title}.", title=title)
            )
        self._session.toolbox.take_modeler(modeler)
        self._mark()  # the session decides; a click alone does not check a button

    def _mark(self) -> None:
        active = self._session.toolbox.modeler
        for name, button in self._buttons.items():
            button.setChecked(name == active)

    def _fit(self) -> None:
        compact = self.sizeHint().width() > self.width()
        for button in self._buttons.values():
            if button.compact != compact:
                button.compact = compact
                button.updateGeometry()

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._fit()
        super().resizeEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        fill(painter, self.rect(), tones().panel)
