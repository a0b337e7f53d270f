"""The details of a fault, for whoever mends the plugin."""

from __future__ import annotations

from PySide6.QtGui import QFontDatabase, QGuiApplication
from PySide6.QtWidgets import QPlainTextEdit, QWidget

from bozzetto_app.dialogs.dialog import Page, label
from bozzetto_app.i18n import tr

__all__ = ["FaultDetails"]


class FaultDetails(Page):
    """Dialog with a fault in one sentence, and its traceback with a button that copies it.

    Parameters
    ----------
    text : str
    details : str
    """

    def __init__(self, text: str, details: str, parent: QWidget | None = None) -> None:
        super().__init__("fault-details", tr("FaultDetails", "What happened"), parent)
        self._all = f"{text}\n\n{details}".strip()
        words = label(text, kind="heading")
        trace = QPlainTextEdit(details)
        trace.setReadOnly(True)
        trace.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        trace.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        trace.setAccessibleName(tr("FaultDetails", "Traceback"))
        self.column.addWidget(words)
        self.column.addWidget(trace, 1)
        self.copy = self.add_button(tr("FaultDetails", "C&opy"))
        self.copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(self._all))
        self.add_button(tr("FaultDetails", "&Close"), default=True).clicked.connect(self.accept)
        self.resize(640, 420)
