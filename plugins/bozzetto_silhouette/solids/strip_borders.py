"""Where strips begin: meshes of bodies that are blended, cut along their own edges.

A mesh is kept as far as the blend is hardly felt.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Flags, Index
from bozzetto_silhouette.numerics.grouping import connected_pieces, face_neighbours
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.contacts import Apart, Contact, Pair
from bozzetto_silhouette.solids.strip_nets import Net, net_of

PEELINGS = 12
"""Rounds of taking away triangles that stick out of a border, at most."""


class Border(NamedTuple):
    """A closed row of vertices where a kept mesh ends, as the faces beside it run.

    Attributes
    ----------
    vertices : (n,) int array
    pair : int
        The number of the pair that it belongs to.
    owner : int
        The number of the body whose mesh ends.
    """

    vertices: Index
    pair: int
    owner: int


def cut_meshes(
    bodies: Sequence[Body], met: Sequence[Contact]
) -> tuple[Net, list[Pair], Index, list[Border]]:
    """Cut the meshes of bodies where they are blended.

    Parameters
    ----------
    bodies : sequence of Body
        Closed meshes.
    met : sequence of Contact
        Which of them meet.

    Returns
    -------
    net : Net
    pairs : list of Pair
    kept : (f, 3) int array
        The faces that are left.
    borders : list of Border

    Raises
    ------
    Apart
        Where sharp edges are blended, or no border is left between two blends.
    """
    pairs = [Pair.of(contact, bodies) for contact in sorted(met, key=lambda some: some[:2])]
    net = net_of(bodies, pairs)
    return net, pairs, *_cut(net, pairs)


def _cut(net: Net, pairs: list[Pair]) -> tuple[Index, list[Border]]:
    """Return the faces that are kept, and their borders."""
    gone = _covered(net, pairs)
    if not gone.any():
        return np.concatenate([net.rest, net.faces]), []
    count = len(net.vertices)
    near: NearFaces | None = None
    for _ in range(PEELINGS):
        near = near or NearFaces.of(net.faces, gone, count)
        rows, faces, inner, beside = near
        out = gone[rows]
        bordering = ~out[:, None] & (beside >= 0) & out[beside]
        leaving = np.bincount(faces[bordering], minlength=count)
        pinched = (leaving > 1)[faces].any(axis=1)
        ragged: Flags = ~out & ((bordering.sum(axis=1) >= 2) | pinched)
        if not ragged.any():
            break
        gone[rows[ragged]] = True
        if not inner[faces[ragged]].all():
            near = None
    else:
        met = np.unique(net.pair[faces[ragged]])
        raise Apart({end for k in met[met >= 0].tolist() for end in pairs[k].ends})
    face, corner = np.nonzero(bordering)
    begin, end = faces[face, corner], faces[face, (corner + 1) % 3]
    across = faces[beside[face, corner]]
    lead = across[np.arange(len(across)), net.level[across].argmax(axis=1)]
    borders = _walked(net, pairs, begin, end, net.pair[lead])
    return np.concatenate([net.rest, net.faces[~gone]]), borders


class NearFaces(NamedTuple):
    """The faces near where a mesh ends.

    Attributes
    ----------
    rows : (n,) int array
        Which of all faces.
    faces : (n, 3) int array
    inner : (v,) bool array
        The vertices of which all faces are among them.
    beside : (n, 3) int array
        Which of them is on the other side of each edge; -1 where none is.
    """

    rows: Index
    faces: Index
    inner: Flags
    beside: Index

    @classmethod
    def of(cls, faces: Index, gone: Flags, count: int) -> NearFaces:
        """Find the faces (f, 3) near those that are gone (f,), of a mesh of `count` vertices."""
        left, taken = np.zeros((2, count), bool)
        left[faces[~gone]] = True
        taken[faces[gone]] = True
        inner = left & taken
        inner[faces[inner[faces].any(axis=1)]] = True
        rows = np.flatnonzero(inner[faces].any(axis=1))
        return cls(rows, faces[rows], inner, face_neighbours(faces[rows], count))


def _covered(net: Net, pairs: list[Pair]) -> Flags:
    """Mark the faces that strips replace, or other bodies cover."""
    level = net.level
    covered: Flags = np.asarray((level > -net.cut)[net.faces].any(axis=1))
    rows = np.flatnonzero(covered)
    if not len(rows):
        return covered
    corners = net.faces[rows]
    _, piece = connected_pieces(corners.ravel(), np.roll(corners, -1, axis=1).ravel(), len(level))
    met = np.unique(corners)
    # Without contact nothing is blended: only where the other body is entered.
    entered, touched = np.zeros((2, int(piece.max()) + 1), bool)
    entered[piece[met[level[met] > 0.0]]] = True
    gaps = np.array([pair.gap for pair in pairs])[net.pair[met]]
    touched[piece[met[level[met] > -gaps]]] = True
    doubtful = met[(touched & ~entered)[piece[met]]]
    if len(doubtful):
        raise Apart(*(pairs[k].ends for k in np.unique(net.pair[doubtful])))
    covered[rows[~entered[piece[corners[:, 0]]]]] = False
    return covered


def _walked(net: Net, pairs: list[Pair], begin: Index, end: Index, number: Index) -> list[Border]:
    """Return the closed rows of edges from `begin` to `end` (e,), with the pairs beside them."""
    after, beside = np.full((2, len(net.vertices)), -1)
    after[begin], beside[begin] = end, number
    following, seen = after.tolist(), set[int]()
    borders, mixed = [], []
    for start in np.sort(begin).tolist():
        if start in seen:
            continue
        walk, here = [], start
        while here not in seen:
            seen.add(here)
            walk.append(here)
            here = following[here]
        mine = np.array(walk, np.intp)
        met = np.unique(beside[mine])
        if len(met) > 1 or here != start:
            mixed.append({k for pair in met.tolist() for k in pairs[pair].ends})
        borders.append(Border(mine, int(met[0]), int(net.owner[start])))
    if mixed:
        raise Apart(*mixed)
    return borders
