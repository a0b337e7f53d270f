"""What several views say about one curve, in one.

Every view knows a curve well in some directions and badly in others. Their places are
brought together along the curve, where they contradict one another least for what each
claims to know, and combined by their inverse covariances: the mean that has the least
variance (Gauss; Aitken 1935).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.ink.ordered_feet import ordered_feet
from bozzetto_symmetry.starting import trusted_steps

__all__ = ["Estimate", "fused"]

Array = NDArray[np.float64]

PLACES: Final = 100
"""Places along a curve at which estimates are combined."""

NODES: Final = 300
"""Places of the other estimate among which the partner of a place is looked for."""

KNOWN: Final = 1e-4
"""Standard deviation, as a share of the curve's size, that every estimate has at least."""

LEAST_DOUBT: Final = 1e-3
"""Variance in the best known direction, as a share of that in all, with which places are
brought together."""

TAIL: Final = 0.05
"""Share of an estimate beyond the end of the best one that leads it on; less is the
uncertainty of where that end belongs."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What one view says about a curve.

    Parameters
    ----------
    points : (k, 3) float
        In order along the curve, mm.
    covariances : (k, 3, 3) float
        mm².
    """

    points: Array
    covariances: Array


def fused(estimates: Sequence[Estimate], *, closed: bool = False) -> Estimate:
    """Combine estimates of the same curve, each from a view of its own.

    They may run in different senses, begin at different places of a closed curve, and cover
    different parts of it. The result runs like the best of them, and is led on where another
    one knows more of the curve. Where estimates contradict one another by more than their
    covariances allow, those of the result are larger by as much (Birge 1932).

    Parameters
    ----------
    estimates : sequence of Estimate
        At least one; points that are not finite are left out.
    closed : bool
        The curve returns to its start; the first point is not repeated.

    Returns
    -------
    Estimate
        One that stands alone is given back as it is.
    """
    known = [finite for e in estimates if len((finite := _finite(e)).points) > 1]
    if len(estimates) == 1 or not known:
        return estimates[0]
    best = min(known, key=_trouble)
    whole = _resampled(best, PLACES, closed)
    information = np.linalg.inv(whole.covariances)
    weighted = np.einsum("nij,nj->ni", information, whole.points)
    misfit, shared = 0.0, 0
    tails = (_none(), _none())
    for other in known:
        if other is best:
            continue
        partners, has, beyond = _partners(whole, _resampled(other, NODES, closed), closed)
        apart = (partners.points - whole.points)[has]
        doubt = np.linalg.inv((partners.covariances + whole.covariances)[has])
        misfit += float(np.einsum("ni,nij,nj->", apart, doubt, apart))
        shared += int(has.sum())
        more = has[:, None, None] * np.linalg.inv(partners.covariances)
        information = information + more
        weighted = weighted + np.einsum("nij,nj->ni", more, partners.points)
        tails = (_longer(tails[0], beyond[0]), _longer(tails[1], beyond[1]))
    covariances = np.linalg.inv(information)
    points = np.einsum("nij,nj->ni", covariances, weighted)
    # Partners are looked for along the curve: two of three directions are left to differ.
    excess = max(1.0, misfit / (2.0 * shared)) if shared else 1.0
    parts = (tails[0], Estimate(points, covariances * excess), tails[1])
    return Estimate(
        np.vstack([part.points for part in parts]),
        np.concatenate([part.covariances for part in parts]),
    )


def _none() -> Estimate:
    return Estimate(np.zeros((0, 3)), np.zeros((0, 3, 3)))


def _longer(one: Estimate, other: Estimate) -> Estimate:
    return other if len(other.points) > len(one.points) else one


def _finite(estimate: Estimate) -> Estimate:
    """What is finite, with covariances that can be inverted."""
    known = np.isfinite(estimate.points).all(axis=1)
    known &= np.isfinite(estimate.covariances).all(axis=(1, 2))
    points = estimate.points[known]
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    return Estimate(points, estimate.covariances[known] + (KNOWN * size) ** 2 * np.eye(3))


def _typical(estimate: Estimate) -> Array:
    """A covariance of middling size in the directions that are middling, (3, 3) mm²."""
    sizes = np.trace(estimate.covariances, axis1=1, axis2=2)
    shapes = estimate.covariances / sizes[:, None, None]
    return np.asarray(shapes.mean(axis=0) * float(np.median(sizes)))


def _trouble(estimate: Estimate) -> float:
    """Median variance, mm²."""
    return float(np.median(np.trace(estimate.covariances, axis1=1, axis2=2)))


def _resampled(estimate: Estimate, count: int, closed: bool) -> Estimate:
    """At places that are evenly spaced by what is known of the steps between them."""
    points, covariances = estimate.points, estimate.covariances
    steps = trusted_steps(points, covariances, closed=closed)
    along = np.concatenate(([0.0], np.cumsum(steps)))
    at = np.linspace(0.0, along[-1], count, endpoint=not closed)
    columns = np.hstack((points, covariances.reshape(-1, 9)))
    columns = np.vstack((columns, columns[:1])) if closed else columns
    made = np.column_stack([np.interp(at, along, column) for column in columns.T])
    return Estimate(made[:, :3], made[:, 3:].reshape(-1, 3, 3))


def _partners(
    whole: Estimate, other: Estimate, closed: bool
) -> tuple[Estimate, NDArray[np.bool_], tuple[Estimate, Estimate]]:
    """What another estimate says about the places of one.

    Returns
    -------
    partners : Estimate
        As long as `whole`.
    has : (n,) bool
        Which places have a partner: not those beyond the ends of the other one.
    beyond : (Estimate, Estimate)
        What the other one knows before the first place and after the last.
    """
    # Distances count as the two estimates together doubt them, in the middle of the curve.
    doubt = _typical(whole) + _typical(other)
    whiten = np.linalg.cholesky(np.linalg.inv(doubt + np.trace(doubt) * LEAST_DOUBT * np.eye(3)))
    rows, nodes = whole.points @ whiten, other.points @ whiten
    steps = np.linalg.norm(np.diff(nodes, axis=0, append=nodes[:1]), axis=1)
    if not closed:
        steps[-1] = 0.0
    lengths = 0.5 * (steps + np.roll(steps, 1))
    step = float(np.linalg.norm(np.diff(rows, axis=0), axis=1).mean())
    chosen = ordered_feet(rows, step, nodes, lengths, closed=closed)
    at = chosen % len(nodes)
    partners = Estimate(other.points[at], other.covariances[at])
    has = np.ones(len(rows), bool)
    if closed:
        return partners, has, (_none(), _none())
    stays = np.diff(chosen) == 0
    ends = (chosen == 0) | (chosen == len(nodes) - 1)
    has[:-1] &= ~(stays & ends[:-1] & (np.arange(len(rows) - 1) < len(rows) // 2))
    has[1:] &= ~(stays & ends[1:] & (np.arange(1, len(rows)) >= len(rows) // 2))
    if chosen[0] > chosen[-1]:
        other = Estimate(other.points[::-1], other.covariances[::-1])
        chosen = len(nodes) - 1 - chosen
    before, after = slice(0, chosen[0]), slice(chosen[-1] + 1, None)
    tails = [Estimate(other.points[part], other.covariances[part]) for part in (before, after)]
    least = TAIL * len(nodes)
    first, last = (tail if len(tail.points) >= least else _none() for tail in tails)
    return partners, has, (first, last)
