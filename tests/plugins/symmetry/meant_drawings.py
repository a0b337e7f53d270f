"""Drawings of known things, by seed, as a hand would draw them where the rays say little.

Everything is in the frame of the centre plane (y = 0, mm), in a box of 200 × 100 × 100 of which
the diagonal is 800 px long.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from bozzetto.ink import Stroke
from bozzetto.view import Camera
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import scenes as s
from tests.plugins.symmetry.scenes import Array

PLACES: Final = 300
"""Places along a true curve."""

SHARE: Final = np.linspace(0.0, 1.0, PLACES)
ROUND: Final = 2.0 * np.pi * np.arange(PLACES) / PLACES


@dataclass(frozen=True)
class Meant:
    """A curve that somebody means, with the ink of it.

    Attributes
    ----------
    reading : str
        What it is.
    truth : (n, 3) float
        Of a pair the side that is drawn first, mm.
    strokes : tuple of Stroke
        In the order drawn.
    closed : bool
    """

    reading: str
    truth: Array
    strokes: tuple[Stroke, ...]
    closed: bool = False

    @property
    def size(self) -> float:
        """The diagonal of the smallest box around it, mm."""
        return float(np.linalg.norm(np.ptp(self.truth, axis=0)))


def view_of(random: np.random.Generator) -> Camera:
    """A view as people take it: aslant, a little from above, one in four of them parallel."""
    kind = "orthographic" if random.random() < 0.25 else "perspective"
    side = random.choice((-1.0, 1.0))
    return s.camera(side * random.uniform(20, 70), random.uniform(5, 35), kind, pixels=800.0)


def stroke(curve: Array, view: Camera, noise: float, random: np.random.Generator) -> Stroke:
    """A curve as one stroke, in either sense."""
    sense = int(random.choice((-1, 1)))
    pixels = s.drawn(curve, view, noise=noise, sense=sense, random=random)
    return Stroke(pixels[:, 0], pixels[:, 1], view)


def _across(curve: Array, noise: float, random: np.random.Generator, closed: bool = False) -> Meant:
    """One stroke across the plane; a ring begins anywhere and ends a little beside there."""
    view = view_of(random)
    if not closed:
        return Meant("self", curve, (stroke(curve, view, noise, random),))
    rolled = np.roll(curve, int(random.integers(len(curve))), axis=0)
    pixels = s.drawn(rolled, view, noise=noise, random=random, closed=True)
    pixels = pixels[:: int(random.choice((-1, 1)))]
    return Meant("self", curve, (Stroke(pixels[:, 0], pixels[:, 1], view),), True)


def bar(noise: float, random: np.random.Generator) -> Meant:
    """A straight line across the plane."""
    half = random.uniform(15, 45)
    place = random.uniform((-90, 0, -45), (90, 0, 45))
    return _across(place + np.outer(2 * SHARE - 1, (0.0, half, 0.0)), noise, random)


def hoop(noise: float, random: np.random.Generator) -> Meant:
    """A bent tube: straight across the plane, round a corner, and straight on."""
    half, leg = random.uniform(20, 45), random.uniform(30, 80)
    corner = random.uniform(0.2, 0.9) * half
    turn = random.uniform(0, 2 * np.pi)
    out = np.array((np.cos(turn), 0.0, np.sin(turn)))
    bend = 0.5 * np.pi * np.linspace(0, 1, 60)
    middle = np.column_stack(
        (half - corner + corner * np.sin(bend), corner - corner * np.cos(bend))
    )
    legs = np.array(((half, leg),))
    flat = np.vstack(((0.0, 0.0), middle, np.maximum(legs, (0.0, corner))))
    line = s.resample(flat, count=PLACES // 2)
    right = np.outer(line[:, 0], (0.0, 1.0, 0.0)) + np.outer(line[:, 1], out)
    curve = np.vstack(((right * MIRROR)[:0:-1], right))
    room = np.array((100.0, 0.0, 50.0)) - 0.5 * np.ptp(curve, axis=0) * (1, 0, 1)
    centre = random.uniform(-1, 1, 3) * np.maximum(room, 0.0) - curve.mean(0)
    return _across(curve + centre * (1, 0, 1), noise, random)


def ring(noise: float, random: np.random.Generator) -> Meant:
    """A ring round a body, level, upright or aslant; one in three rather a rounded box."""
    wide, high = random.uniform(20, 45, 2)
    turn = random.choice((0.0, 0.5 * np.pi, random.uniform(0, np.pi)))
    power = random.choice((1.0, 1.0, 0.6))
    cosine, sine = np.cos(ROUND), np.sin(ROUND)
    y = wide * np.sign(sine) * np.abs(sine) ** power
    out = high * np.sign(cosine) * np.abs(cosine) ** power
    flat = np.column_stack((out * np.cos(turn), y, out * np.sin(turn)))
    flat = s.resample(flat, count=PLACES, closed=True)
    # A place on the plane comes first, as in a ring that is drawn.
    centre = random.uniform((-50, 0, -8), (50, 0, 8))
    return _across(flat + centre, noise, random, closed=True)


def smooth_side(random: np.random.Generator) -> Array:
    """A smooth line on one side of the plane, through five places, as long as half the box."""
    while True:
        x = np.sort(random.uniform(-90, 90, 5))
        if x[-1] - x[0] > 80 and np.diff(x).min() > 12:
            break
    y, z = random.uniform(12, 45, 5), random.uniform(-40, 40, 5)
    made = CubicSpline(np.linspace(0, 1, 5), np.column_stack((x, y, z)), bc_type="natural")(SHARE)
    made[:, 1] = np.clip(made[:, 1], 4.0, 60.0)
    return np.asarray(s.resample(made, count=PLACES))


def _pair(
    side: Array, noise: float, random: np.random.Generator, part: slice = slice(None)
) -> Meant:
    view = view_of(random)
    side = side * (MIRROR if random.random() < 0.5 else 1.0)
    far = (side * MIRROR)[part]
    both = stroke(side, view, noise, random), stroke(far, view, noise, random)
    return Meant("pair", side, both)


def pair(noise: float, random: np.random.Generator) -> Meant:
    """Both sides of a smooth line, each drawn whole."""
    return _pair(smooth_side(random), noise, random)


def partial(share: float) -> Callable[[float, np.random.Generator], Meant]:
    """Both sides of a smooth line, the second one drawn in part: its beginning, middle or end."""

    def made(noise: float, random: np.random.Generator) -> Meant:
        kept = round(share * PLACES)
        begin = int(random.choice((0, (PLACES - kept) // 2, PLACES - kept)))
        return _pair(smooth_side(random), noise, random, slice(begin, begin + kept))

    return made


def _two_cameras(random: np.random.Generator) -> tuple[Camera, Camera]:
    """Two views, turned by 20 to 60°."""
    azimuth, elevation = random.uniform(20, 50), random.uniform(5, 30)
    turn = random.uniform(20, 60) * random.choice((-1.0, 1.0))
    return (
        s.camera(azimuth, elevation, pixels=800.0),
        s.camera(azimuth + turn, random.uniform(5, 30), pixels=800.0),
    )


def two_views(noise: float, random: np.random.Generator) -> Meant:
    """One side drawn in one view, and the other in another view."""
    side, views = smooth_side(random), _two_cameras(random)
    first = stroke(side, views[0], noise, random)
    return Meant("pair", side, (first, stroke(side * MIRROR, views[1], noise, random)))


def strangers(noise: float, random: np.random.Generator) -> Meant:
    """A left side and a right side of two different smooth lines, which are no pair."""
    view = view_of(random)
    one, other = smooth_side(random), smooth_side(random) * MIRROR
    return Meant(
        "half", one, (stroke(one, view, noise, random), stroke(other, view, noise, random))
    )


def strangers_in_two_views(noise: float, random: np.random.Generator) -> Meant:
    """A left side in one view and a right side in another, of two different smooth lines."""
    views = _two_cameras(random)
    one, other = smooth_side(random), smooth_side(random) * MIRROR
    both = stroke(one, views[0], noise, random), stroke(other, views[1], noise, random)
    return Meant("half", one, both)


def spiral(noise: float, random: np.random.Generator) -> Meant:
    """Springs and shells: lines that wind one and a half to four times round an axis."""
    turns, radius = random.uniform(1.5, 4.0), random.uniform(10, 20)
    narrow = random.choice((0.0, 0.0, random.uniform(0.3, 0.8)))
    angle = 2 * np.pi * turns * SHARE + random.uniform(0, 2 * np.pi)
    size = radius * (1.0 - narrow * SHARE)
    way = random.uniform(20, 80) * (SHARE - 0.5)
    coil = np.column_stack((way, size * np.cos(angle), size * np.sin(angle)))
    coil = np.roll(coil, int(random.integers(3)), axis=1)
    room = np.maximum((95, 48, 45) - 0.5 * np.ptp(coil, axis=0), 0.0)
    centre = random.uniform(-1, 1, 3) * room
    depth = 0.5 * float(np.ptp(coil[:, 1]))
    centre[1] = depth + random.uniform(5, 15)
    middle = 0.5 * (coil.min(axis=0) + coil.max(axis=0))
    return _pair(np.asarray(s.resample(coil - middle + centre, count=PLACES)), noise, random)


def frame(noise: float, random: np.random.Generator) -> tuple[list[Meant], list[Meant]]:
    """The cross edges of a box frame, and its other edges; all drawn in one view."""
    view = view_of(random)
    length, width, height = random.uniform((60, 15, 30), (180, 45, 90))
    low = -0.5 * np.array((length, 0.0, height)) + random.uniform(-5, 5, 3) * (1, 0, 1)
    ends = [low + np.array((length * i, 0.0, height * k)) for i in (0, 1) for k in (0, 1)]
    crosses = []
    for end in ends:
        line = end + np.outer(2 * SHARE - 1, (0.0, width, 0.0))
        crosses.append(Meant("self", line, (stroke(line, view, noise, random),)))
    others = []
    for one, two in ((0, 2), (1, 3), (0, 1), (2, 3)):
        first, last = ends[one] + (0, width, 0), ends[two] + (0, width, 0)
        side = first + np.outer(SHARE, last - first)
        both = stroke(side, view, noise, random), stroke(side * MIRROR, view, noise, random)
        others.append(Meant("pair", side, both))
    return crosses, others


def bicycle(noise: float, random: np.random.Generator) -> tuple[list[Stroke], list[int]]:
    """A bicycle's frame in one view, and how many strokes each of its curves has.

    Four straight tubes in the plane, straight stays and a bent fork on both sides, the bar across.
    """
    view = s.camera(random.uniform(30, 55), random.uniform(10, 25), pixels=800.0)

    def tube(one: tuple[float, ...], two: tuple[float, ...]) -> Array:
        way = np.subtract(two, one) + random.uniform(-2, 2, 3) * (1, 0, 1)
        return np.array(one) + np.outer(SHARE, way)

    fork = CubicSpline((0, 1, 2), ((50, 5, 22), (56, 6, -6), (66, 6, -26)))(2 * SHARE)
    bar = np.column_stack((42 - 8 * (2 * SHARE - 1) ** 2, 38 * (2 * SHARE - 1), 48 + 0 * SHARE))
    curves = [
        tube((-10, 0, -28), (48, 0, 28)), tube((-22, 0, 30), (46, 0, 34)),
        tube((-10, 0, -28), (-24, 0, 38)), tube((44, 0, 44), (48, 0, 24)),
    ]  # fmt: skip
    for side in (fork, tube((-10, 4, -28), (-66, 7, -26)), tube((-23, 3, 30), (-66, 7, -26))):
        curves += [side, side * MIRROR]
    drawn = [stroke(curve, view, noise, random) for curve in (*curves, bar)]
    return drawn, [1, 1, 1, 1, 2, 2, 2, 1]
