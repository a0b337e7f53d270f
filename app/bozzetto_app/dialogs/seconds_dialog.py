"""Base of dialogs that ask how many seconds a moving picture takes."""

from __future__ import annotations

from PySide6 import QtWidgets

from bozzetto_app.session.films import LONGEST_FILM

__all__ = ["SecondsDialog"]


class SecondsDialog(QtWidgets.QDialog):
    """A field of seconds, and the buttons below what a dialog asks besides.

    Parameters
    ----------
    name : str
        Of the object.
    title : str
    parent : QtWidgets.QWidget
    """

    def __init__(self, name: str, title: str, parent: QtWidgets.QWidget) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setWindowTitle(title)
        self.seconds = QtWidgets.QDoubleSpinBox()
        self.seconds.setRange(0.2, LONGEST_FILM)
        self.seconds.setDecimals(1)
        self.seconds.setValue(4.0)
        self.seconds.setSuffix(" s")
        self.finished.connect(self.deleteLater)

    def lay_out(self, *rows: QtWidgets.QLayout | QtWidgets.QWidget) -> None:
        """Put rows below one another, and the buttons below them."""
        standard = QtWidgets.QDialogButtonBox.StandardButton
        buttons = QtWidgets.QDialogButtonBox(standard.Ok | standard.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        layout = QtWidgets.QVBoxLayout(self)
        for row in (*rows, buttons):
            if isinstance(row, QtWidgets.QLayout):
                layout.addLayout(row)
            else:
                layout.addWidget(row)
