"""A curve on the sheet as a signal: the epipolar lines that it crosses, in order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.ink.polyline import interpolate
from bozzetto_symmetry.stereo.mirror_camera import Stereo

FLAT: Final = 150.0
"""Spread of a signal, px, below which prices shrink no more: a hand that shakes by a pixel
would leave everything without a partner."""

STEEPEST: Final = 1e12
"""Most pixels per unit of angle, so that their squares stay finite."""


@dataclass(frozen=True, eq=False)
class Signal:
    """The epipolar lines that a curve crosses, sample by sample.

    Attributes
    ----------
    pixels : (n, 2) float
        At even steps, px.
    angles : (n,) float
        Of the epipolar lines, as `Stereo.angles`.
    scales : (n,) float
        Pixels per unit of angle.
    """

    pixels: Array
    angles: Array
    scales: Array

    @classmethod
    def of(cls, stereo: Stereo, pixels: Array) -> Signal:
        """Return the signal of a curve that was resampled at even steps."""
        scales = np.minimum(stereo.pixels_per_angle(pixels), STEEPEST)
        return cls(pixels, stereo.angles(pixels), scales)

    def shifted(self, stereo: Stereo, other: Signal) -> Signal:
        """Return the signal with whole turns added, so that it lies beside another one."""
        if stereo.parallel:
            return self
        turns = np.round((np.median(other.angles) - np.median(self.angles)) / (2.0 * np.pi))
        return self.rotated(2.0 * np.pi * float(turns))

    def turned(self) -> Signal:
        """Return the signal from its end to its beginning."""
        return self.part(slice(None, None, -1))

    def rotated(self, angle: float) -> Signal:
        """Return the signal with an angle added everywhere."""
        return replace(self, angles=self.angles + angle)

    def part(self, which: slice) -> Signal:
        """Return some of the samples."""
        return Signal(self.pixels[which], self.angles[which], self.scales[which])

    def followed_by(self, other: Signal) -> Signal:
        """Return the samples of this signal and then those of another one."""
        return Signal(
            np.vstack([self.pixels, other.pixels]),
            np.concatenate([self.angles, other.angles]),
            np.concatenate([self.scales, other.scales]),
        )

    @property
    def step(self) -> float:
        """Mean distance of neighbours, px."""
        return float(np.linalg.norm(np.diff(self.pixels, axis=0), axis=1).mean())


def differences(first: Signal, second: Signal) -> Array:
    """Return the distances across the epipolar lines, (n, m) px.

    Scales differ between the near and the far side; both hands shake alike, so their squares
    are added.
    """
    weights = np.sqrt(squared_scales(first.scales[:, None], second.scales))
    return np.asarray(weights * np.abs(first.angles[:, None] - second.angles))


def spread(*signals: Signal) -> float:
    """Return the range of the widest of some signals, px: the unit of prices."""
    return max(FLAT, *(float(np.ptp(s.angles) * np.median(s.scales)) for s in signals))


def squared_scales(one: Array, other: Array) -> Array:
    """Return the squares of the pixels that a difference of angles is worth, for two scales."""
    return np.asarray(2.0 / (1.0 / one**2 + 1.0 / other**2))


def at_stations(values: Array, stations: Array) -> Array:
    """Return rows of an array at fractions of its indices."""
    return interpolate(stations, np.arange(len(values)), values)
