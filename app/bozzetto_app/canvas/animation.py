"""Changes of the view that the eye can follow."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, QTimer

from bozzetto.view.navigation import interpolate, turn

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera
    from bozzetto_app.session.session import Session

__all__ = ["FRAME", "ViewMotion"]

VIEW_TIME: Final = 0.18
"""Length of a change of view, seconds."""

TILT_TIME: Final = 1.1
"""Length of the tilt that shows depth, there and back, seconds."""

TILT_AZIMUTH: Final = 9.0
TILT_ELEVATION: Final = 5.0
"""How far the tilt goes, degrees."""

FRAME: Final = 16
"""Time between two steps, milliseconds."""


class ViewMotion(QObject):
    """Moves the session's camera along a path.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.reduced = False
        """Whether the person wants no motion: changes happen at once, the tilt never."""
        self._session = session
        self._path: Callable[[float], Camera] | None = None
        self._length = VIEW_TIME
        self._begun = 0.0
        self._timer = QTimer(self, interval=FRAME)
        self._timer.timeout.connect(self._step)

    @property
    def is_running(self) -> bool:
        """Whether the view is on its way."""
        return self._path is not None

    def animate_to(self, camera: Camera) -> None:
        """Go to another view, easing in and out."""
        begin: Camera = self._session.view.camera
        if self.reduced:
            self._session.view.set_camera(camera)
            return
        self._start(lambda share: interpolate(begin, camera, share), VIEW_TIME)

    def tilt(self) -> None:
        """Lean the view a few degrees and back, so that the eye sees depth."""
        if self.reduced:
            return
        begin: Camera = self._session.view.camera

        def leaning(share: float) -> Camera:
            if share >= 1.0:
                return begin
            # Out and back once; no speed at either end.
            lean = math.sin(math.pi * share) ** 2
            return turn(begin, TILT_AZIMUTH * lean, TILT_ELEVATION * lean)

        self._start(leaning, TILT_TIME)

    def finish(self) -> None:
        """Be where the motion was going, now: the hand has something else to do."""
        if self._path is not None:
            self._show(1.0)

    def _start(self, path: Callable[[float], Camera], length: float) -> None:
        self._path, self._length, self._begun = path, length, perf_counter()
        self._timer.start()

    def _step(self) -> None:
        self._show(min((perf_counter() - self._begun) / self._length, 1.0))

    def _show(self, share: float) -> None:
        if self._path is None:
            return
        # The canvas may have been resized meanwhile.
        camera = self._path(share).with_viewport(*self._session.view.camera.viewport)
        if share >= 1.0:
            self._path = None
            self._timer.stop()
        self._session.view.set_camera(camera)
