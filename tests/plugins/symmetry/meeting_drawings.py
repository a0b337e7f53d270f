"""Drawings of several curves of which some ends meet and some do not, by seed.

In the frame of the centre plane (y = 0, mm), in the box of `meant_drawings`. Besides its tremor the
hand begins and ends its strokes too early or too late.
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
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry.scenes import Array, distances

ENDS: Final = 2.0
"""How far a hand of 1 px ends too early or too late along its way, px."""

MEETS: Final = 0.3
"""Distance, mm, up to which true curves meet."""


@dataclass(frozen=True)
class Line:
    """A true curve of a drawing, with its strokes.

    Attributes
    ----------
    truth : (n, 3) float
        Of a pair one side, mm.
    strokes : tuple of Stroke
    """

    truth: Array
    strokes: tuple[Stroke, ...]

    @property
    def ends(self) -> Array:
        """Both ends, (2, 3) mm."""
        return self.truth[[0, -1]]


def _ends_missed(drawn: Stroke, noise: float, random: np.random.Generator) -> Stroke:
    """A stroke that begins and ends too early or too late."""
    points = drawn.points
    for _ in range(2):
        points = points[::-1]
        by = noise * ENDS * float(random.standard_normal())
        way = points[-1] - points[-12]
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
        if by > 0:
            points = np.vstack((points, points[-1] + by * way / np.linalg.norm(way)))
        else:
            points = points[along <= along[-1] + by]
    return Stroke(points[:, 0], points[:, 1], drawn.camera)


def _line(truth: Array, view: Camera, noise: float, random: np.random.Generator) -> Line:
    """A curve by its strokes: one in the plane or across it, else one for each side."""
    one = abs(truth[:, 1]).max() < 1e-9 or abs(truth[0, 1] + truth[-1, 1]) < 1e-9
    sides = (truth,) if one else (truth, truth * MIRROR)
    strokes = [m.stroke(side, view, noise, random) for side in sides]
    return Line(truth, tuple(_ends_missed(each, noise, random) for each in strokes))


def _drawn(truths: list[Array], noise: float, random: np.random.Generator) -> list[Line]:
    view = m.view_of(random)
    order = random.permutation(len(truths))
    return [_line(truths[k], view, noise, random) for k in order]


def _straight(one: Array, two: Array) -> Array:
    return np.asarray(one + np.outer(m.SHARE, np.subtract(two, one)))


def _bar(place: Array, half: float) -> Array:
    return np.asarray(place * (1, 0, 1) + np.outer(2 * m.SHARE - 1, (0.0, half, 0.0)))


def loose(noise: float, random: np.random.Generator) -> list[Line]:
    """Two smooth pairs and two bars at any places."""
    truths = [m.smooth_side(random), m.smooth_side(random)]
    truths += [
        _bar(random.uniform((-90, 0, -45), (90, 0, 45)), random.uniform(15, 45)) for _ in range(2)
    ]
    return _drawn(truths, noise, random)


def ladder(noise: float, random: np.random.Generator) -> list[Line]:
    """A pair of posts aslant, and four bars across: three from post to post, one free."""
    foot = random.uniform((-80, 20, -45), (-20, 45, -30))
    head = random.uniform((20, 15, 20), (80, 40, 45))
    post = _straight(foot, head)
    rungs = [post[k] for k in (60, 150, 240)]
    truths = [post, *(_bar(rung, float(rung[1])) for rung in rungs)]
    beside = post[105] + random.uniform(-1, 1, 3) * (8, 0, 8)
    truths.append(_bar(beside, float(post[105, 1] * random.uniform(0.5, 0.8))))
    return _drawn(truths, noise, random)


def box_frame(noise: float, random: np.random.Generator) -> list[Line]:
    """The edges of a box that is smaller than the one around it."""
    length, width, height = random.uniform((60, 15, 30), (180, 45, 90))
    low = -0.5 * np.array((length, 0.0, height)) + random.uniform(-5, 5, 3) * (1, 0, 1)
    ends = [low + np.array((length * i, width, height * k)) for i in (0, 1) for k in (0, 1)]
    truths = [_bar(end, width) for end in ends]
    truths += [_straight(ends[a], ends[b]) for a, b in ((0, 2), (1, 3), (0, 1), (2, 3))]
    return _drawn(truths, noise, random)


def bicycle(noise: float, random: np.random.Generator) -> list[Line]:
    """A bicycle's frame: tubes in the plane that meet, stays and fork beside them, the bar across.

    Stays meet at the dropouts, and nothing else of them meets: they are 3 to 5 mm beside the tubes.
    """
    shift = random.uniform(-2, 2, (8, 3)) * (1, 0, 1)
    bottom, head = np.array((-10.0, 0, -28)) + shift[0], np.array((46.0, 0, 44)) + shift[1]
    low, seat = np.array((49.0, 0, 24)) + shift[2], np.array((-24.0, 0, 38)) + shift[3]
    drop = np.array((-66.0, 7, -26)) + shift[4]
    steering, pillar = _straight(head, low), _straight(bottom, seat)
    fork = CubicSpline((0, 1, 2), ((50, 5, 22), (56, 6, -6), (66, 6, -26)))(2 * m.SHARE)
    bar = np.column_stack(
        (head[0] - 6 * (2 * m.SHARE - 1) ** 2, 38 * (2 * m.SHARE - 1), head[2] + 0 * m.SHARE)
    )
    tubes = [_straight(bottom, steering[220]), _straight(pillar[240], steering[80])]
    stays = [
        _straight(place + np.array((0.0, beside, 0.0)), drop)
        for place, beside in ((bottom, 4.0), (pillar[210], 3.0))
    ]
    return _drawn([steering, pillar, *tubes, fork + shift[5], *stays, bar], noise, random)


KINDS: Final[dict[str, Callable[[float, np.random.Generator], list[Line]]]] = {
    "bars and pairs that meet nothing": loose,
    "posts with bars": ladder,
    "box frames": box_frame,
    "bicycle frames": bicycle,
}


def meets(place: Array, own: Line, lines: list[Line], box: tuple[float, float, float]) -> bool:
    """Return whether a true end is on another true curve, in the centre plane, or on the box."""
    if abs(place[1]) < MEETS or (np.abs(np.abs(place) - 0.5 * np.array(box)) < MEETS).any():
        return True
    others = [line.truth for line in lines if line is not own]
    both = [side for truth in others for side in (truth, truth * MIRROR)]
    return any(float(distances(place[None], truth)[0]) < MEETS for truth in both)
