"""The curve in space while its second side is still being drawn."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index
from bozzetto.ink import resample, steps_along
from bozzetto_symmetry.stereo.correspondence import ASTRAY, Heights
from bozzetto_symmetry.stereo.dynamic_time_warping import first_row, next_row
from bozzetto_symmetry.stereo.epipolar_signal import Signal, at_stations, differences, spread
from bozzetto_symmetry.stereo.mirror_camera import Stereo

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


class GrowingCurve:
    """The first side of a pair, and how the second one has been matched to it so far.

    Every new place of the second side adds a row to a table of sums, and only the last
    partners are looked up again, so a pen event costs the same however long the stroke is.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    near : (n, 2) array_like
        The first side, px.
    """

    def __init__(self, stereo: Stereo, near: ArrayLike) -> None:
        self._stereo = stereo
        known = Signal.of(stereo, resample(near, count=SAMPLES))
        # The sense in which the second side is drawn is not known: both are followed.
        self._senses = (known, known.turned())
        self._slopes = tuple(np.gradient(signal.angles) for signal in self._senses)
        self._step = max(known.step, 1.0)
        self._price = UNEVEN * spread(known)
        self._places: Array
        self._revised: list[Array]
        self._sense: int
        self._forget()

    def points(self, pixels: ArrayLike) -> Array:
        """Return where the second side, as drawn so far, meets the first.

        Parameters
        ----------
        pixels : (n, 2) array_like
            All of the second side so far, px. The answer depends on it alone; where it goes
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
        if known < len(places):
            self._take(places[known:])
        self._places = places
        for settled in self._settled:
            settled[:] = [np.vstack((np.zeros((0, 3)), *settled))]
        found = np.vstack((*self._settled[self._sense], self._revised[self._sense]))
        return np.asarray(found[np.isfinite(found).all(axis=1)])

    def _forget(self) -> None:
        self._places = np.zeros((0, 2))
        self._tail = Signal(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
        self._sums = np.zeros((2, SAMPLES))
        self._sources: list[Index] = []
        self._settled: tuple[list[Array], list[Array]] = ([], [])
        self._heights = [Heights(), Heights()]
        self._revised = [np.zeros((0, 3)), np.zeros((0, 3))]
        self._sense = 0

    def _take(self, places: Array) -> None:
        """Match new places one by one: the answer must not depend on how often one asks."""
        before = self._tail.pixels[-1:]
        signal = Signal.of(self._stereo, np.vstack([before, places]))
        if len(before):
            signal = signal.rotated(float(self._tail.angles[-1] - signal.angles[0]))
        else:
            signal = signal.shifted(self._stereo, self._senses[0])
        signal = signal.part(slice(len(before), None))
        tables = np.stack([differences(signal, known) for known in self._senses], axis=1)
        for number, costs in enumerate(tables):
            if self._sources:
                self._sums, sources = next_row(self._sums, costs, self._price)
            else:
                self._sums = first_row(costs, 0.0)
                sources = np.zeros(costs.shape, np.intp)
            self._sources.append(sources)
            self._tail = self._tail.followed_by(signal.part(slice(number, number + 1)))
            self._revise()

    def _revise(self) -> None:
        """Look the last partners up again, and follow the sense that fits better."""
        prices = []
        self._revised = self._met()
        for sense, found in enumerate(self._revised):
            if len(found) > REVISED:
                self._settled[sense].append(found[:1])
                self._heights[sense] = self._heights[sense].with_more(found[:1, 1])
                self._revised[sense] = found[1:]
            astray = self._heights[sense].with_more(self._revised[sense][:, 1]).share_astray
            prices.append(float(self._sums[sense].min()) * (1.0 + ASTRAY * astray))
        self._tail = self._tail.part(slice(-REVISED, None))
        self._sources = self._sources[-REVISED:]
        if prices[1 - self._sense] < LEAD * prices[self._sense]:
            self._sense = 1 - self._sense

    def _met(self) -> list[Array]:
        """Return places in space of the last part of the second side, for both senses."""
        nears = []
        for sense, known in enumerate(self._senses):
            column = int(self._sums[sense].argmin())
            columns = [column]
            for sources in self._sources[:0:-1]:
                column = int(sources[sense, column])
                columns.append(column)
            partners = np.array(columns[::-1], np.intp)
            slope = self._slopes[sense][partners]
            rest = self._tail.angles - known.angles[partners]
            share = np.divide(rest, slope, out=np.zeros_like(rest), where=slope != 0)
            at = partners.astype(float) + np.clip(share, -FURTHEST, FURTHEST)
            nears.append(at_stations(known.pixels, at))
        near, drawn = np.vstack(nears), np.vstack((self._tail.pixels, self._tail.pixels))
        way = self._stereo.toward_vanishing(near)
        far = near + ((drawn - near) * way).sum(axis=1, keepdims=True) * way
        return np.split(self._stereo.intersected(near, far), 2)
