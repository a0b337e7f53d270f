"""Triangles of bodies that other objects hand over."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, meshed
from bozzetto.plugin import override, remembered
from bozzetto_polyhedron.mechanism.convex_parts import Polytope, convex_parts
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import PolyhedronState

Sources: TypeAlias = Mapping[str, Shapes]
"""What the objects hand over that a model follows, by their ids, in the frame of the model."""

MOST_BODIES: Final = 24
"""Bodies that one object becomes; one with more parts becomes a single body."""


@dataclass(frozen=True, eq=False)
class Same:
    """Shapes as a key: the very same object, which stays as long as the key does."""

    shapes: Shapes

    @override
    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.shapes is other.shapes

    @override
    def __hash__(self) -> int:
        return id(self.shapes)


def key_of(sources: Sources) -> Hashable:
    """Return what tells sources from one another, for what is remembered."""
    return tuple((name, Same(shapes)) for name, shapes in sources.items())


def bodies_of(sources: Sources) -> PolyhedronState:
    """Return a state whose bodies are all parts of some objects.

    Raises
    ------
    UserError
        If an object has nothing with a surface.
    """
    state = PolyhedronState()
    for source, shapes in sources.items():
        names = list(_by_name(shapes))
        if not names:
            raise UserError("There is no solid in it to move. Choose another object.")
        for name in names if len(names) <= MOST_BODIES else [""]:
            part = Followed(
                id=state.unused_id(),
                name=state.unused_name(name or "Part"),
                source=source,
                solid=name,
            )
            state = state.with_node(part)
    return state


def followed_meshes(state: PolyhedronState, sources: Sources) -> dict[str, Mesh]:
    """Return the triangles of the followed bodies that are shown and there, by their ids."""
    found = {}
    for part in state.shown(Followed):
        shapes = sources.get(part.source)
        mesh = None if shapes is None else _mesh(part, _named(Same(shapes)))
        if mesh is not None:
            found[part.id] = mesh
    return found


def _mesh(part: Followed, named: Mapping[str, Mesh]) -> Mesh | None:
    """Return the triangles of a body; an object that has a single part is that part."""
    if part.solid == "" or len(named) == 1:
        return _joined(list(named.values()))
    return named.get(part.solid)


@remembered(limit=16)
def _named(same: Same) -> dict[str, Mesh]:
    return _by_name(same.shapes)


def _by_name(shapes: Shapes) -> dict[str, Mesh]:
    """Return the triangles of all parts; those of one name together."""
    meshes: dict[str, list[Mesh]] = {}
    for part in meshed(shapes).meshes():
        meshes.setdefault(part.name, []).append(part.mesh)
    made = {name: _joined(several) for name, several in meshes.items()}
    return {name: mesh for name, mesh in made.items() if mesh is not None}


def _joined(meshes: list[Mesh]) -> Mesh | None:
    kept = [mesh for mesh in meshes if len(mesh.faces)]
    if len(kept) < 2:
        return kept[0] if kept else None
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in kept[:-1])])
    faces = [mesh.faces + start for mesh, start in zip(kept, starts, strict=True)]
    vertices = np.concatenate([mesh.vertices for mesh in kept])
    return Mesh(vertices, np.concatenate(faces).astype(np.int32))


def is_closed(mesh: Mesh) -> bool:
    """Whether every side of a triangle is that of another one, too."""
    faces = np.asarray(mesh.faces, np.int64)
    sides = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    numbers = sides.min(axis=1) * len(mesh.vertices) + sides.max(axis=1)
    return bool((np.unique(numbers, return_counts=True)[1] == 2).all())


def _triangles(mesh: Mesh) -> Hashable:
    return mesh.vertices.tobytes(), mesh.faces.tobytes()


@remembered(limit=32, key=_triangles)
def parts_of(mesh: Mesh) -> tuple[Polytope, ...]:
    """Return the convex parts of a body that meet others, mm."""
    return convex_parts(mesh)
