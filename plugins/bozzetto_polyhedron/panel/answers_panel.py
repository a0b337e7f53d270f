"""The answers panel: a small picture of every solid that the drawing could mean, to choose from."""

from __future__ import annotations

from functools import partial
from typing import Final

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QIcon, QImage, QPixmap
from PySide6.QtWidgets import (
    QGridLayout,
    QLabel,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from bozzetto.plugin import Command, Context, PanelHost, override
from bozzetto_app.toolkit import PanelScroll, PanelWorker, palette_of
from bozzetto_polyhedron.commands.answers import with_answer
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.panel.answer_pictures import AnswerPicture, Gallery, gallery_of

PATIENCE: Final = 120
"""Time from a change to the update of the panel, ms: the program solves the drawing first, and its
answers are then remembered."""

SIZE: Final = (96, 80)
"""Width and height of a picture, px."""

COLUMNS: Final = 2


class AnswersPanel(PanelScroll):
    """The panel that shows the ranked answers of the chosen body.

    Parameters
    ----------
    host : PanelHost
        Access to the selected object.
    parent : QWidget
        The widget that holds the panel.
    """

    def __init__(self, host: PanelHost, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("answers")
        self._host = host
        self._state: PolyhedronState | None = None
        self._gallery = Gallery("", "")
        self._worker = PanelWorker(self)
        self._soon = QTimer(self, singleShot=True, interval=PATIENCE)
        self._soon.timeout.connect(self._begin)
        inside = QWidget()
        self._grid = QGridLayout(inside)
        self._grid.setContentsMargins(0, 0, 4, 0)
        self._grid.setSpacing(8)
        self.sentence = QLabel(inside)
        self.sentence.setWordWrap(True)
        self._grid.addWidget(self.sentence, 0, 0, 1, COLUMNS)
        self.cards: list[QToolButton] = []
        self.setWidget(inside)
        host.on_change(self._soon.start)
        self._soon.start()

    @property
    def busy(self) -> bool:
        """Whether the panel does not show the newest state yet."""
        return self._soon.isActive() or self._worker.busy

    @override
    def sizeHint(self) -> QSize:
        return QSize(280, 360)

    def _begin(self) -> None:
        """Have the pictures of the newest state made."""
        state = self._host.state
        if isinstance(state, PolyhedronState) and state is not self._state:
            self._state = state
            palette, scale = palette_of(self), self.devicePixelRatioF()
            self._worker.ask(
                lambda: gallery_of(state, palette, SIZE, scale),
                self._show,
                lambda problem: self._show(Gallery("", str(problem))),
            )

    def _show(self, gallery: Gallery) -> None:
        self._gallery = gallery
        self.sentence.setText(gallery.sentence)
        for card in self.cards:
            card.hide()
            card.deleteLater()
        self.cards = [self._card(each) for each in gallery.pictures]
        for place, card in enumerate(self.cards):
            self._grid.addWidget(card, 1 + place // COLUMNS, place % COLUMNS)
        rows = 2 + len(self.cards) // COLUMNS
        for row in range(self._grid.rowCount()):
            self._grid.setRowStretch(row, 0)
        self._grid.setRowStretch(rows, 1)

    def _card(self, each: AnswerPicture) -> QToolButton:
        card = QToolButton(self.widget())
        card.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        card.setAutoRaise(True)
        card.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        card.setCheckable(True)
        card.setChecked(each.number == self._gallery.chosen)
        card.setText(each.words)
        card.setAccessibleName(f"Answer {each.number + 1}: {each.words}")
        card.setToolTip(f"Answer {each.number + 1}, {100 * each.share:.0f} % likely")
        card.setIcon(QIcon(_pixmap(each, self.devicePixelRatioF())))
        card.setIconSize(QSize(*SIZE))
        card.clicked.connect(lambda _, number=each.number: self._choose(number))
        return card

    def _choose(self, number: int) -> None:
        """Take an answer of the body that is shown, in the newest state."""
        chosen = partial(_chosen, self._gallery.body, number)
        self._host.run(Command("choose-answer", "Choose an answer", "Take this answer.", chosen))


def _chosen(body_id: str, number: int, state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with an answer of a body, counted from 0; as it is where that is gone."""
    body = state.node(body_id)
    if not isinstance(body, Body):
        return state
    return with_answer(state, body, number, alone=context.alone)


def _pixmap(each: AnswerPicture, scale: float) -> QPixmap:
    height, width = each.pixels.shape[:2]
    data = each.pixels.tobytes()
    image = QImage(data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
    image.setDevicePixelRatio(scale)
    return QPixmap.fromImage(image)
