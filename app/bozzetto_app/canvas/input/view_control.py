"""Moves the view by drags of pen and mouse, by the wheel and by fingers; none of them inks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF

from bozzetto.view.navigation import orbit, pan, zoom
from bozzetto_app.canvas.input.state_machine import Motion

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera
    from bozzetto_app.session.session import Session

__all__ = ["Fingers", "ViewControl"]

ZOOM_PER_PIXEL: Final = 0.01
"""Natural logarithm of the enlargement for a pixel of drag."""

ZOOM_PER_NOTCH: Final = 1.2
"""Enlargement for one notch of the wheel."""

LINE_REACH: Final = 12.0
"""Distance within which a press beside all surfaces means a line, px."""

NOTCH: Final = 120.0
"""Qt's angle of one notch, eighths of a degree."""

LEAST_SPREAD: Final = 1.0
"""Distance from their middle below which two fingers say nothing about scale, pixels."""


class Fingers:
    """The fingers at the last event.

    Parameters
    ----------
    places : sequence of QPointF
        At least one.
    pivot : (3,) float
        What one finger turns the view about, and what more than one hold, mm in the world.
    """

    def __init__(self, places: Sequence[QPointF], pivot: NDArray[np.float64]) -> None:
        self.count = len(places)
        self._pivot = pivot
        self._middle, self._spread = middle_and_spread(places)

    def moved(
        self, places: Sequence[QPointF], camera: Camera, *, eye_fixed: bool = False
    ) -> Camera:
        """Return the view after as many fingers moved: one orbits, more pan and zoom.

        Parameters
        ----------
        places : sequence of QPointF
            Canvas positions of the fingers, as many as before.
        camera : Camera
            The view before.
        eye_fixed : bool
            Whether the eye stays where it is.
        """
        before, spread_before = self._middle, self._spread
        self._middle, self._spread = middle_and_spread(places)
        dx, dy = self._middle[0] - before[0], self._middle[1] - before[1]
        if self.count == 1:
            return orbit(camera, dx, dy, self._pivot)
        camera = pan(camera, dx, dy, self._pivot, eye_fixed=eye_fixed)
        if min(self._spread, spread_before) > LEAST_SPREAD:
            factor = self._spread / spread_before
            camera = zoom(camera, factor, self._middle, eye_fixed=eye_fixed)
        return camera


def middle_and_spread(places: Sequence[QPointF]) -> tuple[tuple[float, float], float]:
    """Return the mean of some places, and the largest distance from it, pixels."""
    x = sum(place.x() for place in places) / len(places)
    y = sum(place.y() for place in places) / len(places)
    return (x, y), max(math.hypot(place.x() - x, place.y() - y) for place in places)


class ViewControl:
    """Moves the camera of a session about the place under the pointer.

    A view that stands where a picture was drawn from keeps its eye; see `ViewAdvice.pinned`.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._camera = session.view.camera
        self._grip: NDArray[np.float64] = np.zeros(3)
        self._pivot: NDArray[np.float64] = np.zeros(3)
        self._fingers: Fingers | None = None

    def begin(self, x: float, y: float) -> None:
        """Remember the view, and the place under a press, canvas pixels."""
        self._camera = self._session.view.camera
        hit = self._seen_under(x, y)
        self._grip = self._on_sheet(x, y) if hit is None else hit
        self._pivot = self._middle() if hit is None else hit

    def turn(self, motion: Motion | None, dx: float, dy: float) -> None:
        """Orbit, pan or zoom by the distance from the press, pixels."""
        held = self._session.advice.holds_eye(self._camera)
        if motion is Motion.ORBIT:
            camera = orbit(self._camera, dx, dy, self._pivot)
        elif motion is Motion.PAN:
            camera = pan(self._camera, dx, dy, self._grip, eye_fixed=held)
        else:
            factor = math.exp(-ZOOM_PER_PIXEL * dy)
            camera = zoom(self._camera, factor, at=self._grip, eye_fixed=held)
        self._session.view.set_camera(camera)

    def wheel(self, x: float, y: float, turned: float) -> None:
        """Zoom to a canvas position by an angle of the wheel, eighths of a degree."""
        camera = self._session.view.camera
        held = self._session.advice.holds_eye(camera)
        factor = ZOOM_PER_NOTCH ** (turned / NOTCH)
        self._session.view.set_camera(zoom(camera, factor, at=self.under(x, y), eye_fixed=held))

    def touch_began(self) -> None:
        """Forget the fingers of the last touch."""
        self._fingers = None

    def touch(self, places: Sequence[QPointF]) -> None:
        """Follow the fingers; where their number differs, start again from there."""
        if self._fingers is None or self._fingers.count != len(places):
            (x, y), _ = middle_and_spread(places)
            hit = self._seen_under(x, y)
            beside = self._middle() if len(places) == 1 else self._on_sheet(x, y)
            self._fingers = Fingers(places, beside if hit is None else hit)
            return
        camera = self._session.view.camera
        held = self._session.advice.holds_eye(camera)
        self._session.view.set_camera(self._fingers.moved(places, camera, eye_fixed=held))

    def under(self, x: float, y: float) -> NDArray[np.float64]:
        """Return the place under a canvas position, mm: of what is seen, or else on the sheet."""
        hit = self._seen_under(x, y)
        return self._on_sheet(x, y) if hit is None else hit

    def _seen_under(self, x: float, y: float) -> NDArray[np.float64] | None:
        """Return the place on the surface, else on the line, under a canvas position, mm."""
        from bozzetto.scene.picking import cast_rays, place_on_lines

        camera, scene = self._session.view.camera, self._session.scene.visible
        hits = cast_rays(scene, camera.rays([(x, y)]))
        if hits.hit[0]:
            return np.asarray(hits.points[0])
        return place_on_lines(scene, camera, (x, y), LINE_REACH)

    def _on_sheet(self, x: float, y: float) -> NDArray[np.float64]:
        camera = self._session.view.camera
        return np.asarray(camera.on_plane([(x, y)], camera.target, camera.axes[2])[0])

    def _middle(self) -> NDArray[np.float64]:
        """Return what a turn beside all objects goes about, (3,) mm: it must not lose them.

        It is the middle of what is there; the middle of the view where that is out of sight.
        """
        camera = self._session.view.camera
        points = self._session.scene.visible.points()
        if len(points):
            middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
            (place,), (depth,) = camera.project([middle])
            with np.errstate(invalid="ignore"):
                if depth > 0.0 and (place >= 0.0).all() and (place <= camera.viewport).all():
                    return np.asarray(middle)
        return np.array(camera.target, dtype=float)
