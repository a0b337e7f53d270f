"""Where the chosen underlay lies: fields, and its two places brought to two others."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QPushButton, QVBoxLayout, QWidget

from bozzetto.document.underlay_place import LARGEST, SMALLEST
from bozzetto_app.i18n import tr
from bozzetto_app.panels.properties.drag_pace import DragPace
from bozzetto_app.panels.properties.place_form import TURN_STEP, PlaceRows
from bozzetto_app.widgets.number_field import NumberField

if TYPE_CHECKING:
    from bozzetto.document.underlay_place import UnderlayPlace
    from bozzetto_app.session.session import Session

__all__ = ["UnderlayForm"]

STEP = 10.0
"""Step of a drag of the width, mm."""


class UnderlayForm(QWidget):
    """Width, middle and turn of the chosen underlay, and a button that aligns it.

    Typed or dragged; by handles on the sheet as well.
    """

    _placed = Signal(object, bool)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._placing = session.pictures.placing
        self._place: UnderlayPlace | None = None
        self.rows = PlaceRows()
        self.width_field = NumberField(
            tr("Underlay", "Width"),
            self.rows,
            minimum=SMALLEST,
            maximum=LARGEST,
            step=STEP,
            unit="mm",
        )
        wide = tr("Underlay", "Of the picture, from its left to its right side")
        self.rows.add_row(self.width_field, wide)
        self.axes = self.rows.add_axes()
        self.turn = NumberField(
            tr("Place", "Turn"), self.rows, minimum=-360.0, maximum=360.0, step=TURN_STEP, unit="°"
        )
        self.rows.add_row(self.turn, tr("Underlay", "About its middle, in its own plane"))
        self.align = QPushButton(tr("Underlay", "Align by two places"))
        self.align.setToolTip(
            tr("Underlay", "Touch a place in the picture and where it belongs, twice")
        )
        self.align.clicked.connect(self._align)
        self.wish = QLabel()
        self.wish.setWordWrap(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        for widget in (self.rows, self.align, self.wish):
            column.addWidget(widget)
        pace = DragPace(self._put, self)
        self._placed.connect(pace.change)
        self.rows.drag_ended.connect(pace.end)
        self.rows.drag_ended.connect(session.objects.end_drag)
        self.width_field.edited.connect(lambda value, going: self._tell(going, width=value))
        self.turn.edited.connect(lambda value, going: self._tell(going, turn=value))
        for axis, field in enumerate(self.axes):
            field.edited.connect(partial(self._move, axis))

    def show_place(self, place: UnderlayPlace) -> None:
        """Show where the chosen underlay lies, and the touch that is expected."""
        self._place = place
        self.width_field.set_silently(place.width)
        for field, value in zip(self.axes, place.middle, strict=True):
            field.set_silently(value)
        self.turn.set_silently(place.turn)
        wish = self._placing.wish
        self.wish.setText(wish)
        self.wish.setVisible(bool(wish))
        self.align.setText(
            tr("Underlay", "Stop aligning") if wish else tr("Underlay", "Align by two places")
        )

    def _align(self) -> None:
        if not self._placing.end_alignment():
            self._placing.begin_alignment()

    def _move(self, axis: int, value: float, going: bool) -> None:
        if self._place is not None:
            middle = list(self._place.middle)
            middle[axis] = value
            self._tell(going, middle=(middle[0], middle[1], middle[2]))

    def _tell(self, going: bool, **changes: Any) -> None:
        if self._place is not None:
            self._place = replace(self._place, **changes)
            self._placed.emit(self._place, going)

    def _put(self, place: UnderlayPlace, going: bool) -> None:
        self._placing.set_place(place, dragging=going)
