"""About: which versions of what, for bug reports and for the curious."""

from __future__ import annotations

import platform

import numpy as np
from PySide6 import __version__ as pyside_version
from PySide6.QtCore import QRectF, QSize, Qt, qVersion
from PySide6.QtGui import QGuiApplication, QPainter, QPaintEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

import bozzetto
from bozzetto_app.dialogs.dialog import Page, quiet
from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import tones

__all__ = ["AboutDialog", "versions"]


def versions(renderer: str) -> tuple[tuple[str, str], ...]:
    """Return the names and versions of the software that runs here."""
    return (
        ("Bozzetto", bozzetto.__version__),
        ("Python", platform.python_version()),
        ("Qt", f"{qVersion()} (PySide {pyside_version})"),
        ("NumPy", np.__version__),
        (tr("About", "Renderer"), renderer),
        (tr("About", "System"), f"{platform.system()} {platform.release()}"),
    )


class _Emblem(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.setFixedSize(QSize(56, 56))

    def paintEvent(self, event: QPaintEvent) -> None:
        paint_icon(QPainter(self), "drawing", QRectF(self.rect()), tones().accent)


class AboutDialog(Page):
    """Name, licence and versions.

    Parameters
    ----------
    renderer : str
        Who draws the viewport.
    """

    def __init__(self, renderer: str, parent: QWidget | None = None) -> None:
        super().__init__("about", tr("About", "About Bozzetto"), parent)
        rows = versions(renderer)
        name = QLabel("Bozzetto")
        name.setProperty("type", "heading")
        words = QVBoxLayout()
        words.setSpacing(4)
        words.addStretch(1)
        words.addWidget(name)
        words.addWidget(quiet(tr("About", "Strokes go in, three-dimensional models come out.")))
        words.addStretch(1)
        top = QHBoxLayout()
        top.setSpacing(16)
        top.addWidget(_Emblem())
        top.addLayout(words, 1)
        self.column.addLayout(top)
        grid = QGridLayout()
        grid.setHorizontalSpacing(16)
        grid.setVerticalSpacing(4)
        grid.setColumnStretch(1, 1)
        for row, (what, version) in enumerate(rows):
            value = QLabel(version)
            value.setWordWrap(True)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            grid.addWidget(quiet(what), row, 0, Qt.AlignmentFlag.AlignTop)
            grid.addWidget(value, row, 1)
        self.column.addLayout(grid)
        self.column.addWidget(
            quiet(tr("About", "Free software under the Apache License, version 2.0."))
        )
        self.column.addStretch(1)
        copied = "\n".join(f"{what}: {version}" for what, version in rows)
        copy = self.add_button(tr("About", "C&opy"))
        copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(copied))
        self.add_button(tr("About", "&Close"), default=True).clicked.connect(self.accept)
        self.setFixedWidth(440)
