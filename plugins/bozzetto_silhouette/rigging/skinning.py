"""Skinning: weights of joints for every vertex, smooth across the surface.

A vertex follows the bones of the part that it came from (`bones`); at a seam between two parts
both have half a say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.rigging.armature import Armature
from bozzetto_silhouette.rigging.bone_weights import Bones, Gaps, eased
from bozzetto_silhouette.rigging.weight_diffusion import MOST, gentle
from bozzetto_silhouette.solids.body import Body, meet
from bozzetto_silhouette.solids.draft import Drafted

Singles = NDArray[np.float32]

SEAM = 0.5
"""How far parts blend into each other at a seam, in largest radii of the thinner one."""

CHUNK = 8192
"""Vertices at a time: what is worked on stays in the cache, and the window can breathe."""


class Table(NamedTuple):
    """Shares of joints at n points.

    Attributes
    ----------
    joints : (k,) int array
        Numbers in the rig, all different.
    shares : (n, k) float32 array
        Sum 1.
    """

    joints: Index
    shares: Singles


Follower = Callable[[Array], Table]
"""Gives the joints that points (n, 3) of one part, in the model's frame, follow."""


def followed(
    armature: Armature, body: Body, checkpoint: Checkpoint = ignore
) -> tuple[NDArray[np.int32], Singles]:
    """Assign joints and weights to the vertices of a body.

    Parameters
    ----------
    armature : Armature
        In the body's frame.
    body : Body
        The whole shape.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    joints : (v, 4) int32 array
        All different where the weight is not 0; 0 where it is.
    weights : (v, 4) float32 array
        Sum 1.
    """
    bones = [Bones(limbs) for limbs in armature.limbs]
    followers = [_follower(armature, body, bones, owner) for owner in range(len(body.sources))]
    shares = np.zeros((len(body.vertices), len(armature.radii)))
    for owner in np.unique(body.origins).tolist():
        mine = np.flatnonzero(body.origins == owner)
        for start in range(0, len(mine), CHUNK):
            checkpoint(1.0, "skin")  # the last step
            some = mine[start : start + CHUNK]
            table = followers[owner](body.vertices[some])
            shares[some[:, None], table.joints] = table.shares
    _sew(armature, body, followers, shares)
    return _strongest(gentle(body.vertices, body.faces, armature.rig, shares, checkpoint))


def loosely_followed(
    armature: Armature, draft: Drafted, checkpoint: Checkpoint = ignore
) -> tuple[NDArray[np.int32], Singles]:
    """Assign joints and weights to the vertices of a draft, whose surfaces are not one mesh.

    Each follows the joints of its part alone, fillets those of all parts that they meet. Parameters
    and what is returned are those of `followed`.
    """
    body = replace(draft.body, origins=draft.under.astype(np.int32))
    bones = [Bones(limbs) for limbs in armature.limbs]
    followers: dict[int, Follower] = {}
    boxes = {shell.owner: shell.lump.box for shell in draft.shells if not shell.fills}
    shares = np.zeros((len(body.vertices), len(armature.radii)))
    first = 0
    for shell in draft.shells:
        checkpoint(1.0, "skin")
        mine = slice(first, first + len(shell.lump.shown().vertices))
        owner = int(draft.under[first])
        first = mine.stop
        beside = [
            one for one in bones
            if shell.fills and one.limbs.part in boxes
            and meet(boxes[one.limbs.part], shell.lump.box)
        ]  # fmt: skip
        if beside:
            table = _mixed(beside, body.vertices[mine])
        else:
            if owner not in followers:
                followers[owner] = _follower(armature, body, bones, owner)
            table = followers[owner](body.vertices[mine])
        shares[mine, table.joints] = table.shares
    return _strongest(shares)


def _follower(armature: Armature, body: Body, bones: Sequence[Bones], owner: int) -> Follower:
    """Return a function that says how points of one part follow its joints.

    With bones of its own, by those. A part that adds to the shape without bones, as one that
    goes straight through, follows as a whole what it is nearest to. The walls of what was cut
    away follow whatever is around them.
    """
    part = body.sources[owner]
    own = [one for one in bones if one.limbs.part == part]
    if own or part not in armature.rigid:
        return lambda points: _mixed(own or bones, points)
    points = body.vertices[body.origins == owner]
    if not len(points):
        return lambda points: Table(np.zeros(1, np.intp), np.ones((len(points), 1), np.float32))
    gaps = np.min([one.shares(points)[1].gap for one in bones], axis=0)
    nearest = _mixed(bones, points[[gaps.argmin()]])
    joint = nearest.joints[[nearest.shares[0].argmax()]]
    return lambda points: Table(joint, np.ones((len(points), 1), np.float32))


def _mixed(bones: Sequence[Bones], points: Array) -> Table:
    """Mix the shares of the joints of several pieces, of those that are near."""
    found = [one.shares(points) for one in bones]
    joints = [one.limbs.first + np.arange(len(one.limbs.nodes)) for one in bones]
    if len(found) == 1:
        return Table(joints[0], found[0][0])
    gaps = Gaps(*(np.stack(rows) for rows in zip(*(nearest for _, nearest in found), strict=True)))
    nearest = gaps.nearest()
    says = eased(1.0 - (gaps.gap - nearest.gap) / gaps.widths(nearest))
    says /= says.sum(axis=0)
    shares = [share * say[:, None] for (share, _), say in zip(found, says, strict=True)]
    return Table(np.concatenate(joints), np.concatenate(shares, axis=1))


def _strongest(shares: Array) -> tuple[NDArray[np.int32], Singles]:
    """Return the joints with the largest shares, (n, 4), and their weights."""
    shares = np.pad(shares, ((0, 0), (0, max(0, MOST - shares.shape[1]))))
    columns = np.argsort(-shares, axis=1, kind="stable")[:, :MOST]
    largest = np.take_along_axis(shares, columns, axis=1)
    weights = (largest / largest.sum(axis=1, keepdims=True)).astype(np.float32)
    return np.where(weights > 0.0, columns, 0).astype(np.int32), weights


def _sew(
    armature: Armature,
    body: Body,
    followers: Sequence[Follower],
    shares: Array,
) -> None:
    """Mix what vertices near a seam follow with what the part beyond it follows, in place.

    With s the share of the seam at a vertex, one half on it and fading to 0, the part beyond
    weighs s / (1 - s) as much as the vertex's own.
    """
    edges = np.concatenate([body.faces[:, [k, (k + 1) % 3]] for k in range(3)])
    across = body.origins[edges]
    seam = across[:, 0] < across[:, 1]
    if not seam.any():
        return
    pairs, which = np.unique(across[seam], axis=0, return_inverse=True)
    middles = body.vertices[edges[seam]].mean(axis=1)
    said: list[tuple[Index, Array, Table]] = []
    for number, pair in enumerate(pairs.tolist()):
        here = middles[which.ravel() == number]
        width = SEAM * min(_thickness(armature, body.sources[owner]) for owner in pair)
        for mine, other in (pair, pair[::-1]):
            own = np.flatnonzero(body.origins == mine)
            near, gap = _near(body.vertices[own], here, width)
            share = 0.5 * eased(1.0 - gap / width)
            table = followers[other](body.vertices[own[near]])
            said.append((own[near], share / (1.0 - share), table))
    for near, odds, table in said:
        shares[near[:, None], table.joints] += odds[:, None] * table.shares
    shares /= shares.sum(axis=1, keepdims=True)


def _near(points: Array, others: Array, width: float) -> tuple[Index, Array]:
    """Find the points that have another one within a width, and its distance."""
    from scipy.spatial import cKDTree

    low, high = others.min(axis=0) - width, others.max(axis=0) + width
    inside = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
    gap = np.asarray(cKDTree(others).query(points[inside], distance_upper_bound=width)[0])
    return inside[gap < width], gap[gap < width]


def _thickness(armature: Armature, part: str) -> float:
    """Return the largest radius of a part; of all parts for one without bones."""
    own = [limbs.radii.max() for limbs in armature.limbs if limbs.part == part]
    return float(max(own, default=armature.radii.max()))
