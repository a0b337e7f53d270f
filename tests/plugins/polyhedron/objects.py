"""Solids with flat faces as a CAD program makes them, and views of them as a person may draw them.

``OBJECTS`` are fourteen known ones; ``made(seed)`` is a random one. Lengths of a `View` are shares
of the diagonal of its picture; x right, y up, z away from the eye.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from manifold3d import CrossSection, Manifold, Mesh, triangulate

from bozzetto.view import Camera
from bozzetto_polyhedron.graph.line_graph import LineGraph

Face = tuple[tuple[int, ...], ...]

THINNEST = 0.08
"""Least length of an edge, and distance of a vertex from a foreign edge, in diagonals."""

CANVAS = (1200.0, 900.0)
SPAN = 560.0
"""Diagonal of a picture, px."""

TO_CANVAS = np.array((1.0, -1.0))
"""From a picture with y up, as objects are seen, to a canvas."""


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """Vertices, straight edges, and faces as rings: the outer one, then holes."""

    vertices: np.ndarray
    edges: np.ndarray
    faces: tuple[Face, ...]
    name: str = ""

    @cached_property
    def orthogonal(self) -> bool:
        """Whether all edges lie along three axes."""
        spans = np.abs(self.vertices[self.edges[:, 1]] - self.vertices[self.edges[:, 0]])
        return bool((np.sort(spans, axis=1)[:, 1] < 1e-4 * spans.max()).all())

    @cached_property
    def parts(self) -> int:
        """Number of connected parts of the edges."""
        label = np.arange(len(self.vertices))
        for _ in self.vertices:
            for first, second in self.edges:
                label[[first, second]] = min(label[first], label[second])
        return len(np.unique(label))

    @cached_property
    def triangles(self) -> np.ndarray:
        found = []
        for face in self.faces:
            ids = np.array([corner for ring in face for corner in ring])
            normal = newell(self.vertices[list(face[0])])
            keep = np.delete(np.arange(3), np.abs(normal).argmax())
            keep = keep if np.linalg.det(np.vstack((np.eye(3)[keep], normal))) > 0 else keep[::-1]
            rings = [self.vertices[list(ring)][:, keep] for ring in face]
            found += [ids[list(each)] for each in np.asarray(triangulate(rings))]
        return np.array(found)

    def face_sets(self) -> set[frozenset[frozenset[int]]]:
        return {frozenset(frozenset(ring) for ring in face) for face in self.faces}


def newell(ring: np.ndarray) -> np.ndarray:
    return 0.5 * np.cross(ring, np.roll(ring, -1, axis=0)).sum(0)


# -- from a solid to faces with rings --


def polyhedron_of(solid: Manifold, name: str = "", thinnest: float = THINNEST) -> Polyhedron | None:
    """Join coplanar triangles to faces; None where a feature is too thin or a vertex is pinched."""
    mesh = solid.to_mesh()
    points = np.asarray(mesh.vert_properties, float)[:, :3]
    triangles = np.asarray(mesh.tri_verts, int)
    if not len(triangles) or len(solid.decompose()) != 1:
        return None
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    rings = _rings(points, triangles)
    if rings is None:
        return None
    made = _contracted(points, rings)
    if made is None:
        return None
    found = Polyhedron(*made, name)
    return found if _sturdy(found, thinnest * diagonal) else None


def chance_made(
    make: Callable[[np.random.Generator], Manifold],
    salt: int,
    seed: int,
    name: str,
    thinnest: float,
) -> Polyhedron | None:
    """Make a part of random dimensions; None where chance made it too thin, eight times."""
    for number in range(8):
        made = make(np.random.default_rng((salt, seed, number)))
        found = polyhedron_of(made, name, thinnest)
        if found is not None:
            return found
    return None


def _rings(points: np.ndarray, triangles: np.ndarray) -> list[list[list[int]]] | None:
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    if areas.min() < 1e-9:
        return None
    normals /= areas[:, None]
    half = {(t[i], t[(i + 1) % 3]): k for k, t in enumerate(triangles) for i in range(3)}
    group = np.full(len(triangles), -1)
    for start in range(len(triangles)):
        if group[start] < 0:
            group[start] = start
            waiting = [start]
            for number in waiting:
                for i in range(3):
                    a, b = triangles[number][i], triangles[number][(i + 1) % 3]
                    other = half[b, a]
                    if group[other] < 0 and normals[other] @ normals[number] > 1 - 1e-6:
                        group[other] = start
                        waiting.append(other)
    found = []
    for name in np.unique(group):
        following: dict[int, int] = {}
        for number in np.flatnonzero(group == name):
            for i in range(3):
                a, b = triangles[number][i], triangles[number][(i + 1) % 3]
                if group[half[b, a]] != name:
                    if a in following:
                        return None
                    following[int(a)] = int(b)
        rings = []
        while following:
            ring = [next(iter(following))]
            while ring[-1] in following:
                ring.append(following.pop(ring[-1]))
            rings.append(ring[:-1])
        normal = normals[np.flatnonzero(group == name)[0]]
        rings.sort(key=lambda ring: -(newell(points[ring]) @ normal))
        found.append(rings)
    return found


def _contracted(
    points: np.ndarray, faces: list[list[list[int]]]
) -> tuple[np.ndarray, np.ndarray, tuple[Face, ...]] | None:
    """Leave out vertices on straight edges and those inside faces, and number the rest anew."""
    degree: dict[int, set[int]] = {}
    for face in faces:
        for ring in face:
            for a, b in zip(ring, ring[1:] + ring[:1], strict=True):
                degree.setdefault(a, set()).add(b)
                degree.setdefault(b, set()).add(a)
    straight = set()
    for vertex, near in degree.items():
        if len(near) == 2:
            a, b = (points[other] - points[vertex] for other in near)
            if np.linalg.norm(np.cross(a, b)) > 1e-4 * np.linalg.norm(a) * np.linalg.norm(b):
                return None
            straight.add(vertex)
    kept = sorted(set(degree) - straight)
    number = {vertex: k for k, vertex in enumerate(kept)}
    rings = tuple(
        tuple(tuple(number[v] for v in ring if v in number) for ring in face) for face in faces
    )
    if any(len(ring) < 3 for face in rings for ring in face):
        return None
    return points[kept], edges_of(rings), rings


def edges_of(faces: Sequence[Face]) -> np.ndarray:
    found = {
        (min(a, b), max(a, b))
        for face in faces
        for ring in face
        for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
    }
    return np.array(sorted(found))


def _sturdy(solid: Polyhedron, thinnest: float) -> bool:
    ends = solid.vertices[solid.edges]
    if not 6 <= len(solid.edges) <= 48:
        return False
    if np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min() < thinnest:
        return False
    return bool(_clearance(solid.vertices, solid.edges) > thinnest)


def _clearance(points: np.ndarray, edges: np.ndarray) -> float:
    """Least distance of a vertex from an edge that it does not end, in any dimension."""
    start, span = points[edges[:, 0]], points[edges[:, 1]] - points[edges[:, 0]]
    share = ((points[:, None] - start) * span).sum(2) / (span**2).sum(1)
    foot = start + np.clip(share, 0, 1)[..., None] * span
    apart = np.linalg.norm(points[:, None] - foot, axis=2)
    number = np.arange(len(edges))
    apart[edges[:, 0], number] = apart[edges[:, 1], number] = np.inf
    return float(apart.min())


# -- known objects --


def prism(outline: Sequence[Sequence[float]], height: float = 1.0, name: str = "") -> Polyhedron:
    base = np.asarray(outline, float)
    count = len(base)
    vertices = np.vstack(
        (np.column_stack((base, np.zeros(count))), np.column_stack((base, np.full(count, height))))
    )
    below, above = tuple(range(count)), tuple(range(count, 2 * count))
    sides = [((i, (i + 1) % count, count + (i + 1) % count, count + i),) for i in range(count)]
    faces: tuple[Face, ...] = ((below[::-1],), (above,), *sides)
    return Polyhedron(vertices, edges_of(faces), faces, name)


def frustum(
    count: int = 4, below: float = 2.0, above: float = 1.0, height: float = 1.2
) -> Polyhedron:
    turn = np.arange(count) * 2 * np.pi / count + np.pi / count
    ring = np.column_stack((np.cos(turn), np.sin(turn)))
    body = prism(ring, height, "frustum")
    return Polyhedron(
        np.vstack(
            (
                np.column_stack((below * ring, np.zeros(count))),
                np.column_stack((above * ring, np.full(count, height))),
            )
        ),
        body.edges,
        body.faces,
        body.name,
    )


def box(size: Sequence[float], at: Sequence[float] = (0, 0, 0)) -> Manifold:
    return Manifold.cube(tuple(map(float, size))).translate(tuple(map(float, at)))


def _solid(solid: Manifold, name: str) -> Polyhedron:
    found = polyhedron_of(solid, name)
    assert found is not None
    return found


L_SHAPE = ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))
STAIRS = ((0, 0), (3, 0), (3, 1), (2, 1), (2, 2), (1, 2), (1, 3), (0, 3))
U_SHAPE = ((0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2))
T_SHAPE = ((1, 0), (2, 0), (2, 1.5), (3, 1.5), (3, 2.5), (0, 2.5), (0, 1.5), (1, 1.5))
PLUS = (
    *((1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2)),
    *((2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)),
)
FIVE_STAIRS = (
    *((0, 0), (5, 0), (5, 1), (4, 1), (4, 2), (3, 2)),
    *((3, 3), (2, 3), (2, 4), (1, 4), (1, 5), (0, 5)),
)
HEXAGON = tuple((np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3)

OBJECTS: dict[str, Polyhedron] = {
    "box": prism(((0, 0), (1.2, 0), (1.2, 1), (0, 1)), 1.4, "box"),
    "wedge": prism(((0, 0), (2, 0), (0, 1.2)), 1.5, "wedge"),
    "L": prism(L_SHAPE, 1.3, "L"),
    "stairs": prism(STAIRS, 2.0, "stairs"),
    "U": prism(U_SHAPE, 1.6, "U"),
    "T": prism(T_SHAPE, 1.2, "T"),
    "house": prism(((0, 0), (2, 0), (2, 1.2), (1, 2), (0, 1.2)), 2.6, "house"),
    "frustum": frustum(),
    "notch": _solid(box((2, 2, 2)) - box((1, 1, 1), (1, 1, 1)), "notch"),
    "wedge step": prism(((0, 0), (3, 0), (3, 1), (2, 1), (1, 2), (0, 2)), 1.5, "wedge step"),
    "hexagonal prism": prism(HEXAGON, 1.5, "hexagonal prism"),
    "plus": prism(PLUS, 1.2, "plus"),
    "five stairs": prism(FIVE_STAIRS, 3.0, "five stairs"),
    "hole": _solid(box((3, 3, 2)) - box((1.1, 1.2, 4), (1, 0.8, -1)), "hole"),
}

UNIONS: dict[str, Polyhedron] = {
    "flush boss": _solid(box((3, 2, 1)) + box((1, 1, 1), (1, 0, 1)), "flush boss"),
}
"""Solids whose lines alone do not tell their faces."""


# -- random objects --


def _extruded(outline: np.ndarray, height: float) -> Manifold:
    return CrossSection([np.asarray(outline, float)]).extrude(height)


def _size(rng: np.random.Generator, low: float = 1.0, high: float = 3.0) -> np.ndarray:
    return np.round(rng.uniform(low, high, 3), 2)


def _rectilinear(rng: np.random.Generator) -> Manifold:
    """A prism over a union of two to four rectangles whose sides may lie on one line."""
    x = np.round(np.cumsum(rng.uniform(0.6, 1.4, 4)), 2)
    y = np.round(np.cumsum(rng.uniform(0.6, 1.4, 4)), 2)
    found = CrossSection()
    for _ in range(rng.integers(2, 5)):
        a, b = np.sort(rng.choice(4, 2, replace=False))
        c, d = np.sort(rng.choice(4, 2, replace=False))
        found += CrossSection([np.array([(x[a], y[c]), (x[b], y[c]), (x[b], y[d]), (x[a], y[d])])])
    return found.extrude(float(rng.uniform(0.8, 3.0)))


def _stairs(rng: np.random.Generator) -> Manifold:
    steps = int(rng.integers(2, 5))
    run = np.concatenate(([0.0], np.cumsum(rng.uniform(0.6, 1.2, steps))))
    rise = np.concatenate(([0.0], np.cumsum(rng.uniform(0.5, 1.0, steps))))[::-1]
    outline = [(0.0, 0.0), (run[-1], 0.0)]
    for k in range(steps, 0, -1):
        outline += [(run[k], rise[k - 1]), (run[k - 1], rise[k - 1])]
    return _extruded(np.array(outline), float(rng.uniform(1.0, 3.0)))


def _known_prism(rng: np.random.Generator) -> Manifold:
    shapes = (L_SHAPE, U_SHAPE, T_SHAPE, PLUS, STAIRS)
    shape = np.array(shapes[rng.integers(len(shapes))], float)
    for axis in range(2):
        values = np.unique(shape[:, axis])
        moved = np.cumsum(
            np.diff(values, prepend=values[0] - 1) * rng.uniform(0.6, 1.5, len(values))
        )
        shape[:, axis] = moved[np.searchsorted(values, shape[:, axis])]
    return _extruded(shape, float(rng.uniform(0.8, 3.0)))


def _boxes(rng: np.random.Generator) -> Manifold:
    """A box, and others on or in it whose faces are often flush."""
    size = _size(rng, 1.5, 3.0)
    found = box(size)
    for _ in range(rng.integers(1, 3)):
        inner = np.round(size * rng.uniform(0.3, 0.7, 3), 2)
        at = np.where(rng.random(3) < 0.5, 0.0, size - inner)
        free = rng.integers(3)
        at[free] = np.round(rng.uniform(0.15, 0.85) * (size - inner)[free], 2)
        if rng.random() < 0.5:
            found -= box(inner, at)
        else:
            upward = rng.integers(3)
            at[upward] = size[upward]
            found += box(inner, at)
    return found


def _notched(rng: np.random.Generator) -> Manifold:
    size = _size(rng, 1.5, 3.0)
    inner = np.round(size * rng.uniform(0.3, 0.7, 3), 2)
    at = np.where(rng.random(3) < 0.5, 0.0, size - inner)
    through = rng.integers(4)
    if through < 2:
        at[through], inner[through] = -1.0, 9.0
    return box(size) - box(inner, at)


def _polygon(rng: np.random.Generator) -> np.ndarray:
    """A polygon with slanted sides: cut corners, a gable, a trapezium, or a star-shaped ring."""
    kind = rng.integers(6)
    w, h = rng.uniform(1.2, 3.0, 2)
    a, b = rng.uniform(0.25, 0.7, 2)
    if kind == 0:
        return np.array([(0, 0), (w, 0), (w, h * a), (w * b, h), (0, h)])
    if kind == 1:
        return np.array([(0, 0), (w, 0), (w, h * a), (w * 0.5, h), (0, h * a)])
    if kind == 2:
        return np.array([(0, 0), (w, 0), (w * (1 - a / 2), h), (w * a / 2, h)])
    if kind == 3:
        return np.array([(0, 0), (w, 0), (w * a, h)])
    if kind == 4:
        count = int(rng.integers(5, 9))
        turn = np.arange(count) * 2 * np.pi / count
        return w * np.column_stack((np.cos(turn), np.sin(turn)))
    count = int(rng.integers(4, 8))
    turn = np.sort(rng.uniform(0, 2 * np.pi, count))
    return np.column_stack((np.cos(turn), np.sin(turn))) * rng.uniform(0.7, 1.5, (count, 1))


def _slanted_prism(rng: np.random.Generator) -> Manifold:
    return _extruded(_polygon(rng), float(rng.uniform(0.8, 3.0)))


def _slanted_step(rng: np.random.Generator) -> Manifold:
    w, h = rng.uniform(2.0, 3.5, 2)
    a, b, c = rng.uniform(0.3, 0.7, 3)
    outlines = (
        [(0, 0), (w, 0), (w, h * a), (w * b, h * a), (w * b * c, h), (0, h)],
        [(0, 0), (w, 0), (w, h * a), (w * 0.7, h * a), (w * 0.7 * b, h), (0, h), (0, h * 0.5)],
        [
            (0, 0),
            (w, 0),
            (w, h),
            (w * (0.5 + a / 3), h),
            (w / 2, h * b),
            (w * (0.5 - a / 3), h),
            (0, h),
        ],
    )
    return _extruded(np.array(outlines[rng.integers(3)]), float(rng.uniform(0.8, 3.0)))


def _tapered(rng: np.random.Generator) -> Manifold:
    outline = _polygon(rng)
    top = rng.uniform(0.4, 0.75, 2)
    if rng.random() < 0.5:
        top[1] = top[0]
    section = CrossSection([outline - outline.mean(0)])
    return section.extrude(float(rng.uniform(0.8, 2.5)), scale_top=tuple(top))


def _chamfered(rng: np.random.Generator) -> Manifold:
    base = (_known_prism if rng.random() < 0.3 else lambda r: box(_size(r, 1.5, 3.0)))(rng)
    low, high = np.array(base.bounding_box()).reshape(2, 3)
    axes = rng.permutation(3)
    normal = np.zeros(3)
    normal[axes[:2]] = rng.uniform(0.5, 1.0, 2) * rng.choice((-1, 1), 2)
    if rng.random() < 0.25:
        normal[axes[2]] = rng.uniform(0.4, 1.0)
    normal /= np.linalg.norm(normal)
    corner = np.where(normal > 0, high, low)
    depth = float(rng.uniform(0.25, 0.6)) * float((high - low).min()) * 0.8
    return base.trim_by_plane(tuple(-normal), float(-(corner @ normal) + depth))


def _looped(rng: np.random.Generator) -> Manifold:
    """A block with a pocket, a boss or a through-hole off its middle."""
    if rng.random() < 0.65:
        base = box(_size(rng, 1.8, 3.2))
    else:
        base = _known_prism(rng) if rng.random() < 0.5 else _slanted_prism(rng)
    if base.is_empty():
        return base
    low, high = np.array(base.bounding_box()).reshape(2, 3)
    size = high - low
    inner = size[:2] * rng.uniform(0.22, 0.5, 2)
    at = low[:2] + size[:2] * rng.uniform(0.12, 0.45, 2)
    depth = float(size[2] * rng.uniform(0.3, 0.6))
    kind = rng.integers(3)
    if kind == 0:
        return base - box((*inner, size[2] + 2), (*at, low[2] - 1))
    if kind == 1:
        return base - box((*inner, depth + 1), (*at, high[2] - depth))
    return base + box((*inner, depth), (*at, high[2]))


MAKERS: dict[str, tuple[Callable[[np.random.Generator], Manifold], float]] = {
    "rectilinear prism": (_rectilinear, 1.6),
    "stairs": (_stairs, 0.8),
    "letter prism": (_known_prism, 1.2),
    "boxes": (_boxes, 0.8),
    "notched box": (_notched, 1.0),
    "slanted prism": (_slanted_prism, 2.2),
    "slanted step": (_slanted_step, 1.2),
    "tapered": (_tapered, 0.7),
    "chamfered": (_chamfered, 0.9),
    "looped": (_looped, 1.0),
}
"""Ways to make a solid, and how often they are taken."""


def made(seed: int, kinds: Sequence[str] = tuple(MAKERS)) -> Polyhedron:
    """Make a random solid; the same seed gives the same one."""
    rng = np.random.default_rng((11, seed))
    shares = np.array([MAKERS[kind][1] for kind in kinds])
    kind = kinds[rng.choice(len(kinds), p=shares / shares.sum())]
    while True:
        found = polyhedron_of(MAKERS[kind][0](rng), kind)
        if found is not None:
            return found


# -- views --


@dataclass(frozen=True, eq=False)
class View:
    """A solid as it is seen: ``space`` in the frame of the eye, ``plane`` its picture."""

    solid: Polyhedron
    space: np.ndarray
    plane: np.ndarray
    perspective: float = 0.0
    hidden: np.ndarray = field(default_factory=lambda: np.zeros(0))


def view(solid: Polyhedron, seed: int, distance: float | None = None) -> View | None:
    """See a solid from a random side in general position; None where none is found.

    Parameters
    ----------
    solid : Polyhedron
    seed : int
    distance : float, optional
        Of the eye, in sizes of the object; a parallel view without.
    """
    rng = np.random.default_rng((7, seed))
    for _ in range(120):
        space = solid.vertices - solid.vertices.mean(0)
        space = np.roll(space, rng.integers(3), axis=1) @ random_rotation(rng).T
        away = np.ones(len(space))
        depth = 0.0
        if distance is not None:
            depth = 1.0 / (distance * float(np.linalg.norm(np.ptp(space, axis=0))))
            away = 1.0 + depth * space[:, 2]
            if away.min() < 0.1:
                continue
        plane = space[:, :2] / away[:, None]
        diagonal = float(np.linalg.norm(np.ptp(plane, axis=0)))
        space, plane = space / diagonal, plane / diagonal
        apart = np.linalg.norm(plane[:, None] - plane, axis=2) + np.eye(len(plane))
        if apart.min() > 0.03 and _clearance(plane, solid.edges) > 0.012:
            found = View(solid, space, plane, depth * diagonal)
            return View(solid, space, plane, depth * diagonal, hidden_shares(found))
    return None


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    azimuth, elevation = rng.uniform(np.radians((20, 18)), np.radians((70, 45)))
    azimuth += rng.integers(4) * np.pi / 2
    roll = rng.normal(0, np.radians(3))
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    about = np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, se, ce], [0, ce, -se]])
    cr, sr = np.cos(roll), np.sin(roll)
    return np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]]) @ tilt @ about


def hidden_shares(seen: View, samples: int = 9) -> np.ndarray:
    """Share of each edge that lies behind a face."""
    return hidden_places(seen, np.linspace(0.06, 0.94, samples)).mean(1)


def hidden_places(seen: View, share: np.ndarray) -> np.ndarray:
    """Whether each edge lies behind a face at places along it, (m, s); shares of its length."""
    ends = seen.space[seen.solid.edges]
    points = ends[:, None, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])[:, None]
    points = points.reshape(-1, 3)
    corners = seen.space[seen.solid.triangles]
    towards = np.array([0.0, 0.0, -1.0]) - seen.perspective * points
    if seen.perspective:
        towards = np.array([0.0, 0.0, -1.0 / seen.perspective]) - points
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    cross = np.cross(towards[:, None], second[None])
    level = (cross * first).sum(2)
    level = np.where(np.abs(level) < 1e-12, 1e-12, level)
    start = points[:, None] - corners[None, :, 0]
    u = (start * cross).sum(2) / level
    turn = np.cross(start, first[None])
    v = (turn * towards[:, None]).sum(2) / level
    t = (turn * second).sum(2) / level
    reach = np.linalg.norm(towards, axis=1)[:, None] * t
    behind = (u > 1e-6) & (v > 1e-6) & (u + v < 1 - 1e-6) & (reach > 2e-3)
    return behind.any(1).reshape(-1, len(share))


def graph_of(
    seen: View, noise: float, seed: int, marks: float | None = None
) -> tuple[LineGraph, np.ndarray]:
    """Draw a view with an unsteady hand.

    Parameters
    ----------
    seen : View
    noise : float
        Standard deviation of a corner, diagonals. What the graph says of it is an estimate.
    seed : int
    marks : float, optional
        Share of lines that are marked wrongly as hidden or visible; all alike without.

    Returns
    -------
    graph : LineGraph
    plane : (n, 2) array
        The corners as drawn, diagonals.
    """
    rng = np.random.default_rng((13, seed))
    plane = seen.plane + rng.normal(0, noise / np.sqrt(2), seen.plane.shape)
    estimate = max(noise, 0.001) * float(np.exp(rng.normal(0, 0.25)))
    light = np.zeros(len(seen.solid.edges))
    if marks is not None:
        light = (seen.hidden > 0.5) ^ (rng.random(len(light)) < marks)
        light = np.where(light, 0.9, 0.1)
    places = np.multiply(CANVAS, 0.5) + SPAN * plane * (1, -1)
    lines = np.sort(seen.solid.edges, axis=1)
    strokes = tuple((k,) for k in range(len(lines)))
    return LineGraph(places, lines, light, strokes, (), estimate * SPAN, ()), plane


CAMERA = Camera(kind="orthographic", eye=(300.0, -400.0, 350.0), height=200.0, viewport=CANVAS)


def perspective_camera(seen: View) -> Camera:
    """Return the camera through which a perspective view was seen, on the canvas of `graph_of`."""
    scale = 150.0
    distance = scale / seen.perspective
    eye = np.array((0.5, -0.7, 0.5))
    eye *= distance / np.linalg.norm(eye)
    visible = scale / SPAN * CANVAS[1]
    fov = float(np.degrees(2 * np.arctan(visible / (2 * distance))))
    return Camera(eye=tuple(eye), fov_y=fov, viewport=CANVAS)


# -- what is right --


def in_eye_frame(vertices: np.ndarray, camera: Camera) -> np.ndarray:
    """Return vertices right, up and away from the eye, in diagonals of a picture by `graph_of`."""
    return camera.view_space(vertices) * camera.pixels_per_mm / SPAN


def errors(seen: View, shape: np.ndarray, mirrored: bool = True) -> tuple[float, float]:
    """Return the distance after alignment, diagonals, and the mean angle of edges, degrees."""
    found = []
    edges = seen.solid.edges
    true = seen.space - seen.space.mean(0)
    for side in (1.0, -1.0) if mirrored else (1.0,):
        given = (shape - shape.mean(0)) * (1.0, 1.0, side)
        u, v = given[edges[:, 1]] - given[edges[:, 0]], true[edges[:, 1]] - true[edges[:, 0]]
        cosines = (u * v).sum(1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
        angle = float(np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean())
        left, values, right = np.linalg.svd(given.T @ true)
        fitted = given @ (left @ right) * (values.sum() / (given**2).sum())
        found.append((float(np.sqrt(((fitted - true) ** 2).sum(1).mean())), angle))
    return min(found, key=lambda each: each[1])


def is_right(seen: View, shape: np.ndarray, noise: float, mirrored: bool = True) -> bool:
    """Whether a shape is the one that was seen, as far as a drawing so noisy can tell."""
    distance, angle = errors(seen, shape, mirrored)
    return distance < 0.06 + noise and angle < 10.0 + 115.0 * noise


def mesh_of(solid: Polyhedron) -> Manifold:
    return Manifold(
        Mesh(
            vert_properties=solid.vertices.astype(np.float32),
            tri_verts=solid.triangles.astype(np.uint32),
        )
    )
