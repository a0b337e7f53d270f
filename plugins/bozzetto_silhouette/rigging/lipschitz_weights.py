"""Weights whose slopes over the skin are nowhere so steep that a turn of a joint tears it.

With C the share of a vertex that follows a joint at p or one beyond it, no turn by the angle a
makes an edge e with the middle m longer than by s of its length if

    |ΔC| <= s |e| / (2 sin(a / 2) |m - p|) = d(e).

With d(e) for the length of an edge, and d(u, v) for that of the shortest way, these are the
Lipschitz functions with the bound 1. Below any function the largest of them is
min over u of C(u) + d(u, v), above it the smallest is max over u of C(u) - d(u, v); their mean is
one as well, and differs from C least (E. J. McShane, *Extension of range of functions*, 1934). All
joints together have to follow two more rules: what follows the joints that hang on one is no more
than what follows that one, and few joints have a share in a vertex. Either is had by lowering C at
some vertices; then the largest Lipschitz function below that is taken, in turn, until all is true.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Rig
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.rigging.skin_graph import SkinGraph, beyond

ROUNDS = 40
"""Turns at most; one to ten are usual."""

SLACK = 0.02
"""By how much steeper than it shall be the skin may stay: else small changes go on for long."""

SAME = 1e-9
"""Shares that differ by less are the same."""

LEAST = 1e-4
"""A share below this is passed on to the joint that its own hangs on."""


def lipschitz_weights(
    skin: SkinGraph,
    rig: Rig,
    shares: Array,
    stretch: float,
    most: int,
    checkpoint: Checkpoint = ignore,
) -> Array:
    """Return shares near to some by which no turn of a joint tears the skin.

    Parameters
    ----------
    skin : SkinGraph
        The skin at rest.
    rig : Rig
        At rest; parents before children.
    shares : (v, n) float array
        Of each joint; sum 1.
    stretch : float
        By how much of its length an edge may get longer.
    most : int
        Joints with a share in one vertex.
    checkpoint : callable
        Called with (fraction, step) between turns; may raise `Cancelled`.

    Returns
    -------
    (v, n) float array
        Sum 1.
    """
    slopes = [skin.steepest(place, (1.0 - SLACK) * stretch) for place in rig.joints]
    holders = _first_roots(skin, rig, shares)
    for root, first in enumerate(holders.tolist()):
        if first != root:  # what the first one moves is all that the others do not
            together = int(np.count_nonzero(holders == first)) - 1
            slopes[root] = np.minimum(slopes[root], slopes[first] / together)
    held = (rig.parents < 0) & (holders != np.arange(len(holders)))
    rig = replace(rig, parents=np.where(held, holders, rig.parents).astype(np.int32))
    moved = beyond(rig, shares)
    for joint, row in enumerate(moved):
        above = -_lowered(skin, -row, slopes[joint])
        moved[joint] = 0.5 * (above + _lowered(skin, row, slopes[joint]))
    found = shares.copy()
    changed = np.arange(len(shares))
    for _ in range(ROUNDS):
        checkpoint(1.0, "skin")
        few = _passed_on(rig, _own(rig, moved[:, changed]), most)
        found[changed] = few
        before = moved[:, changed]
        moved[:, changed] = beyond(rig, few)
        fresh = np.flatnonzero((moved[:, changed] != before).any(axis=1))
        lower = np.zeros(len(shares), bool)
        for joint in fresh.tolist():
            row = _lowered(skin, moved[joint], slopes[joint])
            lower |= row < moved[joint]
            moved[joint] = row
        changed = np.flatnonzero(lower)
        if not len(changed):
            break
    return found


def _first_roots(skin: SkinGraph, rig: Rig, shares: Array) -> Index:
    """Return for each joint (n,) the first of the roots with shares in the same skin; else itself.

    Two roots are in the same skin also if a third one is with either.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    roots = np.flatnonzero(rig.parents < 0)
    firsts = np.arange(len(rig.parents))
    if len(roots) < 2:
        return firsts
    count = len(shares)
    vertex, which = np.nonzero(beyond(rig, shares)[roots].T)
    a = np.concatenate([skin.a, vertex])
    b = np.concatenate([skin.b, count + which])
    size = count + len(roots)
    _, skins = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(size, size)))
    _, first, same = np.unique(skins[count:], return_index=True, return_inverse=True)
    firsts[roots] = roots[first[same.ravel()]]
    return firsts


def _lowered(skin: SkinGraph, values: Array, slopes: Array) -> Array:
    """Return the largest function below values (v,) that is nowhere steeper than slopes (e,).

    The values themselves where they are hardly steeper.
    """
    rise = values[skin.a] - values[skin.b]
    steep = np.flatnonzero(np.abs(rise) > slopes / (1.0 - SLACK))
    if not len(steep):
        return values
    steep = np.flatnonzero(np.abs(rise) > slopes + SAME)
    lower = np.zeros(len(values), bool)
    lower[np.where(rise > 0.0, skin.b, skin.a)[steep]] = True
    found = values.copy()
    while lower.any():
        ends, there, edges = skin.around(np.flatnonzero(lower))
        most = found[ends] + slopes[edges]
        less = most < found[there] - SAME
        there = there[less]
        np.minimum.at(found, there, most[less])
        lower[:] = False
        lower[there] = True
    return found


def _own(rig: Rig, moved: Array) -> Array:
    """Return the shares (n, v) of single joints; where too much lies beyond one, less does."""
    moved = moved.copy()
    for joint in range(len(moved)):
        hung = np.flatnonzero(rig.parents == joint)
        total = moved[hung].sum(axis=0)
        over = np.flatnonzero(total > moved[joint])
        moved[np.ix_(hung, over)] *= moved[joint, over] / total[over]
    roots = rig.parents < 0
    moved[roots] /= moved[roots].sum(axis=0)
    shares = moved.copy()
    for joint, parent in enumerate(rig.parents.tolist()):
        if parent >= 0:
            shares[parent] -= moved[joint]
    return np.maximum(shares, 0.0)


def _passed_on(rig: Rig, shares: Array, most: int) -> Array:
    """Pass shares (n, v) on to the joints that theirs hang on, until few are left; (v, n)."""
    found = shares.copy()
    for joint in range(len(found) - 1, 0, -1):
        parent = int(rig.parents[joint])
        if parent >= 0:
            slight = np.flatnonzero((found[joint] > 0.0) & (found[joint] < LEAST))
            found[parent, slight] += found[joint, slight]
            found[joint, slight] = 0.0
    many = np.flatnonzero(np.count_nonzero(found, axis=0) > most)
    while len(many):
        few = found[:, many]
        few[rig.parents < 0] += 2.0  # a root has nothing to pass its share on to
        few[few == 0.0] = np.inf
        least = few.argmin(axis=0)
        found[rig.parents[least], many] += found[least, many]
        found[least, many] = 0.0
        many = many[np.count_nonzero(found[:, many], axis=0) > most]
    return np.ascontiguousarray((found / found.sum(axis=0)).T)
