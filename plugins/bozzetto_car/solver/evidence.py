"""The probability of marks for cars and hands of a kind.

If a car differs by a share t of what a cost expects and the hand is s times as unsteady, the marks
lie about their places in the template, to first order, with the covariance

    C = s² (I + b² K) + t² A Σ Aᵀ ,

where A is their derivative by the car, Σ the covariance of cars, K the correlation of what the hand
bends (`hand`), and b by how much more it bends than it trembles; the unknown motions of the cameras
have been projected out (restricted maximum likelihood: Patterson & Thompson 1971). One symmetric
eigenvalue problem serves every t and s. How probable all marks are together needs less: the matrix
is made tridiagonal by reflections that bring the residuals to the first axis, and one sweep up the
three diagonals gives the determinant and the first entry of the inverse for every t and s (Golub &
Van Loan, *Matrix Computations*, sections 4.3.6 and 8.3.1). From C⁻¹ follows how probable a mark is
given the others (Sundararajan & Keerthi, *Predictive approaches for choosing hyperparameters in
Gaussian processes*, 2001).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.plugin import cached_property
from bozzetto_car.camera.marked_view import MarkedView, Reprojection
from bozzetto_car.solver.hand import bend_correlation
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.template.model import Template

SPREADS: Final = np.geomspace(0.03, 1.5, 12)
"""Shares t of the deviations that the cost expects."""

STEADY: Final = 1.6
"""Factor by which hands differ (the scale of the logarithm)."""

USUAL: Final = (0.5, 2.5)
"""Median of these shares, and the factor by which they differ (one standard deviation of the
logarithm): who draws a car seldom draws the template."""

HANDS: Final = np.geomspace(0.7, 10.0, 9)
"""Factors s by which a hand is less steady than the cost assumes. Less than the least counts as
exact: nobody wants to hear that a mark disagrees by 5 px."""

DETERMINED: Final = 1e-12
"""Least determinant of a mark's block, of 1: below, the mark alone determines the camera."""

UNDETERMINED: Final = 1e-9
"""Least size of a motion of the camera, of the greatest, that counts."""

USUAL_BEND: Final = (10.0, 1.35)
"""Median of what a hand that bends a drawing bends it by, in steady standard deviations of a mark
(2 % of the diagonal of the marks), and the factor by which such hands differ. A bend is a matter of
the eye and does not grow with the tremor of the pen."""

_GRID: Final = tuple(grid.ravel() for grid in np.meshgrid(SPREADS, HANDS))
"""All pairs of a spread and a hand."""

_LOGS: Final = np.log(_GRID)
"""Their logarithms, (2, g)."""

_RATIO: Final = (_GRID[0] / _GRID[1]) ** 2
"""Squares of their ratios."""

KNOWN: Final = 64
"""Number of pairs of a template and a cost whose factors are remembered."""

SKETCHES: Final = 32
"""Number of answers on single sketches that are remembered: while a mark is dragged, the other
sketches stay what they were."""

TOGETHER: Final = 8
"""Factors that are multiplied before the logarithm is taken of them. They are 1 at least, and as
large as the squares of distances in standard deviations of a hand."""


@dataclass(frozen=True, eq=False)
class LinearSketch:
    """A sketch to first order about the template, in standard deviations of the hand.

    Attributes
    ----------
    missed : (k, 2) float
    by_car : (k, 2, q) float
        Derivative by the variables of the car.
    by_camera : (k, 2, c) float
    together : (k, k) float
        Correlation of what the hand bends.
    """

    missed: Array
    by_car: Array
    by_camera: Array
    together: Array


@lru_cache(maxsize=SKETCHES)
def linear_sketch(template: Template, view: MarkedView, hand: float) -> LinearSketch:
    """Return a sketch to first order about the template.

    Parameters
    ----------
    template : Template
        The template of the car.
    view : MarkedView
        The sketch, with a camera that has all marked nodes in front of it.
    hand : float
        Standard deviation of a mark, in diagonals of the marks.
    """
    sight, pose = Reprojection.of(template, view, held=False)
    seen = sight.residuals(pose, template.positions)
    if seen is None:
        raise ValueError("a marked node is not before its camera")
    follow = template.basis.reshape(len(template.names), 3, -1)
    by_car = seen.by_nodes @ follow[view.nodes]
    return LinearSketch(
        seen.missed / hand, by_car / hand, seen.by_camera / hand, bend_correlation(sight)
    )


@lru_cache(maxsize=KNOWN)
def _factor(template: Template, cost: Cost) -> Array:
    """Return F (q, q) with the covariance F Fᵀ of the variables of a car, mm²."""
    prior = Prior(template, cost)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(prior.form(prior.variables))).T)


@dataclass(frozen=True, eq=False)
class Independent:
    """A sketch whose marks are made independent, and without the motions of its camera.

    Attributes
    ----------
    missed : (2 k,) float
    by_car : (2 k, q) float
    back : (2 k, 2 k) float
        What turns numbers of marks into such.
    rank : int
        Dimensions that are left.
    log_size : float
        Logarithm of the root of the determinant of the covariance of the hand, without the camera.
    """

    missed: Array
    by_car: Array
    back: Array
    rank: int
    log_size: float


def independent(sketch: LinearSketch, bend: float, counted: Flags) -> Independent:
    """Return the marks of a sketch that count, made independent.

    Parameters
    ----------
    sketch : LinearSketch
        The sketch.
    bend : float
        By how much more the hand bends than it trembles.
    counted : (k,) bool
        Which marks count.
    """
    return _independent(sketch, bend, counted.tobytes())


@lru_cache(maxsize=SKETCHES)
def _independent(sketch: LinearSketch, bend: float, flags: bytes) -> Independent:
    counted = np.frombuffer(flags, bool)
    by_camera = _tall(sketch.by_camera[counted])
    white: Array = np.eye(len(by_camera))
    log_size = 0.0
    if bend > 0.0:
        together = sketch.together[np.ix_(counted, counted)]
        lower = np.linalg.cholesky(np.eye(len(together)) + bend**2 * together)
        white = np.asarray(np.kron(np.linalg.inv(lower), np.eye(2)))
        log_size = 2.0 * float(np.log(np.diag(lower)).sum())
        bent = white @ by_camera
        log_size += _log_extent(bent) - _log_extent(by_camera)
        by_camera = bent
    base, _ = np.linalg.qr(by_camera)
    back = white - base @ (base.T @ white)
    return Independent(
        back @ sketch.missed[counted].ravel(),
        back @ _tall(sketch.by_car[counted]),
        back,
        base.shape[0] - base.shape[1],
        log_size,
    )


@dataclass(frozen=True, eq=False)
class Factored:
    """Marks of sketches with the covariance of cars of a kind taken apart.

    Attributes
    ----------
    sketches : tuple of Independent
        The marks that count.
    bend : float
        By how much more the hand bends than it trembles, which they were made independent with.
    missed : (m,) float
        Of all sketches together.
    sizes : (r,) float
        The eigenvalues of A Σ Aᵀ.
    by_car : (m, r) float
        The eigenvectors, each times the root of its eigenvalue.
    """

    sketches: tuple[Independent, ...]
    bend: float
    missed: Array
    sizes: Array
    by_car: Array

    @classmethod
    def of(
        cls, template: Template, cost: Cost, sketches: Sequence[Independent], bend: float
    ) -> Factored:
        """Take apart the covariance of cars that differ from a template as a cost says."""
        missed = np.concatenate([sketch.missed for sketch in sketches])
        by_car = np.vstack([sketch.by_car for sketch in sketches]) @ _factor(template, cost)
        return cls(tuple(sketches), bend, missed, *_along_principal_axes(by_car))


@dataclass(frozen=True, eq=False)
class Pulls:
    """Evidence of a sketch on the variables of a car, along the factors of several kinds of cars.

    Attributes
    ----------
    squares : (c, q, q) float
        (A F)ᵀ (A F) of each factor F, with the marks made independent.
    slopes : (c, q) float
        The product of A F with the residuals.
    misfit : float
        The square of the residuals.
    """

    squares: Array
    slopes: Array
    misfit: float


@lru_cache(maxsize=SKETCHES)
def pulls(template: Template, costs: tuple[Cost, ...], sketch: Independent) -> Pulls:
    """Return what a sketch says of a car of a template, for each cost."""
    count = len(template.variables)
    along = sketch.by_car @ _side_by_side(template, costs)
    apart = along.reshape(len(along), len(costs), count).transpose(1, 0, 2)
    squares = np.stack([rows.T @ rows for rows in apart])
    slopes = (along.T @ sketch.missed).reshape(len(costs), count)
    return Pulls(squares, slopes, float(sketch.missed @ sketch.missed))


@lru_cache(maxsize=KNOWN)
def _side_by_side(template: Template, costs: tuple[Cost, ...]) -> Array:
    return np.hstack([_factor(template, cost) for cost in costs])


@lru_cache
def _expected(bend: float, anyone: bool) -> Array:
    """Return the logarithms of the probability of every pair of a spread and a hand, (g,)."""
    spreads, hands = _LOGS
    apart = (hands / np.log(STEADY)) ** 2
    logs = -np.log1p(apart) if anyone else -0.5 * apart
    logs -= 0.5 * ((spreads - np.log(USUAL[0])) / np.log(USUAL[1])) ** 2
    if bend > 0.0:
        bent = (np.log(bend / USUAL_BEND[0]) + hands) / np.log(USUAL_BEND[1])
        logs -= 0.5 * bent**2
    return np.asarray(logs)


class Evidence:
    """The probability of the marks of sketches, for all spreads and hands together.

    Parameters
    ----------
    sketches : sequence of Independent
        The marks that count.
    bend : float
        By how much more the hand bends than it trembles, which they were made independent with.
    sizes, misfits : (g,) float
        At each pair of a spread and a hand, the logarithm of the determinant of C / s², and the
        square of the residuals in standard deviations of C / s².
    anyone : bool
        Whether the hand may be anyone's, with heavy tails (Cauchy's distribution of the logarithm),
        so that a very unsteady one is told. With light tails (Gauss') a mistake in one mark is
        likelier than a hand that is unsteady in all.

    Attributes
    ----------
    total : float
        Natural logarithm of the probability of all marks, up to a constant that depends only on
        their number.
    log_spread, log_hand : float
        Means of the logarithms of t and s.
    """

    def __init__(
        self,
        sketches: Sequence[Independent],
        bend: float,
        sizes: Array,
        misfits: Array,
        anyone: bool,
    ) -> None:
        rank = sum(sketch.rank for sketch in sketches)
        known = rank * _LOGS[1] + sum(sketch.log_size for sketch in sketches)
        logs: Array = _expected(bend, anyone) - known - 0.5 * (sizes + misfits / _GRID[1] ** 2)
        self.total = float(log_of_sum(logs))
        self._logs = logs - self.total
        self.log_spread, self.log_hand = (_LOGS @ np.exp(self._logs)).tolist()

    @property
    def spread(self) -> float:
        """How far the car is from the template, as a share of what the cost expects."""
        return float(np.exp(self.log_spread))


class MarkEvidence(Evidence):
    """The same, which also tells how probable each mark is given the others.

    Parameters
    ----------
    factored : Factored
        The marks, and how cars differ from the template.
    anyone : bool
        See `Evidence`.
    """

    def __init__(self, factored: Factored, anyone: bool) -> None:
        sizes = factored.sizes
        self._sketches = factored.sketches
        self._missed, self._by_car = factored.missed, factored.by_car
        self._pulled = self._by_car.T @ self._missed
        self._damped = _RATIO / (1.0 + sizes[:, None] * _RATIO)
        misfits = self._missed @ self._missed - self._pulled**2 @ self._damped
        wide = np.log1p(sizes[:, None] * _RATIO).sum(axis=0)
        super().__init__(factored.sketches, factored.bend, wide, misfits, anyone)

    @cached_property
    def improbable(self) -> list[Array]:
        """For each sketch, the gain in probability of the rest without each mark, (k,)."""
        _, hands = _GRID
        ends = np.cumsum([len(sketch.missed) for sketch in self._sketches])[:-1]
        backs = [sketch.back for sketch in self._sketches]
        # The inverse of C, times s²: its 2 × 2 blocks for each mark, and its product with the
        # residuals, of the marks as they were before they were made independent.
        follow = np.vstack(
            [back.T @ part for back, part in zip(backs, np.split(self._by_car, ends), strict=True)]
        )
        missed = np.concatenate(
            [back.T @ part for back, part in zip(backs, np.split(self._missed, ends), strict=True)]
        )
        blocks = np.concatenate([_blocks(back) for back in backs])
        across, down = follow[::2], follow[1::2]
        xx = blocks[:, 0, :1] - across**2 @ self._damped
        yy = blocks[:, 1, 1:] - down**2 @ self._damped
        xy = blocks[:, 0, 1:] - (across * down) @ self._damped
        left = missed[:, None] - follow @ (self._damped * self._pulled[:, None])
        x, y = left[::2], left[1::2]
        size = np.maximum(xx * yy - xy**2, DETERMINED)
        squared = (yy * x**2 - 2.0 * xy * x * y + xx * y**2) / size / hands**2
        alone = 0.5 * np.log(size) - 2.0 * np.log(hands) - np.log(2.0 * np.pi)
        return np.split(log_of_sum(self._logs - alone + 0.5 * squared), ends // 2)


def of_all_kinds(
    template: Template, costs: tuple[Cost, ...], sketches: Sequence[Independent]
) -> tuple[Array, Array]:
    """Return the sizes and the misfits of `Evidence` for several kinds of cars, (c, g) each.

    Parameters
    ----------
    template : Template
        The template of the car.
    costs : tuple of Cost
        How cars of each kind differ from it.
    sketches : sequence of Independent
        The marks that count.
    """
    found = [pulls(template, costs, sketch) for sketch in sketches]
    squares, slopes = (
        np.sum([getattr(one, name) for one in found], axis=0) for name in ("squares", "slopes")
    )
    sizes, corners = _swept(squares, slopes)
    return sizes, sum(one.misfit for one in found) - _RATIO * corners


def _swept(squares: Array, slopes: Array) -> tuple[Array, Array]:
    """Return log det(I + x G) and bᵀ (I + x G)⁻¹ b for every ratio x of t² to s², (c, g) each.

    Parameters
    ----------
    squares : (c, q, q) float
        Each G.
    slopes : (c, q) float
        Each b.
    """
    from scipy.linalg import lapack

    count, size = slopes.shape
    edged = np.zeros((size + 1, size + 1), order="F")
    diagonals, beside = np.empty((size + 1, count, 1)), np.empty((size, count, 1))
    for number, (square, slope) in enumerate(zip(squares, slopes, strict=True)):
        # With b along the border, the reflections bring it to the first axis.
        edged[1:, 1:], edged[1:, 0] = square, slope
        _, diagonals[:, number, 0], beside[:, number, 0], _, _ = lapack.dsytrd(edged, lower=1)
    steps = diagonals[1:] * _RATIO
    steps += 1.0
    across = beside[1:] * _RATIO
    across *= across
    for row in range(size - 2, -1, -1):
        steps[row] -= across[row] / steps[row + 1]
    whole = np.log(np.multiply.reduceat(steps, np.arange(0, size, TOGETHER), axis=0)).sum(axis=0)
    return whole, beside[0] ** 2 / steps[0]


def log_of_sum(logs: Array) -> Array:
    """Return the logarithm of the sum of exponentials along the last axis."""
    top = logs.max(axis=-1, keepdims=True)
    return np.asarray(np.log(np.exp(logs - top).sum(axis=-1)) + top[..., 0])


def _blocks(back: Array) -> Array:
    """Return the 2 × 2 blocks (k, 2, 2) of Bᵀ B on its diagonal, one for each mark."""
    columns = back.reshape(len(back), -1, 2)
    return np.asarray(np.einsum("mki,mkj->kij", columns, columns))


def _along_principal_axes(rows: Array) -> tuple[Array, Array]:
    """Return P (m, r) with orthogonal columns and P Pᵀ = R Rᵀ, for R (m, q); their squares first.

    The smaller one of both Gram matrices is taken apart.
    """
    count, unknowns = rows.shape
    if count > unknowns:
        sizes, axes = np.linalg.eigh(rows.T @ rows)
        return np.maximum(sizes, 0.0), rows @ axes
    sizes, axes = np.linalg.eigh(rows @ rows.T)
    sizes = np.maximum(sizes, 0.0)
    return sizes, axes * np.sqrt(sizes)


def _log_extent(columns: Array) -> float:
    """Return half the logarithm of the determinant of AᵀA, without what is not determined."""
    sizes = np.linalg.svd(columns, compute_uv=False)
    return float(np.log(np.maximum(sizes, UNDETERMINED * sizes[0])).sum())


def _tall(pairs: Array) -> Array:
    """Return two rows for each mark, (2 k, n), from (k, 2, n)."""
    return pairs.reshape(-1, pairs.shape[2])
