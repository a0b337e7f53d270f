"""“Read this ink as …”: what other modelers make of the ink, with a small picture of each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from bozzetto_app.dialogs.dialog import Page, label, quiet
from bozzetto_app.i18n import tr
from bozzetto_app.style.theme import current_palette

if TYPE_CHECKING:
    from bozzetto.workbench.readings import Reading
    from bozzetto_app.session.ink_readings import Ink
    from bozzetto_app.session.session import Session

__all__ = ["ReadInkDialog"]

SIDE: Final = 104
"""Side of a small picture, pixels of the screen's own measure."""


class ReadInkDialog(Page):
    """Offers readings as they are found; when it closes, nobody is asked any more.

    Parameters
    ----------
    session : Session
    ink : Ink
        What is read.
    parent : QWidget, optional
    """

    def __init__(self, session: Session, ink: Ink, parent: QWidget | None = None) -> None:
        super().__init__("read-ink", tr("ReadInk", "Read this ink as…"), parent)
        self._session, self._ink = session, ink
        said = (
            tr("ReadInk", "What else the ink of “{name}” can be:", name=ink.name)
            if ink.name
            else tr("ReadInk", "What the waiting ink can be:")
        )
        self.column.addWidget(label(said))
        self._cards = QVBoxLayout()
        self._cards.setSpacing(8)
        self.column.addLayout(self._cards)
        self.state = quiet(tr("ReadInk", "Other modelers are being asked…"))
        self.column.addWidget(self.state)
        self.column.addStretch(1)
        self.setMinimumWidth(400)
        close = self.add_button(tr("ReadInk", "&Close"))
        close.clicked.connect(self.reject)
        readings = session.readings
        readings.found.connect(self._offer)
        readings.ended.connect(self._tell_end)
        self.finished.connect(readings.cancel)
        session.drawing.closing.connect(self.reject)
        side = round(SIDE * self.devicePixelRatioF())
        readings.ask(ink, current_palette(), side)

    def _offer(self, reading: Reading) -> None:
        """Add a card for what a modeler made of the ink."""
        title = self._session.registry.info(reading.model.modeler).title
        card = QFrame()
        card.setProperty("shape", "card")
        row = QHBoxLayout(card)
        row.setContentsMargins(8, 8, 12, 8)
        row.setSpacing(12)
        row.addWidget(_picture(reading, title, self.devicePixelRatioF()))
        words = QVBoxLayout()
        words.addStretch(1)
        words.addWidget(label(title, kind="heading"))
        buttons = QHBoxLayout()
        buttons.setSpacing(8)
        for in_place, text, name in self._choices(title):
            button = QPushButton(text)
            button.setAccessibleName(name)
            button.setAutoDefault(False)
            button.clicked.connect(
                lambda _, in_place=in_place: self._take(reading, in_place=in_place)
            )
            buttons.addWidget(button)
        buttons.addStretch(1)
        words.addLayout(buttons)
        words.addStretch(1)
        row.addLayout(words, 1)
        self._cards.addWidget(card)
        self.adjustSize()

    def _choices(self, title: str) -> list[tuple[bool, str, str]]:
        """Return what can be done with a reading: whether in place, the button, its name."""
        if self._ink.model is None:
            name = tr("ReadInk", "Read the waiting ink as {title}", title=title)
            return [(False, tr("ReadInk", "Read it so"), name)]
        beside = tr("ReadInk", "New object, read as {title}", title=title)
        place = tr("ReadInk", "Read as {title} in its place", title=title)
        return [
            (False, tr("ReadInk", "New object"), beside),
            (True, tr("ReadInk", "In its place"), place),
        ]

    def _take(self, reading: Reading, *, in_place: bool) -> None:
        self._session.readings.take(self._ink, reading, in_place=in_place)
        self.accept()

    def _tell_end(self) -> None:
        found = self._cards.count() > 0
        self.state.setVisible(not found)
        self.state.setText(tr("ReadInk", "No other modeler can make a shape of this ink."))
        self.adjustSize()


def _picture(reading: Reading, title: str, scale: float) -> QLabel:
    height, width = reading.picture.shape[:2]
    pixels = reading.picture.tobytes()
    image = QImage(pixels, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
    image.setDevicePixelRatio(scale)
    shown = QLabel()
    shown.setPixmap(QPixmap.fromImage(image))
    shown.setFixedSize(SIDE, SIDE)
    shown.setAlignment(Qt.AlignmentFlag.AlignCenter)
    shown.setAccessibleName(tr("ReadInk", "Picture of it, read as {title}", title=title))
    return shown
