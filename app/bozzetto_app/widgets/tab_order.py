"""The order in which Tab goes, for parts that are made later than the rest of the window."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractSpinBox, QWidget

__all__ = ["last_stop", "put_in_tab_order"]


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
        for widget in _stops(part):
            if widget is not before:
                QWidget.setTabOrder(before, widget)
                before = widget


def last_stop(part: QWidget | None) -> QWidget | None:
    """Return the last widget in a part at which Tab stops, if there is one."""
    return None if part is None else next(iter([*_stops(part)][-1:]), None)


def _stops(part: QWidget) -> Iterator[QWidget]:
    for widget in (part, *part.findChildren(QWidget)):
        policy = widget.focusPolicy()
        if policy is Qt.FocusPolicy.NoFocus or policy is Qt.FocusPolicy.ClickFocus:
            continue
        inner = isinstance(widget.parent(), QAbstractSpinBox)
        elsewhere = widget.window() is not part.window()  # the list of a closed combo box
        if not (inner or elsewhere):
            yield widget
