"""The equations of a symmetric curve against its ink, and the steps that solve them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.fitting.initial_guess import ROUGHNESS, approximate, chord_length
from bozzetto_symmetry.fitting.reprojection import END_NOISE, Ink
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.stereo.bowed_plane import BowedPlane
from bozzetto_symmetry.stereo.uncertainty import image_slopes

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
"""Standard deviation of the first guess as a share of the length: it holds places without ink."""

HELD: Final = 20
"""Places of a half that the first guess holds."""

FLAT: Final = 1e-5
"""Standard deviation of a curve from the planes in which it lies, as a share of the length."""

NO_PLANES: Final = np.zeros((0, 4))

PEN: Final = 1.2
"""Distance of the ink (rms, px) above which anything that brings the curve nearer is better:
the distance is visible."""

SHAPE: Final = 1.5
"""Power of the number of control points by which the distance of the ink must fall for them
to explain shape."""

HIDDEN: Final = 2.0
"""How many times as large as what is left between ink and curve a hand's noise is at least:
it is slow, and a curve follows half of it."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Terms that hold a curve besides the ink.

    Attributes
    ----------
    basis : SymmetricBasis
    matrix : (rows, free) float
    target : (rows,) float
        Each row wants ``matrix @ free = target``, in standard deviations.
    planes : (k, 4) float
        In which the curve lies.
    surface : BowedPlane or None
        On which it lies.
    roughness : float
        Third derivative (rms) that the curve may well have, by a parameter from 0 to 1, in lengths.
    """

    basis: SymmetricBasis
    matrix: Array
    target: Array
    planes: Array = field(default_factory=lambda: NO_PLANES)
    roughness: float = ROUGHNESS
    surface: BowedPlane | None = None

    @classmethod
    def of(
        cls,
        basis: SymmetricBasis,
        start: Array,
        inks: Sequence[Ink],
        planes: Array = NO_PLANES,
        roughness: float = ROUGHNESS,
        surface: BowedPlane | None = None,
    ) -> Problem:
        """Return rows of smoothness, of the first guess (count, 3) mm, and of ends without ink.

        Planes (k, 4), rows (n, d) with ``n · X = d``, hold the whole curve, and so does a bowed
        plane, by its tangent planes at the places of the first guess.
        """
        low, high = basis.half
        at = np.linspace(low, high, HELD, endpoint=not basis.periodic)
        values = basis.values(at)
        length = chord_length(basis.at(values, start))
        leash = [
            basis.rows(values, np.tile(axis, (len(at), 1))) / (LEASH * length) for axis in np.eye(3)
        ]
        free = start.ravel()[basis.free]
        rows = [np.vstack(leash)]
        targets = [rows[0] @ free]
        rows.append(basis.bending() / (roughness * length))
        targets.append(np.zeros(len(rows[1])))
        for end in _loose_ends(basis, inks):
            row = _end_row(basis, start, end, inks[0])
            rows.append(row)
            targets.append(row @ free)
        for plane in planes:
            rows.append(basis.rows(values, np.tile(plane[:3], (len(at), 1))) / (FLAT * length))
            targets.append(np.full(len(at), plane[3]) / (FLAT * length))
        if surface is not None:
            places = basis.at(values, start)
            ways = surface.gradients(places) / (FLAT * length)
            rows.append(basis.rows(values, ways))
            heights = surface.heights(places) / (FLAT * length)
            targets.append((ways * places).sum(axis=1) - heights)
        return cls(basis, np.vstack(rows), np.concatenate(targets), planes, roughness, surface)


def _loose_ends(basis: SymmetricBasis, inks: Sequence[Ink]) -> list[float]:
    """Return the parameters of the ends of the half that no ink shows."""
    if basis.periodic:
        return []
    ends = basis.half[1:] if basis.reading == "self" else basis.half
    return [end for end in ends if not any((ink.parameters[ink.held] == end).any() for ink in inks)]


def _end_row(basis: SymmetricBasis, start: Array, end: float, ink: Ink) -> Array:
    """Return the row that holds an end along the curve, as well as a hand could place it."""
    values = basis.values([end])
    tangent = basis.at(basis.values([end], 1), start)
    slopes = image_slopes(ink.stereo, basis.at(values, start))[0]
    scale = float(np.linalg.norm(slopes)) / (END_NOISE * ink.noise)
    return basis.rows(values, tangent * scale / max(float(np.linalg.norm(tangent)), 1e-300))


@dataclass(frozen=True, eq=False)
class Fit:
    """A curve during the fit, with the closest points of the ink on it.

    Attributes
    ----------
    problem : Problem
    points : (count, 3) float
        Control points of the half, mm.
    inks : tuple of Ink
        One for each view.
    normal, sliding : (free, free) float
        Normal equations, and those of steps along the ink alone.
    right : (free,) float
    cost : float
        Sum of all squared deviations, in standard deviations; infinite where ink shows
        nothing that the eye could see.
    rms : float
        Distance of the ink across the images of the curve, px.
    """

    problem: Problem
    points: Array
    inks: tuple[Ink, ...]
    normal: Array
    sliding: Array
    right: Array
    cost: float
    rms: float

    @classmethod
    def at(cls, problem: Problem, points: Array, inks: Sequence[Ink], steps: int = 1) -> Fit:
        """Return the equations at a curve, after some steps of the closest points towards it."""
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

    def stepped(self, slide: float) -> Fit:
        """Return the fit after one damped Gauss–Newton step."""
        damping = self.sliding + DAMPING * np.diag(np.diag(self.normal))
        step = np.asarray(np.linalg.solve(self.normal + slide * damping, self.right))
        points = self.problem.basis.moved(self.points, step)
        return Fit.at(self.problem, points, self.inks)

    def settled(self) -> Fit:
        """Return the best curve that steps from this one reach."""
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

    def refined(self, basis: SymmetricBasis) -> Fit:
        """Return the best curve with more control points, starting from nearly this one."""
        old = self.problem.basis
        stations = np.linspace(0.0, 1.0, 4 * basis.count, endpoint=not basis.closed)
        low, high = basis.half
        places = old.at(old.values(low + (high - low) * stations), self.points)
        start = approximate(basis, places, np.zeros((len(places), 3, 3)), stations)
        before = self.problem
        problem = Problem.of(
            basis, start, self.inks, before.planes, before.roughness, before.surface
        )
        return Fit.at(problem, start, self.inks, steps=0).settled()

    def betters(self, other: Fit) -> bool:
        """Return whether this fit explains more shape than the other one.

        The distance of missing shape falls by the fourth power of the number of control points,
        that of a corner by the power 1.5; what a slow hand adds falls no faster than the first.
        """
        count, before = self.problem.basis.count, other.problem.basis.count
        return self.rms < other.rms * (1.0 if other.rms > PEN else (before / count) ** SHAPE)

    def calmed(self) -> Fit:
        """Return the fit with the noise of the hands as large as the curve shows it to be."""
        level = HIDDEN * self.rms
        if all(ink.noise >= level for ink in self.inks):
            return self
        inks = [replace(ink, noise=max(ink.noise, level)) for ink in self.inks]
        return Fit.at(self.problem, self.points, inks, steps=0).settled()


def _equations(ink: Ink, basis: SymmetricBasis, points: Array) -> tuple[Array, Array, Array]:
    """Return rows and right side of one view: across the ink, and along it at the ends it shows.

    Third are the rows of a step along the ink.
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
