"""Faces and edges that are changed step by step, before they become a boundary representation."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.geometry import Brep, Curve, Face, Mesh, ParameterCurve, Trim, shaded_faces
from bozzetto.plugin import cached_property, remembered
from bozzetto_product.details.floor import Floor

CREASE: Final = np.cos(np.radians(3.0))
"""Least cosine between faces that meet smoothly over an edge."""

COARSE: Final = 2e-4
"""Distance of shown triangles from the surface, as share of the size of the whole."""


@dataclass(frozen=True)
class Owner:
    """Owner of a face.

    Parameters
    ----------
    patch : int
        Number of the solved patch.
    detail : int
        Number of the solved detail that made it or colours it; −1 for none.
    made : bool
        Whether the detail made it: a wall or a floor, not a piece of the patch.
    floor : Floor, optional
        The floor that it is a piece of.
    """

    patch: int
    detail: int = -1
    made: bool = False
    floor: Floor | None = None

    @property
    def is_wall(self) -> bool:
        """Whether it is a wall: only what goes over creases is drawn over it."""
        return self.made and self.floor is None

    def is_of_one_area(self, other: Owner) -> bool:
        """Whether both are pieces of one patch, or of one floor."""
        walls = self.is_wall or other.is_wall
        return self.patch == other.patch and self.floor is other.floor and not walls


def group_of(owner: Owner) -> tuple[int, int]:
    """Return what faces are listed by: pieces of patches first, then each detail's."""
    return (0, owner.patch) if owner.detail < 0 else (1, owner.detail)


@dataclass(frozen=True, eq=False)
class Shell:
    """Edges, faces, and what each face belongs to.

    Parameters
    ----------
    edges : tuple of Curve
    faces : tuple of Face
    owners : tuple of Owner
        One for each face.
    """

    edges: tuple[Curve, ...]
    faces: tuple[Face, ...]
    owners: tuple[Owner, ...]

    @cached_property
    def size(self) -> float:
        """Diagonal of the box round the control points of patches, mm: no detail changes it."""
        own = [f.surface for f, o in zip(self.faces, self.owners, strict=True) if not o.made]
        nets = {id(surface): surface.control_points.reshape(-1, 3) for surface in own}
        return float(np.linalg.norm(np.ptp(np.concatenate(list(nets.values())), axis=0)))

    @cached_property
    def users(self) -> Mapping[int, tuple[tuple[int, Trim], ...]]:
        """The faces that run each edge, with the side that it is of them."""
        found: dict[int, list[tuple[int, Trim]]] = {}
        for number, face in enumerate(self.faces):
            for trim in face.trims:
                if trim.edge is not None:
                    found.setdefault(trim.edge, []).append((number, trim))
        return {edge: tuple(rows) for edge, rows in found.items()}

    @property
    def is_closed(self) -> bool:
        """Whether each edge has two sides."""
        return all(len(rows) == 2 for rows in self.users.values())

    def brep(self, names: Sequence[str], colors: Sequence[tuple[int, int, int] | None]) -> Brep:
        """Return the faces with names and colours, and the edges that they use."""
        used = sorted(self.users)
        numbers = {old: new for new, old in enumerate(used)}
        faces = tuple(
            replace(face, name=name, color=color, loops=_renumbered(face, numbers))
            for face, name, color in zip(self.faces, names, colors, strict=True)
        )
        return Brep(tuple(self.edges[edge] for edge in used), faces)

    def with_edges_split(self, cuts: Mapping[int, Iterable[float]]) -> tuple[Shell, EdgePieces]:
        """Return the shell with edges cut at parameters, and what became of them."""
        edges = list(self.edges)
        pieces: EdgePieces = {}
        for edge, places in cuts.items():
            at = sorted(set(places))
            if not at:
                continue
            parts = split_curve(self.edges[edge], at)
            pieces[edge] = tuple(at), tuple(range(len(edges), len(edges) + len(parts)))
            edges += parts
        faces = tuple(_with_pieces(face, pieces) for face in self.faces)
        return Shell(tuple(edges), faces, self.owners), pieces


def is_smooth(shell: Shell, one: int, trim: Trim, other: int, side: Trim) -> bool:
    """Whether two faces meet smoothly in the middle of an edge, a side of each."""
    at = np.array([np.mean(trim.curve.range)])
    first = shell.faces[one].surface.normals(*trim.curve.value(at).T)[0]
    second = shell.faces[other].surface.normals(*side.curve.value(at).T)[0]
    return bool(first @ second >= CREASE)


def owned(shell: Shell, faces: Collection[int], number: int) -> Shell:
    """Return the shell with faces coloured by a detail, but for walls."""
    owners = [
        replace(owner, detail=number) if k in faces and not owner.is_wall else owner
        for k, owner in enumerate(shell.owners)
    ]
    return replace(shell, owners=tuple(owners))


def is_crease(shell: Shell, edge: int) -> bool:
    """Whether two faces meet at an edge, and not smoothly."""
    users = shell.users[edge]
    if len(users) != 2:
        return False
    (one, first), (other, second) = users
    return not is_smooth(shell, one, first, other, second)


@remembered(limit=8, key=lambda shell: shell)
def face_meshes(shell: Shell) -> tuple[Mesh, ...]:
    """Return the triangles of each face with its normals, as they are shown."""
    count = len(shell.faces)
    return shaded_faces(shell.brep([""] * count, [None] * count), COARSE * shell.size)


EdgePieces = dict[int, tuple[tuple[float, ...], tuple[int, ...]]]
"""Where an edge was cut, and the numbers of its pieces, by the number of the edge."""


def split_curve(curve: Curve, at: Sequence[float]) -> list[Curve]:
    """Return the exact pieces of a clamped curve, cut at parameters inside its range."""
    degree = curve.degree
    wanted = list(curve.knots)
    for place in at:
        wanted += [place] * (degree - int((curve.knots == place).sum()))
    whole = curve.with_knots(np.sort(wanted))
    knots, points = whole.knots, whole.control_points
    breaks = [float(knots[0]), *at, float(knots[-1])]
    made = []
    for low, high in itertools.pairwise(breaks):
        first = int(np.searchsorted(knots, low, "right")) - 1
        last = int(np.searchsorted(knots, high, "left"))
        inner = knots[first + 1 : last]
        start = first - degree
        rows = slice(start, start + len(inner) + degree + 1)
        own = np.concatenate(([low] * (degree + 1), inner, [high] * (degree + 1)))
        weights = None if whole.weights is None else whole.weights[rows]
        made.append(Curve(degree, own, points[rows], weights, name=curve.name, color=curve.color))
    return made


def _split_path(path: ParameterCurve, at: Sequence[float]) -> list[ParameterCurve]:
    curve = Curve(path.degree, path.knots, path.in_space, path.weights)
    return [
        ParameterCurve(c.degree, c.knots, c.control_points[:, :2], c.weights)
        for c in split_curve(curve, at)
    ]


def _with_pieces(face: Face, pieces: EdgePieces) -> Face:
    if not any(trim.edge in pieces for trim in face.trims):
        return face
    loops = []
    for loop in face.loops:
        row: list[Trim] = []
        for trim in loop:
            if trim.edge is None or trim.edge not in pieces:
                row.append(trim)
                continue
            at, numbers = pieces[trim.edge]
            paths = _split_path(trim.curve, at)
            own = [Trim(n, trim.forward, p) for n, p in zip(numbers, paths, strict=True)]
            row += own if trim.forward else own[::-1]
        loops.append(tuple(row))
    return replace(face, loops=tuple(loops))


def _renumbered(face: Face, numbers: Mapping[int, int]) -> tuple[tuple[Trim, ...], ...]:
    return tuple(
        tuple(t if t.edge is None else replace(t, edge=numbers[t.edge]) for t in loop)
        for loop in face.loops
    )
