"""One estimate of a curve from those of several views.

Every view knows a curve well in some directions and badly in others. Their places are
matched along the curve, where they contradict one another least for what each
claims to know, and combined by their inverse covariances: the mean that has the least
variance (Gauss; Aitken 1935).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink import ordered_feet
from bozzetto_symmetry.fitting.initial_guess import trusted_steps
from bozzetto_symmetry.ink.polyline import interpolate

PLACES: Final = 100
"""Places along a curve at which estimates are combined."""

NODES: Final = 300
"""Places of the other estimate among which the partner of a place is looked for."""

KNOWN: Final = 1e-4
"""Standard deviation, as a share of the curve's size, that every estimate has at least."""

BLIND: Final = 0.2
"""Standard deviation, as a share of the curve's size, above which a place says nothing."""

LEAST_DOUBT: Final = 1e-3
"""Variance in the best known direction, as a share of that in all, with which places are
brought together."""

WORTH: Final = 8.0
"""How many times as uncertain as the best one an estimate may be: beyond it could add next to
nothing, and a wrong partner could take much away."""

LIKELY: Final = 9.0
"""Squared distance between two places, in standard deviations, up to which they agree. The
one from the worse view then counts less in proportion: it is a wrong partner, or a view
that is worse than it claims."""

TAIL: Final = 0.05
"""Share of an estimate beyond the end of the best one that extends it: less is the
uncertainty of where that end belongs. The added part must be known to this share of its size."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Places of a curve with their covariances, as one view gives them.

    Parameters
    ----------
    points : (k, 3) float
        In order along the curve, mm.
    covariances : (k, 3, 3) float
        mm².
    """

    points: Array
    covariances: Array


def fuse(estimates: Sequence[Estimate], *, closed: bool = False) -> Estimate:
    """Combine estimates of the same curve, each from a view of its own.

    They may run in different senses, begin at different places of a closed curve, and cover
    different parts of it. The result runs like the best of them, and is extended where
    another one knows more of the curve. Where estimates contradict one another by more than their
    covariances allow, those of the result grow by the same factor (Birge 1932).

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
        if other is best or _trouble(other) > WORTH**2 * _trouble(best):
            continue
        partners, has, beyond = _partners(whole, _resampled(other, NODES, closed), closed)
        apart = partners.points - whole.points
        doubt = np.linalg.inv(partners.covariances + whole.covariances)
        odds = np.einsum("ni,nij,nj->n", apart, doubt, apart)
        misfit += float(odds[has].sum())
        shared += int(has.sum())
        trust = has / np.maximum(1.0, odds / LIKELY)
        more = trust[:, None, None] * np.linalg.inv(partners.covariances)
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
    """Return the finite places, with covariances that can be inverted.

    A place that may be anywhere along a ray can lie far away from the curve. It is put on the
    chain of the others instead, and known badly in all directions.
    """
    finite = np.isfinite(estimate.points).all(axis=1)
    finite &= np.isfinite(estimate.covariances).all(axis=(1, 2))
    points, covariances = estimate.points[finite], estimate.covariances[finite]
    if len(points) < 2:
        return Estimate(points, covariances)
    size = float(np.ptp(np.quantile(points, (0.1, 0.9), axis=0), axis=0).max())
    covariances = covariances + (KNOWN * size) ** 2 * np.eye(3)
    blind = np.trace(covariances, axis1=1, axis2=2) > (BLIND * size) ** 2
    if 1 < blind.sum() + 1 < len(blind):
        at = np.arange(len(points))
        seen = at[~blind]
        chain = interpolate(at, seen, points[seen])
        points = np.where(blind[:, None], chain, points)
        covariances = covariances + blind[:, None, None] * (BLIND * size) ** 2 * np.eye(3)
    return Estimate(points, covariances)


def _typical(estimate: Estimate) -> Array:
    """Return a covariance of the median size and the mean shape, (3, 3) mm²."""
    sizes = np.trace(estimate.covariances, axis1=1, axis2=2)
    shapes = estimate.covariances / sizes[:, None, None]
    return np.asarray(shapes.mean(axis=0) * float(np.median(sizes)))


def _trouble(estimate: Estimate) -> float:
    """Return the median variance, mm²."""
    return float(np.median(np.trace(estimate.covariances, axis1=1, axis2=2)))


def _resampled(estimate: Estimate, count: int, closed: bool) -> Estimate:
    """Return an estimate at places that are evenly spaced by trusted steps."""
    points, covariances = estimate.points, estimate.covariances
    steps = trusted_steps(points, covariances, closed=closed)
    along = np.concatenate(([0.0], np.cumsum(steps)))
    at = np.linspace(0.0, along[-1], count, endpoint=not closed)
    columns = np.hstack((points, covariances.reshape(-1, 9)))
    columns = np.vstack((columns, columns[:1])) if closed else columns
    made = interpolate(at, along, columns)
    return Estimate(made[:, :3], made[:, 3:].reshape(-1, 3, 3))


def _partners(
    whole: Estimate, other: Estimate, closed: bool
) -> tuple[Estimate, Flags, tuple[Estimate, Estimate]]:
    """Return what another estimate says about the places of one.

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
    partners = _between(other, chosen % len(nodes), rows, nodes, closed)
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
    first, last = (tail if _leads_on(tail, other) else _none() for tail in tails)
    return partners, has, (first, last)


def _leads_on(tail: Estimate, other: Estimate) -> bool:
    """Return whether a stretch is long enough, and known well enough, to be more of the curve."""
    if len(tail.points) < TAIL * len(other.points):
        return False
    return _trouble(tail) < (TAIL * float(np.ptp(other.points, axis=0).max())) ** 2


def _between(other: Estimate, chosen: Index, rows: Array, nodes: Array, closed: bool) -> Estimate:
    """Return an estimate where it is nearest to the rows, up to half a node from the chosen."""
    count = len(nodes)
    ahead, behind = chosen + 1, chosen - 1
    if closed:
        ahead, behind = ahead % count, behind % count
    else:
        ahead, behind = np.minimum(ahead, count - 1), np.maximum(behind, 0)
    way = 0.5 * (nodes[ahead] - nodes[behind])
    squared = (way**2).sum(axis=1)
    share = np.zeros(len(rows))
    np.divide(((rows - nodes[chosen]) * way).sum(axis=1), squared, out=share, where=squared > 0)
    share = np.clip(share, -0.5, 0.5)
    beside = np.where(share < 0.0, behind, ahead)
    share = np.abs(share)
    points, spread = other.points, other.covariances
    return Estimate(
        points[chosen] + share[:, None] * (points[beside] - points[chosen]),
        spread[chosen] + share[:, None, None] * (spread[beside] - spread[chosen]),
    )
