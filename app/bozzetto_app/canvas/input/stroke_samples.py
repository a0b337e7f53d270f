"""Samples: what the pen said, collected at full rate and handed over as strokes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.ink.stroke import Stroke, StrokeTool

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

__all__ = ["Clock", "PressureCurve", "RawSample", "SampleColumns"]

FIRST_ROOM: Final = 1024
"""Samples for which room is made at first; doubled when full."""

COARSE_STEP: Final = 0.016
"""Longest step of a device's clock in use (Windows' system timer), seconds."""


class RawSample(NamedTuple):
    """One event as the device gave it.

    Attributes
    ----------
    x, y : float
        Canvas pixels.
    pressure : float
        0 … 1, before the pressure curve.
    stamp : int
        The device's time, milliseconds; 0 where it gives none.
    tilt_x, tilt_y, twist : float
        Degrees.
    received : float
        Our own clock, seconds.
    """

    x: float
    y: float
    pressure: float
    stamp: int
    tilt_x: float
    tilt_y: float
    twist: float
    received: float


class PressureCurve:
    """How hard a hand must press: the pressure that counts as a power of the device's.

    Parameters
    ----------
    gamma : float
        0.25 … 4; below 1 a light hand draws bold lines, above 1 a heavy hand fine ones.

    Notes
    -----
    The curve is applied when a sample is captured, as painting programs do: it belongs to
    the hand and the tablet, not to the drawing, and the pressure in a stroke is what the
    person saw while drawing it.
    """

    SOFTEST: Final = 0.25
    HARDEST: Final = 4.0

    def __init__(self, gamma: float = 1.0) -> None:
        self.gamma = min(max(float(gamma), self.SOFTEST), self.HARDEST)

    def __call__(self, pressure: float) -> float:
        clipped = min(max(pressure, 0.0), 1.0)
        return clipped if self.gamma == 1.0 else float(clipped**self.gamma)

    @classmethod
    def from_setting(cls, value: object) -> PressureCurve:
        """Read the setting ``pen/pressure_curve``; what is not a number means 1."""
        try:
            return cls(float(str(value)))
        except ValueError:
            return cls()


class Clock:
    """Seconds since a stroke began, from device times that may be missing or repeat.

    The device's own times are kept where they advance, since they know when the pen was
    where; events that were queued while the window was busy arrive at one moment. Where a
    device time is 0, repeats or runs backwards, our own clock says how much time has passed,
    until the device's advances again. It says when a sample was looked at, which may be a whole
    slow frame later, so for a repeated time it counts only as much as a coarse clock hides.
    """

    def __init__(self) -> None:
        self._stamp = 0
        self._begin: tuple[int, float] | None = None
        self._received = 0.0
        self._now: float | None = None

    def __call__(self, stamp: int, received: float) -> float:
        """Return the time of the next sample, seconds; never less than the one before."""
        if self._now is None:
            self._now = 0.0
        elif self._begin is not None and stamp > self._stamp:
            stamped, then = self._begin
            self._now = max(self._now, then + (stamp - stamped) / 1000.0)
        else:
            passed = max(received - self._received, 0.0)
            repeats = stamp > 0 and stamp == self._stamp
            self._now += min(passed, COARSE_STEP) if repeats else passed
        if self._begin is None and stamp > 0:
            self._begin = stamp, self._now
        self._stamp = max(stamp, self._stamp)
        self._received = received
        return self._now


class SampleColumns:
    """The samples of one stroke, growing; adding costs the same however many there are."""

    def __init__(self, curve: PressureCurve, *, has_pressure: bool) -> None:
        self.has_pressure = has_pressure
        self._curve = curve
        self._clock = Clock()
        self._rows: NDArray[np.float64] = np.empty((FIRST_ROOM, 7))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, raw: RawSample) -> float:
        """Add a sample; return its pressure as it counts."""
        if self._count == len(self._rows):
            self._rows = np.concatenate((self._rows, np.empty_like(self._rows)))
        pressure = self._curve(raw.pressure) if self.has_pressure else 0.5
        time = self._clock(raw.stamp, raw.received)
        self._rows[self._count] = (
            raw.x, raw.y, pressure, time, raw.tilt_x, raw.tilt_y, raw.twist,
        )  # fmt: skip
        self._count += 1
        return pressure

    def stroke(self, camera: Camera, tool: StrokeTool) -> Stroke:
        """Return the stroke so far."""
        x, y, pressure, t, tilt_x, tilt_y, twist = self._rows[: self._count].T
        return Stroke(
            x,
            y,
            camera,
            pressure=pressure if self.has_pressure else None,
            t=t,
            tilt_x=tilt_x,
            tilt_y=tilt_y,
            twist=twist,
            tool=tool,
        )
