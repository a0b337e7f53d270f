"""The machine that the bodies of a model make, and where its motion has taken them."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, frozen
from bozzetto.errors import UserError
from bozzetto.geometry import FaceGroup, Mesh
from bozzetto.plugin import remembered
from bozzetto_polyhedron.mechanism.assembly import GROUND, Motion
from bozzetto_polyhedron.mechanism.convex_parts import Polytope
from bozzetto_polyhedron.mechanism.fittings import fastened
from bozzetto_polyhedron.mechanism.pieces import (
    METRE,
    Folds,
    Machine,
    Shape,
    machine_of,
    meeting,
    rigid_faces,
)
from bozzetto_polyhedron.mechanism.stepper import Stepper
from bozzetto_polyhedron.model.fittings import Anchor, Driven, Hinge, Trace
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.limits import is_near
from bozzetto_polyhedron.model.same_view import camera_of
from bozzetto_polyhedron.model.state import Body, Moved, PolyhedronState
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solve.followed import Sources, followed_bodies, key_of, parts_of
from bozzetto_polyhedron.solve.followed_pieces import is_closed
from bozzetto_polyhedron.solve.pipeline import Solved, joined_bodies, solved
from bozzetto_polyhedron.solve.plates import plate_parts
from bozzetto_polyhedron.solve.spots import (
    corner_near,
    corner_places_at_rest,
    fastenings_of,
    place_of,
)

GRAVITY: Final = 9.81
"""m/s²."""

TO_MOVE: Final = (
    "Touch a corner of a drawing to turn it into a solid, or choose “Bars, flat as drawn” under "
    "“Parameters”, “Moves as”."
)
"""What makes something move where nothing does yet."""

AXES = {"no": None, "x": 0, "y": 1, "z": 2}
"""Axes of the world by what is chosen in the form."""


@dataclass(frozen=True, eq=False)
class Moving:
    """A machine with what moves it.

    Parameters
    ----------
    machine : Machine
    stepper : Stepper
    numbers : dict of str to int
        Of the shapes, by the ids of their bodies.
    joined : dict of str to str
        Bodies that have become part of another one, by their ids, and which.
    meshes : dict of str to Mesh
        Surfaces at rest of those that have one, by the ids of their bodies, mm.
    groups : dict of str to tuple of FaceGroup
        Of the triangles of bodies of other objects, by the ids of these bodies: their colours.
    """

    machine: Machine
    stepper: Stepper
    numbers: dict[str, int]
    joined: dict[str, str]
    meshes: dict[str, Mesh]
    groups: dict[str, tuple[FaceGroup, ...]]

    def number_of(self, body_id: str) -> int | None:
        """Return the number of the shape that a body is, or is part of; None without any."""
        return self.numbers.get(self.joined.get(body_id, body_id))

    @property
    def extent(self) -> float:
        """Largest size of a shape at rest, mm."""
        sizes = (float(np.ptp(shape.vertices, axis=0).max()) for shape in self.machine.shapes)
        return max(sizes, default=1.0)

    @property
    def is_driven(self) -> bool:
        """Whether anything has a motor."""
        return bool(self.machine.assembly.joints.drives)

    def moved_place(self, number: int, rest: Array, motion: Motion) -> Array:
        """Return where a place of a shape at rest, (3,) mm, has been taken by a motion."""
        piece = self.machine.piece_at(number, rest)
        if piece == GROUND:
            return rest
        local = rest * METRE - self.machine.rest.places[piece]
        return np.asarray((motion.places[piece] + motion.turns[piece] @ local) / METRE)

    def motion(self, moved: Moved | None) -> Motion:
        """Return the motion that a state keeps; rest where it belongs to other bodies.

        Corners that were held elsewhere than at rest are brought there.
        """
        count = len(self.machine.rest.places)
        if moved is None:
            return self.machine.rest
        if len(moved.places) != count:
            return self.stepper.closed(self.machine.rest)
        turns = moved.turns.reshape(-1, 3, 3)
        return Motion(
            moved.places, turns, moved.velocities, moved.momenta, time=float(moved.seconds)
        )


NOTHING: Final[Sources] = {}
"""Sources of what follows nothing."""


def _at_rest(state: PolyhedronState, sources: Sources) -> Hashable:
    still = replace(as_held(state), moved=None, grab=None, recorded=None, selected="")
    return still, key_of(sources)


@remembered(limit=8, key=_at_rest)
def moving(state: PolyhedronState, sources: Sources = NOTHING) -> Moving:
    """Return the machine of all bodies that are shown and are solids, or are followed."""
    state = as_held(state)
    shapes: list[Shape] = []
    numbers: dict[str, int] = {}
    meshes: dict[str, Mesh] = {}
    drawn = {
        body.id: solved(body, state)
        for body in state.shown(Body)
        if len(body.strokes) and (body.choice is not None or body.moves == "flat")
    }
    joined = joined_bodies(drawn)
    for body in state.shown(Body):
        if body.id not in drawn or body.id in joined:
            continue
        shape = _shape(body, drawn[body.id], state)
        if shape is not None and is_near(shape.vertices):
            numbers[body.id] = len(shapes)
            shapes.append(shape)
            mesh = drawn[body.id].mesh
            if mesh is not None:
                meshes[body.id] = mesh
    followed = followed_bodies(state, sources)
    for part_id, (mesh, _) in followed.items():
        if is_near(mesh.vertices):
            numbers[part_id] = len(shapes)
            shapes.append(_followed_shape(state.node(part_id), mesh, state))
            meshes[part_id] = mesh
    machine = machine_of(
        shapes,
        gravity=GRAVITY if state.gravity else 0.0,
        planar=AXES[state.planar],
        ground=state.ground,
        friction=state.friction,
    )
    aliases = {part: numbers[whole] for part, whole in joined.items() if whole in numbers}
    machine = fastened(machine, fastenings_of(state, numbers | aliases))
    machine = meeting(machine) if state.contact else machine
    groups = {part_id: taken.groups for part_id, taken in followed.items() if part_id in meshes}
    made = Moving(machine, Stepper(machine.assembly), numbers, joined, meshes, groups)
    tolerance = 1e-6 * made.extent * METRE
    stepper = Stepper(machine.assembly, damping=state.damping, tolerance=tolerance)
    return replace(made, stepper=stepper)


def as_held(state: PolyhedronState) -> PolyhedronState:
    """Return a state whose held corners are held where they are: at rest, where nothing moved.

    There motors begin as well.
    """
    if state.moved is not None:
        return state
    chosen = state.selected
    for fitting in state.of_kind(Driven):
        if fitting.since or fitting.offset:
            state = state.with_node(replace(fitting, since=0.0, offset=0.0))
    bodies: tuple[Body | Followed, ...] = (*state.of_kind(Body), *state.of_kind(Followed))
    for body in bodies:
        if any(anchor.at is not None for anchor in body.anchors):
            anchors = tuple(replace(anchor, at=None) for anchor in body.anchors)
            state = state.with_node(replace(body, anchors=anchors))
    return replace(state, selected=chosen)


def moving_bodies(state: PolyhedronState, sources: Sources, purpose: str) -> Moving:
    """Return the machine, which has bodies.

    Parameters
    ----------
    state : PolyhedronState
        With bodies that are shown, or none.
    sources : Sources
        What other objects hand over.
    purpose : str
        What there is nothing to do with, otherwise: "move" or "join".

    Raises
    ------
    UserError
        If nothing is a body yet, with what makes it one.
    """
    made = moving(state, sources)
    if not made.numbers:
        raise UserError(f"There is nothing to {purpose} yet. {TO_MOVE}")
    return made


def has_bodies(state: PolyhedronState) -> bool:
    """Return whether anything can be moved or joined."""
    return bool(state.shown(Followed)) or bool(moving(state).numbers)


def is_mechanism(state: PolyhedronState) -> bool:
    """Return whether anything is moved, held, joined or traced."""
    held = any(body.anchors for body in state.shown(Body))
    joined = bool(state.fittings() or state.shown(Trace) or state.shown(Followed))
    return state.moved is not None or held or joined


def kept(motion: Motion) -> Moved:
    """Return a motion as a document keeps it."""
    return Moved(
        places=frozen(motion.places, np.float64, 3),
        turns=frozen(motion.turns.reshape(-1, 3), np.float64, 3),
        velocities=frozen(motion.velocities, np.float64, 3),
        momenta=frozen(motion.momenta, np.float64, 3),
        seconds=float(motion.time),
    )


def _shape(body: Body, found: Solved, state: PolyhedronState) -> Shape | None:
    if body.moves == "flat":
        if not len(found.graph.lines):
            return None
        corners = corner_places_at_rest(body, found)
        normal = body.placement.directions(np.asarray(camera_of(body).axes[2])[None])[0]
        return Shape(
            corners,
            found.graph.lines,
            (),
            "flat",
            _held(body, state, corners),
            density=body.density,
            thickness=body.wall,
            normal=normal / np.linalg.norm(normal),
        )
    if found.answer is None:
        return None
    vertices: Array = body.placement.points(found.answer.vertices)
    faces = found.answer.faces
    edges = found.graph.lines
    moves = body.moves if faces else "links"
    solid = False
    if found.base is not None and found.body is not None:
        vertices = found.base.vertices
        solid = found.body.closed and body.wall == 0.0
        if moves != "links":
            vertices, faces = found.body.vertices, found.body.faces
            edges = edges_of(faces)
    folds = None
    if moves == "whole":
        folds = _folds_of(body, state, vertices)
        moves = "plates" if rigid_faces(faces, folds).any() else moves
    parts: tuple[Polytope, ...] = ()
    numbers: tuple[int, ...] = ()
    if moves == "whole" and found.mesh is not None:
        parts = parts_of(found.mesh)
    elif folds:
        parts, numbers = plate_parts(vertices, faces, body.wall)
    return Shape(
        vertices,
        edges,
        faces,
        moves,
        _held(body, state, vertices),
        density=body.density,
        thickness=body.wall,
        solid=solid,
        parts=parts,
        faces_of_parts=numbers,
        folds=folds,
    )


def _folds_of(body: Body, state: PolyhedronState, vertices: Array) -> Folds:
    """Return the edges of a body along which a hinge with itself was drawn."""
    folds = set()
    for fitting in state.fittings():
        if isinstance(fitting, Hinge) and fitting.begin.body == fitting.second == body.id:
            ends = (place_of(spot, state) for spot in (fitting.begin, fitting.end))
            one, other = sorted(_nearest(vertices, end) for end in ends)
            folds.add((one, other))
    return frozenset(folds)


def _followed_shape(part: Followed, mesh: Mesh, state: PolyhedronState) -> Shape:
    vertices = np.asarray(mesh.vertices, float)
    return Shape(
        vertices,
        np.zeros((0, 2), np.intp),
        (),
        "whole",
        _held(part, state, vertices),
        density=part.density,
        solid=is_closed(mesh),
        triangles=np.asarray(mesh.faces, np.intp),
        parts=parts_of(mesh),
    )


def _held(body: Body | Followed, state: PolyhedronState, vertices: Array) -> dict[int, Array]:
    """Return which vertices of a shape are held, and where, mm."""
    held: dict[int, Array] = {}
    for anchor in body.anchors:
        vertex = held_vertex(anchor, body, state, vertices)
        if vertex is not None:
            held[vertex] = vertices[vertex] if anchor.at is None else np.array(anchor.at)
    return held


def held_vertex(
    anchor: Anchor, body: Body | Followed, state: PolyhedronState, vertices: Array
) -> int | None:
    """Return which vertex of a shape at rest, (n, 3) mm, is held; None where its corner is gone."""
    corner = anchor.spot.corner
    if corner is not None and isinstance(body, Body):
        if corner_near(solved(body, state), corner) is None:
            return None
    return _nearest(vertices, place_of(anchor.spot, state))


def corner_of(body: Body, found: Solved, place: Array) -> int:
    """Return the corner of the drawing that is nearest to a place in space at rest, mm."""
    return _nearest(corner_places_at_rest(body, found), place)


def _nearest(points: Array, place: Array) -> int:
    return int(np.argmin(np.linalg.norm(points - place, axis=1)))
