"""Surfaces that hang together, as bodies: turned outward, and given walls."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Flags, Index, cross_product
from bozzetto.geometry import CornerNormals, FaceGroup, Mesh
from bozzetto.plugin import Job, remembered
from bozzetto_product.details.bodies import DetailedBodies, detailed_bodies
from bozzetto_product.details.shell import Owner, Shell, face_meshes, group_of
from bozzetto_product.model.state import ProductState
from bozzetto_product.shaping.wall import Wall, walled
from bozzetto_product.solve.result import SolvedPatch, WalledBody


@dataclass(frozen=True, eq=False)
class JoinedPatches:
    """Patches that share edges, as one mesh.

    Parameters
    ----------
    patches : tuple of SolvedPatch
    mesh : Mesh
        Vertices at the very same place are one; outward where it is closed.
    groups : tuple of FaceGroup
        The triangles of each patch.
    normals : CornerNormals
        Of the surfaces themselves: where two meet, each has its own.
    closed : bool
        Whether it bounds a volume.
    turned_over : bool
        Its triangles run against those of the fills.
    """

    patches: tuple[SolvedPatch, ...]
    mesh: Mesh
    groups: tuple[FaceGroup, ...]
    normals: CornerNormals
    closed: bool
    turned_over: bool


@remembered(limit=4, key=lambda patches: tuple(patches))
def joined_patches(patches: Sequence[SolvedPatch]) -> tuple[JoinedPatches, ...]:
    """Return the parts that hang together by shared edges, in their order."""
    made = []
    for part in _connected(patches):
        mesh, groups, normals = _joined(part)
        uses = [edge for one in part for edge, _ in one.loop]
        closed = all(uses.count(edge) == 2 for edge in set(uses)) and is_closed_mesh(mesh)
        over = closed and _volume(mesh) < 0.0
        if over:
            mesh, normals = replace(mesh, faces=mesh.faces[:, ::-1]), normals.turned_over()
        made.append(JoinedPatches(tuple(part), mesh, groups, normals, closed, over))
    return tuple(made)


def walled_bodies(
    state: ProductState,
    patches: Sequence[SolvedPatch],
    detailed: DetailedBodies,
    job: Job,
) -> tuple[WalledBody, ...]:
    """Return a body of walls for each part; none without a thickness, and in a preview.

    Parameters
    ----------
    state : ProductState
        Thickness, and to which side walls grow.
    patches : sequence of SolvedPatch
        Those that have a surface.
    detailed : DetailedBodies
        The same with details. What is pressed in or raised is so on both sides of a wall; what is
        cut goes through it.
    job : Job
        Called between the parts.
    """
    if state.wall <= 0.0 or job.quality != "final":
        return ()
    outward = state.wall_side == "outside"
    made = []
    for part in joined_patches(tuple(patches)):
        numbers = {k for k, one in enumerate(patches) if any(one is own for own in part.patches)}
        changed = next((s for s in detailed.changed if s.owners[0].patch in numbers), None)
        whole = _without_cuts(detailed, changed, part, numbers, state, job)
        rows = [_meshes(part, sorted(numbers), shell) for shell in (changed, whole)]
        left_out = outward and whole is not changed
        (meshes, owners), (plain, others) = (rows[1], rows[1]) if left_out else rows
        if whole is changed or left_out:
            plain, others = (), ()
        turned, plain = (
            tuple(map(_turned_over, row)) if part.turned_over else row for row in (meshes, plain)
        )
        wall: Wall | None = walled(
            turned, state.wall, outward, lambda: job.checkpoint(0.95, "Walls"), plain
        )
        made.append(WalledBody(part.patches, wall, (*owners, *others), left_out))
    return tuple(made)


def _without_cuts(
    detailed: DetailedBodies,
    changed: Shell | None,
    part: JoinedPatches,
    numbers: Collection[int],
    state: ProductState,
    job: Job,
) -> Shell | None:
    """Return the shell of a closed part without what is cut through it; the same if nothing is."""
    cut = {
        number
        for number, one in enumerate(detailed.details)
        if one.detail.kind == "cut" and not one.problem
    }
    if changed is None or not part.closed or cut.isdisjoint(o.detail for o in changed.owners):
        return changed
    kept = [one for number, one in enumerate(detailed.details) if number not in cut]
    details = tuple(dict.fromkeys(one.detail for one in kept))
    less = detailed_bodies(
        detailed.grounds, details, state.symmetry, lambda: job.checkpoint(0.95, "Walls")
    )
    own = next(s for s in less.shells if s.owners[0].patch in numbers)
    order = [detailed.number_of(one.detail, one.mirrored) for one in less.details]
    owners = tuple(
        owner if owner.detail < 0 else replace(owner, detail=order[owner.detail])
        for owner in own.owners
    )
    return Shell(own.edges, own.faces, owners)


def _meshes(
    part: JoinedPatches, numbers: Sequence[int], shell: Shell | None
) -> tuple[tuple[Mesh, ...], tuple[Owner, ...]]:
    """Return meshes with normals of a part, and what each belongs to."""
    if shell is None:
        meshes = tuple(one.mesh for one in part.patches if one.mesh is not None)
        return meshes, tuple(map(Owner, numbers))
    meshes = face_meshes(shell)
    order = sorted(range(len(meshes)), key=lambda k: group_of(shell.owners[k]))
    return tuple(meshes[k] for k in order), tuple(shell.owners[k] for k in order)


@remembered(limit=1024, key=lambda mesh: mesh)
def _turned_over(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces[:, ::-1], -mesh.vertex_normals())


def _connected(patches: Sequence[SolvedPatch]) -> Iterator[list[SolvedPatch]]:
    """Yield patches that hang together by shared edges, in their order."""
    from scipy.cluster.hierarchy import DisjointSet

    sets = DisjointSet(range(len(patches)))
    first: dict[int, int] = {}
    for number, one in enumerate(patches):
        for edge, _ in one.loop:
            sets.merge(number, first.setdefault(edge, number))
    for group in sorted(sorted(subset) for subset in sets.subsets()):
        yield [patches[number] for number in group]


def _joined(
    part: Sequence[SolvedPatch],
) -> tuple[Mesh, tuple[FaceGroup, ...], CornerNormals]:
    """Return one mesh, in which vertices at the very same place are one, its groups and normals."""
    meshes = [one.mesh for one in part if one.mesh is not None]
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = np.concatenate([m.faces + start for m, start in zip(meshes, starts, strict=True)])
    _, first, same = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    rows = rank[same.ravel()][faces]
    sound = _is_triangle(rows)
    groups = []
    begin = 0
    for one, mesh in zip(part, meshes, strict=True):
        kept = int(sound[begin : begin + len(mesh.faces)].sum())
        groups.append(FaceGroup(one.name, kept, one.patch.color, one.patch.finish))
        begin += len(mesh.faces)
    normals = CornerNormals.of_meshes(meshes).of_faces(sound)
    return Mesh(vertices[first[order]], rows[sound].astype(np.int32)), tuple(groups), normals


def _is_triangle(rows: Index) -> Flags:
    a, b, c = rows.T
    return np.asarray((a != b) & (b != c) & (c != a))


def is_closed_mesh(mesh: Mesh) -> bool:
    """Whether every edge is run once each way."""
    forth = np.concatenate([mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)]).astype(np.int64)
    count = np.int64(len(mesh.vertices))
    keys, times = np.unique(forth[:, 0] * count + forth[:, 1], return_counts=True)
    back = (keys % count) * count + keys // count
    return bool((times == 1).all() and np.isin(back, keys).all())


def _volume(mesh: Mesh) -> float:
    corners = (mesh.vertices - mesh.vertices[:1])[mesh.faces].astype(np.float64)
    return float(
        np.einsum("ij,ij->", corners[:, 0], cross_product(corners[:, 1], corners[:, 2])) / 6
    )
