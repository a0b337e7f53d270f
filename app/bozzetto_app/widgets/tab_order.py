"""The order in which Tab goes, for parts that are made later than the rest of the window."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractSpinBox, QWidget

__all__ = ["put_in_tab_order"]


def put_in_tab_order(first: QWidget, parts: Iterable[QWidget]) -> None:
    """Let Tab go from `first` through everything in the parts, in their order.

    Parameters
    ----------
    first : QWidget
        Where to begin; it keeps its place in the window.
    parts : iterable of QWidget
        In the same window; each comes with what is in it.
    """
    before = first
    for part in parts:
        for widget in (part, *part.findChildren(QWidget)):
            policy = widget.focusPolicy()
            if policy is Qt.FocusPolicy.NoFocus or policy is Qt.FocusPolicy.ClickFocus:
                continue
            inner = isinstance(widget.parent(), QAbstractSpinBox)
            elsewhere = widget.window() is not first.window()  # the list of a closed combo box
            if inner or elsewhere:
                continue
            if widget is not before:
                QWidget.setTabOrder(before, widget)
                before = widget
