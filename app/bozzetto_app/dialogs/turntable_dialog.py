"""Question of how long a turntable takes, and whether it begins with the sketch."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtWidgets

from bozzetto_app.dialogs.seconds_dialog import SecondsDialog
from bozzetto_app.i18n import tr

__all__ = ["TurntableDialog"]


class TurntableDialog(SecondsDialog):
    """Asks how a turntable is made.

    Parameters
    ----------
    then : callable
        Gets the seconds of one turn, and whether it begins with the sketch.
    parent : QtWidgets.QWidget
    """

    def __init__(self, then: Callable[[float, bool], None], parent: QtWidgets.QWidget) -> None:
        super().__init__("turntable", tr("Files", "Turntable"), parent)
        self.from_sketch = QtWidgets.QCheckBox(tr("Files", "&Begin with the sketch"))
        self.from_sketch.setToolTip(
            tr("Files", "The sketch is drawn again, and what it became turns from there.")
        )
        form = QtWidgets.QFormLayout()
        form.addRow(tr("Files", "One &turn takes"), self.seconds)
        self.lay_out(form, self.from_sketch)
        self.accepted.connect(lambda: then(self.seconds.value(), self.from_sketch.isChecked()))
