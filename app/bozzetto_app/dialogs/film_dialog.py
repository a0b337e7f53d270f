"""Question of what a film shows, where something was recorded."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtWidgets

from bozzetto_app.dialogs.seconds_dialog import SecondsDialog
from bozzetto_app.i18n import tr

__all__ = ["FilmDialog"]


class FilmDialog(SecondsDialog):
    """Asks whether a film shows what was recorded or the next seconds.

    Parameters
    ----------
    title : str
    recorded : float
        How long the recording is, s.
    then : callable
        Gets the seconds that are to be made; None for the recording.
    parent : QtWidgets.QWidget
    """

    def __init__(
        self,
        title: str,
        recorded: float,
        then: Callable[[float | None], None],
        parent: QtWidgets.QWidget,
    ) -> None:
        super().__init__("film", title, parent)
        self.recorded = QtWidgets.QRadioButton(
            tr("Files", "&What was recorded ({seconds} s)", seconds=f"{recorded:.1f}")
        )
        self.recorded.setChecked(True)
        self.next = QtWidgets.QRadioButton(tr("Files", "The &next seconds"))
        self.seconds.setAccessibleName(tr("Files", "Seconds"))
        self.seconds.setEnabled(False)
        self.next.toggled.connect(self.seconds.setEnabled)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.next)
        row.addWidget(self.seconds)
        self.lay_out(self.recorded, row)

        def answered() -> None:
            then(self.seconds.value() if self.next.isChecked() else None)

        self.accepted.connect(answered)
