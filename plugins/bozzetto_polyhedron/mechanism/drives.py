"""What motors do: an angle, rad, or a place on a line, m, against time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property

JOINING: Final = 1.0
"""Time, s, in which a motor that begins elsewhere than its course does comes to it."""


class Course(Protocol):
    """A value against time, and how fast it changes."""

    @property
    def goes_on(self) -> bool:
        """Whether it may begin anywhere, or is about where things are at rest."""

    def at(self, seconds: float) -> float:
        """Return the value at a time."""

    def rate(self, seconds: float) -> float:
        """Return its slope at a time, 1/s."""


@dataclass(frozen=True)
class Steady:
    """Value that grows at one speed, 1/s."""

    speed: float
    goes_on: bool = True

    def at(self, seconds: float) -> float:
        """Return the value at a time."""
        return self.speed * seconds

    def rate(self, seconds: float) -> float:
        """Return its slope at a time, 1/s."""
        return self.speed


@dataclass(frozen=True)
class Swing:
    """Value that goes to and fro: size · sin(frequency · time)."""

    size: float
    frequency: float
    goes_on: bool = False

    def at(self, seconds: float) -> float:
        """Return the value at a time."""
        return float(self.size * np.sin(self.frequency * seconds))

    def rate(self, seconds: float) -> float:
        """Return its slope at a time, 1/s."""
        return float(self.size * self.frequency * np.cos(self.frequency * seconds))


@dataclass(frozen=True)
class Keyed:
    """Value through keys, smooth and never beyond its neighbours.

    Cubic Hermite splines whose slopes are harmonic means of those to both sides, and 0 at extremes
    (Fritsch and Butland 1984): between two keys the value is between theirs. At the ends of what
    happens once it stands still.

    Parameters
    ----------
    keys : tuple of (float, float)
        Time, s, and value; at least two, in the order of time.
    again : bool
        Whether all begins again at the last key, from the value that it has there.
    """

    keys: tuple[tuple[float, float], ...]
    again: bool
    goes_on: bool = False

    @cached_property
    def _pieces(self) -> tuple[Array, Array, Array]:
        """Times (k,), values (k,) and slopes (k,) of the keys."""
        times, values = np.array(self.keys, float).T
        steps, rises = np.diff(times), np.diff(values)
        before, after = (steps[-1:], steps[:1]) if self.again else (steps[:1], steps[:1])
        still = np.zeros(1)
        steps = np.concatenate((before, steps, after))
        rises = np.concatenate(
            (rises[-1:], rises, rises[:1]) if self.again else (still, rises, still)
        )
        each = rises / steps
        one, other, left, right = each[:-1], each[1:], steps[:-1], steps[1:]
        weights = 2.0 * right + left, right + 2.0 * left
        turns = one * other <= 0.0
        with np.errstate(divide="ignore"):
            mean = (weights[0] + weights[1]) / (
                weights[0] / np.where(turns, 1.0, one) + weights[1] / np.where(turns, 1.0, other)
            )
        return times, values, np.where(turns, 0.0, mean)

    def at(self, seconds: float) -> float:
        """Return the value at a time."""
        times, values, _ = self._pieces
        if not self.again:
            return self._hermite(float(np.clip(seconds, times[0], times[-1])))[0]
        rounds = np.floor((seconds - times[0]) / (times[-1] - times[0]))
        within = seconds - rounds * (times[-1] - times[0])
        return self._hermite(float(within))[0] + float(rounds * (values[-1] - values[0]))

    def rate(self, seconds: float) -> float:
        """Return its slope at a time, 1/s."""
        times, _, _ = self._pieces
        if not self.again:
            inside = times[0] <= seconds <= times[-1]
            return self._hermite(seconds)[1] if inside else 0.0
        rounds = np.floor((seconds - times[0]) / (times[-1] - times[0]))
        return self._hermite(float(seconds - rounds * (times[-1] - times[0])))[1]

    def _hermite(self, seconds: float) -> tuple[float, float]:
        """Return the value and the slope at a time within the keys."""
        times, values, slopes = self._pieces
        k = int(np.clip(np.searchsorted(times, seconds, side="right") - 1, 0, len(times) - 2))
        step, rise = times[k + 1] - times[k], values[k + 1] - values[k]
        x = (seconds - times[k]) / step
        bend = slopes[k] + slopes[k + 1] - 2.0 * rise / step
        lean = 3.0 * rise / step - 2.0 * slopes[k] - slopes[k + 1]
        value = values[k] + step * x * (slopes[k] + x * (lean + x * bend))
        return float(value), float(slopes[k] + x * (2.0 * lean + 3.0 * x * bend))


@dataclass(frozen=True)
class Drive:
    """A motor on its course.

    Parameters
    ----------
    course : Course
    since : float
        When it began, s since rest.
    offset : float
        By how much things were beyond the course then. What goes on keeps that for good; else it
        is gone after `JOINING`, and speed and acceleration are continuous meanwhile.
    owner : str
        Id of the fitting that has the motor.
    """

    course: Course
    since: float = 0.0
    offset: float = 0.0
    owner: str = ""

    def at(self, seconds: float) -> float:
        """Return the value at a time since rest."""
        own = seconds - self.since
        if self.offset == 0.0:
            return self.course.at(own)
        return self.course.at(own) + self.offset * (1.0 - self._joined(own)[0])

    def rate(self, seconds: float) -> float:
        """Return its slope at a time since rest, 1/s."""
        own = seconds - self.since
        if self.offset == 0.0:
            return self.course.rate(own)
        return self.course.rate(own) - self.offset * self._joined(own)[1]

    def _joined(self, own: float) -> tuple[float, float]:
        """Return how far it has come to its course, 0 … 1, and the slope of that, 1/s."""
        if self.course.goes_on:
            return 0.0, 0.0
        x = float(np.clip(own / JOINING, 0.0, 1.0))
        return x**3 * (10.0 + x * (6.0 * x - 15.0)), 30.0 * x**2 * (1.0 - x) ** 2 / JOINING
