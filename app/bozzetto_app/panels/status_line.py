"""The line at the bottom: what to do next, what is under way, and what went wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject, QRect, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QHideEvent, QKeySequence, QPainter, QPaintEvent, QShortcut
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import fill, set_tone, text_height, tones
from bozzetto_app.widgets.icon_button import IconButton

if TYPE_CHECKING:
    from bozzetto_app.session.notices import Notice
    from bozzetto_app.session.session import Session

__all__ = ["FaultBar", "StatusLine"]

ERROR_TIME = 8000
"""How long an error stays without a new gesture, ms."""

INFO_TIME = 4000
"""How long a remark stays before the hint returns, ms."""

PATIENCE = 300
"""Work shorter than this is not shown, ms: the line does not flicker."""


class _Sign(QWidget):
    """The little sign in front of a message."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFixedSize(QSize(16, 16))
        self.show_kind("hint")

    def show_kind(self, kind: str) -> None:
        """Show of which kind the message is; a screen reader says it."""
        self.kind = kind
        names = {
            "hint": tr("StatusLine", "Next step"),
            "info": tr("StatusLine", "Note"),
            "error": tr("StatusLine", "Problem"),
            "fault": tr("StatusLine", "Fault"),
        }
        self.setAccessibleName(names[kind])
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        name, color = {
            "hint": ("pen", colors.quiet),
            "info": ("info", colors.second),
            "error": ("warning", colors.warning),
            "fault": ("fault", colors.accent_text),
        }[self.kind]
        paint_icon(QPainter(self), name, QRectF(self.rect()), color)


class _Elided(QLabel):
    """One line of words that never asks for more room than there is."""

    def minimumSizeHint(self) -> QSize:
        return QSize(40, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setPen(self.palette().windowText().color())
        words = self.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideRight, self.width()
        )
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignVCenter, words)


class FaultBar(QFrame):
    """Says that a plugin stopped, and goes on letting the person draw.

    Signals
    -------
    details_wanted : Notice
    switch_off_wanted : str
        The plugin's id.
    stop_wanted
        Slow work is not to be waited for.
    """

    details_wanted = Signal(object)
    switch_off_wanted = Signal(str)
    stop_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._notice: Notice | None = None
        self.setProperty("shape", "fault")
        self.setAccessibleName(tr("FaultBar", "Fault"))
        sign = _Sign()
        sign.show_kind("fault")
        self._words = QLabel()
        self._words.setObjectName("fault-words")
        self._words.setWordWrap(True)
        self._words.setTextFormat(Qt.TextFormat.PlainText)
        self._details = QPushButton(tr("FaultBar", "Details"))
        self._switch_off = QPushButton(tr("FaultBar", "Switch off"))
        self._wait = QPushButton(tr("FaultBar", "Wait"))
        self._stop = QPushButton(tr("FaultBar", "Stop"))
        self._wait.clicked.connect(self.hide)
        self._stop.clicked.connect(self._ask_stop)
        self._escape = QShortcut(QKeySequence(Qt.Key.Key_Escape), self)
        self._escape.setEnabled(False)
        self._escape.activated.connect(self._ask_stop)
        close = IconButton("cross", tr("FaultBar", "Close"), side=24, glyph=16, faint=True)
        self._details.clicked.connect(lambda: self.details_wanted.emit(self._notice))
        self._switch_off.setObjectName("fault-switch-off")
        self._switch_off.clicked.connect(self._ask_switch_off)
        close.clicked.connect(self.hide)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 6, 8, 6)
        row.setSpacing(8)
        row.addWidget(sign)
        row.addWidget(self._words, 1)
        for button in (self._details, self._switch_off, self._wait, self._stop, close):
            row.addWidget(button)
        self.hide()

    def hideEvent(self, event: QHideEvent) -> None:
        self._escape.setEnabled(False)

    def lie_over(self, sheet: QWidget) -> None:
        """Lie over the lower edge of a sheet, which must not move under the pen."""
        self.setParent(sheet)
        self.setAttribute(Qt.WidgetAttribute.WA_NoMousePropagation)
        self.setCursor(Qt.CursorShape.ArrowCursor)
        sheet.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Resize and watched is self.parent():
            self._settle_down()
        return False

    def _settle_down(self) -> None:
        sheet = self.parentWidget()
        layout = self.layout()
        if sheet is not None and layout is not None and sheet.layout() is None:
            tall = layout.totalHeightForWidth(sheet.width())
            self.setGeometry(0, sheet.height() - tall, sheet.width(), tall)
            self.raise_()

    def show_fault(self, notice: Notice) -> None:
        """Show a fault in place of the last one."""
        self._notice = notice
        self._words.setText(notice.text)
        self._words.setAccessibleName(notice.text)
        self._details.setVisible(bool(notice.details))
        slow = notice.kind == "slow"
        self._switch_off.setVisible(bool(notice.plugin) and not slow)
        self._wait.setVisible(slow)
        self._stop.setVisible(slow)
        self._escape.setEnabled(slow)
        self._settle_down()
        self.show()

    def work_ended(self) -> None:
        """Take away what was said of slow work: it has ended."""
        if self._notice is not None and self._notice.kind == "slow":
            self.hide()

    def _ask_stop(self) -> None:
        self.hide()
        self.stop_wanted.emit()

    def _ask_switch_off(self) -> None:
        if self._notice is not None:
            self.hide()
            self.switch_off_wanted.emit(self._notice.plugin)


class _Progress(QWidget):
    """A line two pixels high; without a known share it is drawn faintly over all its length."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.fraction = 0.0
        self.setFixedHeight(2)
        self.setAccessibleName(tr("StatusLine", "Progress"))

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        fill(painter, self.rect(), colors.hairline)
        done = self.width() * min(max(self.fraction, 0.02), 1.0)
        fill(painter, QRectF(0, 0, done, 2), colors.accent)


class StatusLine(QWidget):
    """Hint, errors, progress and units; the fault bar above them, or over a sheet.

    Signals
    -------
    details_wanted : Notice
        The person wants to read a fault's traceback.
    switched_off : str
        A plugin was switched off from here.
    """

    details_wanted = Signal(object)
    switched_off = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self.setObjectName("status")
        self.setWindowTitle(tr("StatusLine", "Status"))
        self.setAccessibleName(self.windowTitle())
        self.faults = FaultBar()
        self.faults.details_wanted.connect(self.details_wanted)
        self.faults.switch_off_wanted.connect(self._switch_off)
        self.faults.stop_wanted.connect(session.cancel_work)
        self._progress = _Progress()
        self._progress.setObjectName("status-progress")
        # A line that takes its room along would resize the sheet whenever work begins.
        room = self._progress.sizePolicy()
        room.setRetainSizeWhenHidden(True)
        self._progress.setSizePolicy(room)
        self._sign = _Sign()
        self._sign.setObjectName("status-sign")
        self._words = _Elided(session.hints.step.sentence)
        self._words.setObjectName("status-words")
        self._step = QLabel()
        self._step.setObjectName("status-step")
        self._step.setProperty("tone", "quiet")
        self._cancel = IconButton(
            "cross", tr("StatusLine", "Stop this work"), side=24, glyph=16, faint=True
        )
        self._cancel.setObjectName("status-cancel")
        self._cancel.clicked.connect(session.cancel_work)
        units = QLabel(tr("StatusLine", "mm"))
        units.setProperty("tone", "quiet")
        units.setToolTip(tr("StatusLine", "Lengths are millimetres."))
        self._line = line = QHBoxLayout()
        line.setContentsMargins(12, 0, 12, 0)
        line.setSpacing(8)
        line.addWidget(self._sign)
        line.addWidget(self._words, 1)
        for widget in (self._step, self._cancel, units):
            line.addWidget(widget)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.faults)
        column.addWidget(self._progress)
        row = QWidget()
        row.setFixedHeight(text_height(28))
        row.setLayout(line)
        column.addWidget(row)

        self._return = QTimer(self, singleShot=True)
        self._return.timeout.connect(self._show_hint)
        self._patience = QTimer(self, singleShot=True, interval=PATIENCE)
        self._patience.timeout.connect(lambda: self._show_work(True))
        session.notices.noticed.connect(self.show_notice)
        session.hints.changed.connect(self._next_step_changed)
        session.progressed.connect(self._advance)
        session.busy_changed.connect(self._busy)
        session.drawing.changed.connect(self.went_on)
        session.toolbox.tool_changed.connect(self.went_on)
        session.drawing.changed.connect(self.faults.work_ended)
        session.notices.caught_up.connect(self.faults.work_ended)
        self._show_work(False)
        self._show_hint()

    def show_notice(self, notice: Notice) -> None:
        """Say something in the way that its kind asks for."""
        if notice.kind in ("fault", "slow"):
            self.faults.show_fault(notice)
        else:
            self._say(notice.kind, notice.text)
            self._return.start(ERROR_TIME if notice.kind == "error" else INFO_TIME)

    def _next_step_changed(self) -> None:
        """Show what is next, unless something is being said that is to be read first."""
        if self._sign.kind == "hint":
            self._show_hint()

    def went_on(self) -> None:
        """Show the hint again: the person went on, so the last message has been read."""
        if self._sign.kind != "hint":
            self._show_hint()

    def _show_hint(self) -> None:
        self._return.stop()
        self._say("hint", self._session.hints.step.sentence)

    def _say(self, kind: str, words: str) -> None:
        self._sign.show_kind(kind)
        self._words.setText(words)
        self._words.setToolTip(words)
        self._words.setAccessibleName(words)
        set_tone(self._words, "warning" if kind == "error" else "")

    def _busy(self, busy: bool) -> None:
        if busy:
            self._progress.fraction = 0.0
            self._patience.start()
        else:
            self._patience.stop()
            self._show_work(False)
            self.faults.work_ended()

    def _advance(self, fraction: float, step: str) -> None:
        self._progress.fraction = fraction
        self._progress.update()
        self._step.setText(step)
        self._line.activate()  # a frame that is due already would cut off the new words

    def _show_work(self, shown: bool) -> None:
        if not shown:
            self._progress.fraction = 0.0
            self._step.clear()
        self._progress.setVisible(shown)
        self._step.setVisible(shown)
        self._cancel.setVisible(shown)

    def _switch_off(self, plugin: str) -> None:
        self._session.registry.set_disabled(plugin, True)
        self.switched_off.emit(plugin)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        fill(painter, self.rect(), tones().panel)
        fill(painter, QRect(0, 0, self.width(), 1), tones().hairline)
