"""The pen tester: whether the tablet says what the hand does."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from bozzetto_app.canvas.input.stroke_samples import PressureCurve
from bozzetto_app.dialogs.dialog import Page, quiet
from bozzetto_app.dialogs.pen_pad import PenPad, PressureGraph, Reading
from bozzetto_app.dialogs.pressure_editor import PressureEditor
from bozzetto_app.i18n import tr
from bozzetto_app.settings import settings
from bozzetto_app.style.theme import qcolor, tones
from bozzetto_app.widgets.number_field import NumberField

__all__ = ["PRESSURE_CURVE", "PenTester"]

PRESSURE_CURVE = "pen/pressure_curve"
"""Setting: the exponent of the pressure curve."""

MOST_TILT = 60.0
"""Tilt that reaches the rim of the dial, degrees; most pens end there."""


class _Tilt(QWidget):
    """Where the pen leans, seen from above."""

    def __init__(self) -> None:
        super().__init__()
        self._tilt = (0.0, 0.0)
        self.setFixedSize(QSize(72, 72))
        self.setAccessibleName(tr("Pen", "Tilt"))

    def show_tilt(self, x: float, y: float) -> None:
        self._tilt = (x, y)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QRectF(self.rect()).center()
        radius = self.width() / 2 - 1
        painter.setPen(QPen(qcolor(colors.hairline), 1))
        painter.setBrush(qcolor(colors.field))
        painter.drawEllipse(middle, radius, radius)
        painter.drawEllipse(middle, radius / 2, radius / 2)
        x, y = (max(-1.0, min(1.0, part / MOST_TILT)) for part in self._tilt)
        tip = QPointF(middle.x() + x * (radius - 6), middle.y() + y * (radius - 6))
        painter.setPen(QPen(qcolor(colors.text), 1.5))
        painter.drawLine(middle, tip)
        painter.setBrush(qcolor(colors.accent))
        painter.drawEllipse(tip, 4, 4)


class PenTester(Page):
    """A pad, what the device says, and the pressure curve.

    Signals
    -------
    curve_changed : float
        The exponent that is now in the settings.
    """

    curve_changed = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("pen-tester", tr("Pen", "Pen tester"), parent)
        self.pad = PenPad()
        self.graph = PressureGraph()
        self.editor = PressureEditor()
        self.exponent = NumberField(
            tr("Pen", "Exponent of the pressure curve"),
            minimum=PressureCurve.SOFTEST,
            maximum=PressureCurve.HARDEST,
            step=0.05,
        )
        self._tilt = _Tilt()
        self._values = {
            key: QLabel("–") for key in ("device", "tool", "pressure", "rate", "tilt", "twist")
        }
        self.pad.read.connect(self._show)
        self.pad.sampled.connect(self.graph.add)
        self.editor.edited.connect(self._take_gamma)
        self.exponent.edited.connect(lambda value, going: self._take_gamma(value))
        curve = PressureCurve.from_setting(settings().value(PRESSURE_CURVE, 1.0))
        self._show_gamma(curve.gamma)

        left = QVBoxLayout()
        left.setSpacing(8)
        left.addWidget(self.pad, 1)
        left.addWidget(quiet(tr("Pen", "Pressure")))
        left.addWidget(self.graph)
        right = QVBoxLayout()
        right.setSpacing(8)
        right.addLayout(self._facts())
        right.addWidget(self._tilt, 0, Qt.AlignmentFlag.AlignLeft)
        right.addStretch(1)
        heading = QLabel(tr("Pen", "Pressure curve"))
        heading.setProperty("type", "heading")
        right.addWidget(heading)
        right.addWidget(self.editor)
        line = QHBoxLayout()
        line.addWidget(quiet(tr("Pen", "Exponent")), 1)
        line.addWidget(self.exponent)
        right.addLayout(line)
        both = QHBoxLayout()
        both.setSpacing(20)
        both.addLayout(left, 1)
        both.addLayout(right)
        self.column.addLayout(both)
        self.add_button(tr("Pen", "C&lear")).clicked.connect(self.pad.clear)
        self.add_button(tr("Pen", "&Close"), default=True).clicked.connect(self.accept)
        self.resize(720, 520)

    def _facts(self) -> QGridLayout:
        names = {
            "device": tr("Pen", "Device"),
            "tool": tr("Pen", "Tool"),
            "pressure": tr("Pen", "Pressure"),
            "rate": tr("Pen", "Rate"),
            "tilt": tr("Pen", "Tilt"),
            "twist": tr("Pen", "Twist"),
        }
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(4)
        grid.setColumnStretch(1, 1)
        for row, (key, name) in enumerate(names.items()):
            grid.addWidget(quiet(name), row, 0)
            self._values[key].setAccessibleName(name)
            self._values[key].setMinimumWidth(104)
            grid.addWidget(self._values[key], row, 1)
        return grid

    def _show(self, reading: Reading) -> None:
        pressure = reading.pressure
        said = {
            "device": reading.device,
            "tool": reading.tool,
            "pressure": tr("Pen", "none") if pressure is None else f"{pressure:.3f}",
            "rate": tr("Pen", "{rate} Hz", rate=round(reading.rate)),
            "tilt": f"{reading.tilt_x:.0f}°, {reading.tilt_y:.0f}°",
            "twist": f"{reading.twist:.0f}°",
        }
        for key, words in said.items():
            self._values[key].setText(words)
            self._values[key].setToolTip(words)
        self._tilt.show_tilt(reading.tilt_x, reading.tilt_y)
        self.editor.show_pressure(pressure)

    def _show_gamma(self, gamma: float) -> None:
        self.pad.curve = PressureCurve(gamma)
        self.editor.show_gamma(gamma)
        self.exponent.set_silently(gamma)

    def _take_gamma(self, gamma: float) -> None:
        self._show_gamma(gamma)
        settings().setValue(PRESSURE_CURVE, self.pad.curve.gamma)
        self.curve_changed.emit(self.pad.curve.gamma)
