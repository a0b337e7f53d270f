"""Triangles of bodies that other objects hand over."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Solid, Surface, meshed
from bozzetto.plugin import override, remembered
from bozzetto_polyhedron.mechanism.convex_parts import Polytope, convex_parts
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.followed_pieces import Divided, Taken, divided

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
        names = list(_by_name(Same(shapes)))
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


def followed_bodies(state: PolyhedronState, sources: Sources) -> dict[str, Taken]:
    """Return the followed bodies that are shown and there, by their ids."""
    found = {}
    for part in state.shown(Followed):
        whole = divided_of(part, sources)
        if whole is None:
            continue
        number = whole.number_of(part.piece)
        if part.piece and number is None:
            continue
        others = {each.piece for each in siblings_of(part, state)} - {part.piece}
        left = tuple(k for k, name in enumerate(whole.names) if name not in others)
        taken = _taken(whole, left if number is None else (number,))
        if taken is not None:
            found[part.id] = taken
    return found


def siblings_of(part: Followed, state: PolyhedronState) -> tuple[Followed, ...]:
    """Return the bodies that are pieces of the same part of an object, itself among them."""
    wanted = (part.source, part.solid)
    return tuple(each for each in state.of_kind(Followed) if (each.source, each.solid) == wanted)


def divided_of(part: Followed, sources: Sources) -> Divided | None:
    """Return a followed body and the pieces that it can come apart in; None where it is gone.

    An object that has a single part is that part.
    """
    shapes = sources.get(part.source)
    if shapes is None:
        return None
    parts = _by_name(Same(shapes))
    return _divided(Same(shapes), "" if len(parts) == 1 else part.solid)


@remembered(limit=16)
def _divided(same: Same, solid: str) -> Divided | None:
    """Return the pieces of all parts of one name; of all parts where it is ""."""
    parts = _by_name(same)
    if not solid:
        return divided(
            [each for several in parts.values() for each in several], next(iter(parts), "")
        )
    return divided(parts[solid], solid) if solid in parts else None


@remembered(limit=64)
def _taken(whole: Divided, numbers: tuple[int, ...]) -> Taken | None:
    return whole.taken(numbers)


@remembered(limit=16)
def _by_name(same: Same) -> dict[str, list[Solid | Surface]]:
    """Return the parts that have triangles, those of one name together."""
    parts: dict[str, list[Solid | Surface]] = {}
    for part in meshed(same.shapes).meshes():
        if len(part.mesh.faces):
            parts.setdefault(part.name, []).append(part)
    return parts


def _triangles(mesh: Mesh) -> Hashable:
    return mesh.vertices.tobytes(), mesh.faces.tobytes()


@remembered(limit=32, key=_triangles)
def parts_of(mesh: Mesh) -> tuple[Polytope, ...]:
    """Return the convex parts of a body that meet others, mm."""
    return convex_parts(mesh)
