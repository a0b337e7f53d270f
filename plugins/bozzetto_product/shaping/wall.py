"""Walls of even thickness: closed bodies become hollow, open sheets become plates.

Each surface and its offset bound a slab, and wedges go between slabs that gape at creases. A body
without them is its hollow; open sheets are their union. What comes of it is measured, and where a
slab ran into itself the offset is taken from the field of distances instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Index, frozen
from bozzetto.geometry import Mesh
from bozzetto.plugin import remembered
from bozzetto_product.shaping.slivers import contracted, moved_apart
from bozzetto_product.shaping.wall_field import SAMPLES_PER_WALL, offset_by_field, places_on
from bozzetto_product.shaping.wall_slabs import Sheets, Slab, slabs_of, wedges_of

if TYPE_CHECKING:
    from manifold3d import Manifold

THIN: Final = 0.97
"""Share of the thickness asked for below which a wall is not what slabs promise: chords of the
meshes and arcs about creases cost less than that."""

MOST_BENT: Final = 8000
"""Prisms, of open sheets, up to which they are united."""

LEAST_HOLLOW: Final = 0.01
"""Volume of a hollow, in cubes of the thickness, below which it is left full."""

SLIVER: Final = 1e-5
"""Length, as share of the size, of edges that are drawn together: above what single precision
tells apart, below anything seen."""

ROUNDING: Final = 1e-9
"""Share of the size below which a coordinate is nought."""

TURN: Final = frozen(
    np.array(((2, 3, 6), (3, -6, 2), (6, 2, -3)))
    / 7.0
    @ ((0.8, -0.6, 0), (0.6, 0.8, 0), (0, 0, 1)),
    np.float64,
)
"""A rotation: bodies are combined in a frame in which no wall lies across an axis. manifold3d takes
those whose boxes only touch for apart, and does not join them."""

NOBODY: Final = -1
"""Number of the surface of triangles that belong to none."""


@dataclass(frozen=True, eq=False)
class Wall:
    """A body of walls.

    Parameters
    ----------
    mesh : Mesh
        Closed: the surfaces that were given, their offsets, and rims between them.
    groups : tuple of (int, bool, int)
        Triangles that follow one another: the number of their surface, `NOBODY` where they belong
        to none; whether they are that surface, or else its offset or a rim; and how many.
    rounded : bool
        The offset is from the field of distances: its creases are rounded off.
    thinnest, thickest : float
        Least and greatest distance of the offset from the surfaces, mm.
    """

    mesh: Mesh
    groups: tuple[tuple[int, bool, int], ...]
    rounded: bool
    thinnest: float
    thickest: float

    @property
    def offset(self) -> Mesh:
        """The triangles that are not the given surfaces."""
        own = np.concatenate([np.full(count, own) for _, own, count in self.groups])
        return Mesh(self.mesh.vertices, self.mesh.faces[~own])


MOST_MENDED: Final = 400
"""Places of a far side that is too near to its surface, up to which balls mend it."""

BALL_SEGMENTS: Final = 48
"""Sides round a ball about a place of the surface: it is within a fifth of a percent of round."""

MENDS: Final = 3
"""Rounds in which that is tried."""


def _key(
    meshes: Sequence[Mesh],
    thickness: float,
    outward: bool,
    checkpoint: Callable[[], None],
    whole: Sequence[Mesh] = (),
) -> tuple[object, ...]:
    return tuple(meshes), thickness, outward, tuple(whole)


@remembered(limit=16, key=_key)
def walled(
    meshes: Sequence[Mesh],
    thickness: float,
    outward: bool = False,
    checkpoint: Callable[[], None] = lambda: None,
    whole: Sequence[Mesh] = (),
) -> Wall | None:
    """Give surfaces that hang together a wall.

    Parameters
    ----------
    meshes : sequence of Mesh
        With normals, turned alike, and with vertices at the very same places on common edges. They
        look outward where they are closed.
    thickness : float
        mm, positive.
    outward : bool
        To the side of the normals.
    checkpoint : callable
        Called between the steps.
    whole : sequence of Mesh
        The same closed body without its openings, where it has some: the walls are those of this
        one, and the openings go through them. Their numbers in `Wall.groups` follow the others.

    Returns
    -------
    Wall or None
        None where the wall is too thick: nothing is left hollow, or an open sheet bends too much
        for it.
    """
    if whole:
        hollow = walled.__wrapped__(whole, thickness, outward, checkpoint)
        return None if hollow is None else _opened(meshes, hollow)
    sheets = Sheets.of(meshes, TURN)
    body, numbers = _body(sheets)
    closed = body.status().name == "NoError" and body.num_tri() > 0
    offset = thickness if outward else -thickness
    slabs = slabs_of(sheets, offset, lean=not closed)
    checkpoint()
    bent = sum(len(slab.prisms) for slab in slabs)
    if closed and bent:
        return _by_field(body, numbers, thickness, outward, checkpoint)
    if bent > MOST_BENT:
        return None
    added, tags = _united(slabs, wedges_of(sheets, offset))
    checkpoint()
    tags |= numbers
    if not closed:
        return _plate(added, tags, thickness)
    made = _sharp(body, added, tags, thickness, outward)
    return made or _by_field(body, tags, thickness, outward, checkpoint)


Tags = dict[int, tuple[int, bool]]
"""Number and kind of surface of triangles, by the id that manifold3d keeps for them."""


def _body(sheets: Sheets) -> tuple[Manifold, Tags]:
    """Return the body within the surfaces, if they are closed, and what its triangles are."""
    _, first, same = np.unique(
        np.concatenate(sheets.places), return_index=True, return_inverse=True
    )
    vertices = np.concatenate(sheets.vertices)[first]
    starts = np.cumsum([0, *map(len, sheets.vertices[:-1])])
    rows = [same.ravel()[f + start] for f, start in zip(sheets.faces, starts, strict=True)]
    sound = [(r != np.roll(r, 1, axis=1)).all(axis=1) for r in rows]
    rows = [r[s] for r, s in zip(rows, sound, strict=True)]
    return _manifold(
        vertices, np.concatenate(rows), [(n, True, len(r)) for n, r in enumerate(rows)]
    )


def _manifold(
    vertices: Array, faces: Index, groups: Sequence[tuple[int, bool, int]]
) -> tuple[Manifold, Tags]:
    from manifold3d import Manifold, Mesh64

    first = Manifold.reserve_ids(len(groups))
    ends = 3 * np.cumsum([0, *(count for *_, count in groups)])
    mesh = Mesh64(
        np.array(vertices, order="C"),
        np.ascontiguousarray(faces, dtype=np.uint64),
        run_index=ends.astype(np.uint64),
        run_original_id=(first + np.arange(len(groups))).astype(np.uint32),
    )
    tags = {first + k: (number, own) for k, (number, own, _) in enumerate(groups)}
    return Manifold(mesh), tags


def _united(slabs: Sequence[Slab], wedges: Sequence[Array]) -> tuple[Manifold, Tags]:
    from manifold3d import Manifold, OpType

    tags: Tags = {}
    parts = []
    for number, slab in enumerate(slabs):
        for prism in slab.prisms:
            part, own = _prism(prism, number)
            tags |= own
            parts.append(part)
        if not slab.kept:
            continue
        rest = len(slab.faces) - slab.kept
        groups = [(number, True, slab.kept), (number, False, rest)]
        part, own = _manifold(slab.vertices, slab.faces, groups)
        tags |= own
        parts.append(part)
    parts += [Manifold.hull_points(np.ascontiguousarray(wedge)) for wedge in wedges]
    return Manifold.batch_boolean(parts, OpType.Add), tags


def _prism(corners: Array, number: int) -> tuple[Manifold, Tags]:
    """Return the hull of a triangle of a surface, the first three corners, and of its offset."""
    from manifold3d import Manifold

    hull = Manifold.hull_points(np.ascontiguousarray(corners))
    if hull.is_empty():
        return hull, {}
    mesh = hull.to_mesh64()
    places, faces = mesh.vert_properties[:, :3], mesh.tri_verts.astype(np.intp)
    first = (places[:, None] == corners[:3]).all(axis=2).any(axis=1)
    own = first[faces].all(axis=1)
    groups = [(number, True, int(own.sum())), (number, False, int((~own).sum()))]
    return _manifold(
        places, faces[np.argsort(~own, kind="stable")], [each for each in groups if each[2]]
    )


def _sharp(
    body: Manifold, added: Manifold, tags: Tags, thickness: float, outward: bool
) -> Wall | None:
    """Return the body less its hollow, or a coat about it; None where slabs ran into themselves."""
    from manifold3d import Manifold, OpType

    limit = Manifold.batch_boolean([body, added], OpType.Add) if outward else body - added
    full = _bodies(limit, thickness)
    if full.is_empty():
        return None
    return _between(body, full, tags, thickness, outward, rounded=False)


def _bodies(part: Manifold, thickness: float) -> Manifold:
    """Return what is left without hollows, and without specks."""
    from manifold3d import Manifold

    least = LEAST_HOLLOW * thickness**3
    return Manifold.compose([each for each in part.decompose() if each.volume() > least])


def _without_specks(part: Manifold, thickness: float) -> Manifold:
    """Return what is left without bodies and hollows that are specks."""
    from manifold3d import Manifold

    least = LEAST_HOLLOW * thickness**3
    return Manifold.compose([each for each in part.decompose() if abs(each.volume()) > least])


def _by_field(
    body: Manifold,
    tags: Tags,
    thickness: float,
    outward: bool,
    checkpoint: Callable[[], None],
) -> Wall | None:
    own = body.to_mesh64()
    mesh = Mesh(own.vert_properties[:, :3].astype(np.float32), own.tri_verts.astype(np.int32))
    vertices, faces = offset_by_field(mesh, thickness, outward, checkpoint)
    if not len(faces):
        return None
    limit, found = _manifold(vertices, faces, [(NOBODY, False, len(faces))])
    full = _bodies(limit, thickness)
    if full.is_empty():
        return None
    return _between(body, full, tags | found, thickness, outward, rounded=True)


def _between(
    body: Manifold, limit: Manifold, tags: Tags, thickness: float, outward: bool, *, rounded: bool
) -> Wall | None:
    """Return what is between a body and its offset, if the offset keeps its distance."""
    from scipy.spatial import cKDTree

    size = _size(body)
    vertices, faces, groups = _taken(body, tags)
    mesh = Mesh(vertices.astype(np.float32), faces.astype(np.int32))
    places = places_on(mesh, thickness / SAMPLES_PER_WALL)
    tree = cKDTree(places)
    for _ in range(MENDS):
        other, inner, more = _taken(limit.simplify(SLIVER * size), tags)
        found = tree.query(other)
        away, feet = np.asarray(found[0]), np.asarray(found[1])
        near = away < THIN * thickness
        if rounded or not near.any():
            break
        if int(near.sum()) > MOST_MENDED:
            return None
        limit = _with_balls(limit, places[np.unique(feet[near])], thickness, outward)
    if not len(other) or (not rounded and away.min() < THIN * thickness):
        return None
    if outward:
        faces = faces[:, ::-1]
    else:
        inner = inner[:, ::-1]
    more = [(number, False, count) for number, _, count in more]
    return _wall(
        np.concatenate((vertices, other)),
        np.concatenate((faces, inner + len(vertices))),
        [*groups, *more],
        size,
        rounded=rounded,
        thinnest=float(away.min()),
        thickest=float(away.max()),
    )


def _with_balls(limit: Manifold, places: Array, thickness: float, outward: bool) -> Manifold:
    """Return a far side that keeps its distance from places of the surface, too.

    Where a crease ends in a smooth surface a wedge may be missing beside it.
    """
    from manifold3d import Manifold, OpType

    ball = Manifold.sphere(thickness, BALL_SEGMENTS)
    balls = [ball.translate(place) for place in places.tolist()]
    added = Manifold.batch_boolean(balls, OpType.Add)
    return _bodies(limit + added if outward else limit - added, thickness)


def _opened(meshes: Sequence[Mesh], walls: Wall) -> Wall | None:
    """Return walls through which the openings of a body go.

    Parameters
    ----------
    meshes : sequence of Mesh
        The body with its openings.
    walls : Wall
        Those of the body without them; they grow inward.
    """
    sheets = Sheets.of(meshes, TURN)
    body, tags = _body(sheets)
    far = walls.offset
    groups = [
        (number if number == NOBODY else number + len(meshes), False, count)
        for number, own, count in walls.groups
        if not own
    ]
    hollow, other = _manifold(
        far.vertices.astype(float) @ TURN.T, far.faces[:, ::-1].astype(np.intp), groups
    )
    tags |= other
    made = _without_specks(body - hollow, walls.thinnest)
    size = _size(made)
    vertices, faces, found = _taken(made.simplify(SLIVER * size), tags)
    if not len(faces):
        return None
    return _wall(
        vertices,
        faces,
        found,
        size,
        rounded=walls.rounded,
        thinnest=walls.thinnest,
        thickest=walls.thickest,
    )


def _size(part: Manifold) -> float:
    return float(np.linalg.norm(np.ptp(np.reshape(part.bounding_box(), (2, 3)), axis=0)))


def _plate(added: Manifold, tags: Tags, thickness: float) -> Wall | None:
    """Return open surfaces as a plate."""
    size = _size(added)
    whole = _without_specks(added.simplify(SLIVER * size), thickness)
    vertices, faces, groups = _taken(whole, tags)
    if not len(faces):
        return None
    return _wall(
        vertices, faces, groups, size, rounded=False, thinnest=thickness, thickest=thickness
    )


def _wall(
    vertices: Array,
    faces: Index,
    groups: Sequence[tuple[int, bool, int]],
    size: float,
    *,
    rounded: bool,
    thinnest: float,
    thickest: float,
) -> Wall:
    """Return triangles turned back, closed also for files that know corners by their places."""
    vertices, faces, kept = contracted(vertices @ TURN, faces, SLIVER * size)
    label = np.repeat(np.arange(len(groups)), [count for *_, count in groups])[kept]
    counts = np.bincount(label, minlength=len(groups)).tolist()
    left = [
        (number, own, count)
        for (number, own, _), count in zip(groups, counts, strict=True)
        if count
    ]
    vertices[np.abs(vertices) < ROUNDING * size] = 0.0
    return Wall(moved_apart(vertices, faces, size), tuple(left), rounded, thinnest, thickest)


def _taken(part: Manifold, tags: Tags) -> tuple[Array, Index, list[tuple[int, bool, int]]]:
    """Return vertices and faces, those of one surface after another."""
    mesh = part.to_mesh64()
    faces = mesh.tri_verts.astype(np.intp)
    counts = np.diff(mesh.run_index) // 3
    which = [tags.get(int(each), (NOBODY, False)) for each in mesh.run_original_id]
    label = np.repeat(np.arange(len(which)), counts.astype(np.intp))
    order: list[Index] = [np.empty(0, np.intp)]
    groups: list[tuple[int, bool, int]] = []
    for number, own in sorted(set(which)):
        runs = [k for k, each in enumerate(which) if each == (number, own)]
        rows = np.flatnonzero(np.isin(label, runs))
        if len(rows):
            order.append(rows)
            groups.append((number, own, len(rows)))
    return mesh.vert_properties[:, :3], faces[np.concatenate(order)], groups
