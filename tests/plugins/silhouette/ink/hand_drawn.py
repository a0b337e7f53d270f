"""Outlines as a hand draws them: it trembles, drifts, and does not arrive where it began."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import resample

SIZE = 300.0
"""Longest side of what is drawn, px."""

SPACING = 4.0
"""Distance of samples, px."""

STEP = 0.012
"""Step over which turns are measured, in sizes."""


def trembling(random: np.random.Generator, count: int, tremor: float) -> Array:
    """Return the deviation of samples by a tremor that lasts some of them, (count, 2) px."""
    reach = np.arange(-12, 13)
    kernel = np.exp(-(reach**2) / 18.0)
    kernel /= np.linalg.norm(kernel)
    noise = random.normal(0.0, tremor, (count + len(reach) - 1, 2))
    return np.column_stack([np.convolve(noise[:, k], kernel, "valid") for k in (0, 1)])


def ellipse(random: np.random.Generator, tremor: float) -> Array:
    """Return an ellipse by one stroke that stops up to a sixteenth early or late, (n, 2) px."""
    wide, high = 0.5 * SIZE, 0.5 * SIZE * random.uniform(0.5, 1.0)
    count = int(2.0 * np.pi * wide / SPACING)
    share = np.linspace(0.0, 1.0, count)
    turned = random.uniform(0.0, 2.0 * np.pi) + share * 2.0 * np.pi * (
        1.0 + random.uniform(-0.06, 0.08)
    )
    radius = 1.0 + 2.0 * random.normal(0.0, 0.012) * (share - 0.5)
    for wave in (2, 3):
        radius += (
            random.normal(0.0, 0.008) / wave * np.cos(wave * turned + random.uniform(0.0, 6.0))
        )
    drift = wide * random.normal(0.0, 0.01, 2) * share[:, None]
    places = np.column_stack((wide * radius * np.cos(turned), high * radius * np.sin(turned)))
    return places + drift + trembling(random, count, tremor)


def with_fold(random: np.random.Generator, line: Array) -> Array:
    """Return ink in which the pen went back a little, and on again."""
    place, back = int(random.integers(15, len(line) - 15)), int(random.integers(2, 7))
    fold = line[place - back : place][::-1] + random.normal(0.0, 0.7, (back, 2))
    return np.vstack((line[:place], fold, line[place - back :]))


def with_folded_end(random: np.random.Generator, line: Array, *, start: bool) -> Array:
    """Return ink that ends by going back over itself, or begins so, by 8 to 30 px."""
    if start:
        return with_folded_end(random, line[::-1], start=False)[::-1]
    back = int(random.integers(2, 9))
    return np.vstack((line, line[-1 - back : -1][::-1] + random.normal(0.0, 0.8, (back, 2))))


def by_a_fast_pen(random: np.random.Generator, line: Array, spacing: float, jitter: float) -> Array:
    """Return ink of few samples, each off by a jitter of its own, px."""
    places = resample(line, spacing=spacing)
    return places + random.normal(0.0, jitter, places.shape)


def polygon(random: np.random.Generator, corners: Array, tremor: float) -> tuple[Array, Array]:
    """Return a polygon by one stroke from a corner to that corner, up to 14 px off, and corners."""
    corners = corners + random.normal(0.0, 8.0, corners.shape)
    path = np.vstack((corners, corners[:1]))
    way = path[-1] - path[-2]
    long = np.hypot(*way)
    path[-1] = (
        path[-2] + way * (1.0 + random.uniform(-14.0, 14.0) / long) + random.normal(0.0, 2.0, 2)
    )
    line = resample(path, spacing=SPACING)
    return line + trembling(random, len(line), tremor), corners


def turning(ring: Array) -> float:
    """Return how much a ring turns in all, over the whole turn that a convex one makes."""
    return float(turns(ring)[0].sum()) / 360.0


def turns(ring: Array) -> tuple[Array, Array]:
    """Return the turn at equal steps round a ring, degrees, and the places, (n,) and (n, 2)."""
    places = resample(ring, spacing=STEP * float(np.ptp(ring, axis=0).max()), closed=True)
    way = np.roll(places, -1, axis=0) - places
    heading = way[:, 0] + 1j * way[:, 1]
    return np.abs(np.degrees(np.angle(np.roll(heading, -1) / heading))), np.roll(places, -1, axis=0)
