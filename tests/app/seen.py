"""Finds what a person sees of a widget: its buttons by their names, its parts by theirs."""

from __future__ import annotations

from typing import Any

from PySide6.QtWidgets import QAbstractButton, QWidget


def button(widget: QWidget, name: str) -> QAbstractButton:
    """The button that a screen reader calls so."""
    return next(b for b in widget.findChildren(QAbstractButton) if b.accessibleName() == name)


def buttons(widget: QWidget) -> list[Any]:
    """All buttons there that can be switched on."""
    found = widget.findChildren(QAbstractButton)
    return [b for b in found if b.isCheckable() and b.isVisibleTo(widget)]


def chosen(widget: QWidget) -> list[str]:
    """The names of the buttons that are on."""
    return [b.accessibleName() for b in buttons(widget) if b.isChecked()]


def part(widget: QWidget, name: str) -> Any:
    """The part of a widget that has this object name."""
    found = widget.findChild(QWidget, name)
    assert found is not None, f"no {name} in {widget.objectName()}"
    return found
