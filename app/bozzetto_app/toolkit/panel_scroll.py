"""The ground of a panel: what is too high for it is scrolled."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QWidget

__all__ = ["PanelScroll"]


class PanelScroll(QScrollArea):
    """A scroll area whose content keeps its width.

    The place of the bar stays free while there is nothing to scroll. Wrapped words and pictures are
    of another height where they are narrower: a bar that came and went would change its own reason,
    and Qt would lay the panel out again and again, until the stack is full.

    Parameters
    ----------
    parent : QWidget, optional
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        bar = self.verticalScrollBar()
        bar.setEnabled(False)  # the theme shows no handle then
        bar.rangeChanged.connect(lambda least, most: bar.setEnabled(most > least))
