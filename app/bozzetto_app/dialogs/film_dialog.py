"""Question of what a film shows, where something was recorded."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtWidgets

from bozzetto_app.i18n import tr
from bozzetto_app.session.films import LONGEST_FILM

__all__ = ["FilmDialog"]


class FilmDialog(QtWidgets.QDialog):
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
        super().__init__(parent)
        self.setObjectName("film")
        self.setWindowTitle(title)
        self.recorded = QtWidgets.QRadioButton(
            tr("Files", "&What was recorded ({seconds} s)", seconds=f"{recorded:.1f}")
        )
        self.recorded.setChecked(True)
        self.next = QtWidgets.QRadioButton(tr("Files", "The &next seconds"))
        self.seconds = QtWidgets.QDoubleSpinBox()
        self.seconds.setRange(0.2, LONGEST_FILM)
        self.seconds.setDecimals(1)
        self.seconds.setValue(4.0)
        self.seconds.setSuffix(" s")
        self.seconds.setAccessibleName(tr("Files", "Seconds"))
        self.seconds.setEnabled(False)
        self.next.toggled.connect(self.seconds.setEnabled)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.next)
        row.addWidget(self.seconds)
        standard = QtWidgets.QDialogButtonBox.StandardButton
        buttons = QtWidgets.QDialogButtonBox(standard.Ok | standard.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        layout = QtWidgets.QVBoxLayout(self)
        layout.addWidget(self.recorded)
        layout.addLayout(row)
        layout.addWidget(buttons)

        def answered() -> None:
            then(self.seconds.value() if self.next.isChecked() else None)

        self.accepted.connect(answered)
        self.finished.connect(self.deleteLater)
