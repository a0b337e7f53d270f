"""A curve across the centre plane as a flat one, where the ink does not contradict that.

The plane of a flat curve that is its own mirror image contains the normal of the centre plane:
two figures say which it is, and the whole of the ink tells them. Every place is where its ray
meets the plane, also where the epipolar lines run along the curve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.interpretation.flat_places import FEWEST, Flat, on_plane
from bozzetto_symmetry.interpretation.folding import Folding
from bozzetto_symmetry.interpretation.mirrored_ink import (
    CONTRADICTED,
    MEASURES,
    USUAL,
    InkLine,
    MirrorImage,
    equations,
)
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace
from bozzetto_symmetry.interpretation.straight_crossing import end_of
from bozzetto_symmetry.stereo.bowed_plane import FIGURES, BowedPlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

ROUNDS: Final = 15
"""Most Gauss–Newton steps for the plane."""

SETTLED: Final = 1e-6
"""Change of the plane, radians and shares of the curve's size, at which it counts as found."""

OFF: Final = (2.5, 0.01)
"""Distance of the mirror image from the ink (rms, px; as a share of the ink's length) up to which a
curve may be flat. Curves that are not are off by 20 px and more, or could not be told by hand."""

BENT: Final = (0.15, 5.0)
"""A curve is bent if its mirror image is farther than this from the ink (rms, px), and this many
times as far as that of a curve bent along and across its plane. Hands of 1 px reach 3."""

UNLIKELY: Final = 2.0
"""Such a gain up to which it is no part of the doubt that a curve bends: then by 3 % at most."""

HALVES: Final = float(np.sqrt(0.5))
"""Share of this distance that counts: the hand errs in either half."""

TURNS: Final = 12
"""Angles of a plane that are tried where a line may cross the centre plane."""

BEST: Final = 2
"""Of these, how many the search begins at."""

SPARSE: Final = 4
"""Every which place of a half is looked at while planes are tried."""

PLANE: Final = 2
"""Figures that say which plane a flat curve lies in."""

BOWED: Final = 2.0
"""Distance of the mirror image from the ink (rms, px) up to which a curve may lie in a plane that
is bowed."""

SHALLOW: Final = 0.5
"""Standard deviation of a bow, in sizes of the curve."""

ASLANT: Final = 0.01
"""Standard deviation, radians, from the box's ways of a plane that is meant to be level or
upright."""

ANY_TURN: Final = 0.5
"""Standard deviation of a plane's angle, radians, from which on the ink does not tell it: of an
angle that may be any it is 0.9."""

ODDS: Final = 3.0
"""Odds above which a plane is taken to be level or upright."""

WORST: Final = 1e8
"""Condition of the equations from which the ink does not say in which plane a curve lies."""


def flattened(
    stereo: Stereo,
    folding: Folding,
    half: HalfInSpace,
    pixels: Array,
    ring: bool,
    straight: bool = False,
) -> tuple[Flat, ...]:
    """Return a folded line as a flat curve: its places, its half in space, and its plane.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    folding : Folding
        How its halves belong together.
    half : HalfInSpace
        What the matching alone gives.
    pixels : (n, 2) float
        The line as drawn, px; a ring does not repeat its first point.
    ring : bool
        The line is closed.
    straight : bool
        The line may be straight: then it lies in many planes.

    Returns
    -------
    tuple
        Empty where the ink says that the curve is not flat. Where it does not say in which plane a
        bent line lies, as of a shallow bow, that is level and upright; a ring has its own depth.
    """
    near, ink = folding.pairing.near, InkLine.of(pixels, ring, folding.first)
    if len(near) < FEWEST:
        return ()
    size = float(np.linalg.norm(np.ptp(half.points, axis=0)))
    most = max(OFF[0], OFF[1] * length_of(pixels))
    tried = [
        _settled(stereo, near, ink, BowedPlane(angle, away, size=size), PLANE)
        for angle, away in _starts(stereo, folding, half, ink)
    ]
    best = min(filter(None, tried), key=lambda fitted: fitted.off, default=None)
    if not (straight or ring) and (best is None or not best.is_turned):
        found = _facing(stereo, folding, near, ink, size, most)
    else:
        told = None if best is None else _told(stereo, near, ink, half, best, most)
        found = () if told is None else (told,)
    placed = [
        on_plane(
            stereo, folding, half, pixels, ring,
            SimpleForm.on(each.surface, each.covariance),
            _off(stereo, ink, each) * HALVES,
        )
        for each in found if each.is_told
    ]  # fmt: skip
    return tuple(filter(None, placed))


def _told(
    stereo: Stereo, near: Array, ink: InkLine, half: HalfInSpace, best: FittedPlane, most: float
) -> FittedPlane | None:
    """Return the plane that the ink tells, or a bowed one where a plane does not explain it."""
    flat = _off(stereo, ink, best) <= most
    gain = _gain_of_a_bow(best.rest, best.columns)
    if flat and gain < UNLIKELY:
        return aligned(stereo, near, ink, best)
    middle = float(np.mean(half.points @ best.surface.along))
    bowed = _settled(stereo, near, ink, replace(best.surface, middle=middle), FIGURES)
    if flat and gain <= CONTRADICTED:
        return doubted(aligned(stereo, near, ink, best), bowed, gain)
    return bowed if bowed is not None and _off(stereo, ink, bowed) <= BOWED else None


def doubted(plane: FittedPlane, bowed: FittedPlane | None, gain: float) -> FittedPlane:
    """Return a plane with the doubt that the curve bows out of it after all.

    The two are a mixture, each with its share of the odds: its variance holds that of either, and
    how far they are apart.
    """
    if bowed is None or not (plane.is_told and bowed.is_told):
        return plane
    share = 1.0 / (1.0 + np.exp(0.5 * (CONTRADICTED - gain)))
    apart = bowed.surface.figures - plane.surface.figures
    doubt = share * (bowed.covariance + (1.0 - share) * np.outer(apart, apart))
    doubt[:PLANE, :PLANE] += (1.0 - share) * plane.covariance
    return replace(plane, surface=replace(plane.surface, middle=bowed.surface.middle), doubt=doubt)


def _facing(
    stereo: Stereo, folding: Folding, near: Array, ink: InkLine, size: float, most: float
) -> tuple[FittedPlane, ...]:
    """Return a level and an upright plane, where the ink allows them.

    The search begins at the crossing, and at the ends, which are each other's mirror images: those
    of a shallow bow are known better.
    """
    starts = [stereo.on_plane(folding.crossings[:1])[0]]
    if not ink.ring:
        end, other, _ = ink.ends
        ends = np.vstack((end, other))
        starts.append(end_of(stereo, ends, float(stereo.angles(ends).mean())))
    found = []
    for axis in (0.0, 0.5 * np.pi):
        way = np.array((np.cos(axis), 0.0, np.sin(axis)))
        aways = [float(way @ start) for start in starts]
        tried = [
            _settled(stereo, near, ink, BowedPlane(axis, away, size=size), PLANE, axis)
            for away in aways
            if np.isfinite(away)
        ]
        best = min(filter(None, tried), key=lambda each: each.off, default=None)
        if best is None or _off(stereo, ink, best) > most:
            continue
        if _gain_of_a_bow(best.rest, best.columns) <= CONTRADICTED:
            found.append(best)
    return tuple(found)


@dataclass(frozen=True, eq=False)
class FittedPlane:
    """A surface in which a line may lie, and what the ink says of it.

    Attributes
    ----------
    surface : BowedPlane
    rest : (m,) float
        How far the mirror image is from the ink, px.
    columns : (m, 5) float
        Derivatives of that; see `equations`.
    free : int
        How many figures were looked for.
    axis : float or None
        Angle that it is drawn to.
    doubt : (k, k) float or None
        Covariance of its figures where another surface is likely, too.
    """

    surface: BowedPlane
    rest: Array
    columns: Array
    free: int
    axis: float | None = None
    doubt: Array | None = None

    @property
    def covariance(self) -> Array:
        """How well its figures are known, for a hand of 1 px, (k, k)."""
        return np.asarray(np.linalg.inv(self.information)) if self.doubt is None else self.doubt

    @property
    def off(self) -> float:
        """Root mean square of the distance from the ink, px."""
        return float(np.sqrt(np.mean(self.rest**2)))

    @property
    def information(self) -> Array:
        """Information of a hand of 1 px and of the axis about the free figures, (k, k)."""
        moves = self.columns[:, : self.free]
        told = moves.T @ moves * (MEASURES / len(self.rest)) / 2.0
        if self.axis is not None:
            told[0, 0] += 1.0 / ASLANT**2
        told[2:, 2:] += np.eye(self.free - 2) / SHALLOW**2
        return np.asarray(told)

    @property
    def is_turned(self) -> bool:
        """Whether the ink says how the plane is turned about the y axis."""
        return self.is_told and float(self.covariance[0, 0]) < ANY_TURN**2

    @property
    def is_told(self) -> bool:
        """Whether the ink says in which plane it lies: then the information has an inverse."""
        units = np.array((1.0, self.surface.size, 1.0, 1.0, 1.0))[: self.free]
        weighed = self.information * np.outer(units, units)
        return bool(np.isfinite(weighed).all() and np.linalg.cond(weighed) < WORST)


def _starts(
    stereo: Stereo, folding: Folding, half: HalfInSpace, ink: InkLine
) -> list[tuple[float, float]]:
    """Return planes from which the search begins, as angles and distances.

    One fits the matched places best. Where these are badly known, others contain the place where
    the line crosses the centre plane; the best of all angles are taken.
    """
    through = _plane_through(half)
    starts = [] if through is None else [through]
    foot = stereo.on_plane(folding.crossings[:1])[0]
    tried = []
    for angle in np.arange(TURNS) * np.pi / TURNS:
        away = float(foot[0] * np.cos(angle) + foot[2] * np.sin(angle))
        points = BowedPlane(float(angle), away).met(stereo, folding.pairing.near[::SPARSE])[0]
        images = stereo.project(points * MIRROR)
        if np.isfinite(images).all():
            apart = images - ink.pixels[ink.nearest(images)]
            tried.append((float((apart**2).sum()), float(angle), away))
    return starts + [(angle, away) for _, angle, away in sorted(tried)[:BEST]]


def _settled(
    stereo: Stereo,
    near: Array,
    ink: InkLine,
    start: BowedPlane,
    free: int,
    axis: float | None = None,
) -> FittedPlane | None:
    """Return the surface nearest to a start that explains the ink best by its first figures."""
    surface, size = start, start.size
    made = equations(stereo, near, ink, None, surface)
    for _ in range(ROUNDS):
        if made is None:
            return None
        rest, columns, images = made
        # A figure that is known besides counts as so many places.
        weight = float(np.sqrt(2.0 * len(rest) / MEASURES))
        figures = surface.figures[:free]
        known = np.zeros((free, free))
        wanted = np.zeros(free)
        known[range(2, free), range(2, free)] = weight / SHALLOW
        wanted[2:] = -weight / SHALLOW * figures[2:]
        if axis is not None:
            known[0, 0], wanted[0] = weight / ASLANT, weight / ASLANT * (axis - surface.angle)
        units = np.array((1.0, size, 1.0, 1.0, 1.0))[:free]
        rows = np.vstack((columns[:, :free], known)) * units
        step = np.linalg.lstsq(rows, np.append(-rest, wanted), rcond=None)[0]
        angle, away, *bows = figures + step * units
        surface = replace(surface, angle=float(angle), away=float(away))
        if bows:
            surface = replace(surface, bows=(float(bows[0]), float(bows[1]), float(bows[2])))
        made = equations(stereo, near, ink, ink.nearest(images), surface)
        if np.abs(step).max() < SETTLED:
            break
    return None if made is None else FittedPlane(surface, made[0], made[1], free, axis)


def aligned(stereo: Stereo, near: Array, ink: InkLine, plane: FittedPlane) -> FittedPlane:
    """Return a plane that is level or upright where the ink may well mean that, else itself.

    Of a plane that is not, any angle is as likely as any other; so the odds are those of a normal
    density about the axis to an even one (Bayes factor). What the ink says against the axis is how
    much worse the plane explains it that is level or upright.
    """
    if not plane.is_told:
        return plane
    surface = plane.surface
    spread = float(plane.covariance[0, 0]) + ASLANT**2
    axis = 0.5 * np.pi * round(surface.angle / (0.5 * np.pi))
    made = _settled(stereo, near, ink, replace(surface, angle=axis), PLANE, axis)
    if made is None:
        return plane
    against = 0.5 * MEASURES * (made.off**2 - plane.off**2)
    against += ((made.surface.angle - axis) / ASLANT) ** 2
    odds = 0.5 * np.pi * np.exp(-0.5 * against) / np.sqrt(2.0 * np.pi * spread)
    return made if odds > ODDS else plane


def _plane_through(half: HalfInSpace) -> tuple[float, float] | None:
    """Return the angle and the distance of the plane that fits the places of a half best."""
    place = half.points[:, [0, 2]]
    middle = half.trust @ place
    apart = (place - middle) * np.sqrt(half.trust)[:, None]
    sizes, ways = np.linalg.svd(apart, full_matrices=False)[1:]
    if not sizes[0] > 0.0:
        return None
    normal = ways[-1]
    return float(np.arctan2(normal[1], normal[0])), float(normal @ middle)


def _off(stereo: Stereo, ink: InkLine, plane: FittedPlane) -> float:
    """Return how far the ink is from its mirror image, all of it or the matched half (rms, px).

    A line that is folded at a wrong place has ink that the halves have no part in.
    """
    seen = MirrorImage.of(stereo, ink.pixels, plane.surface)
    if not np.isfinite(seen.pixels).all():
        return np.inf
    feet = ink.nearest(seen.pixels)
    apart = ((seen.pixels - ink.pixels[feet]) * ink.normals[feet]).sum(axis=1)
    apart = (seen.shares(ink.normals[feet]) * apart)[ink.shown(feet)]
    return max(plane.off, float(np.sqrt(np.mean(apart**2)))) if len(apart) else np.inf


def _gain_of_a_bow(rest: Array, columns: Array) -> float:
    """Return how much better a bow explains what is off, in squared errors of the hand.

    It is infinite where it leaves hardly anything: then it is shape.
    """
    columns = columns[:, :-1]
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left = rest - scaled @ np.linalg.lstsq(scaled, rest, rcond=1e-9)[0]
    least, factor = BENT
    off, bent = float(np.mean(rest**2)), float(np.mean(left**2))
    if np.sqrt(off) > max(least, factor * np.sqrt(bent)):
        return np.inf
    # Two halves err, seven measurements tell, and a bend takes two of them.
    hand = (USUAL + MEASURES * bent) / (USUAL + 3.0)
    return MEASURES * (off - bent) / hand
