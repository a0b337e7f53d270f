"""The symmetric spline that explains all the ink of a curve, in all views at once.

A bundle adjustment: the control points of a half are moved until the images of the curve and
of its mirror image lie in the middle of the ink that shows them. The ink decides across
itself only; where that says next to nothing about space, because the curve points at the
vanishing point, the curve goes on as smoothly as it can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import distances_to_polyline
from bozzetto_symmetry.fitting.initial_guess import ROUGHNESS, approximate, half_of, stations_of
from bozzetto_symmetry.fitting.normal_equations import NO_PLANES, Fit, Problem
from bozzetto_symmetry.fitting.reprojection import Ink, match_ink
from bozzetto_symmetry.fitting.space_curve import Reading, SpaceCurve
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.stereo.bowed_plane import BowedPlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

Controls = Literal["adaptive", "seven"]

FEWEST: Final = 7
"""Control points of a half to begin with (Bae, Kijima & Kim 2004 always take seven)."""

MORE: Final = 3
"""Control points added until the curve is good."""

MOST: Final = 40
"""Control points of a half at which adding ends."""

ENOUGH: Final = 0.1
"""Distance of the ink from the image of the curve (rms, px) at which more control points are
of no use: a tenth of what a hand can do, for the error in space is several times as large."""

NOISE_FACTOR: Final = 0.7
"""The same limit as a multiple of the hand's noise. The noise is slow, and a curve follows about
half of it: what is left at the full noise is shape."""

LOST: Final = 4.0
"""Distance (rms, px) above which the ink may be matched to the wrong branches of the curve."""

ASTRAY: Final = 4.0
"""Distance, px, of the image of the first curve from that of its places, above which ink may be
matched to the next turn of a spiral."""

WINDING: Final = 13
"""Control points of a half at the beginning above which a curve winds like a spiral."""

WORSE: Final = 0.9
"""Share of the places that must be nearer than that."""


@dataclass(frozen=True, eq=False)
class Sight:
    """The ink of one curve in one view.

    Parameters
    ----------
    stereo : Stereo
    near : tuple of (n, 2) float
        Pieces of ink, px, that show the half that was drawn.
    far : tuple of (n, 2) float
        Pieces of ink that show its mirror image.
    noise : float
        Standard deviation of the hand across the ink, px.
    whole : bool
        Every piece ends where the curve does.
    """

    stereo: Stereo
    near: tuple[Array, ...]
    far: tuple[Array, ...] = ()
    noise: float = 0.0
    whole: bool = False


@dataclass(frozen=True, eq=False)
class Adjusted:
    """A curve, and how well it follows the ink.

    Attributes
    ----------
    curve : SpaceCurve
    rms : float
        Root mean square distance of the ink from the images of the curve, px.
    """

    curve: SpaceCurve
    rms: float


def adjust_bundle(
    reading: Reading,
    points: ArrayLike,
    covariances: ArrayLike,
    sights: Sequence[Sight],
    *,
    closed: bool = False,
    ring: bool = False,
    controls: Controls = "adaptive",
    planes: Array = NO_PLANES,
    surface: BowedPlane | None = None,
) -> Adjusted:
    """Fit one symmetric spline to all ink of all views.

    Least squares of the distances of the ink across the image of the curve, each over the
    noise of its hand, with closest points updated at every step (Gauss–Newton, tangent distance
    minimisation; Wang, Pottmann & Liu 2006, section 3.3), and of the curve's third
    derivative, which decides only where the ink does not.

    Parameters
    ----------
    reading : {"pair", "self", "plane"}
        What the curve is.
    points : (k, 3) array_like
        Where the curve is, roughly, mm, in order: along the side that was drawn; of a curve
        across the plane along all of it, beginning with the half that was drawn first, or
        along that half from the plane outwards. Those that are not finite are left out.
    covariances : (k, 3, 3) array_like
        Covariances of these places, mm².
    sights : sequence of Sight
        The ink of each view.
    closed : bool
        The side that was drawn is closed.
    ring : bool
        The curve across the plane is closed.
    controls : {"adaptive", "seven"}
        Control points of a half. "adaptive" takes 7, then 3 more until the ink is within
        0.1 px (rms) or 0.7 times the noise of the hand, or more explain no shape. A straight
        line has no more than 7.
    planes : (k, 4) float
        Rows (n, d): the curve lies in the planes ``n · X = d``, whatever the ink says.
    surface : BowedPlane, optional
        The curve lies on it.

    Returns
    -------
    Adjusted

    Raises
    ------
    UserError
        If the points are a dot, or no view has ink that shows the curve.
    """
    place = np.reshape(np.asarray(points, float), (-1, 3))
    spread = np.reshape(np.asarray(covariances, float), (-1, 3, 3))
    pairwise = closed and reading != "self"
    basis = SymmetricBasis(reading, FEWEST, pairwise, ring)
    place, spread = half_of(place, spread, basis)
    if reading == "self" and _shows_mirror_image(sights, place):
        place, spread = place * MIRROR, spread * MIRROR * MIRROR[:, None]
    stations = stations_of(place, spread, basis)
    straight = len(planes) > 1
    most = MOST if controls == "adaptive" and not straight else FEWEST
    enough = max(ENOUGH, NOISE_FACTOR * min((sight.noise for sight in sights), default=0.0))

    while sights and _strays(basis, place, spread, stations, sights) and basis.count + MORE <= most:
        basis = SymmetricBasis(reading, basis.count + MORE, pairwise, ring)
    # The third derivative of a wave grows by the third power of the number of its turns.
    turning = basis.count / FEWEST if basis.count > WINDING else 1.0
    roughness = ROUGHNESS * turning**3
    held = planes, surface
    made = best = _fitted(basis, place, spread, stations, sights, held, roughness)
    idle = 0
    while made.rms > enough and idle < 2 and made.problem.basis.count + MORE <= most:
        basis = SymmetricBasis(reading, made.problem.basis.count + MORE, pairwise, ring)
        if made.rms > LOST:
            made = _fitted(basis, place, spread, stations, sights, held, roughness)
        else:
            made = made.refined(basis)
        better = made.betters(best)
        best, idle = (made, 0) if better else (best, idle + 1)
    best = best.calmed()
    return Adjusted(best.problem.basis.curve(best.points), best.rms)


def _shows_mirror_image(sights: Sequence[Sight], half: Array) -> bool:
    """Return whether the ink of the half drawn first shows the other half of the points."""
    for sight in sights:
        for ink in sight.near:
            images = [sight.stereo.project(half * side) for side in (np.ones(3), MIRROR)]
            if all(np.isfinite(image).all() for image in images):
                own, other = (float(distances_to_polyline(ink, i).mean()) for i in images)
                return other < own
    return False


def _strays(
    basis: SymmetricBasis,
    points: Array,
    covariances: Array,
    stations: Array,
    sights: Sequence[Sight],
) -> bool:
    """Return whether too few control points give the places an image on other branches of the ink.

    The turns of a spiral lie beside one another: ink of a curve that leaves one out is matched to
    the wrong ones, and what it looks like in the end is right.
    """
    start = approximate(basis, points, covariances, stations)
    low, high = basis.half
    made = basis.at(basis.values(low + (high - low) * stations), start)
    images = [sights[0].stereo.project(places) for places in (made, points)]
    if not all(np.isfinite(image).all() for image in images):
        return False
    return float(np.quantile(np.linalg.norm(images[0] - images[1], axis=1), WORSE)) > ASTRAY


def _fitted(
    basis: SymmetricBasis,
    points: Array,
    covariances: Array,
    stations: Array,
    sights: Sequence[Sight],
    held: tuple[Array, BowedPlane | None],
    roughness: float,
) -> Fit:
    """Return the best curve with one number of control points, from places in space."""
    start = approximate(basis, points, covariances, stations)
    inks = _matched(sights, basis, start)
    planes, surface = held
    problem = Problem.of(basis, start, inks, planes, roughness, surface)
    return Fit.at(problem, start, inks, steps=0).settled()


def _matched(sights: Sequence[Sight], basis: SymmetricBasis, points: Array) -> tuple[Ink, ...]:
    """Return the ink of the views, matched to a curve."""
    inks = [
        match_ink(sight.stereo, sight.near, sight.far, sight.noise, basis, points, sight.whole)
        for sight in sights
    ]
    found = tuple(ink for ink in inks if ink is not None)
    if not found:
        raise UserError("No ink shows this curve. Draw it again.")
    return found
