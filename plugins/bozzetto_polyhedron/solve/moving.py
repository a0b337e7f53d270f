"""The machine that the bodies of a model make, and where its motion has taken them."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, frozen
from bozzetto.plugin import remembered
from bozzetto_polyhedron.mechanism.assembly import GROUND, Motion
from bozzetto_polyhedron.mechanism.fittings import fastened
from bozzetto_polyhedron.mechanism.pieces import METRE, Machine, Shape, machine_of
from bozzetto_polyhedron.mechanism.stepper import Stepper
from bozzetto_polyhedron.model.fittings import Trace
from bozzetto_polyhedron.model.limits import is_near
from bozzetto_polyhedron.model.same_view import camera_of
from bozzetto_polyhedron.model.state import Body, Moved, PolyhedronState, Recording
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solve.pipeline import Solved, solved
from bozzetto_polyhedron.solve.spots import corner_near, corner_places_at_rest, fastenings_of

MOST_POSES: Final = 3600
"""Poses that are recorded: a minute."""

GRAVITY: Final = 9.81
"""m/s²."""

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
    """

    machine: Machine
    stepper: Stepper
    numbers: dict[str, int]

    @property
    def extent(self) -> float:
        """Largest size of a shape at rest, mm."""
        sizes = (float(np.ptp(shape.vertices, axis=0).max()) for shape in self.machine.shapes)
        return max(sizes, default=1.0)

    @property
    def is_driven(self) -> bool:
        """Whether anything has a motor."""
        joints = self.machine.assembly.joints
        return bool(joints.rate.any() or joints.swing.any())

    def moved_place(self, number: int, rest: Array, motion: Motion) -> Array:
        """Return where a place of a shape at rest, (3,) mm, has been taken by a motion."""
        piece = self.machine.piece_at(number, rest)
        if piece == GROUND:
            return rest
        local = rest * METRE - self.machine.rest.places[piece]
        return np.asarray((motion.places[piece] + motion.turns[piece] @ local) / METRE)

    def motion(self, moved: Moved | None) -> Motion:
        """Return the motion that a state keeps; rest where it belongs to other bodies."""
        count = len(self.machine.rest.places)
        if moved is None or len(moved.places) != count:
            return self.machine.rest
        turns = moved.turns.reshape(-1, 3, 3)
        return Motion(
            moved.places, turns, moved.velocities, moved.momenta, time=float(moved.seconds)
        )


def _at_rest(state: PolyhedronState) -> Hashable:
    return replace(state, moved=None, grab=None, recorded=None, selected="")


@remembered(limit=8, key=_at_rest)
def moving(state: PolyhedronState) -> Moving:
    """Return the machine of all bodies that are shown and were turned into solids."""
    shapes: list[Shape] = []
    numbers: dict[str, int] = {}
    for body in state.shown(Body):
        if not len(body.strokes) or (body.choice is None and body.moves != "flat"):
            continue
        shape = _shape(body, solved(body, state))
        if shape is not None and is_near(shape.vertices):
            numbers[body.id] = len(shapes)
            shapes.append(shape)
    machine = machine_of(
        shapes,
        gravity=GRAVITY if state.gravity else 0.0,
        planar=AXES[state.planar],
        friction=state.friction if state.ground else None,
    )
    machine = fastened(machine, fastenings_of(state, numbers))
    made = Moving(machine, Stepper(machine.assembly), numbers)
    tolerance = 1e-6 * made.extent * METRE
    stepper = Stepper(machine.assembly, damping=state.damping, tolerance=tolerance)
    return replace(made, stepper=stepper)


def is_mechanism(state: PolyhedronState) -> bool:
    """Return whether anything is moved, held, joined or traced."""
    held = any(body.anchors for body in state.shown(Body))
    return state.moved is not None or held or bool(state.fittings() or state.shown(Trace))


def kept(motion: Motion) -> Moved:
    """Return a motion as a document keeps it."""
    return Moved(
        places=frozen(motion.places, np.float64, 3),
        turns=frozen(motion.turns.reshape(-1, 3), np.float64, 3),
        velocities=frozen(motion.velocities, np.float64, 3),
        momenta=frozen(motion.momenta, np.float64, 3),
        seconds=float(motion.time),
    )


def recorded(state: PolyhedronState, motion: Motion) -> Recording | None:
    """Return the recording of a state with one more pose.

    It begins anew where the machine or its time has: with other pieces, or back at rest.
    """
    before, count = state.recorded, len(motion.places)
    if not state.records or not count:
        return before
    known = before is not None and len(before.places) == count * len(before.seconds)
    if (
        before is None
        or not known
        or (len(before.seconds) and motion.time <= before.seconds[-1, 0])
    ):
        before = Recording()
    if len(before.seconds) >= MOST_POSES:
        return before
    return Recording(
        frozen(np.vstack((before.seconds, [[motion.time]])), np.float64, 1),
        frozen(np.vstack((before.places, motion.places)), np.float64, 3),
        frozen(np.vstack((before.turns, motion.turns.reshape(-1, 3))), np.float64, 3),
    )


def _shape(body: Body, found: Solved) -> Shape | None:
    anchors = [corner_near(found, place) for place in body.anchors]
    corners = corner_places_at_rest(body, found)
    if body.moves == "flat":
        if not len(found.graph.lines):
            return None
        held = tuple(sorted({corner for corner in anchors if corner is not None}))
        normal = body.placement.directions(np.asarray(camera_of(body).axes[2])[None])[0]
        return Shape(
            corners,
            found.graph.lines,
            (),
            "flat",
            held,
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
    near = {_nearest(vertices, corners[corner]) for corner in anchors if corner is not None}
    return Shape(
        vertices,
        edges,
        faces,
        moves,
        tuple(sorted(near)),
        density=body.density,
        thickness=body.wall,
        solid=solid,
    )


def corner_of(body: Body, found: Solved, place: Array) -> int:
    """Return the corner of the drawing that is nearest to a place in space at rest, mm."""
    return _nearest(corner_places_at_rest(body, found), place)


def _nearest(points: Array, place: Array) -> int:
    return int(np.argmin(np.linalg.norm(points - place, axis=1)))
