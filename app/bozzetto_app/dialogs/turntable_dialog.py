"""Question of how long a turntable takes, and whether it begins with the sketch."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtWidgets

from bozzetto_app.i18n import tr
from bozzetto_app.session.films import LONGEST_FILM

__all__ = ["TurntableDialog"]


class TurntableDialog(QtWidgets.QDialog):
    """Asks how a turntable is made.

    Parameters
    ----------
    then : callable
        Gets the seconds of one turn, and whether it begins with the sketch.
    parent : QtWidgets.QWidget
    """

    def __init__(self, then: Callable[[float, bool], None], parent: QtWidgets.QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("turntable")
        self.setWindowTitle(tr("Files", "Turntable"))
        self.seconds = QtWidgets.QDoubleSpinBox()
        self.seconds.setRange(0.2, LONGEST_FILM)
        self.seconds.setDecimals(1)
        self.seconds.setValue(4.0)
        self.seconds.setSuffix(" s")
        self.from_sketch = QtWidgets.QCheckBox(tr("Files", "&Begin with the sketch"))
        self.from_sketch.setToolTip(
            tr("Files", "The sketch is drawn again, and what it became turns from there.")
        )
        form = QtWidgets.QFormLayout()
        form.addRow(tr("Files", "One &turn takes"), self.seconds)
        standard = QtWidgets.QDialogButtonBox.StandardButton
        buttons = QtWidgets.QDialogButtonBox(standard.Ok | standard.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        layout = QtWidgets.QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.from_sketch)
        layout.addWidget(buttons)
        self.accepted.connect(lambda: then(self.seconds.value(), self.from_sketch.isChecked()))
        self.finished.connect(self.deleteLater)
