"""After a crash: what is here, and how far it goes. Nothing is deleted without an answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QDateTime, QLocale
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QMessageBox,
    QPushButton,
    QVBoxLayout,
    QWidget,
)
from shiboken6 import isValid

from bozzetto_app.dialogs.dialog import Page, label, quiet
from bozzetto_app.i18n import tr
from bozzetto_app.toolkit.panel_scroll import PanelScroll

if TYPE_CHECKING:
    from bozzetto.document.recovery.recovery import CrashedSession

__all__ = ["RecoveryDialog"]

MOST_OF_SCREEN: Final = 0.6
"""Share of the screen's height that the drawings may take; more of them are scrolled."""


def _clock(seconds: float) -> str:
    """Return the time of day, with the date if that is not today."""
    try:
        when = datetime.fromtimestamp(seconds)
    except (ValueError, OverflowError, OSError):  # a clock, or a file, out of order
        return tr("Recovery", "a time that is not known")
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
        Opens one, and calls back with whether it is on the sheet now.
    discard : callable
        Deletes one, and calls back with whether it is gone.
    suspect : str
        Title of the plugin that was at work when the program crashed; "" if none is known.
    switch_off : callable
        Switches that plugin off.
    """

    def __init__(
        self,
        sessions: Sequence[CrashedSession],
        open_: Callable[[CrashedSession, Callable[[bool], None]], object],
        discard: Callable[[CrashedSession, Callable[[bool], None]], object],
        parent: QWidget | None = None,
        *,
        suspect: str = "",
        switch_off: Callable[[], object] = lambda: None,
    ) -> None:
        super().__init__("recovery", tr("Recovery", "Recover drawings"), parent)
        self._open, self._discard = open_, discard
        self._left = len(sessions)
        self._first = QPushButton()
        self.column.addWidget(
            label(tr("Recovery", "Bozzetto closed unexpectedly."), kind="heading")
        )
        if suspect:
            self.column.addLayout(self._suspicion(suspect, switch_off))
        self._cards = QVBoxLayout()
        self._cards.setContentsMargins(0, 0, 0, 0)
        self._cards.setSpacing(12)
        for number, session in enumerate(sessions):
            self._cards.addWidget(self._card(session, first=number == 0))
        self._cards.addStretch(1)
        self._area = PanelScroll()
        page = QWidget()
        page.setLayout(self._cards)
        self._area.setWidget(page)
        self.column.addWidget(self._area, 1)
        self.column.addWidget(
            quiet(tr("Recovery", "What you do not open now is kept and offered again."))
        )
        self.keep = self.add_button(tr("Recovery", "&Keep for later"))
        self.keep.clicked.connect(self.reject)
        self.setMinimumWidth(520)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._first.setFocus()
        # The words wrap: how tall the cards are is known once they have a width and a screen.
        tall = self._cards.totalHeightForWidth(self._area.viewport().width())
        most = round(MOST_OF_SCREEN * self.screen().availableGeometry().height())
        self._area.setMinimumHeight(min(tall, most))
        self.adjustSize()

    def _suspicion(self, title: str, switch_off: Callable[[], object]) -> QHBoxLayout:
        """Say which plugin was at work, which may crash again over the same drawing."""
        button = QPushButton(tr("Recovery", "Switch off"))
        button.setObjectName("switch-off-suspect")
        button.setAccessibleName(tr("Recovery", "Switch off “{title}”", title=title))
        button.setAutoDefault(False)

        def off() -> None:
            switch_off()
            button.setText(tr("Recovery", "Switched off"))
            button.setEnabled(False)

        button.clicked.connect(off)
        said = tr(
            "Recovery",
            "The plugin “{title}” was at work when it did. If opening a drawing closes the program "
            "again, switch the plugin off first: its objects are kept as they are.",
            title=title,
        )
        row = QHBoxLayout()
        row.setSpacing(12)
        row.addWidget(label(said), 1)
        row.addWidget(button)
        return row

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
        if session.host:
            place += "\n" + tr(
                "Recovery",
                "It was open on “{host}”. Open it here only if it is not open there any more.",
                host=session.host,
            )
        button = QPushButton(tr("Recovery", "Open"))
        button.setAccessibleName(tr("Recovery", "Open “{name}”", name=session.name))
        button.setProperty("rank", "first" if first else "")
        button.setDefault(first)
        button.setAutoDefault(first)
        away = QPushButton(tr("Recovery", "Discard…"))
        away.setAccessibleName(tr("Recovery", "Discard “{name}”", name=session.name))
        away.setAutoDefault(False)
        if first:
            self._first = button

        def tell(words: str, *, is_free: bool) -> None:
            button.setText(words)
            button.setEnabled(is_free)
            away.setEnabled(is_free)

        def ended(done: str) -> Callable[[bool], None]:
            def show(is_done: bool) -> None:
                if not isValid(self):
                    return
                tell(done if is_done else tr("Recovery", "Open"), is_free=not is_done)
                self._left -= is_done
                if self._left == 0:
                    self.accept()

            return show

        def open_it() -> None:
            tell(tr("Recovery", "Opening…"), is_free=False)
            self._open(session, ended(tr("Recovery", "Opened")))

        def discard_it() -> None:
            if self._is_sure(session):
                tell(tr("Recovery", "Discarding…"), is_free=False)
                self._discard(session, ended(tr("Recovery", "Discarded")))

        button.clicked.connect(open_it)
        away.clicked.connect(discard_it)
        column = QVBoxLayout()
        column.setSpacing(4)
        column.addWidget(label(said))
        column.addWidget(quiet(place))
        row = QHBoxLayout(card)
        row.setContentsMargins(12, 12, 12, 12)
        row.setSpacing(12)
        row.addLayout(column, 1)
        row.addWidget(away)
        row.addWidget(button)
        return card

    def _is_sure(self, session: CrashedSession) -> bool:
        """Ask before the only copy of a drawing is deleted."""
        box = QMessageBox(self)
        box.setObjectName("discard")
        box.setIcon(QMessageBox.Icon.NoIcon)
        box.setText(tr("Recovery", "Discard “{name}” for good?", name=session.name))
        box.setInformativeText(tr("Recovery", "This cannot be undone."))
        sure = box.addButton(tr("Recovery", "&Discard"), QMessageBox.ButtonRole.DestructiveRole)
        keep = box.addButton(tr("Recovery", "&Keep"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(keep)
        box.exec()
        return box.clickedButton() is sure
