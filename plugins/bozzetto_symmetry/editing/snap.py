"""Ends of curves moved to given places; in the frame of the plane (y = 0), mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import DEGREE, Spline
from bozzetto.ink import arc_length
from bozzetto_symmetry.fitting.half_curve import halves_of, symmetrize
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

FADE: Final = 8.0
"""Length of the stretch that moves with an end, over the distance that the end moves; the curve
turns by a few degrees, and by less than a fifth of a radian at most."""

LEAST_FADE: Final = 0.1
"""Least share of the curve that moves with an end."""

TURNED_FADE: Final = 0.25
"""The same share where the direction at the end changes."""

STEPS: Final = 8
"""Least number of knots on that stretch: its displacement has one bend each way."""

ON_PLANE: Final = 1e-12
"""Distance from the plane, as a share of that from the origin, that counts as rounding."""

IN_FORM: Final = 1e-4
"""Distance from a line or a plane, in sizes of the curve, that nobody sees: so nearly is a curve
fitted that is held there."""

WIDER: Final = 2.0
"""Ratio of widths up to which a flat curve keeps its form when its end is taken elsewhere; one
that is closed to a drop, or opened, bends near its ends."""

LEVER: Final = 0.5
"""How far from the crossing a flat curve ends, in its size, to turn about that."""

LOOKS: Final = 256
"""Places by which lengths are measured."""


def snap_end(
    curve: SpaceCurve, end: int, point: ArrayLike, tangent: ArrayLike | None = None
) -> SpaceCurve:
    """Return a curve whose end is at a given place.

    The direction at the end stays, or becomes the one given. A stretch before it moves along, the
    less the farther it is from the end; the rest does not move. Across the plane, a straight curve
    stays straight, whatever the direction, and a flat one flat.

    Parameters
    ----------
    curve : SpaceCurve
        An open curve, in the frame of the plane.
    end : {0, 1}
        Of a curve across the plane its one free end is 1.
    point : (3,) array_like
        mm; of a curve in the plane y counts as 0.
    tangent : (3,) array_like, optional
        Unit direction in which the curve leaves that end; of a curve in the plane y counts as 0.

    Raises
    ------
    UserError
        If the curve is closed, or the place is not finite.
    """
    if curve.closed:
        raise UserError("A closed curve has no end to snap. Split it first.")
    place = np.array(point, float)
    if not np.isfinite(place).all():
        raise UserError("The end of a curve cannot be taken there. Choose another place.")
    if curve.reading == "plane" or abs(place[1]) <= ON_PLANE * np.abs(place).max():
        place[1] = 0.0
    if curve.reading == "self":
        return SpaceCurve("self", _both_ends_moved(curve.spline, place, tangent))
    if tangent is not None and curve.reading == "plane":
        tangent = np.asarray(tangent, float) * (1.0, 0.0, 1.0)
    base = curve.spline if end == 1 else curve.spline.reversed()
    moved = _end_moved(base, place, tangent)
    return SpaceCurve(curve.reading, moved if end == 1 else moved.reversed())


def end_direction(spline: Spline) -> Array:
    """Return the unit direction in which a spline leaves its last end, (3,)."""
    way = spline.control_points[-1] - spline.control_points[-2]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-300))


def _end_moved(spline: Spline, place: Array, tangent: ArrayLike | None) -> Spline:
    way = place - spline.value(spline.range[1:])[0]
    turn = _turn(spline, tangent)
    fade = _Fade.of(spline, spline.range[0], way, turned=bool(turn.any()))
    finer = spline.refined(fade.knots)
    points = finer.control_points + fade.moves(finer, way, turn)
    _pin(points, place, tangent)
    return Spline(finer.knots, points)


def _both_ends_moved(spline: Spline, place: Array, tangent: ArrayLike | None) -> Spline:
    """Return a curve across the plane with its free end, and the image of that, moved."""
    form = _simple_form(spline.control_points)
    if form is not None and _is_near(spline, place):
        spline = _turned_to(spline, place)
        if form == "straight" or tangent is None:
            return spline
    middle = halves_of(spline).middle
    way = place - spline.value(spline.range[1:])[0]
    turn = _turn(spline, tangent)
    fade = _Fade.of(spline, middle, way, turned=bool(turn.any()))
    finer = symmetrize(spline.refined(np.concatenate((fade.knots, 2.0 * middle - fade.knots))))
    shift = fade.moves(finer, way, turn, middle)
    points = finer.control_points + shift + shift[::-1] * MIRROR
    _pin(points, place, tangent)
    points[:2] = points[:-3:-1] * MIRROR
    return Spline(finer.knots, points)


def _simple_form(points: Array) -> Literal["straight", "flat"] | None:
    """Return what a curve across the plane is that lies in planes along the normal of that."""
    beside = points[:, ::2] - points[:, ::2].mean(axis=0)
    _, wide = np.linalg.svd(beside, compute_uv=False)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not wide <= IN_FORM * size:
        return None
    return "straight" if float(np.abs(beside).max()) <= IN_FORM * size else "flat"


def _is_near(spline: Spline, place: Array) -> bool:
    """Return whether a curve across the plane is about as wide with its end at a place."""
    end = abs(float(spline.control_points[-1, 1]))
    return bool(end < WIDER * abs(place[1]) <= WIDER**2 * end)


def _turned_to(spline: Spline, place: Array) -> Spline:
    """Return a flat curve across the plane that ends at a place, and is flat.

    It is as wide as its end. Its plane turns where the curve crosses the centre plane, which is
    what the ink leaves open of it, and is stretched along; a curve that ends beside where it
    crosses moves as a whole, as a straight one does.
    """
    middle, end = spline.value((0.5 * sum(spline.range), spline.range[1]))
    points = spline.control_points.copy()
    points[:, 1] *= place[1] / end[1]
    beside, was, now = (at[..., ::2] - middle[::2] for at in (points, end, place))
    length, size = float(np.linalg.norm(was)), float(np.linalg.norm(beside, axis=1).max())
    if length > LEVER * max(size, abs(float(end[1]))):
        points[:, ::2] = middle[::2] + np.outer(beside @ was / length**2, now)
    else:
        points[:, ::2] += now - was
    points[-1] = place
    points[0] = place * MIRROR
    return Spline(spline.knots, points)


def _turn(spline: Spline, tangent: ArrayLike | None) -> Array:
    """Return what the unit direction at the last end changes by, (3,)."""
    if tangent is None:
        return np.zeros(3)
    return np.asarray(tangent, float) - end_direction(spline)


def _pin(points: Array, place: Array, tangent: ArrayLike | None) -> None:
    """Put the last control point where it goes, and the one before it along the tangent."""
    length = float(np.linalg.norm(points[-1] - points[-2]))
    points[-1] = place
    if tangent is not None:
        points[-2] = place - length * np.asarray(tangent, float)


@dataclass(frozen=True, eq=False)
class _Fade:
    """A stretch before the end of a spline.

    Its parameters, how far each is from the end (mm), and what share of the way it goes.
    """

    at: Array
    before: Array
    share: Array

    @classmethod
    def of(cls, spline: Spline, begin: float, way: Array, *, turned: bool) -> _Fade:
        at = np.linspace(begin, spline.range[1], LOOKS)
        along = arc_length(spline.value(at))
        length = along[-1] or 1.0
        least = (TURNED_FADE if turned else LEAST_FADE) * length
        reach = min(length, max(FADE * float(np.linalg.norm(way)), least))
        done = np.clip(1.0 - (length - along) / reach, 0.0, 1.0)
        return cls(at, length - along, done**2 * (3.0 - 2.0 * done))

    @property
    def knots(self) -> Array:
        """Parameters at which the displacement needs knots."""
        begin = self.at[max(0, int(np.argmax(self.share > 0.0)) - 1)]
        return np.linspace(begin, self.at[-1], STEPS + 1)[:-1]

    def moves(self, spline: Spline, way: Array, turn: Array, middle: float = -np.inf) -> Array:
        """Return how far each control point goes, (n, 3) mm.

        The last two go all the way, which keeps the direction at the end, but for its turn.
        """
        places = (spline.knots[1:-3] + spline.knots[2:-2] + spline.knots[3:-1]) / DEGREE
        share = np.interp(places, self.at, self.share)
        share[-2:] = 1.0
        share = np.where(places > middle, share, 0.0)
        before = np.interp(places, self.at, self.before)
        return np.asarray(share[:, None] * (way - before[:, None] * turn))
