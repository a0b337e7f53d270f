"""One parameter in the form: its words, its control, and the way back to its default."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from bozzetto.parameters import LONGEST_TEXT, Field
from bozzetto_app.i18n import tr
from bozzetto_app.widgets.choice import ChoiceBox, Segments, make_choice
from bozzetto_app.widgets.icon_button import IconButton
from bozzetto_app.widgets.number_field import NumberField, format_number, is_scale, sensible_step
from bozzetto_app.widgets.slider import Slider
from bozzetto_app.widgets.swatch import Swatch, color_name
from bozzetto_app.widgets.text_field import TextField
from bozzetto_app.widgets.toggle import Toggle

__all__ = ["ParameterRow"]

NUMBER_WIDTH = 96
"""Width of a number field, px: six digits and a unit."""

CHOICE_WIDTH = 216
"""Width within which segments must fit, px: the narrowest dock without its margins."""


class _Words(QLabel):
    """The parameter's label; a double click restores the default."""

    restore = Signal()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.restore.emit()


class ParameterRow(QWidget):
    """A row of the form, made from a parameter's annotation.

    Signals
    -------
    changed : object, bool
        A person chose this value; True while a drag goes on.
    drag_ended
    """

    changed = Signal(object, bool)
    drag_ended = Signal()

    def __init__(self, field: Field, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.field = field
        label = field.parameter.label
        self._show: Callable[[Any], None] = lambda value: None
        self.words = _Words(label)
        self.words.restore.connect(self._restore)
        default = self._said(field.default)
        tip = tr("Parameters", "Double-click restores {value}.", value=default)
        self.words.setToolTip(f"{field.parameter.help}\n{tip}".strip())
        self.reset = IconButton(
            "reset",
            tr("Parameters", "Restore {label} to {value}", label=label, value=default),
            side=20,
            glyph=14,
            faint=True,
        )
        policy = self.reset.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.reset.setSizePolicy(policy)
        self.reset.clicked.connect(self._restore)

        self._line = QHBoxLayout()
        self._line.setSpacing(4)
        self._line.addWidget(self.words)
        self._line.addWidget(self.reset)
        self._line.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addLayout(self._line)
        self._below = column
        {
            "number": self._make_number,
            "integer": self._make_number,
            "switch": self._make_switch,
            "choice": self._make_choice,
            "text": self._make_text,
            "color": self._make_color,
        }[field.kind]()
        inside = self.findChildren(QWidget)
        self._tips = {widget: widget.toolTip() for widget in inside if widget.toolTip()}

    def show_idle(self, reason: str) -> None:
        """Switch the row off while it changes nothing, and on where there is no reason ("")."""
        if reason == self.accessibleDescription():
            return
        self.setAccessibleDescription(reason)
        self.setToolTip(reason)
        for widget, tip in self._tips.items():
            widget.setToolTip(reason or tip)
        self.setEnabled(not reason)

    def show_value(self, value: Any) -> None:
        """Show the value that the model has."""
        self._show(value)
        self.reset.setVisible(bool(value != self.field.default))  # a number may be one of numpy

    def _said(self, value: Any) -> str:
        if self.field.kind == "switch":
            return tr("Parameters", "on") if value else tr("Parameters", "off")
        if self.field.kind == "choice":
            return dict(self._options()).get(value, str(value))
        if self.field.kind == "color":
            return color_name(value)
        if self.field.kind == "text":
            return tr("Parameters", "nothing") if not value else f"“{value}”"
        if self.field.parameter.zero and value == 0:
            return self.field.parameter.zero
        step = self._step() if self._is_scale else sensible_step(0.0, abs(value))
        return f"{format_number(value, step)} {self.field.parameter.unit}".strip()

    def _restore(self) -> None:
        self.changed.emit(self.field.default, False)

    @property
    def _is_scale(self) -> bool:
        """Whether the range of a number, if it has one, tells how far values go."""
        low, high = self.field.parameter.minimum, self.field.parameter.maximum
        if low is None or high is None or self.field.parameter.step:
            return True
        return is_scale(low, high, float(self.field.default))

    def _step(self) -> float:
        asked, whole = self.field.parameter, self.field.kind == "integer"
        step = asked.step or sensible_step(asked.minimum, asked.maximum, whole=whole)
        if asked.step or whole or not self.field.default:
            return step
        return min(step, sensible_step(0.0, 10.0 * abs(self.field.default)))

    def _options(self) -> tuple[tuple[str, str], ...]:
        named = dict(self.field.parameter.choices)
        return tuple((value, named.get(value, value)) for value in self.field.values)

    def _typed(self, number: float) -> int | float:
        return round(number) if self.field.kind == "integer" else number

    def _make_number(self) -> None:
        asked = self.field.parameter
        number = NumberField(
            asked.label,
            minimum=asked.minimum,
            maximum=asked.maximum,
            step=self._step(),
            usual=None if self._is_scale else float(self.field.default),
            unit=asked.unit,
            whole=self.field.kind == "integer",
            zero=asked.zero,
        )
        number.setFixedWidth(NUMBER_WIDTH)
        number.setToolTip(asked.help)
        number.edited.connect(lambda v, going: self.changed.emit(self._typed(v), going))
        number.drag_ended.connect(self.drag_ended)
        self._line.addWidget(number)
        self.words.setBuddy(number)
        # On a slider, what is not given would be one end, beside the least that can be.
        low, high = asked.minimum, asked.maximum
        if low is None or high is None or asked.zero or not self._is_scale:
            self._show = number.set_silently
            return
        slider = Slider(asked.label, low, high, self._step(), float(self.field.default))
        slider.setToolTip(asked.help)
        slider.slid.connect(lambda v, going: self.changed.emit(self._typed(v), going))
        slider.drag_ended.connect(self.drag_ended)
        self._below.addWidget(slider)

        def show(value: float) -> None:
            number.set_silently(value)
            slider.set_silently(value)

        self._show = show

    def _make_switch(self) -> None:
        toggle = Toggle(self.field.parameter.label)
        toggle.clicked.connect(lambda on: self.changed.emit(bool(on), False))
        self._line.addWidget(toggle)
        self.words.setBuddy(toggle)
        self._show = toggle.setChecked

    def _make_choice(self) -> None:
        choice: Segments | ChoiceBox = make_choice(
            self.field.parameter.label, self._options(), CHOICE_WIDTH, self
        )
        choice.chosen.connect(lambda value: self.changed.emit(value, False))
        self._below.addWidget(choice)
        self.words.setBuddy(choice)
        self._show = choice.set_silently

    def _make_color(self) -> None:
        swatch = Swatch()
        swatch.chosen.connect(lambda color: self.changed.emit(color, False))
        self._line.addWidget(swatch)
        self.words.setBuddy(swatch)
        self._show = lambda color: swatch.show_color(color, self.field.parameter.label)

    def _make_text(self) -> None:
        text = TextField()
        text.setAccessibleName(self.field.parameter.label)
        text.setMaxLength(LONGEST_TEXT)

        def finished() -> None:
            if text.text() != text.shown:
                self.changed.emit(text.text(), False)

        text.editingFinished.connect(finished)
        self._below.addWidget(text)
        self.words.setBuddy(text)
        self._show = text.show_text
