"""A drawing without what is round in it: lines go on to the corners that were rounded.

What is left is a drawing of flat faces, read as any other. A drawing of nothing but cylinders with
one axis has none: the box about its largest cylinder stands for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import remembered
from bozzetto_polyhedron.rounds.ellipses import Ellipse
from bozzetto_polyhedron.rounds.ink_left import Evidence
from bozzetto_polyhedron.rounds.reading import read
from bozzetto_polyhedron.rounds.round_things import Barrel, Reading

SAMPLES: Final = 24
"""Points of a straight stroke in the place of something round."""

OVER: Final = 0.5
"""How far a line that goes on from dashes runs over them, in lengths of it."""

FEWEST_LINES: Final = 5
"""Straight strokes that are left, below which a drawing is of cylinders alone: six edges bound the
simplest solid."""

TURN_OF_BOX: Final = np.radians(33.0)
"""How far the box about a cylinder is turned about its axis, from the longer axis of its rims: no
two of its corners lie on one another then, and no two of its edges run alike."""

STEEPEST: Final = 0.94
"""Ratio of the axes of a rim above which the sides of its cylinder are not seen."""


@dataclass(frozen=True, eq=False)
class Column:
    """The largest cylinder of a drawing that has nothing else.

    Parameters
    ----------
    rim : Ellipse
        The near one, with its shorter axis along the sides.
    shift : (2,) float64
        To the far one, px.
    corners : (8, 2) float64
        Of the box about it: four about the near rim, then four about the far one, px.
    barrel : Barrel
        Whose rims it has.
    """

    rim: Ellipse
    shift: Array
    corners: Array
    barrel: Barrel


@dataclass(frozen=True, eq=False)
class Straightened:
    """A drawing of flat faces, and what was round.

    Parameters
    ----------
    strokes : Strokes
        Straight ones in the place of round ones among them.
    numbers : tuple of int
        Of each the number of the stroke that was drawn, −1 where there is none.
    reading : Reading or None
        What was round; None where nothing was: the strokes are those that were drawn.
    column : Column or None
        Where there is nothing but cylinders.
    """

    strokes: Strokes
    numbers: tuple[int, ...]
    reading: Reading | None = None
    column: Column | None = None

    def drawn(self, numbers: tuple[int, ...]) -> tuple[int, ...]:
        """Return the numbers of strokes that were drawn, without those in the place of others."""
        return tuple(sorted({self.numbers[k] for k in numbers if self.numbers[k] >= 0}))


@remembered(limit=64)
def straightened(strokes: Strokes, evidence: Evidence) -> Straightened:
    """Return a drawing without what is round in it.

    Parameters
    ----------
    strokes : Strokes
        Of one view.
    evidence : {"clear", "all", "none"}
        What is read as round: nothing that may as well be a polygon, all that may be round, or
        nothing.
    """
    reading = read(list(strokes), evidence)
    if reading is None:
        return Straightened(strokes, tuple(range(len(strokes))))
    gone = reading.strokes
    kept = [number for number in range(len(strokes)) if number not in gone]
    pens = _Pens(strokes, reading)
    made: list[tuple[Stroke, int]] = []
    column = None
    if reading.straight < FEWEST_LINES and not reading.bends:
        column = _column(reading)
    if column is not None:
        return Straightened(
            Strokes(_box_strokes(column.corners, pens)), (-1,) * 12, reading, column
        )
    ends = {
        (stroke, tuple(at)): corner
        for bend in reading.bends
        for stroke, at, corner in bend.ends
        if stroke >= 0
    }
    for number in kept:
        stroke = strokes[number]
        for (owner, place), corner in ends.items():
            if owner == number:
                stroke = _drawn_on(stroke, np.array(place), corner)
        made.append((stroke, number))
    for bend in reading.bends:
        for owner, begin, corner in bend.ends:
            if owner < 0:
                over = begin - OVER * (corner - begin)
                made.append((pens.line(over, corner, bend.light[1]), -1))
        far = bend.corners + bend.shift
        for one, other in zip(bend.corners, far, strict=True):
            made.append((pens.line(one, other, any(bend.light)), -1))
        if len(far) == 2:
            for end, light in zip((bend.corners, far), bend.light, strict=True):
                made.append((pens.line(end[0], end[1], light), -1))
    return Straightened(
        Strokes([stroke for stroke, _ in made]), tuple(number for _, number in made), reading
    )


class _Pens:
    """Straight strokes as firm or as light as those of a drawing."""

    def __init__(self, strokes: Strokes, reading: Reading) -> None:
        pressure = np.array([float(np.mean(stroke.pressure)) for stroke in strokes])
        firm, light = pressure[~reading.light], pressure[reading.light]
        self.firm = float(np.median(firm)) if len(firm) else 0.5
        self.light = float(np.median(light)) if len(light) else 0.4 * self.firm
        self.camera = strokes[0].camera

    def line(self, begin: Array, end: Array, light: bool) -> Stroke:
        """Return a stroke from one place to another."""
        x, y = np.linspace(begin, end, SAMPLES).T
        pressure = np.full(SAMPLES, self.light if light else self.firm)
        return Stroke(x, y, self.camera, pressure=pressure)


def _drawn_on(stroke: Stroke, at: Array, corner: Array) -> Stroke:
    """Return a stroke that goes on, along itself, as far as a corner beyond its end at a place."""
    path = np.asarray(stroke.points, float)
    backward = bool(np.linalg.norm(path[0] - at) < np.linalg.norm(path[-1] - at))
    if backward:
        path = path[::-1]
    begin, end = path[0], path[-1]
    along = (end - begin) / np.linalg.norm(end - begin)
    reached = begin + along * float((corner - begin) @ along)
    if (reached - end) @ along > 0.0:
        path = np.concatenate((path, np.linspace(end, reached, SAMPLES)[1:]))
    if backward:
        path = path[::-1]
    pressure: Any = None
    if stroke.has_pressure:
        pressure = np.full(len(path), float(np.mean(stroke.pressure)))
    return Stroke(path[:, 0], path[:, 1], stroke.camera, pressure=pressure, color=stroke.color)


def _column(reading: Reading) -> Column | None:
    """Return the cylinder with the largest rims of those that are seen from outside."""
    outside = [each for each in reading.barrels if each.outside]
    if not outside:
        return None
    barrel = max(outside, key=lambda each: reading.rims[each.near].ellipse.radius)
    near, far = reading.rims[barrel.near].ellipse, reading.rims[barrel.far].ellipse
    rim, shift = _made_true(reading, barrel, near, far)
    if rim.lengths[1] > STEEPEST * rim.lengths[0]:
        return None
    cosine, sine = np.cos(TURN_OF_BOX), np.sin(TURN_OF_BOX)
    first = cosine * rim.axes[0] + sine * rim.axes[1]
    second = cosine * rim.axes[1] - sine * rim.axes[0]
    near_corners = rim.center + np.array(
        (first + second, first - second, -first - second, second - first)
    )
    return Column(rim, shift, np.concatenate((near_corners, near_corners + shift)), barrel)


def _made_true(
    reading: Reading, barrel: Barrel, near: Ellipse, far: Ellipse
) -> tuple[Ellipse, Array]:
    """Return a rim with its shorter axis along the shift to the other one, and that shift.

    Each of both directions is believed by how sure it is: the shift by its length, the axis by how
    flat the rims are.
    """
    shift = far.center - near.center
    length = float(np.linalg.norm(shift))
    long, short = near.lengths
    across = near.axes[1] / short * (1.0 if near.axes[1] @ shift > 0 else -1.0)
    flat = (long * long - short * short) / long
    way = length**2 * shift / length + flat**2 * across
    way = way / np.linalg.norm(way)
    if reading.rims[barrel.far].is_whole:
        lengths = 0.5 * (near.lengths + far.lengths)
    else:
        lengths = near.lengths
    beside = np.array((way[1], -way[0]))
    return (
        Ellipse(near.center, np.array((lengths[0] * beside, lengths[1] * way))),
        float(shift @ way) * way,
    )


def _box_strokes(corners: Array, pens: _Pens) -> list[Stroke]:
    """Return the edges of a box, those light that end at its hidden corner.

    That is the one of its far corners that lies within the outline.
    """
    middle = corners.mean(axis=0)
    hidden = 4 + int(np.linalg.norm(corners[4:] - middle, axis=1).argmin())
    edges = [(k, (k + 1) % 4) for k in range(4)]
    edges += [(k + 4, (k + 1) % 4 + 4) for k in range(4)] + [(k, k + 4) for k in range(4)]
    return [pens.line(corners[one], corners[two], hidden in (one, two)) for one, two in edges]
