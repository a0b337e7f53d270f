"""After a crash: what is here, and how far it goes. Nothing is deleted without an answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime

from PySide6.QtCore import QDateTime, QLocale
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from bozzetto.document.recovery import CrashedSession
from bozzetto_app.dialogs.page import Page, label, quiet
from bozzetto_app.words import tr

__all__ = ["RecoveryDialog"]


def _clock(seconds: float) -> str:
    """The time of day; with its date where that is not today."""
    when = datetime.fromtimestamp(seconds)
    if when.date() == datetime.now().date():
        return when.strftime("%H:%M:%S")
    moment = QDateTime.fromSecsSinceEpoch(round(seconds))
    return QLocale().toString(moment, QLocale.FormatType.ShortFormat)


class RecoveryDialog(Page):
    """Offers every drawing that a crash left behind.

    Closing the dialog, by whatever means, keeps everything for later.

    Parameters
    ----------
    sessions : sequence of CrashedSession
    open_ : callable
        Opens one; called once for each that the person asks for.
    """

    def __init__(
        self,
        sessions: Sequence[CrashedSession],
        open_: Callable[[CrashedSession], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("recovery", tr("Recovery", "Recover drawings"), parent)
        self._open = open_
        self._left = len(sessions)
        self.column.addWidget(
            label(tr("Recovery", "Bozzetto closed unexpectedly."), kind="heading")
        )
        for number, session in enumerate(sessions):
            self.column.addWidget(self._card(session, first=number == 0))
        self.column.addWidget(
            quiet(tr("Recovery", "What you do not open now is kept and offered again."))
        )
        self.column.addStretch(1)
        self.keep = self.add_button(tr("Recovery", "Keep for later"))
        self.keep.clicked.connect(self.reject)
        self.setMinimumWidth(520)

    def _card(self, session: CrashedSession, *, first: bool) -> QFrame:
        card = QFrame()
        card.setProperty("shape", "card")
        said = tr(
            "Recovery",
            "Your drawing “{name}” is here, complete to {time}.",
            name=session.name,
            time=_clock(session.complete_to),
        )
        place = str(session.path) if session.path else tr("Recovery", "It was never saved.")
        button = QPushButton(tr("Recovery", "Open"))
        button.setAccessibleName(tr("Recovery", "Open “{name}”", name=session.name))
        button.setProperty("rank", "first" if first else "")
        button.setDefault(first)
        button.setAutoDefault(first)

        def open_it() -> None:
            button.setEnabled(False)
            button.setText(tr("Recovery", "Opened"))
            self._left -= 1
            self._open(session)
            if self._left == 0:
                self.accept()

        button.clicked.connect(open_it)
        column = QVBoxLayout()
        column.setSpacing(4)
        column.addWidget(label(said))
        column.addWidget(quiet(place))
        row = QHBoxLayout(card)
        row.setContentsMargins(12, 12, 12, 12)
        row.setSpacing(12)
        row.addLayout(column, 1)
        row.addWidget(button)
        return card
