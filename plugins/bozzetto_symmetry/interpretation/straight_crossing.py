"""One line as a straight bar across the centre plane.

A straight line that is its own mirror image runs along the plane's normal, so its image lies on
one epipolar line and no place of it has a partner. Its two ends have: they are mirror images.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.interpretation.candidate import Candidate, Read
from bozzetto_symmetry.interpretation.mirrored_ink import CONTRADICTED, USUAL
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace
from bozzetto_symmetry.stereo.degeneracies import intersect_rays
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

ON_LINE: Final = (2.5, 0.01)
"""Distance from one epipolar line (rms, px; as a share of the length) up to which a line is
straight along it: a short stroke from corner to corner that misses either by 4 px."""

HABIT: Final = 0.005
"""Bow of a line that is meant to be straight, by the habit of an arm (rms, as a share of the
length): its middle is 1.7 % of the length aside."""

LONGEST: Final = 1.1
"""Length of a straight line, in distances of its ends: more turns back."""

LEAST: Final = 1e-6
"""Share of the length that the ends of a bar are at least apart in space."""

PLACES: Final = 61
"""Places along half a bar."""

HAND: Final = 0.25
"""Change of an end, px, by which the doubt about a bar is worked out."""

AT_END: Final = 1.5
"""Error of a line's end for a hand that errs by 1 px, px: nothing beyond an end evens it out."""

STRETCHES: Final = 7.0
"""Stretches of a line that a hand errs in apart."""

MEAN: Final = 0.38
"""Error of the mean of a line of a hand that errs by 1 px, px, over all of these."""


def as_bar(stereo: Stereo, pixels: Array, more: float) -> Iterator[Candidate]:
    """Yield a line as a straight bar across the plane, if it may be one.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    pixels : (n, 2) float
        The line as drawn, px.
    more : float
        Price that the reading bears besides, px.
    """
    length = length_of(pixels)
    if len(pixels) < 2 or not length > 0:
        return
    angles, scales = stereo.angles(pixels), stereo.pixels_per_angle(pixels)
    if not np.isfinite(scales @ scales):  # a view of everything
        return
    middle = float(np.average(angles, weights=scales**2))
    off = float(np.sqrt(np.mean((scales * (angles - middle)) ** 2)))
    widest, share = ON_LINE
    chord = float(np.linalg.norm(pixels[-1] - pixels[0]))
    if not (off <= max(widest, share * length) and length <= LONGEST * chord):
        return
    end = end_of(stereo, pixels[[0, -1]], middle)
    if not (np.isfinite(end).all() and abs(end[1]) > LEAST * float(np.linalg.norm(end))):
        return
    doubt = _doubt(stereo, pixels[[0, -1]], middle)
    form = SimpleForm(np.array(((1.0, 0.0, 0.0, end[0]), (0.0, 0.0, 1.0, end[2]))), doubt[:2, :2])
    half = np.outer(np.linspace(1.0, 0.0, PLACES), (0.0, end[1], 0.0)) + end * (1.0, 0.0, 1.0)
    points = np.vstack((half, (half * MIRROR)[-2::-1]))
    spread = np.zeros((3, 3))
    spread[np.ix_((0, 2, 1), (0, 2, 1))] = doubt
    covariances = np.tile(spread, (len(points), 1, 1))
    foot = stereo.project(half[-1:])
    cut = int(np.argmin(np.linalg.norm(pixels - foot, axis=1)))
    read = Read(
        "self", off + more, 1.0, points, covariances, None, foot,
        (np.vstack((foot, pixels[:cut][::-1])),), (np.vstack((foot, pixels[cut + 1 :])),),
        form=form,
    )  # fmt: skip
    even = np.full(PLACES, 1.0 / PLACES)
    known = HalfInSpace(half, covariances[:PLACES], even, 1.0, 0.0, 0.0)
    yield Candidate(known, lambda _: read)


def is_bowed(pixels: Array) -> bool:
    """Return whether a line bows more than a hand does that draws a straight one.

    It does where a cubic polynomial explains more of what is off the chord than tremor would, and
    the bow is more than the habit of an arm.

    Parameters
    ----------
    pixels : (n, 2) float
        The line as drawn, px, at even steps.
    """
    length, chord = length_of(pixels), pixels[-1] - pixels[0]
    way = chord / max(float(np.linalg.norm(chord)), 1e-12)
    height = (pixels - pixels[0]) @ (-way[1], way[0])
    share = np.linspace(-1.0, 1.0, len(pixels))
    straight, bent = (
        float(np.mean((height - np.polynomial.Polynomial.fit(share, height, degree)(share)) ** 2))
        for degree in (1, 3)
    )
    hand = (USUAL + STRETCHES * bent) / (USUAL + STRETCHES - 4.0)
    much = STRETCHES * (straight - bent) > CONTRADICTED * hand
    return bool(much and np.sqrt(straight) > HABIT * length)


def end_of(stereo: Stereo, ends: Array, angle: float) -> Array:
    """Return the first end in space of a bar of which both ends are drawn, (3,) mm."""
    level = _onto(stereo, ends, angle)
    return np.asarray(intersect_rays(stereo, level[:1], level[1:])[0][0])


def _onto(stereo: Stereo, pixels: Array, angle: float) -> Array:
    """Return the nearest places on one epipolar line, px."""
    way = stereo.toward_vanishing(pixels)
    normal = np.column_stack((-way[:, 1], way[:, 0]))
    steps = np.zeros(len(pixels))
    for _ in range(3):
        place = pixels + steps[:, None] * normal
        slope = stereo.angles(place + 0.5 * normal) - stereo.angles(place - 0.5 * normal)
        rest = angle - stereo.angles(place)
        steps = steps + np.divide(rest, slope, out=np.zeros_like(rest), where=slope != 0)
    return np.asarray(pixels + steps[:, None] * normal)


def _doubt(stereo: Stereo, ends: Array, angle: float) -> Array:
    """Return the covariance of (x, z, y) of an end for 1 px of the hand, (3, 3) mm²."""
    way = stereo.toward_vanishing(ends)
    columns = []
    for number in (0, 1):
        moved = np.zeros((2, 2))
        moved[number] = HAND * AT_END * way[number]
        columns.append(end_of(stereo, ends + moved, angle) - end_of(stereo, ends - moved, angle))
    scale = float(stereo.pixels_per_angle(ends.mean(axis=0)[None])[0])
    aside = HAND / scale
    columns.append(end_of(stereo, ends, angle + aside) - end_of(stereo, ends, angle - aside))
    slopes = np.column_stack(columns)[[0, 2, 1]] / (2.0 * HAND)
    slopes[:, 2] *= MEAN
    made = np.nan_to_num(slopes @ slopes.T)
    return np.asarray(made + 1e-12 * np.eye(3))
