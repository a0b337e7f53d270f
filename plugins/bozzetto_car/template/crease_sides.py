"""Creases that bulge, or are hollow, all along: none is one at one end and the other at the other.

The angle over a crease has a sign: above 0 the body bulges there, below 0 it is hollow. In each end
it follows from three tangents, that of the crease and those of the two edges beside it. Where marks
move nodes, these turn with their chords, and an edge that bulges in one end may become hollow in
the other. Stylists call that a lost line, and a body of such edges cannot be offset: CAD takes
an edge for what it is in its middle.

So both edges beside an end of a crease turn about it, half the way each, until the angle there has
the sign that the template's crease has, and at least `LEAST`, or what the template has.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import KNOWN, Network, junctions, with_tangents

LEAST: Final = np.radians(4.0)
"""Least angle over the end of a crease, radians, if the template has as much."""

LEAST_BESIDE_SMOOTH: Final = np.radians(10.0)
"""The same of a crease over whose other end lines run on smoothly, as over the head of a screen in
the middle of the car: it has about a third of it half way."""

ROUNDS: Final = 12
"""Most rounds: an edge lies beside several creases."""

NEAR: Final = np.radians(0.01)
"""What may be missing in the end, radians."""

TINY: Final = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class CreaseEnds:
    """Ends of the creases of the right half and the middle at which no two edges run on smoothly.

    Attributes
    ----------
    creases : (c, 2) int
        Edge, and which end of it.
    beside : (c, 2, 2) int
        The edge to the left of the crease as it runs, and that to the right: edge, and which end.
    leaving : (c, 2, 1) float
        1 where a tangent leaves the node, -1 where it leads to it.
    free : (c, 2) bool
        Whether an edge beside it runs on in no other and so may turn.
    """

    creases: Index
    beside: Index
    leaving: Array
    free: Flags


@lru_cache(maxsize=KNOWN)
def crease_ends(template: Template) -> CreaseEnds:
    """Return the ends of creases whose angle follows from lines that do not run on there."""
    left = set(template.pairs[:, 1].tolist())
    joints = [frozenset((joint.before, joint.after)) for joint in junctions(template)]
    held = {end for joint in joints for end in joint}
    sides = {side: divmod(at, 4) for at, side in enumerate(template.sides.ravel().tolist())}
    creases, beside = [], []
    for edge in sorted(template.creases):
        if left.intersection(template.edges[edge].tolist()):
            continue
        (one, at), (two, back) = sides[edge], sides[~edge]
        rings = template.sides[one].tolist(), template.sides[two].tolist()
        for end, pair in enumerate(
            (
                (~rings[0][at - 1], rings[1][(back + 1) % 4]),
                (rings[0][(at + 1) % 4], ~rings[1][back - 1]),
            )
        ):
            own = [(side, 0) if side >= 0 else (~side, 1) for side in pair]
            if frozenset(own) not in joints:
                creases.append((edge, end))
                beside.append(own)
    places = np.array(beside, np.intp).reshape(-1, 2, 2)
    free = [[(edge, end) not in held for edge, end in pair] for pair in places.tolist()]
    return CreaseEnds(
        np.array(creases, np.intp).reshape(-1, 2),
        places,
        np.where(places[:, :, 1:] == 0, 1.0, -1.0),
        np.array(free, bool).reshape(-1, 2),
    )


def end_angles(network: Network) -> Array:
    """Return the angle over each end of the creases of the right half and the middle, (c,) radians.

    Above 0 the body bulges there; below it is hollow. Ends over which lines run on are left out.
    """
    ends = crease_ends(network.template)
    return _angles(ends, network.tangents)


def _angles(ends: CreaseEnds, tangents: Array) -> Array:
    along = _units(tangents[ends.creases[:, 0], ends.creases[:, 1]])
    beside = ends.leaving * tangents[ends.beside[..., 0], ends.beside[..., 1]]
    one, other = cross_product(along, beside[:, 0]), cross_product(beside[:, 1], along)
    sine = (cross_product(one, other) * along).sum(axis=1)
    return np.asarray(np.arctan2(sine, (one * other).sum(axis=1)))


def _units(ways: Array) -> Array:
    sizes = np.linalg.norm(ways, axis=-1, keepdims=True)
    return np.asarray(ways / np.where(sizes > 0.0, sizes, 1.0))


def turning_creases(network: Network) -> tuple[int, ...]:
    """Return the creases that bulge at one end and are hollow at the other."""
    ends = crease_ends(network.template)
    angles = _angles(ends, network.tangents)
    bulging, hollow = (set(ends.creases[sign * angles > NEAR, 0].tolist()) for sign in (1.0, -1.0))
    return tuple(sorted(bulging & hollow))


@lru_cache(maxsize=KNOWN)
def wanted_angles(template: Template) -> tuple[Array, Array]:
    """Return the sign of each end's crease, and the least angle in it, times this sign."""
    ends = crease_ends(template)
    angles = _angles(ends, template.tangents)
    sums = np.zeros(len(template.edges))
    np.add.at(sums, ends.creases[:, 0], angles)
    signs = np.where(sums < 0.0, -1.0, 1.0)[ends.creases[:, 0]]
    alone = np.bincount(ends.creases[:, 0], minlength=len(template.edges))[ends.creases[:, 0]] == 1
    return signs, np.minimum(signs * angles, np.where(alone, LEAST_BESIDE_SMOOTH, LEAST))


def one_sided(network: Network) -> Network:
    """Return a network whose creases bulge or are hollow all along, as those of its template are.

    Only directions of tangents change, and those of edges that run on smoothly do not.

    Parameters
    ----------
    network : Network
        The network to change.
    """
    ends = crease_ends(network.template)
    signs, least = wanted_angles(network.template)
    tangents = np.array(network.tangents)
    sizes = np.linalg.norm(tangents, axis=2, keepdims=True)
    share = ends.free / np.maximum(ends.free.sum(axis=1, keepdims=True), 1)
    numbers = ends.beside[..., 0] * 2 + ends.beside[..., 1]
    for _ in range(ROUNDS):
        missing = np.maximum(least - signs * _angles(ends, tangents), 0.0) * share.any(axis=1)
        if missing.max(initial=0.0) < NEAR:
            break
        along = _units(tangents[ends.creases[:, 0], ends.creases[:, 1]])
        wishes = missing[:, None] * share
        turns = signs[:, None] * wishes * (-1.0, 1.0)
        beside = tangents[ends.beside[..., 0], ends.beside[..., 1]]
        # Where creases want the same edge to turn, it turns as they wish in the mean, by weight.
        moves = (wishes * turns)[..., None] * cross_product(along[:, None], beside)
        sums, weights = np.zeros((2 * len(tangents), 3)), np.zeros(2 * len(tangents))
        np.add.at(sums, numbers.ravel(), moves.reshape(-1, 3))
        np.add.at(weights, numbers.ravel(), wishes.ravel())
        sums /= np.where(weights > 0.0, weights, 1.0)[:, None]
        tangents = tangents + sums.reshape(tangents.shape)
        tangents *= sizes / np.maximum(np.linalg.norm(tangents, axis=2, keepdims=True), TINY)
    changed = np.argwhere((tangents != network.tangents).any(axis=2)).tolist()
    return with_tangents(network, {(edge, end): tangents[edge, end] for edge, end in changed})
