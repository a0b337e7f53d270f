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
from bozzetto_silhouette.solids.seams import OFF, RINGS, SPREAD, Sewn, settled, with_even
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
    spacing = mean_edges(vertices, faces)
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
    vertices, settled_normals = settled(vertices, number, spacing, solid)
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
    """Whether a mesh is closed, faces outwards, and has a volume that the bodies can have."""
    vertices, faces, normals, _ = mesh
    if not len(faces) or not np.isfinite(vertices).all():
        return False
    a, b = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    along, against = np.sort(a * len(vertices) + b), np.sort(b * len(vertices) + a)
    if not np.array_equal(along, against) or (np.diff(along) == 0).any():
        return False
    one, two, three = (vertices[corner] for corner in faces.T)
    facing = dot(cross(two - one, three - one), normals[faces].sum(axis=1))
    if (facing < 0.0).sum() > TURNED * len(faces):
        return False
    parts = [volume_of(body.vertices, body.faces) for body in bodies]
    volume = volume_of(vertices, faces.astype(np.int32))
    return (1.0 - LOST) * max(parts) < volume < (1.0 + RESAMPLED) * sum(parts)
