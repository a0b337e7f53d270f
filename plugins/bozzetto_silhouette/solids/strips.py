"""The mesh of bodies that are blended two by two, without a union of solids.

Each body keeps its own mesh as far as no blend is felt. Between, strips are laid on the blended
surface, and triangles are made even around them, as around all other seams.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.inflation.manifold_check import volume_of
from bozzetto_silhouette.numerics.isotropic_remeshing import cross, dot
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.contacts import Apart, Contact, Pair
from bozzetto_silhouette.solids.evening import Sewn
from bozzetto_silhouette.solids.on_surface import OFF, settled
from bozzetto_silhouette.solids.seams import RINGS, SPREAD, with_even
from bozzetto_silhouette.solids.strip_borders import cut_meshes
from bozzetto_silhouette.solids.strip_nets import Net, mean_edges
from bozzetto_silhouette.solids.strip_rows import Strips
from bozzetto_silhouette.solids.volume_check import RESAMPLED

EVENINGS = 1
"""Rounds of evening out after the first: rows are even as they are laid, but for their ends."""

THIRD = 0.25
"""Depth below the surface of a third body, as a share of the reach, from which on it tells."""

TURNED = 2e-4
"""Share of the triangles that may face inwards: of slivers that are not seen."""

SHIFTS = np.uint64(30), np.uint64(27)
FACTORS = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
"""Of the finalizer of SplitMix64 (Steele, Lea and Flood 2014)."""

LOST = 0.02
"""Share of the volume of the largest body that the result may lack."""


class Stitched(NamedTuple):
    """A closed mesh of several bodies.

    Attributes
    ----------
    vertices, normals : (v, 3) float array
    faces : (f, 3) int array
        Oriented outwards.
    parents : (v,) int array
        Which of the bodies' vertices in a row each is; -1 for new ones.
    """

    vertices: Array
    faces: Index
    normals: Array
    parents: Index


def stitched(bodies: Sequence[Body], met: Sequence[Contact], solid: Implicit) -> Stitched:
    """Return the mesh of bodies that are added or merged.

    Parameters
    ----------
    bodies : sequence of Body
        Closed meshes.
    met : sequence of Contact
        Which of them meet.
    solid : Implicit
        Whose surface the mesh is.

    Raises
    ------
    Apart
        Where strips would touch, or do not suit.
    """
    net, pairs, kept, borders = cut_meshes(bodies, met)
    strips = Strips(net.vertices, pairs, borders)
    _check_thirds(strips, pairs, bodies)
    mesh = _even(net, kept, strips, solid)
    if not _is_sound(mesh, bodies):
        raise Apart
    return mesh


def _check_thirds(strips: Strips, pairs: list[Pair], bodies: Sequence[Body]) -> None:
    """Refuse strips that a third body reaches."""
    if not len(strips.points):
        return
    ends = np.array([(pair.one, pair.other) for pair in pairs])[strips.pair]
    reach = np.array([pair.solid.reach for pair in pairs])[strips.pair]
    met: list[set[int]] = []
    for k, body in enumerate(bodies):
        low, high = body.bounds
        within = ((strips.points >= low) & (strips.points <= high)).all(axis=1)
        at = np.flatnonzero(within & (ends != k).all(axis=1))
        if len(at):
            deep = at[body.implicit.value(strips.points[at]) > -THIRD * reach[at]]
            met += [{k} | pairs[number].ends for number in np.unique(strips.pair[deep])]
    if met:
        raise Apart(*met)


def _even(net: Net, kept: Index, strips: Strips, solid: Implicit) -> Stitched:
    """Put meshes and strips together, and make them even where they are blended."""
    new = len(strips.points)
    every = np.concatenate([strips.vertices, strips.points])
    faces = np.concatenate([kept, strips.faces])
    used = np.zeros(len(every), bool)
    used[faces] = True
    vertices, faces = every[used], (np.cumsum(used) - 1)[faces]
    is_new = np.arange(len(vertices)) >= len(vertices) - new
    felt = np.where(net.level > -1.0, net.pair, -1)
    on_border = strips.faces[strips.faces < len(felt)]
    felt[on_border] = net.pair[on_border]
    number = np.concatenate([felt, strips.pair])[used]
    around = np.zeros(len(number), bool)
    around[faces[(number >= 0)[faces].any(axis=1)]] = True
    spacing = mean_edges(vertices, faces[around[faces].any(axis=1)])
    added = np.concatenate([0.25 * (1.0 + net.level) ** 2 * net.reach, np.zeros(new)])[used]
    off = added > OFF * spacing
    spacing[is_new] = strips.sizes
    a, b = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    mine = is_new
    for ring in range(SPREAD):
        reached = np.zeros(len(number), bool)
        reached[b[mine[a]]] = True
        reached &= ~mine & (number >= 0) & (off | (ring < RINGS))
        if not reached.any():
            break
        mine = mine | reached
    number = np.where(mine, number, -1)
    between = np.zeros(len(number), bool)
    between[a[(number[a] >= 0) & (number[b] >= 0) & (number[a] != number[b])]] = True
    # What is made even next gets its normals there.
    vertices, settled_normals = settled(vertices, number, spacing, between, solid)
    mesh = Sewn(vertices, faces, np.arange(len(vertices)), mine, settled_normals)
    mesh = with_even(mesh, np.where(between, -1, number), spacing, solid, EVENINGS)
    normals = np.concatenate([net.normals, np.zeros((new, 3))])[used]
    parents = np.concatenate([net.parents, np.full(new, -1)])[used]
    return Stitched(
        mesh.vertices,
        mesh.faces,
        np.where(mesh.moved[:, None], mesh.normals, normals[mesh.parents]),
        np.where(mesh.moved, -1, parents[mesh.parents]),
    )


def _is_sound(mesh: Stitched, bodies: Sequence[Body]) -> bool:
    """Whether a mesh is closed, faces outwards, and has a volume that the bodies can have.

    What was kept of the bodies was sound before: only around what is new every edge is looked at.
    """
    vertices, faces, normals, parents = mesh
    if not len(faces) or not np.isfinite(vertices).all():
        return False
    if _edge_sum(faces) != _edge_sum(faces[:, ::-1]):
        return False
    new = faces[(parents < 0)[faces].any(axis=1)]
    around = np.zeros(len(vertices), bool)
    around[new] = True
    beside = faces[around[faces].sum(axis=1) >= 2]
    a, b = beside.ravel(), beside[:, [1, 2, 0]].ravel()
    both = around[a] & around[b]
    a, b = a[both], b[both]
    along, against = np.sort(a * len(vertices) + b), np.sort(b * len(vertices) + a)
    if not np.array_equal(along, against) or (np.diff(along) == 0).any():
        return False
    one, two, three = (vertices[corner] for corner in new.T)
    facing = dot(cross(two - one, three - one), normals[new].sum(axis=1))
    if (facing < 0.0).sum() > TURNED * len(faces):
        return False
    parts = [body.volume for body in bodies]
    volume = volume_of(vertices, faces.astype(np.int32))
    return (1.0 - LOST) * max(parts) < volume < (1.0 + RESAMPLED) * sum(parts)


def _edge_sum(faces: Index) -> int:
    """Return a sum over the edges of faces as they run, which is the same for the same edges.

    Each counts by a number that its ends are mixed to; of a closed mesh the sum is that of its
    edges run backwards, and of no other but by a chance of 2⁻⁶⁴.
    """
    ends = faces.astype(np.uint64)
    mixed = (ends << np.uint64(32)) | ends[:, [1, 2, 0]]
    for shift, factor in zip(SHIFTS, FACTORS, strict=True):
        mixed = (mixed ^ (mixed >> shift)) * factor
    return int((mixed ^ (mixed >> SHIFTS[0])).sum(dtype=np.uint64))
