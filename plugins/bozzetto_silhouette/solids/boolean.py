"""Two bodies become one; the mesh of whatever was put together."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.composite import signature
from bozzetto_silhouette.inflation.closed_surface import vertex_normals
from bozzetto_silhouette.inflation.manifold_check import volume_of
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.model.state import Operation
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.handle_removal import without_narrow_handles
from bozzetto_silhouette.solids.assembly import Assembly, assembled, remade, restricted
from bozzetto_silhouette.solids.body import Body, meet
from bozzetto_silhouette.solids.contacts import Apart, Contact, contacts
from bozzetto_silhouette.solids.evening import Sewn
from bozzetto_silhouette.solids.fillet import fillets_of
from bozzetto_silhouette.solids.seams import sewn
from bozzetto_silhouette.solids.strips import Stitched, stitched
from bozzetto_silhouette.solids.union_mesh import UnionMesh, found, union_mesh
from bozzetto_silhouette.solids.variational_csg import variational_combined
from bozzetto_silhouette.solids.volume_check import RESAMPLED, is_allowed

SPECK = 8.0
"""Volume, in cubes of the spacing of the finer mesh, below which a piece by itself is no part: the
smallest part has hundreds, for its own spacing suits it."""

NARROW = 3.0
"""Length of a loop around a tunnel or a handle of a fillet, in its cells, up to which nobody means
it: where a fillet goes under the mesh of a body the two meet in slivers."""

ATTEMPTS = 3
"""Times that bodies are grouped anew where strips between them would touch."""

FEWEST = 0.5
"""Share of the bodies that there must be groups: uniting all at once is faster than trying on."""

KEPT = 0.5
"""Share of a solid's volume that even seams must leave: thin slivers would be turned inside out."""


def combined(
    first: Body,
    second: Body,
    operation: Operation,
    blend: float,
    checkpoint: Checkpoint = ignore,
) -> Body | None:
    """Combine two bodies into one.

    Parameters
    ----------
    first, second : Body
        In the same frame.
    operation : {"add", "merge", "carve", "intersect"}
        What the second does to the first.
    blend : float
        Radius of the blend as a share of the smaller `radius` of the two; 0 is a sharp crease.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    Body or None
        None where nothing is left.
    """
    both = joined(Assembly.of(first), Assembly.of(second), operation, blend, checkpoint)
    return None if both is None else meshed(both, checkpoint)


def joined(
    first: Assembly,
    second: Assembly,
    operation: Operation,
    blend: float,
    checkpoint: Checkpoint = ignore,
) -> Assembly | None:
    """Put two assemblies together; parameters are those of `combined`.

    Variational bodies merge and carve by what they interpolate.
    """
    one, other = first.alone, second.alone
    if (
        operation in ("merge", "carve") and blend > 0.0
        and one is not None and one.constraints is not None
        and other is not None and other.constraints is not None
        and meet(one.bounds, other.bounds)
    ):  # fmt: skip
        with suppress(UserError):  # no sound surface through them: blended like all others
            body = variational_combined(one, other, operation, blend, checkpoint)
            if body is None:
                return None
            if is_allowed(body.manifold, operation, one.manifold, other.manifold, RESAMPLED):
                return Assembly.of(body)
    return assembled(first, second, operation, blend, checkpoint)


def meshed(assembly: Assembly, checkpoint: Checkpoint = ignore) -> Body:
    """Return the body of an assembly: its lumps united and its seams made even.

    Where the lumps make no sound solid it is made anew from their functions.

    Raises
    ------
    UserError
        If not even that is sound.
    """
    if assembly.alone is not None:
        return assembly.alone
    body = _laid(assembly, checkpoint)
    return _united(assembly, checkpoint) if body is None else body


def _united(assembly: Assembly, checkpoint: Checkpoint) -> Body:
    """Return the body of an assembly by uniting all lumps at once."""
    fillets_of(assembly.blends, checkpoint)  # all at once, and remembered
    checkpoint(0.8, "combine")
    whole = union_mesh(assembly.lumps)
    if whole is None:
        return _remade(assembly, checkpoint)
    vertices, faces = whole.vertices, whole.faces
    bodies = [piece.body for piece in assembly.pieces]
    before = np.vstack([
        *(body.vertices for body in bodies), *(f.surface.vertices for f in assembly.fillets),
    ])  # fmt: skip
    parents = found(vertices, before)
    count = sum(len(body.vertices) for body in bodies)
    seam = _seam(assembly, whole)
    kept = _without_specks(vertices, faces, assembly.step)
    faces = (np.cumsum(kept, dtype=np.int32) - np.int32(1))[faces[kept[faces[:, 0]]]]
    vertices, parents, seam = vertices[kept], parents[kept], seam[kept]
    if (seam >= 0).any():
        longest = NARROW * np.array([*(fillet.cell for fillet in assembly.fillets), 0.0])[seam]
        cut, copies = without_narrow_handles(vertices, faces.astype(np.intp), longest)
        faces = cut.astype(np.int32)
        vertices, parents, seam = vertices[copies], parents[copies], seam[copies]
    new = parents < 0
    of_fillet = parents >= count
    normals = np.vstack([
        *(side * body.normals for body, side in assembly.pieces),
        *(f.surface.normals for f in assembly.fillets),
    ])[parents]  # fmt: skip
    sharp = np.zeros(len(before) + 1, dtype=bool)
    sharp[_numbered([body.creases for body in bodies], bodies)] = True
    creases = (new | sharp[parents]) & (seam < 0)
    on_crease = np.flatnonzero(creases)
    normals[on_crease] = _crease_normals(vertices, faces, on_crease)
    origins = _spread(_origins(bodies, len(before))[parents], new | of_fillet, faces)
    unmoved = np.zeros(len(vertices), dtype=bool)
    result = Sewn(vertices, faces.astype(np.intp), np.arange(len(vertices)), unmoved, normals)
    if (seam >= 0).any():
        checkpoint(0.9, "blend")
        even = _with_seams(assembly, vertices, faces, seam, creases, parents - count)
        if volume_of(even.vertices, even.faces.astype(np.int32)) > KEPT * volume_of(
            vertices, faces
        ):
            result = even
    normals = np.where(result.moved[:, None], result.normals, normals[result.parents])
    return Body(
        result.vertices,
        result.faces.astype(np.int32),
        normals,
        origins[result.parents],
        assembly.sources,
        assembly.implicit,
        assembly.radius,
        assembly.step,
        np.flatnonzero(creases[result.parents] & ~result.moved),
        resampled=assembly.resampled,
    )


def _laid(assembly: Assembly, checkpoint: Checkpoint) -> Body | None:
    """Return the body of an assembly, with strips between bodies that are blended two by two.

    Where strips would touch, the bodies beside are united first, by themselves. None where that
    were all, or where something was carved.
    """
    if not assembly.blends or len(assembly.loose) < len(assembly.blends):
        return None
    if len(assembly.solids) < len(assembly.pieces):
        return None
    # The same to the last bit, whichever came first.
    bodies = sorted(
        (piece.body for piece in assembly.pieces), key=lambda body: body.bounds.ravel().tolist()
    )
    checkpoint(0.6, "blend")
    met = contacts(bodies, assembly.implicit)
    if met is None:
        return None
    group = np.arange(len(bodies))
    for _ in range(ATTEMPTS):
        number, group = np.unique(group, return_inverse=True)
        if len(number) <= FEWEST * len(bodies):
            return None
        together = [
            _by_itself(assembly, [bodies[i] for i in np.flatnonzero(group == k)], checkpoint)
            for k in range(len(number))
        ]
        ends = [(int(group[some.one]), int(group[some.other]), some.node) for some in met]
        between = {Contact(min(i, j), max(i, j), node) for i, j, node in ends if i != j}
        try:
            mesh = stitched(together, list(between), assembly.implicit)
        except Apart as refused:
            if not any(refused.groups):
                return None
            links = [(min(some), k) for some in refused.groups for k in some]
            one, other = np.array(links, np.intp).T
            group = connected_pieces(one, other, len(number))[1].astype(np.intp)[group]
            continue
        return _with_origins(assembly, together, mesh)
    return None


def _by_itself(assembly: Assembly, bodies: list[Body], checkpoint: Checkpoint) -> Body:
    """Return some bodies of an assembly, united."""
    if len(bodies) == 1:
        return bodies[0]
    some = restricted(assembly.implicit, {body.implicit: body for body in bodies})
    assert some is not None
    return _remembered_union(some, checkpoint)


@remembered(limit=64, key=lambda some, checkpoint: signature(some.implicit))
def _remembered_union(some: Assembly, checkpoint: Checkpoint) -> Body:
    return _united(some, checkpoint)


def _with_origins(assembly: Assembly, bodies: list[Body], mesh: Stitched) -> Body:
    """Return a body with the mesh of several ones, which knows where its vertices come from."""
    place = {source: k for k, source in enumerate(assembly.sources)}
    origins = np.concatenate([
        np.array([place[source] for source in body.sources], np.int32)[body.origins]
        for body in bodies
    ])  # fmt: skip
    sharp = np.zeros(len(origins), dtype=bool)
    sharp[_numbered([body.creases for body in bodies], bodies)] = True
    faces, new = mesh.faces.astype(np.int32), mesh.parents < 0
    return Body(
        mesh.vertices,
        faces,
        mesh.normals,
        _spread(origins[mesh.parents], new, faces),
        assembly.sources,
        assembly.implicit,
        assembly.radius,
        assembly.step,
        np.flatnonzero(sharp[mesh.parents] & ~new),
        resampled=any(body.resampled for body in bodies),
    )


def _remade(assembly: Assembly, checkpoint: Checkpoint) -> Body:
    again = remade(assembly, checkpoint)
    if again is None or again.alone is None:
        raise UserError("These parts leave no solid. Move one of them a little, or undo.")
    return again.alone


def _without_specks(vertices: Array, faces: Faces, step: float) -> Flags:
    """Return which vertices (v,) belong to pieces that are larger than a speck.

    Where a fillet grazes a body, slivers of it may stay by themselves, or hollows within.
    """
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    once = a < b
    pieces, piece = connected_pieces(a[once], b[once], len(vertices))
    if pieces == 1:
        return np.ones(len(vertices), dtype=bool)
    one, two, three = (vertices[faces] - vertices.mean(axis=0)).transpose(1, 0, 2)
    sixfold = np.einsum("nk,nk->n", one, np.cross(two, three))
    volumes = np.abs(np.bincount(piece[faces[:, 0]], sixfold, pieces)) / 6.0
    large = volumes > min(SPECK * step**3, 0.5 * float(volumes.max()))
    return np.asarray(large[piece])


def _seam(assembly: Assembly, whole: UnionMesh) -> Index:
    """Return for every vertex of a fillet's faces the number of the fillet, else -1."""
    mine = {number: k for k, fillet in enumerate(assembly.fillets) for number in fillet.numbers}
    known, at = np.unique(whole.numbers, return_inverse=True)
    fillet = np.array([mine.get(int(number), -1) for number in known], np.intp)[at]
    seam = np.full(len(whole.vertices), -1)
    made = fillet >= 0
    np.maximum.at(seam, whole.faces[made], fillet[made, None])
    return seam


def _with_seams(
    assembly: Assembly, vertices: Array, faces: Faces, seam: Index, creases: Flags, number: Index
) -> Sewn:
    """Make the seams even; `number` is that of a vertex in the row of all fillets' vertices."""
    cells = np.concatenate([
        np.full(len(f.surface.vertices), f.cell) for f in assembly.fillets
    ])  # fmt: skip
    spacing = np.full(len(vertices), assembly.step)
    inside = number >= 0
    spacing[inside] = cells[number[inside]]
    smallest = min(fillet.cell for fillet in assembly.fillets)
    spacing[~inside] = np.minimum(spacing[~inside], 2.0 * smallest)
    return sewn(vertices, faces.astype(np.intp), seam, creases, spacing, assembly.implicit)


def _numbered(indices: list[Index], bodies: list[Body]) -> Index:
    """Return indices of vertices of several bodies as those of all their vertices in a row."""
    starts = np.cumsum([0, *(len(body.vertices) for body in bodies)])
    return np.concatenate([index + start for index, start in zip(indices, starts, strict=False)])


def _origins(bodies: list[Body], count: int) -> Faces:
    """Return the origins of all bodies' vertices, and those of fillets, which have none yet."""
    starts = np.cumsum([0, *(len(body.sources) for body in bodies)])
    own = [body.origins + np.int32(start) for body, start in zip(bodies, starts, strict=False)]
    origins = np.full(count, -1, np.int32)
    row = np.concatenate(own)
    origins[: len(row)] = row
    return origins


def _spread(origins: Faces, new: Flags, faces: Faces) -> Faces:
    """Take the origins of new vertices from neighbours, as far as there are any."""
    origins = np.where(new, np.int32(-1), origins)
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    while True:
        near = (origins[a] < 0) | (origins[b] < 0)
        a, b = a[near], b[near]
        reached = (origins[a] < 0) & (origins[b] >= 0)
        if not reached.any():
            return np.maximum(origins, np.int32(0))
        origins[a[reached]] = origins[b[reached]]


def _crease_normals(vertices: Array, faces: Faces, on_crease: Index) -> Array:
    """Return the mean normals of the faces around some vertices."""
    chosen = np.zeros(len(vertices), dtype=bool)
    chosen[on_crease] = True
    return vertex_normals(vertices, faces[chosen[faces].any(axis=1)])[on_crease]
