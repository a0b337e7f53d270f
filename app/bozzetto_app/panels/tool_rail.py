"""The rail at the left: the active modeler's tools, and what to do with waiting ink."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QSizePolicy, QVBoxLayout, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.session.toolbox import TOOL_KEYS
from bozzetto_app.style.theme import qcolor, small_font, tones
from bozzetto_app.widgets.icon_button import RADIUS, IconButton
from bozzetto_app.widgets.section import hairline

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["ToolRail"]

SIDE = 44
"""Side of a tool's button, px: what a finger or a pen on glass hits surely."""

LOWEST = 24
"""Height of a button in a window that is too low for all of them, px. A rail that kept its height
would make the window higher than the screen when the first ink waits."""


DOT = 4.0
"""Radius of the dot at the tool that is to be taken next, px."""


class _RailButton(IconButton):
    """A button of the rail, lower than wide where there is no room."""

    def __init__(self, source: str | Path | None, name: str, key: str = "") -> None:
        super().__init__(source, name, side=SIDE, key=key)
        self.setMinimumHeight(LOWEST)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)

    def sizeHint(self) -> QSize:
        return QSize(SIDE, SIDE)


class _ToolButton(_RailButton):
    """A tool; the active one has a bar at its left, the one to take next a frame and a dot."""

    is_next = False

    def paint_ground(self, painter: QPainter) -> None:
        super().paint_ground(painter)
        if self.is_next:
            self._paint_next(painter)
        if self.isChecked():
            self._paint_active(painter)

    def _paint_next(self, painter: QPainter) -> None:
        accent = qcolor(tones().accent)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(accent, 1.5))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(3, 3, -3, -3), RADIUS, RADIUS)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(accent)
        painter.drawEllipse(QPointF(self.width() - DOT - 3.5, DOT + 3.5), DOT, DOT)

    def _paint_active(self, painter: QPainter) -> None:
        colors = tones()
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(colors.chosen))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(2, 2, -2, -2), RADIUS, RADIUS)
        painter.setBrush(qcolor(colors.accent))
        edge = min(10.0, self.height() / 4)
        painter.drawRoundedRect(QRectF(0, edge, 3, self.height() - 2 * edge), 1.5, 1.5)


class _FinishButton(_RailButton):
    """The one thing to press while ink waits."""

    def paint_ground(self, painter: QPainter) -> None:
        colors = tones()
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(colors.chosen if not self.underMouse() else colors.press))
        radius = min(self.width(), self.height()) / 2 - 2
        painter.drawEllipse(QRectF(self.rect()).center(), radius, radius)


class ToolRail(QWidget):
    """Tools as icons with names on hover; below them the waiting ink's buttons."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self.setObjectName("tools")
        self.setWindowTitle(tr("ToolRail", "Tools"))
        self.setAccessibleName(self.windowTitle())
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedWidth(SIDE + 8)
        self._buttons: dict[str, _ToolButton] = {}

        self._count = QLabel()
        self._count.setObjectName("waiting-count")
        self._count.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._count.setProperty("type", "small")
        self._count.setFont(small_font(self.font()))
        self._finish = _FinishButton(
            "check",
            tr("ToolRail", "Finish the waiting strokes"),
            key=tr("Keys", "Enter"),
        )
        self._finish.setObjectName("waiting-finish")
        self._finish.clicked.connect(session.gestures.commit)
        self._drop = _RailButton(
            "cross",
            tr("ToolRail", "Take the waiting strokes back; the eraser, or Ctrl, takes one"),
        )
        self._drop.setObjectName("waiting-drop")
        self._drop.clicked.connect(session.gestures.clear)
        self._waiting = QWidget()
        self._waiting.setObjectName("waiting")
        waiting = QVBoxLayout(self._waiting)
        waiting.setContentsMargins(0, 0, 0, 0)
        waiting.setSpacing(4)
        for widget in (hairline(), self._count, self._finish, self._drop):
            waiting.addWidget(widget)

        self._play = _RailButton("play", tr("ToolRail", "Play or stop"), key="P")
        self._play.setObjectName("play")
        self._play.clicked.connect(session.gestures.motion.play)

        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(4, 8, 4, 8)
        self._column.setSpacing(4)
        self._column.addWidget(self._play)
        self._column.addStretch(1)
        self._column.addWidget(self._waiting)
        session.toolbox.modeler_changed.connect(self.refresh)
        session.toolbox.tool_changed.connect(self._mark)
        session.gestures.motion.changed.connect(self._show_play)
        session.hints.changed.connect(self._mark)
        session.drawing.waiting_changed.connect(self._show_waiting)
        self.refresh()
        self._show_waiting()
        self._show_play()

    def refresh(self) -> None:
        """Show the tools that the active modeler has now."""
        for button in self._buttons.values():
            button.hide()
            button.deleteLater()
        self._buttons = {}
        for place, tool in enumerate(self._session.toolbox.tools):
            key = TOOL_KEYS[place : place + 1]
            button = _ToolButton(tool.icon, tool.title, key)
            button.setStatusTip(tool.hint)
            button.setCheckable(True)
            button.clicked.connect(lambda _, name=tool.id: self._take(name))
            self._column.insertWidget(place, button)
            self._buttons[tool.id] = button
        self._mark()

    def _take(self, tool: str) -> None:
        self._session.toolbox.take_tool(tool)
        self._mark()  # the session decides; a click alone does not check a button

    def _mark(self) -> None:
        """Show which tool is in the hand, and which is to be taken next."""
        active, step = self._session.toolbox.tool, self._session.hints.step
        for tool in self._session.toolbox.tools:
            button = self._buttons.get(tool.id)
            if button is not None:
                button.setChecked(tool.id == active)
                button.is_next = tool.id == step.tool != active
                button.setAccessibleDescription(step.sentence if button.is_next else tool.hint)
                button.update()

    def _show_play(self) -> None:
        motion = self._session.gestures.motion
        self._play.set_source("stop" if motion.is_playing else "play")
        self._play.setVisible(motion.can_play or motion.is_playing)

    def _show_waiting(self) -> None:
        count = len(self._session.drawing.pending)
        self._waiting.setVisible(count > 0)
        self._count.setText(str(count))
        said = tr("ToolRail", "Strokes waiting: {count}", count=count)
        reasons = dict.fromkeys(one.reason for one in self._session.drawing.marked_ink)
        self._count.setToolTip("\n".join((said, *reasons)))
        self._count.setAccessibleName(said)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), qcolor(tones().panel))
        painter.fillRect(self.width() - 1, 0, 1, self.height(), qcolor(tones().hairline))
