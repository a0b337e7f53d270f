"""Number fields: drag to change, type, or compute in them."""

from __future__ import annotations

import math
from typing import cast

from PySide6.QtCore import QEvent, QLocale, QObject, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QFocusEvent,
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QValidator,
    QWheelEvent,
)
from PySide6.QtWidgets import QAbstractSpinBox, QDoubleSpinBox, QToolTip, QWidget

from bozzetto.errors import UserError
from bozzetto_app.style.theme import qcolor, tones
from bozzetto_app.widgets.expression import compute

__all__ = ["NumberField", "format_number", "is_scale", "sensible_step"]

DRAG_START = 4
"""Pixels the pointer must move before a press becomes a drag."""

PIXELS_PER_STEP = 3
"""Pixels of dragging for one step."""

COARSE = 10.0
"""Steps at once with Shift held; Ctrl is fine motion by as much."""

MOST_DECIMALS = 6

WHILE_TYPING = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
"""Keys that are the field's own only while somebody types: what was typed is a step by then."""

OF_THE_FIELD = (
    QKeySequence.StandardKey.Copy,
    QKeySequence.StandardKey.Cut,
    QKeySequence.StandardKey.Paste,
    QKeySequence.StandardKey.SelectAll,
)
"""Keys with Control and a letter that a number has a use for. On X11 lines of text take Ctrl+E,
Ctrl+K and others for moves and deletions, and the commands on these keys would not be reached."""

WIDE = 500.0
"""A range this many times as wide as a usual value is no scale."""

UNKNOWN = 2.0
"""Taken as usual where 0 is: ranges to 1,000 are scales then."""

LEAST_SHARE = 0.1
"""Share of a usual value from which on steps become no smaller."""

HEIGHT = 24
"""Height of the field, px."""


def sensible_step(minimum: float | None, maximum: float | None, *, whole: bool = False) -> float:
    """Return a step of 1, 2 or 5 times a power of ten, about a hundredth of the range."""
    if whole or minimum is None or maximum is None or maximum <= minimum:
        return 1.0
    wish = (maximum - minimum) / 100.0
    power = 10.0 ** math.floor(math.log10(wish))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= wish * 0.999)


def is_scale(minimum: float, maximum: float, usual: float) -> bool:
    """Return whether a range tells how far values go; a much wider one only keeps out nonsense.

    A millimetre to a kilometre is no scale for a length of 10 cm: a touch of its slider would be
    metres.
    """
    return maximum - minimum <= WIDE * (abs(usual) or UNKNOWN)


def format_number(value: float, step: float) -> str:
    """Return the value with as many decimals as the step has, and two more if they matter."""
    shown = max(0, min(MOST_DECIMALS, math.ceil(-math.log10(step) - 1e-9)))
    text = f"{value:.{min(MOST_DECIMALS, shown + 2)}f}"
    while "." in text and text.endswith("0") and len(text.split(".")[1]) > shown:
        text = text[:-1]
    text = text.rstrip(".")
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text


class NumberField(QDoubleSpinBox):
    """A number with a unit.

    Drag sideways to change it (Shift coarse, Ctrl fine), click to type, arrow keys to step;
    sums are computed, in other units too; Esc restores.

    Parameters
    ----------
    name : str
        Accessible name.
    minimum, maximum : float, optional
        Values outside are brought to the nearer end.
    step : float, optional
        Default: see `sensible_step`.
    usual : float, optional
        A value that is usual, where the range is no scale: steps are a hundredth of the value then.
    unit : str
        Shown behind the number.
    whole : bool
        Only whole numbers.
    zero : str
        Words in the place of 0, greyed; an empty field is 0 then, and a drag does not begin
        there, for what is not given has no neighbours.

    Signals
    -------
    edited : float, bool
        A person changed the value; True while the drag goes on.
    drag_ended
        The drag is over, for better or worse.
    """

    edited = Signal(float, bool)
    drag_ended = Signal()

    def __init__(
        self,
        name: str,
        parent: QWidget | None = None,
        *,
        minimum: float | None = None,
        maximum: float | None = None,
        step: float | None = None,
        usual: float | None = None,
        unit: str = "",
        whole: bool = False,
        zero: str = "",
    ) -> None:
        super().__init__(parent)
        self._whole = whole
        self._zero = zero
        self._unit = "" if not unit else unit if unit in ("°", "%") else f" {unit}"
        self._step = step or sensible_step(minimum, maximum, whole=whole)
        self._usual = usual
        self._grabbed: tuple[QPointF, float] | None = None
        self._dragging = False
        self._typing = False
        self._clicked_into = False
        self.setDecimals(0 if whole else MOST_DECIMALS)
        self.setRange(
            -math.inf if minimum is None else minimum, math.inf if maximum is None else maximum
        )
        self.setSuffix(self._unit)
        self.setButtonSymbols(QAbstractSpinBox.ButtonSymbols.NoButtons)
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.setKeyboardTracking(False)
        self.setAccessibleName(name)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setFixedHeight(HEIGHT)
        self.lineEdit().setTextMargins(2, 0, 2, 0)
        for watched in (self, self.lineEdit()):
            watched.installEventFilter(self)
        self.lineEdit().setCursor(Qt.CursorShape.SizeHorCursor)
        self.lineEdit().setAccessibleName(name)
        if zero:
            self.lineEdit().setPlaceholderText(zero)
            self.valueChanged.connect(self._suit_unit)
            self._suit_unit()

    # -- how numbers are written and read --

    def step_at(self, value: float) -> float:
        """Return the step from a value."""
        if self._usual is None:
            return self._step
        return sensible_step(0.0, max(abs(value), LEAST_SHARE * (abs(self._usual) or UNKNOWN)))

    def textFromValue(self, value: float) -> str:
        return "" if self._zero and value == 0.0 else format_number(value, self.step_at(value))

    def valueFromText(self, text: str) -> float:
        try:
            return self._read(text)
        except UserError:
            return self.value()

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        try:
            self._read(text)
        except UserError:
            return (QValidator.State.Intermediate, text, position)
        return (QValidator.State.Acceptable, text, position)

    def fixup(self, text: str) -> str:
        return self.textFromValue(self.value()) + self.suffix()

    def _read(self, text: str) -> float:
        bare = text.removesuffix(self._unit).removesuffix(self._unit.strip())
        if self._zero and not bare.strip():
            return 0.0
        parts = QLocale().groupSeparator() == ","
        exact = compute(bare, self._unit.strip(), comma_parts=parts)
        number = float(round(exact)) if self._whole else float(exact)
        return min(max(number, self.minimum()), self.maximum())

    def _suit_unit(self) -> None:
        """No unit behind words."""
        self.setSuffix("" if self.value() == 0.0 else self._unit)

    def set_silently(self, value: float) -> None:
        """Show a value that came from elsewhere, unless the person is busy with the field."""
        if not self._typing and not self._dragging:
            self.setValue(value)

    def _change(self, value: float, *, dragging: bool) -> None:
        value = round(value) if self._whole else round(value, MOST_DECIMALS)
        before = self.value()
        self.setValue(min(max(value, self.minimum()), self.maximum()))
        if self.value() != before:
            self.edited.emit(self.value(), dragging)

    # -- typing --

    def stepBy(self, steps: int) -> None:
        self._change(self.value() + steps * self.step_at(self.value()), dragging=False)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._take_typed()
        elif event.key() == Qt.Key.Key_Escape:
            self._restore()
        elif event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down) and event.modifiers():
            steps = self._pace(event.modifiers()) * (1 if event.key() == Qt.Key.Key_Up else -1)
            self._change(self.value() + steps * self.step_at(self.value()), dragging=False)
        else:
            self._typing = self._typing or bool(event.text().strip())
            super().keyPressEvent(event)

    def _take_typed(self) -> bool:
        try:
            value = self._read(self.lineEdit().text())
        except UserError as problem:
            QToolTip.showText(self.mapToGlobal(self.rect().bottomLeft()), problem.message, self)
            self.setAccessibleDescription(problem.message)
            return False
        self._typing = self._clicked_into = False
        self.setAccessibleDescription("")
        before = self.value()
        self.setValue(value)
        self.lineEdit().setText(self.textFromValue(self.value()) + self.suffix())
        self.selectAll()
        if self.value() != before:
            self.edited.emit(self.value(), False)
        return True

    def _restore(self) -> None:
        if self._grabbed is not None:
            start = self._grabbed[1]
            self._grabbed = None
            if self._dragging:
                self._change(start, dragging=True)
                self._end_drag()
            return
        self._typing = self._clicked_into = False
        self.lineEdit().setText(self.textFromValue(self.value()) + self.suffix())
        self.selectAll()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        if self._typing and not self._take_typed():
            self._restore()
        self._typing = self._clicked_into = False
        super().focusOutEvent(event)
        self.lineEdit().deselect()
        self.lineEdit().setCursor(Qt.CursorShape.SizeHorCursor)

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()  # a panel that scrolls must not change numbers on its way

    # -- dragging --

    def _pace(self, modifiers: Qt.KeyboardModifier) -> float:
        if modifiers & Qt.KeyboardModifier.ShiftModifier:
            return COARSE
        if modifiers & Qt.KeyboardModifier.ControlModifier:
            return 1.0 / COARSE
        return 1.0

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.lineEdit():
            kind = event.type()
            busy = self._typing or self._clicked_into
            if kind == QEvent.Type.MouseButtonPress and not busy:
                return self._press(cast(QMouseEvent, event))
            if kind == QEvent.Type.MouseMove and self._grabbed is not None:
                return self._drag(cast(QMouseEvent, event))
            if kind == QEvent.Type.MouseButtonRelease and self._grabbed is not None:
                return self._release()
        elif event.type() == QEvent.Type.ShortcutOverride:
            if self._is_of_the_document(cast(QKeyEvent, event)):
                event.ignore()
                return True
        return super().eventFilter(watched, event)

    def _is_of_the_document(self, key: QKeyEvent) -> bool:
        """Whether a key with Control is for a command, and not for the number."""
        own = OF_THE_FIELD + (WHILE_TYPING if self._typing else ())
        return (
            key.modifiers() == Qt.KeyboardModifier.ControlModifier
            and Qt.Key.Key_A <= key.key() <= Qt.Key.Key_Z
            and not any(key.matches(kept) for kept in own)
        ) or any(key.matches(other) for other in WHILE_TYPING if not self._typing)

    def _press(self, event: QMouseEvent) -> bool:
        if event.button() != Qt.MouseButton.LeftButton:
            return False
        self._grabbed = (event.globalPosition(), self.value())
        return True

    def _drag(self, event: QMouseEvent) -> bool:
        assert self._grabbed is not None
        origin, start = self._grabbed
        moved = event.globalPosition().x() - origin.x()
        if (not self._dragging and abs(moved) < DRAG_START) or (self._zero and start == 0.0):
            return True
        self._dragging = True
        steps = math.trunc(moved / PIXELS_PER_STEP)
        pace = self._pace(event.modifiers())
        self._change(start + steps * pace * self.step_at(start), dragging=True)
        return True

    def _release(self) -> bool:
        self._grabbed = None
        if self._dragging:
            self._end_drag()
        else:
            self._clicked_into = True
            self.lineEdit().setCursor(Qt.CursorShape.IBeamCursor)
            self.setFocus(Qt.FocusReason.MouseFocusReason)
            self.selectAll()
        return True

    def _end_drag(self) -> None:
        self._dragging = False
        self.drag_ended.emit()

    # -- looks --

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        near = self.underMouse() or self._dragging
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.hasFocus():
            edge = QPen(qcolor(colors.second), 1.5)
        else:
            edge = QPen(qcolor(colors.edge if near and self.isEnabled() else colors.hairline), 1)
        painter.setPen(edge)
        painter.setBrush(qcolor(colors.field))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.75, 0.75, -0.75, -0.75), 4, 4)
