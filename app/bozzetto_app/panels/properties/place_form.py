"""Where an object stands, or a picture lies: fields to move and turn it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.widgets.number_field import NumberField

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

__all__ = ["TURN_STEP", "PlaceForm", "PlaceRows"]

FARTHEST = 1e6
"""Farthest from the origin that an object can be put by hand, mm."""

STEP = 10.0
"""Step of a drag, mm: a field goes on in coarser or finer steps with Shift or Ctrl."""

TURN_STEP = 5.0
"""Step of a turn, degrees."""


class PlaceRows(QWidget):
    """Rows of number fields with their names.

    Signals
    -------
    drag_ended
    """

    drag_ended = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows = QGridLayout(self)
        self._rows.setContentsMargins(0, 4, 0, 0)
        self._rows.setHorizontalSpacing(8)
        self._rows.setVerticalSpacing(6)
        self._rows.setColumnStretch(1, 1)

    def add_row(self, field: NumberField, tip: str) -> None:
        """Put a field below the others, with its name beside it."""
        number = self._rows.rowCount()
        words = QLabel(field.accessibleName())
        words.setBuddy(field)
        field.setToolTip(tip)
        field.setFixedWidth(120)
        self._rows.addWidget(words, number, 0)
        self._rows.addWidget(field, number, 2)
        field.drag_ended.connect(self.drag_ended)

    def add_axes(self) -> tuple[NumberField, ...]:
        """Add rows for x, y and z, mm."""
        made = []
        for words, tip in (
            (tr("Place", "Across"), tr("Place", "Along x: to the right in the front view")),
            (tr("Place", "Deep"), tr("Place", "Along y: away from you in the front view")),
            (tr("Place", "Up"), tr("Place", "Along z: above the ground")),
        ):
            field = NumberField(
                words, self, minimum=-FARTHEST, maximum=FARTHEST, step=STEP, usual=0.0, unit="mm"
            )
            self.add_row(field, tip)
            made.append(field)
        return tuple(made)


class PlaceForm(PlaceRows):
    """Four number fields: x, y and z of an object's own origin, and its heading.

    Typed or dragged; what a file has beside these, such as a scale, a tilt or a mirror, stays.

    Signals
    -------
    placed : Placement, bool
        A person moved it; True while a drag goes on.
    """

    placed = Signal(object, bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._placement: Placement | None = None
        self.axes = self.add_axes()
        self.turn = NumberField(
            tr("Place", "Turn"), self, minimum=-360.0, maximum=360.0, step=TURN_STEP, unit="°"
        )
        self.add_row(self.turn, tr("Place", "About the vertical through its own origin"))
        for axis, field in enumerate(self.axes):
            field.edited.connect(partial(self._move, axis))
        self.turn.edited.connect(self._turn)

    def show_placement(self, placement: Placement) -> None:
        """Show where the object stands."""
        self._placement = placement
        for field, value in zip(self.axes, placement.offset, strict=True):
            field.set_silently(value)
        self.turn.set_silently(placement.heading)

    def _move(self, axis: int, value: float, going: bool) -> None:
        if self._placement is not None:
            offset = list(self._placement.offset)
            offset[axis] = value
            self._tell(replace(self._placement, offset=(offset[0], offset[1], offset[2])), going)

    def _turn(self, heading: float, going: bool) -> None:
        if self._placement is not None:
            self._tell(self._placement.headed(heading), going)

    def _tell(self, placement: Placement, going: bool) -> None:
        self._placement = placement
        self.placed.emit(placement, going)
