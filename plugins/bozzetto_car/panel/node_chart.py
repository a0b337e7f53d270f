"""A chart of all points of a car: which are marked, which disagree; a click asks for one."""

from __future__ import annotations

from typing import Final

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPalette,
    QPen,
)
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from bozzetto.arrays import Array
from bozzetto.plugin import override
from bozzetto_app.toolkit import palette_of
from bozzetto_car.panel.colors import role, warning_of
from bozzetto_car.panel.view_model import Chart, Guide, NodeRow, chart_of

MARGIN: Final = 12.0
"""Free space around the drawing, px."""

REACH: Final = 14.0
"""Farthest a click may be from the node that it means, px."""

ENDS: Final = {"asked": 6.0, "wrong": 5.0, "set": 4.0, "open": 3.5, "hidden": 2.5, "skipped": 2.5}
"""Radius of a node's dot by its status, px."""

WORDS: Final = {
    "asked": "asked for",
    "set": "marked",
    "open": "not marked yet",
    "hidden": "probably not visible here",
    "skipped": "noted as not visible",
}

Role = QPalette.ColorRole


def row_text(row: NodeRow) -> str:
    """Return a node and its status in words."""
    if row.status == "wrong":
        return f"{row.title}: disagrees by {row.off or 0.0:.0f} px"
    if row.off is not None:
        return f"{row.title}: {row.off:.1f} px off"
    return f"{row.title}: {WORDS[row.status]}"


class NodeChart(QWidget):
    """The template as a drawing, with a dot for every node.

    Signals
    -------
    chosen : str
        A node was clicked, or chosen with the keys.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("car-guide-chart")
        self.setAccessibleName("All points")
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._guide: Guide | None = None
        self._chart: Chart | None = None
        self._pointed = ""
        # Not by overriding `event`: PySide cannot take every exception through that.
        self.installEventFilter(self)

    def show_guide(self, guide: Guide) -> None:
        """Show another state of the marks."""
        old = self._guide
        if old is None or old.template is not guide.template or old.near != guide.near:
            self._chart = chart_of(guide.template, guide.near)
            self._fit()
        self._guide = guide
        self.update()

    def place_of(self, node: str) -> QPointF:
        """Return where a node is drawn."""
        if self._guide is None or self._chart is None:
            return QPointF()
        x, y = self._laid(self._chart.places[self._guide.template.node[node]])
        return QPointF(x, y)

    # -- where things are --------------------------------------------------------------------------

    def _fit(self) -> None:
        if self._chart is not None and self.width() > 2.0 * MARGIN:
            inner = self.width() - 2.0 * MARGIN
            self.setFixedHeight(round(inner * self._chart.height + 2.0 * MARGIN))

    def _laid(self, places: Array) -> Array:
        return np.asarray(MARGIN + (self.width() - 2.0 * MARGIN) * places)

    def _row_at(self, at: QPointF) -> NodeRow | None:
        guide, chart = self._guide, self._chart
        if guide is None or chart is None or not guide.rows:
            return None
        numbers = [guide.template.node[row.node] for row in guide.rows]
        away = np.hypot(*(self._laid(chart.places[numbers]) - (at.x(), at.y())).T)
        nearest = int(away.argmin())
        return guide.rows[nearest] if away[nearest] <= REACH else None

    # -- painting ----------------------------------------------------------------------------------

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        guide, chart = self._guide, self._chart
        if guide is None or chart is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        text = Role.WindowText
        for front, opacity, width in ((False, 0.22, 0.8), (True, 0.5, 1.1)):
            painter.setPen(QPen(role(self, text, opacity), width))
            painter.drawPath(self._path(chart.edges[chart.front == front]))
        order = {status: number for number, status in enumerate(reversed(ENDS))}
        for row in sorted(guide.rows, key=lambda row: order[row.status]):
            self._paint_node(painter, row, chart)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(role(self, Role.Link), 1.0))
            painter.drawRoundedRect(self.rect().adjusted(0, 0, -1, -1), 4.0, 4.0)

    def _path(self, edges: Array) -> QPainterPath:
        path = QPainterPath()
        for edge in self._laid(edges).tolist():
            path.moveTo(*edge[0])
            for x, y in edge[1:]:
                path.lineTo(x, y)
        return path

    def _paint_node(self, painter: QPainter, row: NodeRow, chart: Chart) -> None:
        at, radius = self.place_of(row.node), ENDS[row.status]
        ground, quiet = role(self, Role.Window), role(self, Role.WindowText, 0.55)
        if row.node == self._pointed:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(role(self, Role.WindowText, 0.16))
            painter.drawEllipse(at, radius + 5.0, radius + 5.0)
        if row.status == "asked":
            accent = QColor(*palette_of(self).accent)
            painter.setPen(QPen(accent, 1.6))
            painter.setBrush(ground if row.off is None else accent)
            painter.drawEllipse(at, radius, radius)
            painter.setBrush(accent)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.drawEllipse(at, 2.5, 2.5)
            return
        fill = {"set": role(self, Role.Link), "wrong": warning_of(self)}.get(row.status, ground)
        if row.status in ("set", "wrong"):
            painter.setPen(QPen(ground, 1.5))
        else:
            painter.setPen(QPen(quiet, 1.2 if row.status == "open" else 0.8))
        painter.setBrush(fill)
        painter.drawEllipse(at, radius, radius)
        if row.status == "wrong":
            painter.setPen(QPen(ground, 1.6))
            painter.drawLine(at + QPointF(0.0, -2.4), at + QPointF(0.0, 0.6))
            painter.drawPoint(at + QPointF(0.0, 2.4))
        elif row.status == "skipped":
            painter.drawLine(at + QPointF(-3.5, 3.5), at + QPointF(3.5, -3.5))

    # -- the hand ----------------------------------------------------------------------------------

    @override
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self and isinstance(event, QHelpEvent):
            row = self._row_at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), "" if row is None else row_text(row), self)
            return True
        return False

    @override
    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._point_at(self._row_at(event.position()))

    @override
    def leaveEvent(self, event: QEvent) -> None:
        self._point_at(None)

    @override
    def mousePressEvent(self, event: QMouseEvent) -> None:
        row = self._row_at(event.position())
        if row is not None and event.button() == Qt.MouseButton.LeftButton:
            self.chosen.emit(row.node)

    @override
    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go through the nodes with the arrow keys in the order of asking; Enter chooses one."""
        guide = self._guide
        if guide is None or not guide.rows:
            return
        names = [row.node for row in guide.rows]
        now = self._pointed or guide.asked
        at = names.index(now) if now in names else -1
        forward = event.key() in (Qt.Key.Key_Right, Qt.Key.Key_Down)
        if forward or event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Up):
            self._point_at(guide.rows[(at + (1 if forward else -1)) % len(names)])
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space) and now:
            self.chosen.emit(now)
        else:
            super().keyPressEvent(event)

    def _point_at(self, row: NodeRow | None) -> None:
        node = "" if row is None else row.node
        if node != self._pointed:
            self._pointed = node
            self.setAccessibleDescription("" if row is None else row_text(row))
            pointer = (
                Qt.CursorShape.ArrowCursor if row is None else Qt.CursorShape.PointingHandCursor
            )
            self.setCursor(pointer)
            self.update()

    # -- Qt ----------------------------------------------------------------------------------------

    @override
    def sizeHint(self) -> QSize:
        return QSize(260, 150)

    @override
    def resizeEvent(self, event: object) -> None:
        self._fit()
