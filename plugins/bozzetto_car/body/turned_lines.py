"""Lines that turn a little so that the patches between them bend one way.

Lines that are each the fairest through nodes that have moved (`fair_lines`) still force patches to
bend to both sides: a waistline that is hollow by a millimetre in the plan, say, over doors that
bulge. Patches alone cannot mend that, however they are weighted. Here tangents turn with them: the
unknowns of `saddles.bent_one_way` are the inner control points of all patches, and both directions
in which each tangent can turn. It costs

    s² / 2 + 4 W ∑ (|a|² + a · b + |b|²)

to move, with s² the variation that patches gain (`fair_patches`), and a and b the changes of both
tangents of an edge: 4 (|a|² + a · b + |b|²) is ∫ |Δx″|² of a cubic. Creases keep their side
(`crease_angles`).

Tangents keep their lengths, and those in a joint turn together, so surfaces that are smooth over an
edge stay so. Lines that cross the middle stay at right angles to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto.geometry.patches import coons_nets
from bozzetto_car.body.fair_lines import joined, opened, straightened, with_creases_of_one_side
from bozzetto_car.template.crease_angles import end_angles_between
from bozzetto_car.template.fair_patches import FLAT, Corners, least_varying, variation
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import HANDLE, KNOWN, Network, with_tangents
from bozzetto_car.template.saddles import bent_one_way

WEIGHT: Final = 20.0
"""Weight W of what lines bend, relative to the variation of patches. With 10 there are a little
fewer saddles (solved cars of two sets of seeds: 8.7 and 11.4 % of the area, 9.6 and 12.1 with 20),
but lines leap three times as far while nodes move, and CAD offsets fewer bodies."""

WIDEST: Final = 174.0
"""Largest angle of two edges at a corner of a patch in the end, degrees. No edge is bent twice
again for the margin that corners have before (`fair_lines.WIDEST`)."""

ALL: Final = tuple(range(16))
"""Numbers of all control points of a net."""

_VARIATION: Final = variation()


def with_fewer_saddles(network: Network) -> Network:
    """Return a network whose lines have turned a little, so that its patches bend one way.

    Nodes and the lengths of tangents stay. No edge bends twice in the end, creases keep their side,
    and corners of patches stay open.

    Parameters
    ----------
    network : Network
        A network whose chains have one direction at each junction.
    """
    rows = least_varying(network)
    ends = _ends(network.template, rows.corners)
    turns = _turns(network, ends)
    count = len(turns)
    if not count:
        return network
    inner, variation_by_rows = rows.along_normals()
    ways = np.zeros((len(rows.nets), 16, count + inner.shape[2], 3))
    ways[:, :, :count] = np.einsum("kph,nhx->kpnx", ends.by_end, turns, optimize=True)
    ways[:, list(FLAT), count:] = inner
    form = _variation_by(ways)
    form[count:, count:] = variation_by_rows
    form[:count, :count] += WEIGHT * _bending_by(turns)
    patches = tuple(rows.corners.patches.tolist())
    creases = end_angles_between(network.template, patches)
    moved = bent_one_way(rows.nets, ALL, ways, form, creases, gently=True)
    tangents = network.tangents[ends.edges, ends.ends]
    made = tangents + np.tensordot(moved[:count], turns, axes=1)
    sizes = [np.linalg.norm(own, axis=1, keepdims=True) for own in (tangents, made)]
    made *= sizes[0] / np.where(sizes[1] > 0.0, sizes[1], 1.0)
    numbers = zip(ends.edges.tolist(), ends.ends.tolist(), strict=True)
    turned = with_tangents(network, dict(zip(numbers, made, strict=True)))
    sided = opened(with_creases_of_one_side(straightened(turned)))
    return with_creases_of_one_side(opened(straightened(sided), WIDEST))


@dataclass(frozen=True, eq=False)
class _Ends:
    """The ends of the edges of the right half and the middle.

    Attributes
    ----------
    edges, ends : (h,) int
        Edge, and which end of it; both ends of an edge follow one another.
    by_end : (r, 16, h) float
        How far the control points of the patches of the right half move with each tangent.
    senses : (h, 1) float
        1 where an edge runs along with its chain, -1 where it runs against it.
    member : (j, h) float
        1 where an end is in a joint, whose ends turn together, else 0; each end is in one.
    first : (j,) int
        An end of each joint.
    flat, fixed : (j,) bool
        Joints of lines in the middle, which turn in it, and of lines that cross it, which do not.
    """

    edges: Index
    ends: Index
    by_end: Array
    senses: Array
    member: Array
    first: Index
    flat: Flags
    fixed: Flags


@lru_cache(maxsize=KNOWN)
def _ends(template: Template, corners: Corners) -> _Ends:
    signed = template.sides[corners.patches].ravel()
    edges = np.repeat(np.unique(np.maximum(signed, ~signed)), 2)
    ends = np.tile([0, 1], len(edges) // 2)
    by_end = np.zeros((len(corners.patches), 16, len(edges)))
    for at, (edge, end) in enumerate(zip(edges.tolist(), ends.tolist(), strict=True)):
        points = np.zeros((len(template.edges), 4, 3))
        points[edge, 1 + end, 0] = HANDLE * (1 - 2 * end)
        nets = coons_nets(points, template.sides)[corners.patches]
        by_end[:, :, at] = nets[..., 0].reshape(-1, 16)
    joints = joined(template)
    numbers, first = np.unique(joints.at[edges, ends], return_index=True)
    member = joints.at[edges, ends] == numbers[:, None]
    middle = np.isin(template.edges[edges], template.centre).all(axis=1)
    return _Ends(
        edges,
        ends,
        by_end,
        joints.senses[edges, ends],
        member.astype(float),
        first,
        (member & middle).any(axis=1),
        (member & joints.crosses[edges, ends]).any(axis=1),
    )


def _turns(network: Network, ends: _Ends) -> Array:
    """Return how tangents may turn, per radian: two ways for each joint, or one in the middle.

    Returns
    -------
    (n, h, 3) float
        Joints with a tangent that has no length do not turn.
    """
    tangents = network.tangents[ends.edges, ends.ends]
    lengths = np.linalg.norm(tangents, axis=1)
    ways = ends.senses[ends.first] * tangents[ends.first]
    sizes = np.linalg.norm(ways, axis=1, keepdims=True)
    ways = ways / np.where(sizes > 0.0, sizes, 1.0)
    steepest = np.eye(3)[np.argmin(np.abs(ways), axis=1)]
    aside = np.where(ends.flat[:, None], (0.0, 1.0, 0.0), cross_product(ways, steepest))
    size = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = aside / np.where(size > 0.0, size, 1.0)
    sides = np.stack((cross_product(ways, aside), aside), axis=1)
    turns = (ends.member * ends.senses[:, 0] * lengths)[:, None, :, None] * sides[:, :, None]
    there = (ends.member * (lengths == 0.0)).sum(axis=1) == 0.0
    may = np.stack((there & ~ends.fixed, there & ~ends.fixed & ~ends.flat), axis=1)
    return np.asarray(turns[may])


def _variation_by(ways: Array) -> Array:
    """Return the form of the variation of patches whose control points move so, (n, n)."""
    flat = ways.transpose(0, 3, 1, 2)
    count = flat.shape[-1]
    return np.asarray(flat.reshape(-1, count).T @ (_VARIATION @ flat).reshape(-1, count))


def _bending_by(turns: Array) -> Array:
    """Return the form of what edges bend more if their tangents change so, (n, n)."""
    first, last = (turns[:, end::2].reshape(len(turns), -1) for end in (0, 1))
    mixed = first @ last.T
    return np.asarray(4.0 * (first @ first.T + last @ last.T) + 2.0 * (mixed + mixed.T))
