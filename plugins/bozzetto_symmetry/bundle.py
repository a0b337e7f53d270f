"""The symmetric spline that explains all the ink of a curve, in all views at once.

A bundle adjustment: the control points of a half are moved until the images of the curve and
of its mirror image lie in the middle of the ink that shows them. The ink decides across
itself only; where that says next to nothing about space, because the curve points at the
vanishing point, the curve goes on as smoothly as it can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.ink.nearest import distances_to_polyline
from bozzetto_symmetry.sighting import END_NOISE, Ink, inked
from bozzetto_symmetry.space_curve import Reading, SpaceCurve
from bozzetto_symmetry.starting import ROUGHNESS, approximated, half_of, length_of, stations_of
from bozzetto_symmetry.stereo import MIRROR, Stereo
from bozzetto_symmetry.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.through import FEWEST, MORE, MOST, Controls, through
from bozzetto_symmetry.uncertainty import image_slopes

__all__ = ["Bundled", "Sight", "bundled", "through"]

Array = NDArray[np.float64]

ENOUGH: Final = 0.1
"""Distance of the ink from the image of the curve (rms, px) at which more control points are
of no use: a tenth of what a hand can do, for the error in space is several times as large."""

NOISE_FACTOR: Final = 0.7
"""The same as a multiple of the hand's noise. That is slow, and a curve goes along with about
half of it: what is left at the full noise is shape."""

ROUNDS: Final = 10
"""Most Gauss–Newton steps with one number of control points."""

GAIN: Final = 0.002
"""Share of what is to be made small that a step must take away for another one to follow."""

SLIDE: Final = (0.1, 0.25, 16.0, 100.0)
"""First weight of a step along the image against a deviation across it, what it is
multiplied by where a step makes it better and where it makes it worse, and where the search
is given up."""

DAMPING: Final = 1e-3
"""Damping of the steps in all directions, as a share of the diagonal of the equations, where
the weight of a step along the image is 1."""

LEASH: Final = 0.1
"""Standard deviation of the first guess as a share of the length: it holds what no ink does."""

HELD: Final = 20
"""Places of a half that the first guess holds."""

PEN: Final = 1.2
"""Distance of the ink (rms, px) above which anything that brings the curve nearer is better:
it can be seen."""

SHAPE: Final = 1.5
"""Power of the number of control points by which the distance of the ink must fall for them
to explain shape."""

HIDDEN: Final = 2.0
"""How many times as large as what is left between ink and curve a hand's noise is at least:
it is slow, and a curve goes along with half of it."""

LOST: Final = 4.0
"""Distance (rms, px) above which the feet of the ink may be on the wrong branches."""


@dataclass(frozen=True, eq=False)
class Sight:
    """The ink of one curve in one view.

    Parameters
    ----------
    stereo : Stereo
    near : tuple of (n, 2) float
        Pieces of ink, px, that show the half that was drawn.
    far : tuple of (n, 2) float
        Those that show its mirror image.
    noise : float
        Standard deviation of the hand across the ink, px.
    """

    stereo: Stereo
    near: tuple[Array, ...]
    far: tuple[Array, ...] = ()
    noise: float = 0.0


@dataclass(frozen=True, eq=False)
class Bundled:
    """A curve, and how well the ink determines it.

    Attributes
    ----------
    curve : SpaceCurve
    rms : float
        Root mean square distance of the ink from the images of the curve, px.
    """

    curve: SpaceCurve
    rms: float
    _basis: SymmetricBasis = field(repr=False)
    _covariance: Array = field(repr=False)

    def sigma(self, parameters: ArrayLike) -> Array:
        """Standard deviation of the curve across itself, (n,) mm.

        From the covariance of the control points at the noise of the views. What moves a
        place along the curve is left out, it does not change the curve; at a free end it
        counts.

        Parameters
        ----------
        parameters : (n,) array_like
            Of `curve.spline`.
        """
        at = np.atleast_1d(np.asarray(parameters, float))
        values = self._basis.values(at)
        rows = [self._basis.rows(values, np.tile(axis, (len(at), 1))) for axis in np.eye(3)]
        stacked = np.stack(rows, axis=1)
        spread = np.einsum("naf,fg,nbg->nab", stacked, self._covariance, stacked)
        tangent = self.curve.spline.derivative(at)
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        unit = np.divide(tangent, length, out=np.zeros_like(tangent), where=length > 0)
        if not self._basis.periodic:
            low, high = self._basis.whole.range
            unit[(at <= low) | (at >= high)] = 0.0
        along = np.einsum("na,nab,nb->n", unit, spread, unit)
        across = np.trace(spread, axis1=1, axis2=2) - along
        return np.asarray(np.sqrt(np.maximum(across, 0.0)))


def bundled(
    reading: Reading,
    points: ArrayLike,
    covariances: ArrayLike,
    sights: Sequence[Sight],
    *,
    closed: bool = False,
    ring: bool = False,
    controls: Controls = "adaptive",
) -> Bundled:
    """Fit one symmetric spline to all ink of all views.

    Least squares of the distances of the ink across the image of the curve, each over the
    noise of its hand, with feet found anew at every step (Gauss–Newton, tangent distance
    minimisation; Wang, Pottmann & Liu 2006, section 3.3), and of the curve's third
    derivative, which decides only where the ink does not.

    Parameters
    ----------
    reading : {"pair", "self", "plane"}
    points : (k, 3) array_like
        Where the curve is, roughly, mm, in order: along the side that was drawn; of a curve
        across the plane along all of it, beginning with the half that was drawn first, or
        along that half from the plane outwards. Those that are not finite are left out.
    covariances : (k, 3, 3) array_like
        Of these places, mm².
    sights : sequence of Sight
    closed : bool
        The side that was drawn is closed.
    ring : bool
        The curve across the plane is closed.
    controls : {"adaptive", "seven"}
        Control points of a half. "adaptive" takes 7, then 3 more until the ink is within
        0.1 px (rms) or 0.7 times the noise of the hand, or more explain no shape.

    Returns
    -------
    Bundled

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
    most = MOST if controls == "adaptive" else FEWEST
    enough = max(ENOUGH, NOISE_FACTOR * min((sight.noise for sight in sights), default=0.0))

    made = best = _fitted(basis, place, spread, stations, sights)
    idle = 0
    while made.rms > enough and idle < 2 and made.problem.basis.count + MORE <= most:
        basis = SymmetricBasis(reading, made.problem.basis.count + MORE, pairwise, ring)
        if made.rms > LOST:
            made = _fitted(basis, place, spread, stations, sights)
        else:
            made = made.refined(basis)
        better = made.betters(best)
        best, idle = (made, 0) if better else (best, idle + 1)
    best = best.calmed()
    basis = best.problem.basis
    return Bundled(basis.curve(best.points), best.rms, basis, best.covariance())


def _shows_mirror_image(sights: Sequence[Sight], half: Array) -> bool:
    """Whether the ink of the half that was drawn first shows the other half of the points."""
    for sight in sights:
        for ink in sight.near:
            images = [sight.stereo.project(half * side) for side in (np.ones(3), MIRROR)]
            if all(np.isfinite(image).all() for image in images):
                own, other = (float(distances_to_polyline(ink, i).mean()) for i in images)
                return other < own
    return False


@dataclass(frozen=True, eq=False)
class _Problem:
    """What holds a curve beside the ink: rows that say ``matrix @ free = target``."""

    basis: SymmetricBasis
    matrix: Array
    target: Array

    @classmethod
    def of(cls, basis: SymmetricBasis, start: Array, inks: Sequence[Ink]) -> _Problem:
        low, high = basis.half
        at = np.linspace(low, high, HELD, endpoint=not basis.periodic)
        values = basis.values(at)
        length = length_of(basis.at(values, start))
        leash = [
            basis.rows(values, np.tile(axis, (len(at), 1))) / (LEASH * length) for axis in np.eye(3)
        ]
        free = start.ravel()[basis.free]
        rows = [np.vstack(leash)]
        targets = [rows[0] @ free]
        rows.append(basis.bending() / (ROUGHNESS * length))
        targets.append(np.zeros(len(rows[1])))
        for end in _loose_ends(basis, inks):
            row = _end_row(basis, start, end, inks[0])
            rows.append(row)
            targets.append(row @ free)
        return cls(basis, np.vstack(rows), np.concatenate(targets))


def _loose_ends(basis: SymmetricBasis, inks: Sequence[Ink]) -> list[float]:
    """Parameters of the ends of the half that no ink shows."""
    if basis.periodic:
        return []
    ends = basis.half[1:] if basis.reading == "self" else basis.half
    return [end for end in ends if not any((ink.feet[ink.held] == end).any() for ink in inks)]


def _end_row(basis: SymmetricBasis, start: Array, end: float, ink: Ink) -> Array:
    """An end stays where it is along the curve, as well as a hand could say."""
    values = basis.values([end])
    tangent = basis.at(basis.values([end], 1), start)
    slopes = image_slopes(ink.stereo, basis.at(values, start))[0]
    scale = float(np.linalg.norm(slopes)) / (END_NOISE * ink.noise)
    return basis.rows(values, tangent * scale / max(float(np.linalg.norm(tangent)), 1e-300))


@dataclass(frozen=True, eq=False)
class _Fit:
    """A curve on the way, with the feet of the ink on it."""

    problem: _Problem
    points: Array
    inks: tuple[Ink, ...]
    normal: Array
    sliding: Array
    right: Array
    cost: float
    rms: float

    @classmethod
    def at(cls, problem: _Problem, points: Array, inks: Sequence[Ink], steps: int = 1) -> _Fit:
        basis = problem.basis
        inks = tuple(ink.settled(basis, points, steps=steps) for ink in inks)
        rest = problem.target - problem.matrix @ points.ravel()[basis.free]
        normal = problem.matrix.T @ problem.matrix
        sliding = np.zeros_like(normal)
        right = problem.matrix.T @ rest
        cost, squares, count = float(rest @ rest), 0.0, 0
        for ink in inks:
            rows, off, along = _equations(ink, basis, points)
            normal += rows.T @ rows
            sliding += along.T @ along
            right += rows.T @ off
            cost += float(off @ off)
            distance = off[: len(ink.share)] * ink.noise / np.sqrt(ink.share)
            squares, count = squares + float(distance @ distance), count + len(distance)
        if not np.isfinite(cost):
            cost = np.inf
        return cls(problem, points, inks, normal, sliding, right, cost, (squares / count) ** 0.5)

    def stepped(self, slide: float) -> _Fit:
        """After one damped Gauss–Newton step."""
        damping = self.sliding + DAMPING * np.diag(np.diag(self.normal))
        step = np.asarray(np.linalg.solve(self.normal + slide * damping, self.right))
        points = self.problem.basis.moved(self.points, step)
        return _Fit.at(self.problem, points, self.inks)

    def settled(self) -> _Fit:
        """The best curve in steps from this one."""
        fit = self
        slide, better, worse, most = SLIDE
        for _ in range(ROUNDS):
            tried = fit.stepped(slide)
            gain = fit.cost - tried.cost
            if gain >= 0.0:
                fit, slide = tried, slide * better
                if gain < GAIN * fit.cost:
                    break
            else:
                slide *= worse
                if slide > most:
                    break
        return fit

    def refined(self, basis: SymmetricBasis) -> _Fit:
        """The best curve with more control points, from nearly the same curve."""
        old = self.problem.basis
        stations = np.linspace(0.0, 1.0, 4 * basis.count, endpoint=not basis.closed)
        low, high = basis.half
        places = old.at(old.values(low + (high - low) * stations), self.points)
        start = approximated(basis, places, np.zeros((len(places), 3, 3)), stations)
        problem = _Problem.of(basis, start, self.inks)
        return _Fit.at(problem, start, self.inks, steps=0).settled()

    def betters(self, other: _Fit) -> bool:
        """Whether it explains the ink better by more than its control points could anyhow.

        Shape that was missing falls by the fourth power of their number, a corner by the
        first and a half; what a slow hand adds falls no faster than the number rises.
        """
        count, before = self.problem.basis.count, other.problem.basis.count
        return self.rms < other.rms * (1.0 if other.rms > PEN else (before / count) ** SHAPE)

    def calmed(self) -> _Fit:
        """The same with the noise of the hands as large as the curve shows it to be."""
        level = HIDDEN * self.rms
        if all(ink.noise >= level for ink in self.inks):
            return self
        inks = [replace(ink, noise=max(ink.noise, level)) for ink in self.inks]
        return _Fit.at(self.problem, self.points, inks, steps=0).settled()

    def covariance(self) -> Array:
        """Of the free coordinates, mm²: what a hand's noise along the ink does to them."""
        basis = self.problem.basis
        inner = self.problem.matrix.T @ self.problem.matrix
        for ink in self.inks:
            rows, _, _ = _equations(ink, basis, self.points)
            count = len(ink.share)
            ends, rows = rows[count:], rows[:count] * np.sqrt(ink.share)[:, None]
            gap = ink.along[:, None] - ink.along
            alike = np.exp(-((gap / (2.0 * ink.tremor)) ** 2)) * (ink.piece[:, None] == ink.piece)
            inner += rows.T @ alike @ rows + ends.T @ ends
        inverse = np.linalg.inv(self.normal)
        return np.asarray(inverse @ inner @ inverse)


def _equations(ink: Ink, basis: SymmetricBasis, points: Array) -> tuple[Array, Array, Array]:
    """Rows and right side of one view: across the ink, and along it at the ends it shows.

    Third are rows that say how far a step goes along the ink.
    """
    off = ink.deviation(basis, points)
    scale = np.sqrt(ink.share) / ink.noise
    across = np.einsum("ni,nij->nj", off.normal * scale[:, None], off.slopes)
    along = np.einsum("ni,nij->nj", off.along * scale[:, None], off.slopes)
    held = ink.held
    tips = off.along[held] / (END_NOISE * ink.noise)
    ends = np.einsum("ni,nij->nj", tips, off.slopes[held])
    rows = np.vstack((basis.rows(off.values, across), basis.rows(off.values[held], ends)))
    rest = np.concatenate((off.across * scale, (off.offset[held] * tips).sum(axis=1)))
    return rows, rest, basis.rows(off.values, along)


def _fitted(
    basis: SymmetricBasis,
    points: Array,
    covariances: Array,
    stations: Array,
    sights: Sequence[Sight],
) -> _Fit:
    """The best curve with one number of control points, from places in space."""
    start = approximated(basis, points, covariances, stations)
    inks = _matched(sights, basis, start)
    return _Fit.at(_Problem.of(basis, start, inks), start, inks, steps=0).settled()


def _matched(sights: Sequence[Sight], basis: SymmetricBasis, points: Array) -> tuple[Ink, ...]:
    """The ink of the views, matched to a curve."""
    inks = [
        inked(sight.stereo, sight.near, sight.far, sight.noise, basis, points) for sight in sights
    ]
    found = tuple(ink for ink in inks if ink is not None)
    if not found:
        raise UserError("No ink shows this curve. Draw it again.")
    return found
