"""The curve in space while its second side is still being drawn."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.ink.curves.resample import resample, steps_along
from bozzetto_symmetry.stereo.correspondence import ASTRAY, share_astray
from bozzetto_symmetry.stereo.dynamic_time_warping import first_row, next_row
from bozzetto_symmetry.stereo.epipolar_signal import Signal, differences, spread
from bozzetto_symmetry.stereo.mirror_camera import Stereo

__all__ = ["Growing"]

Array = NDArray[np.float64]

SAMPLES: Final = 160
"""Places along the side that is known."""

UNEVEN: Final = 0.01
"""Price of a step along one side only, per px of what the first side ranges over."""

REVISED: Final = 40
"""Places at the end of the second side whose partners later ink may still change."""

LEAD: Final = 0.8
"""Share of the other sense's price from which that sense takes over: less would flicker."""

FURTHEST: Final = 1.5
"""Most samples by which a partner is moved to lie on the very epipolar line."""

MOST_AT_ONCE: Final = 400
"""Places taken between two samples: a jump of the pen across a large sheet is not worth more."""


class Growing:
    """Remembers the first side and how the second one has been matched so far.

    Every new place of the second side adds a row to a table of sums, and only the last
    partners are looked up again, so a pen event costs the same however long the stroke is.

    Parameters
    ----------
    stereo : Stereo
    near : (n, 2) array_like
        The first side, px.
    """

    def __init__(self, stereo: Stereo, near: ArrayLike) -> None:
        self._stereo = stereo
        known = Signal.of(stereo, resample(near, count=SAMPLES))
        self._senses = (known, known.turned())
        self._slopes = tuple(np.gradient(signal.angles) for signal in self._senses)
        self._step = max(known.step, 1.0)
        self._price = UNEVEN * spread(known)
        self._sense: int
        self._places: Array
        self._found: list[Array]
        self._forget()

    def points(self, pixels: ArrayLike) -> Array:
        """Where the second side, as drawn so far, meets the first.

        Parameters
        ----------
        pixels : (n, 2) array_like
            All of the second side so far, px. What is found depends on it alone; where it goes
            on from the ink of the call before, only what is new is matched.

        Returns
        -------
        (k, 3) float
            On the first side, mm, in the order in which the second one is drawn; empty where
            nothing meets.
        """
        ink = np.reshape(np.asarray(pixels, float), (-1, 2))
        places = steps_along(ink, self._step, MOST_AT_ONCE)
        known = len(self._places)
        if known > len(places) or not np.array_equal(self._places, places[:known]):
            self._forget()
            known = 0
        for number in range(known, len(places)):  # one by one: however often one asks
            self._take(places[number : number + 1])
        self._places = places
        found = self._found[self._sense]
        return np.array(found[np.isfinite(found).all(axis=1)])

    def _forget(self) -> None:
        self._places = np.zeros((0, 2))
        self._tail = Signal(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
        self._sums = np.zeros((2, SAMPLES))
        self._sources: list[NDArray[np.intp]] = []
        self._found = [np.zeros((0, 3)), np.zeros((0, 3))]
        self._sense = 0

    def _take(self, places: Array) -> None:
        signal = self._signal(places)
        # The sense in which the second side is drawn is not known: both are followed.
        tables = np.stack([differences(signal, known) for known in self._senses], axis=1)
        for costs in tables:
            if self._sources:
                self._sums, sources = next_row(self._sums, costs, self._price)
            else:
                self._sums = first_row(costs, 0.0)
                sources = np.zeros(costs.shape, np.intp)
            self._sources.append(sources)
        frozen = len(self._found[0]) - len(self._tail.angles)
        self._tail = _joined(self._tail, signal)
        self._found = [
            np.vstack([self._found[sense][:frozen], self._met(sense)]) for sense in (0, 1)
        ]
        self._tail = _ending(self._tail, REVISED)
        self._sources = self._sources[-REVISED:]
        prices = [
            float(sums.min()) * (1.0 + ASTRAY * share_astray(found[:, 1]))
            for sums, found in zip(self._sums, self._found, strict=True)
        ]
        if prices[1 - self._sense] < LEAD * prices[self._sense]:
            self._sense = 1 - self._sense

    def _signal(self, places: Array) -> Signal:
        """Of new places, their angles following on those of the places before."""
        before = self._tail.pixels[-1:]
        signal = Signal.of(self._stereo, np.vstack([before, places]))
        if len(before):
            shift = float(self._tail.angles[-1] - signal.angles[0])
            return _ending(_turned(signal, shift), len(places))
        return signal.shifted(self._stereo, self._senses[0])

    def _met(self, sense: int) -> Array:
        """Places in space for the last part of the second side, the first side in one sense."""
        column = int(self._sums[sense].argmin())
        columns = [column]
        for sources in self._sources[:0:-1]:
            column = int(sources[sense, column])
            columns.append(column)
        partners = np.array(columns[::-1], np.intp)
        known = self._senses[sense]
        slope = self._slopes[sense][partners]
        rest = self._tail.angles - known.angles[partners]
        share = np.divide(rest, slope, out=np.zeros_like(rest), where=slope != 0)
        at = partners + np.clip(share, -FURTHEST, FURTHEST)
        near = np.column_stack([np.interp(at, np.arange(SAMPLES), c) for c in known.pixels.T])
        way = self._stereo.toward_vanishing(near)
        far = near + ((self._tail.pixels - near) * way).sum(axis=1, keepdims=True) * way
        return self._stereo.intersected(near, far)


def _joined(one: Signal, other: Signal) -> Signal:
    return Signal(
        np.vstack([one.pixels, other.pixels]),
        np.concatenate([one.angles, other.angles]),
        np.concatenate([one.scales, other.scales]),
    )


def _ending(signal: Signal, count: int) -> Signal:
    """The last samples of a signal."""
    return Signal(signal.pixels[-count:], signal.angles[-count:], signal.scales[-count:])


def _turned(signal: Signal, angle: float) -> Signal:
    return Signal(signal.pixels, signal.angles + angle, signal.scales)
