"""The rail at the left: the active modeler's tools, and what to do with waiting ink."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QKeyEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import QLabel, QMenu, QSizePolicy, QVBoxLayout, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.session.tool_groups import ToolGroup, ToolInfo, keys_of
from bozzetto_app.style.icons import icon_from_file
from bozzetto_app.style.theme import current_palette, fill, qcolor, small_font, tones
from bozzetto_app.widgets.icon_button import RADIUS, IconButton
from bozzetto_app.widgets.section import hairline

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["ToolRail"]

SIDE = 44
"""Side of a tool's button, px: what a finger or a pen on glass hits surely."""

LOWEST = 18
"""Height of a button in a window that is too low for all of them, px. A rail that kept its height
would make the window higher than the screen when the first ink waits."""

GAPS = (4, 1)
"""Distance between buttons where there is room, and where there is none, px."""

MARGINS = (8, 4)
"""The same at both ends of the rail, px."""

DOT = 4.0
"""Radius of the dot at the tool that is to be taken next, px."""

CORNER = 5.0
"""Side of the triangle at a button that opens to other tools, px."""

HOLD = 400
"""Time for which a button is held until it opens to the other tools of its group, ms."""


class _RailButton(IconButton):
    """A button of the rail, lower than wide where there is no room."""

    def __init__(self, source: str | Path | None, name: str, key: str = "") -> None:
        super().__init__(source, name, side=SIDE, key=key)
        self.setMinimumHeight(LOWEST)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)

    def sizeHint(self) -> QSize:
        return QSize(SIDE, SIDE)


class _ToolButton(_RailButton):
    """A group of tools, of which it shows one.

    The active one has a bar at its left, the one to take next a frame and a dot. A group of several
    has a triangle in its corner; it opens when it is held, pressed again, clicked with the right
    button, or by the key that points to the right.
    """

    opened = Signal()

    def __init__(self, group: ToolGroup, key: str) -> None:
        super().__init__(None, group.title, key)
        self.behind, self._key = group, key
        self.tool = group.tools[0]
        self.is_next = False
        self.setCheckable(True)
        self._hold = QTimer(self, singleShot=True, interval=HOLD)
        self._hold.timeout.connect(self._held)
        if self.opens:
            self.pressed.connect(self._hold.start)
            self.released.connect(self._hold.stop)
        self.show_tool(self.tool)

    @property
    def opens(self) -> bool:
        """Whether there is more than one tool behind it."""
        return len(self.behind.tools) > 1

    def show_tool(self, tool: ToolInfo) -> None:
        """Show one of the group's tools."""
        self.tool = tool
        self.set_source(tool.icon)
        self.rename(tool.title, self._key)
        self.setStatusTip(tool.hint)
        if self.opens:
            titles = ", ".join(each.title for each in self.behind.tools)
            self.setToolTip(f"{self.toolTip()}\n{self.behind.title}: {titles}")

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if self.opens and event.key() == Qt.Key.Key_Right:
            self.opened.emit()
        else:
            super().keyPressEvent(event)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        if self.opens:
            self.opened.emit()

    def _held(self) -> None:
        self.setDown(False)  # the lift that follows is no click
        self.opened.emit()

    def paint_ground(self, painter: QPainter) -> None:
        super().paint_ground(painter)
        if self.is_next:
            self._paint_next(painter)
        if self.isChecked():
            self._paint_active(painter)
        if self.opens:
            self._paint_corner(painter)

    def _paint_corner(self, painter: QPainter) -> None:
        right, bottom = self.width() - 5.0, self.height() - 5.0
        corners = ((right, bottom), (right - CORNER, bottom), (right, bottom - CORNER))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(tones().quiet))
        painter.drawPolygon(QPolygonF([QPointF(*each) for each in corners]))

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
        self._buttons: list[_ToolButton] = []

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
        self._ends = waiting

        self._play = _RailButton("play", tr("ToolRail", "Play or stop"), key="P")
        self._play.setObjectName("play")
        self._play.clicked.connect(session.gestures.motion.play)

        self._column = QVBoxLayout(self)
        self._space_out(GAPS[0], MARGINS[0])
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

    def minimumSizeHint(self) -> QSize:
        """Return the size with the narrowest gaps, which a low window takes."""
        layout, direct = self._column, Qt.FindChildOption.FindDirectChildrenOnly
        # Not by the layout's items: their wrappers outlive those of buttons that have gone.
        lines = sum(not each.isHidden() for each in self.findChildren(QWidget, options=direct))
        inner = max(0, self._ends.count() - 1) if not self._waiting.isHidden() else 0
        spared = (lines + inner) * (layout.spacing() - GAPS[1])
        spared += 2 * (layout.contentsMargins().top() - MARGINS[1])
        return QSize(self.width(), layout.minimumSize().height() - max(0, spared))

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._spread()
        super().resizeEvent(event)

    def _spread(self) -> None:
        """Take narrower gaps in a window that is too low for the usual ones."""
        self._space_out(GAPS[0], MARGINS[0])
        if self._column.minimumSize().height() > self.height():
            self._space_out(GAPS[1], MARGINS[1])

    def _space_out(self, gap: int, margin: int) -> None:
        self._column.setContentsMargins(4, margin, 4, margin)
        self._column.setSpacing(gap)
        self._ends.setSpacing(gap)

    def refresh(self) -> None:
        """Show the tools that the active modeler has now."""
        for button in self._buttons:
            button.hide()
            button.deleteLater()
        self._buttons = []
        groups = self._session.toolbox.groups
        keys = keys_of(groups)
        for place, group in enumerate(groups):
            button = _ToolButton(group, keys.get(group.tools[0].id, ""))
            button.clicked.connect(lambda _, button=button: self._press(button))
            button.opened.connect(lambda button=button: self._open(button))
            self._column.insertWidget(place, button)
            self._buttons.append(button)
        self._mark()
        self._spread()

    def _press(self, button: _ToolButton) -> None:
        if button.opens and button.tool.id == self._session.toolbox.tool:
            self._open(button)
        else:
            self._session.toolbox.take_tool(button.tool.id)
        self._mark()  # the session decides; a click alone does not check a button

    def _open(self, button: _ToolButton) -> None:
        """Show the tools of a group beside its button."""
        menu = self.menu_of(button.behind, button.tool)
        menu.popup(button.mapToGlobal(button.rect().topRight()))

    def menu_of(self, group: ToolGroup, current: ToolInfo) -> QMenu:
        """Return a menu of the tools of a group, one of them the current one."""
        menu = QMenu(group.title, self)
        menu.setObjectName("tool-group")
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for tool in group.tools:
            action = menu.addAction(tool.title)
            if tool.icon is not None:
                action.setIcon(icon_from_file(tool.icon, current_palette()))
            action.setStatusTip(tool.hint)
            action.triggered.connect(lambda _, id=tool.id: self._session.toolbox.take_tool(id))
            if tool is current:
                menu.setActiveAction(action)
        return menu

    def _mark(self) -> None:
        """Show which tool is in the hand, and which is to be taken next."""
        toolbox, step = self._session.toolbox, self._session.hints.step
        for button in self._buttons:
            last = toolbox.last_used.get(button.behind.title, "")
            tool = button.behind.tool_of(toolbox.tool, step.tool, last)
            button.show_tool(tool)
            button.setChecked(tool.id == toolbox.tool)
            wanted = step.tool != toolbox.tool and step.tool in button.behind
            button.is_next = wanted
            button.setAccessibleDescription(step.sentence if wanted else tool.hint)
            button.update()

    def _show_play(self) -> None:
        motion = self._session.gestures.motion
        self._play.set_source("stop" if motion.is_playing else "play")
        self._play.setVisible(motion.can_play or motion.is_playing)

    def _show_waiting(self) -> None:
        count = len(self._session.drawing.pending)
        self._waiting.setVisible(count > 0)
        self._spread()
        self._count.setText(str(count))
        said = tr("ToolRail", "Strokes waiting: {count}", count=count)
        reasons = dict.fromkeys(one.reason for one in self._session.drawing.marked_ink)
        self._count.setToolTip("\n".join((said, *reasons)))
        self._count.setAccessibleName(said)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        fill(painter, self.rect(), tones().panel)
        fill(painter, QRect(self.width() - 1, 0, 1, self.height()), tones().hairline)
