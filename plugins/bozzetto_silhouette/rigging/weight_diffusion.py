"""Weights that change gently: joints' shares diffuse over the skin where turning would tear it.

With C the share of a vertex that follows a joint or one beyond it, a turn by the angle a about
that joint at p stretches an edge e, in the worst direction, to at most

    1 + 2 sin(a / 2) |ΔC| |m - p| / |e|,

m being its middle. Where that is too much, shares diffuse (implicit steps of the heat equation on
the surface, after Baran and Popović, *Automatic rigging and animation of 3D characters*, 2007),
as far as it takes; elsewhere they stay what they were. The diffusion's matrix has no positive
entry beside its diagonal, so shares stay shares. On a fine skin clusters stand for its vertices.
What diffusion does not mend is held to slopes that do not tear (`lipschitz_weights`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Flags
from bozzetto.geometry import Rig
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.rigging.lipschitz_weights import lipschitz_weights
from bozzetto_silhouette.rigging.skin_graph import SkinGraph

STRETCH = 0.8
"""How much longer an edge may get by that, as a share of its length."""

AIM = 0.65
"""The same where shares diffuse: what is beyond `STRETCH` shall not come back by a hair."""

ROUNDS = 10
"""Attempts; each one diffuses farther where the last one was not enough."""

FINEST = 4000
"""Places of a skin on which shares diffuse; a finer skin does so by its clusters, of which there
are about as many."""

CELL = 1.3
"""Side of the cells of clusters, in those of squares that would share the skin among `FINEST`."""

CARRY = 2.0
"""How far a cluster has a say in what its neighbours' vertices follow, in sides of cells."""

PATIENCE = 2
"""Attempts in a row that may be no better: then more diffusion only makes the rig stiff."""

KEPT = 0.1
"""How much of its largest share a joint keeps at least."""

SETTLING = 60
"""Rounds of averaging at the edges that are left."""

HALVING = 12
"""Rounds within which averaging has to mend half of what is left, or it is not worth while."""

REACH = 0.4
"""Length of the diffusion that mends a jump, in distances from the joint: with two steps the
steepest slope of a diffused jump is 0.35 over its length."""

GROWTH = 1.25
"""Factor on the length where the last attempt was not enough."""

TAIL = 0.01
"""A share below this counts as none: diffusion reaches everywhere."""

MOST = 4
"""Joints that a vertex can follow in files."""


def gentle(
    vertices: Array, faces: Faces, rig: Rig, shares: Array, checkpoint: Checkpoint = ignore
) -> Array:
    """Return shares by which no turn of a joint tears the skin.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        The skin, closed.
    rig : Rig
        At rest.
    shares : (v, n) float array
        Of each joint of the rig; sum 1.
    checkpoint : callable
        Called with (fraction, step) between attempts; may raise `Cancelled`.

    Returns
    -------
    (v, n) float array
        Sum 1, at most four of them above 0 per vertex.
    """
    skin = SkinGraph.of(np.asarray(vertices, np.float64), faces)
    spacing = float(np.sqrt(skin.areas.sum() / FINEST))
    if len(vertices) <= FINEST:
        found, _ = _diffused(skin, rig, shares, checkpoint)
    else:
        found = _few(rig, _diffused_by_clusters(skin, rig, shares, CELL * spacing, checkpoint))
    found, least = _settled(skin, rig, found, checkpoint)
    if least == 0.0:
        return found
    held = lipschitz_weights(skin, rig, found, STRETCH, MOST, checkpoint)
    # Where that changed much it left creases: they are smoothed, and what this makes steep is held.
    changed = np.abs(held - found).max(axis=1) > TAIL
    reach = skin.spread(np.where(changed, spacing, 0.0))
    smoothed = _few(rig, skin.diffused(held, reach))
    return lipschitz_weights(skin, rig, smoothed, STRETCH, MOST, checkpoint)


def _diffused(
    skin: SkinGraph, rig: Rig, shares: Array, checkpoint: Checkpoint
) -> tuple[Array, Array]:
    """Diffuse shares where turning would tear, farther with each attempt, and say how far.

    Not so far that some joint would hardly have a share: then it would move nothing.
    """
    reach = np.zeros(len(skin.places))
    best = found = _few(rig, shares)
    best_reach, least, failed = reach, np.inf, 0
    for _ in range(ROUNDS):
        checkpoint(1.0, "skin")
        strain, away = skin.strain(rig, found)
        excess = _excess(strain)
        if excess < least:
            best, best_reach, least, failed = found, reach, excess, 0
        else:
            failed += 1
        if excess == 0.0 or failed == PATIENCE:
            break
        torn = strain > AIM
        needed = REACH * away[torn] * np.sqrt(1.0 - (AIM / strain[torn]) ** 2)
        wider = reach.copy()
        for ends in (skin.a[torn], skin.b[torn]):
            np.maximum.at(wider, ends, np.maximum(needed, GROWTH * reach[ends]))
        reach = skin.spread(wider)
        found = _few(rig, skin.diffused(shares, reach))
        if (found.max(axis=0) < KEPT * shares.max(axis=0)).any():
            break
    return best, best_reach


def _diffused_by_clusters(
    skin: SkinGraph, rig: Rig, shares: Array, cell: float, checkpoint: Checkpoint
) -> Array:
    """Diffuse shares over clusters, and carry them back to where they went a cell or farther.

    Where they went less far, vertices keep so much of their own.
    """
    number = skin.clusters(cell)
    coarse = skin.of_clusters(number)
    there, reach = _diffused(coarse, rig, skin.mean(number, shares), checkpoint)
    found = np.array(shares)
    moved = np.flatnonzero(reach[number] > 0.0)
    if len(moved):
        table = skin.carried(number, coarse, CARRY * cell, moved)
        share = np.minimum(table @ reach / cell, 1.0)[:, None]
        found[moved] += share * (table @ there - found[moved])
    return found


def _settled(
    skin: SkinGraph, rig: Rig, shares: Array, checkpoint: Checkpoint
) -> tuple[Array, float]:
    """Average the shares at the few edges that are left; also say by how much edges are too long.

    Where four joints are not enough diffusion makes jumps of its own. Here it is the vertices of
    torn edges alone that come nearer to each other and, in every other round, to all around.
    """
    best, shares, least = np.array(shares), np.array(shares), np.inf
    strain, _ = skin.strain(rig, shares)
    since: Flags = np.zeros(len(shares), bool)
    first = _excess(strain)
    for number in range(SETTLING):
        checkpoint(1.0, "skin")
        excess = _excess(strain)
        if excess < least:
            best[since], least = shares[since], excess
            since[:] = False
        if excess == 0.0 or (number == HALVING and least > 0.5 * first):
            break
        used = strain > 0.5 * (AIM + STRETCH)
        torn = np.zeros(len(shares), bool)
        torn[skin.a[used]] = torn[skin.b[used]] = True
        around = np.flatnonzero(torn[skin.a] | torn[skin.b])
        mixed = 0.5 * (shares[torn] + skin.averages(shares, torn, around if number % 2 else used))
        if mixed.shape[1] > MOST:
            mixed[mixed <= _fifth(mixed)[:, None]] = 0.0
        shares[torn] = mixed / mixed.sum(axis=1, keepdims=True)
        since |= torn
        strain[around], _ = skin.strain(rig, shares, around)
    return best, least


def _excess(strain: Array) -> float:
    """Return how much longer edges get than they may, all together."""
    return float(np.maximum(strain - STRETCH, 0.0).sum())


def _few(rig: Rig, shares: Array) -> Array:
    """Leave four joints to each vertex, so that nothing jumps where joints change places.

    As much as the fifth has, every joint passes on to the one that it hangs on; then the share
    of the fifth, and tails, are taken off the others.
    """
    found: NDArray[np.float64] = np.maximum(shares - TAIL, 0.0)
    if found.shape[1] > MOST:
        many = np.flatnonzero((found > 0.0).sum(axis=1) > MOST)
        few = found[many]
        fifth = _fifth(few)
        for joint in range(few.shape[1] - 1, 0, -1):
            parent = int(rig.parents[joint])
            if parent >= 0:
                passed = np.minimum(few[:, joint], fifth)
                few[:, parent] += passed
                few[:, joint] -= passed
        few = np.maximum(few - _fifth(few)[:, None], 0.0)
        found[many] = few
    found[found < 1e-6] = 0.0
    total = found.sum(axis=1, keepdims=True)
    alike = total[:, 0] < 1e-6  # five alike leave nothing: then the first of them has it
    found[alike, shares[alike].argmax(axis=1)] = total[alike, 0] = 1.0
    return np.asarray(found / total)


def _fifth(shares: Array) -> Array:
    """Return the fifth largest share in each row."""
    return np.asarray(np.partition(shares, -MOST - 1, axis=1)[:, -MOST - 1])
