"""The application object, made in one way by the program and by its tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QCoreApplication, Qt
from PySide6.QtWidgets import QApplication

from bozzetto_app.canvas.viewport.opengl_setup import prepare

__all__ = ["Application"]

COMPRESSING: Final = (
    Qt.ApplicationAttribute.AA_CompressHighFrequencyEvents,
    Qt.ApplicationAttribute.AA_CompressTabletEvents,
)
FUSION: Final = "Fusion"
"""Qt's own style, the same on all platforms."""


class Application(QApplication):
    """A Qt application that delivers every movement of pen and mouse.

    Parameters
    ----------
    arguments : sequence of str
        Of the process, its name first.

    Notes
    -----
    While the window is busy the system queues movements. With compression on, Qt delivers only
    the newest of them: a stroke drawn during a slow frame loses nearly all of its points. The
    xcb platform switches compression on in the constructor, so it is switched off afterwards.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        prepare()
        # `setStyle` returns the style, whose forty enums PySide then makes: 4 ms of every start.
        super().__init__([*arguments, "-style", FUSION])
        for attribute in COMPRESSING:
            QCoreApplication.setAttribute(attribute, False)
