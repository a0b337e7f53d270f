"""Outlines as a hand draws them: it trembles, drifts, and does not arrive where it began."""

from __future__ import annotations

from dataclasses import dataclass

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


def wavering(random: np.random.Generator, when: Array, tremor: float) -> Array:
    """Return the deviation of a hand that trembles six to twelve times a second, (n, 2) px.

    Five waves of the physiological tremor (Elble and Koller, *Tremor*, 1990), however often samples
    are taken, at times `when` (n,) in seconds.
    """
    rate = random.uniform(6.0, 12.0, 5)
    phase = random.uniform(0.0, 2.0 * np.pi, (5, 2))
    size = random.normal(0.0, tremor * np.sqrt(2.0 / 5.0), (5, 2))
    waves = np.sin(2.0 * np.pi * rate[:, None] * when[:, None, None] + phase)
    return np.asarray((size * waves).sum(axis=1))


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


@dataclass(frozen=True)
class Hand:
    """How somebody draws along an outline.

    Parameters
    ----------
    tremor : float
        px.
    drift : float
        How far it wanders off slowly, px; what it then draws is what it means.
    grain : float
        Distance of the places that the device tells, px: 1 for a mouse.
    miss : float
        How far a stroke may end early or late, px; it lands a quarter of that beside.
    strokes : int
        At most.
    waves : float
        Tremor of six to twelve waves a second, px.
    rate : float
        Samples in a second.
    pace : float
        Speed, as a share of `PACE`.
    """

    tremor: float = 0.5
    drift: float = 3.0
    grain: float = 0.1
    miss: float = 9.0
    strokes: int = 1
    waves: float = 0.0
    rate: float = 120.0
    pace: float = 1.0


PACE = (120.0, 900.0)
"""Speed of the pen in bends and on straight ways, px/s; between, by the cube root of the curvature
(Lacquaniti, Terzuolo and Viviani, 1983)."""

WAY = 0.7
"""Distance of the places of an outline before the pen follows it, px."""


def drawn_after(random: np.random.Generator, ring: Array, hand: Hand) -> tuple[Array, list[Array]]:
    """Return the outline that a hand means (n, 2), px, and the strokes that it leaves."""
    meant = resample(ring, spacing=WAY, closed=True)
    count = len(meant)
    turned = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    meant = meant + sum(
        random.normal(0.0, 0.5 * hand.drift, 2)
        * np.cos(wave * turned[:, None] + random.uniform(0.0, 2.0 * np.pi, 2))
        for wave in (1, 2, 3, 5)
    )
    ahead, behind = (np.roll(meant, k, axis=0) - meant for k in (-6, 6))
    bend = np.abs(np.angle(-(ahead @ (1, 1j)) / (behind @ (1, 1j)))) / (6.0 * WAY)
    bend = np.convolve(np.tile(bend, 3), np.full(24, 1.0 / 24.0), "same")[count : 2 * count]
    speed = hand.pace * np.clip(180.0 * np.maximum(bend, 1e-3) ** (-1.0 / 3.0), *PACE)
    begin = int(random.integers(count))
    cuts = [0]
    if hand.strokes > 1:
        more = random.integers(count // 8, count - count // 8, random.integers(1, hand.strokes))
        cuts = sorted({0, *more.tolist()})
    lines = []
    for start, stop in zip(cuts, [*cuts[1:], count], strict=True):
        late = round(random.uniform(-hand.miss, hand.miss) / WAY)
        early = round(random.uniform(-0.5, 0.5) * hand.miss / WAY) if len(cuts) > 1 else 0
        way = (begin + np.arange(start + early, stop + late)) % count
        when = np.concatenate([[0.0], np.cumsum(WAY / speed[way[1:]])])
        at = np.arange(0.0, when[-1], 1.0 / hand.rate)
        if len(at) < 3:
            continue
        line = np.column_stack([np.interp(at, when, meant[way, k]) for k in (0, 1)])
        line += trembling(random, len(line), hand.tremor)
        if hand.waves:
            line += wavering(random, at, hand.waves)
        beside = random.normal(0.0, 0.25 * hand.miss, 2)
        line += np.linspace(0.0, 1.0, len(line))[:, None] ** 4 * beside
        lines.append(np.round(line / hand.grain) * hand.grain)
    return meant, lines


def corners_missed(meant: Array, ring: Array) -> tuple[int, int, int]:
    """Return how many corners an outline has, how many are lost in a ring, and how many it adds.

    A corner turns by 65° within 7 px to either side; lost, less than 60 % of that is left within
    14 px; one that nobody drew turns by 32°, twice as much as anything within 16 px.
    """
    (places, turn), (others, found) = _turns_along(meant), _turns_along(ring)
    sharp, drawn = _peaks(turn, 65.0), _peaks(found, 32.0)
    lost = sum(_most(others, found, places[k], 14.0) < 0.6 * turn[k] for k in sharp)
    added = sum(_most(places, turn, others[k], 16.0) < 0.45 * found[k] for k in drawn)
    return len(sharp), int(lost), int(added)


def unrest(meant: Array, ring: Array) -> float:
    """Return how much a ring turns in all, over what the outline that was meant turns."""
    return float(_turns_along(ring)[1].sum() / _turns_along(meant)[1].sum())


def _turns_along(ring: Array) -> tuple[Array, Array]:
    places = resample(ring, spacing=1.0, closed=True)
    ahead, behind = (np.roll(places, k, axis=0) - places for k in (-7, 7))
    return places, np.abs(np.degrees(np.angle(-(ahead @ (1, 1j)) / (behind @ (1, 1j)))))


def _peaks(turn: Array, least: float) -> Array:
    highest = np.max([np.roll(turn, k) for k in range(-8, 9)], axis=0)
    return np.flatnonzero((turn >= highest) & (turn > least))


def _most(places: Array, turn: Array, at: Array, within: float) -> float:
    near = np.hypot(*(places - at).T) < within
    return float(turn[near].max()) if near.any() else 0.0
