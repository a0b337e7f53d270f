"""Finds what a person sees of a widget: its buttons by their names, its parts by theirs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QAbstractButton, QLabel, QWidget

from bozzetto.geometry import Mesh
from bozzetto.scene import Shaded


def button(widget: QWidget, name: str) -> Any:
    """The button that a screen reader calls so."""
    found = widget.findChildren(QAbstractButton)
    return next(b for b in found if (b.accessibleName() or b.text().replace("&", "")) == name)


def buttons(widget: QWidget) -> list[Any]:
    """All buttons there that can be switched on."""
    found = widget.findChildren(QAbstractButton)
    return [b for b in found if b.isCheckable() and b.isVisibleTo(widget)]


def chosen(widget: QWidget) -> list[str]:
    """The names of the buttons that are on."""
    return [b.accessibleName() for b in buttons(widget) if b.isChecked()]


def words(widget: QWidget) -> list[str]:
    """What the labels say that a person sees, if the widget is shown."""
    return [label.text() for label in widget.findChildren(QLabel) if label.isVisibleTo(widget)]


def picture(widget: QWidget) -> NDArray[np.float64]:
    """What a widget paints on white paper, colours (h, w, 3), 0 … 1."""
    image = QImage(widget.size(), QImage.Format.Format_RGB888)
    image.fill(Qt.GlobalColor.white)
    widget.render(image)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3) / 255.0


def darkness(widget: QWidget) -> NDArray[np.float64]:
    """How dark the ink is that a widget paints, (h, w), 0 … 1."""
    return 1.0 - picture(widget).mean(axis=2)


def colour(widget: QWidget) -> NDArray[np.float64]:
    """How colourful that is which a widget paints, (h, w), 0 … 1."""
    return np.ptp(picture(widget), axis=2)


def part(widget: QWidget, name: str) -> Any:
    """The part of a widget that has this object name."""
    found = widget.findChild(QWidget, name)
    assert found is not None, f"no {name} in {widget.objectName()}"
    return found


def names(widget: QWidget) -> list[str]:
    """What a screen reader calls the buttons there."""
    return [b.accessibleName() for b in buttons(widget)]


def meshes(session: Any) -> list[Mesh]:
    """What is shaded on the sheet."""
    return [item.mesh for _, item in session.scene.visible.items() if isinstance(item, Shaded)]


def state(window: Any) -> Any:
    """The state of the chosen object."""
    return window.session.selection.model.state


def layer_items(window: Any, name: str) -> list[Any]:
    """What lies in the layers of a name on the sheet."""
    scene = window.session.scene.visible.under(window.session.scene.live)
    return [item for layer in scene.layers if layer.name == name for item in layer.items]
