"""Pull a mechanism with the pen; it keeps its lengths, and swings on while it plays."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, NextStep, Tap, override
from bozzetto.view import Camera, triple
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.mechanism.stepper import Pull
from bozzetto_polyhedron.model.fittings import Anchor, Place
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Body, Grab, PolyhedronState
from bozzetto_polyhedron.solve.aiming import corner_spot
from bozzetto_polyhedron.solve.bars import is_of_bars, with_bars_at
from bozzetto_polyhedron.solve.motors import with_motors_begun
from bozzetto_polyhedron.solve.moving import (
    TO_MOVE,
    Moving,
    as_held,
    has_bodies,
    held_vertex,
    is_mechanism,
    kept,
    moving,
    moving_bodies,
)
from bozzetto_polyhedron.solve.picking import REACH
from bozzetto_polyhedron.solve.recording import recorded, recorded_times
from bozzetto_polyhedron.tools.erase import ErasingTool
from bozzetto_polyhedron.view.motion import moved_vertices

BARS: Final = "These lines move as bars: touch corners to hold them, pull another one with the pen."

PERIOD: Final = 0.12
"""Time in which the pen's spring would swing the whole mechanism once, s: it feels direct."""

SETTLING: Final = 6
"""Samples over which pressure is averaged: a pen that has just touched down trembles."""

UNMEANT: Final = 0.12
"""Change of pressure that nobody means; the rest of it pulls along the view."""

MOST_PIECES: Final = 60
"""Pieces up to which freedoms are counted for the next step: it is asked after every change."""

STRONGEST: Final = 8.0
"""Largest force of the pen, in weights of all that moves."""


PRESSED: Final = np.radians(0.5)
"""Angle beyond the end of a hinge's way, rad, at which its motor does not let it stop there."""


class Move(ErasingTool):
    """The pen as a spring between a corner and where it is.

    Pressing more firmly pulls away from the eye, less firmly nearer; with a mouse Shift and Ctrl
    do.
    """

    id = "move"
    title = "Move"
    icon = "icons/move.svg"
    hint = "Touch corners to hold them, pull another one with the pen; press to pull it deeper."
    gesture = "drag"
    grabs = True
    plays = True

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Hold the corner that is touched where it is, or let it go."""
        state = with_bars_at(state, tap.camera, (tap.x, tap.y))
        made = moving_bodies(state, context.sources, "move")
        body, vertex = _nearest(state, made, tap.camera, np.array([tap.x, tap.y]))
        number = made.numbers[body.id]
        vertices = made.machine.shapes[number].vertices
        left = tuple(
            anchor
            for anchor in body.anchors
            if held_vertex(anchor, body, state, vertices) != vertex
        )
        if len(left) == len(body.anchors):
            now = made.machine.moved(number, made.motion(state.moved))[vertex]
            spot = corner_spot(state, body, vertices[vertex])
            left = (*left, Anchor(spot, None if state.moved is None else triple(now)))
        return replace(state.with_node(replace(body, anchors=left)), grab=None)

    @override
    def step(
        self, state: PolyhedronState, held: Drag | None, seconds: float, context: Context
    ) -> PolyhedronState:
        """Return the state a moment later, pulled by the pen where it holds something."""
        if held is not None:
            state = with_bars_at(state, held.camera, _beginning(held))
        state = as_held(state)
        made = moving_bodies(state, context.sources, "move")
        motion = made.motion(state.moved)
        begun = with_motors_begun(state, made, motion)
        if begun is not state:
            state, made = begun, moving_bodies(begun, context.sources, "move")
        pull, grab = None, None
        if held is not None:
            grab = _deeper(_grabbed(state, made, held), made, held, seconds)
            pull = _pull(made, motion, grab, held)
        before, motion = motion, made.stepper.advanced(motion, seconds, pull)
        if motion.time == before.time and made.is_driven:
            raise UserError(
                "A motor is stuck: the lengths do not let it turn any further. Let it swing to and "
                "fro, or draw its crank shorter."
            )
        if made.is_driven and made.stepper.beyond_stops(motion) > PRESSED:
            raise UserError(
                "A motor presses one body against another. Let it turn less far, or switch "
                "“Contact” off under “Parameters”."
            )
        recording = recorded(state, before, motion)
        return replace(state, moved=kept(motion), grab=grab, recorded=recording)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; where nothing was turned yet, that."""
        if not has_bodies(state):
            if any(map(is_of_bars, state.shown(Body))):
                return NextStep(BARS)
            return NextStep(TO_MOVE, tool="turn")
        return NextStep(f"{_freedoms(state)}{self.hint}{_kept(state)}")


def _freedoms(state: PolyhedronState) -> str:
    """Return in how many ways a mechanism at rest can move, in a sentence; "" where unknown."""
    if state.moved is not None or not is_mechanism(state) or state.shown(Followed):
        return ""
    made = moving(state)
    if not made.numbers or len(made.machine.rest.places) > MOST_PIECES:
        return ""
    degrees = mobility_of(made.machine.assembly, made.machine.rest).degrees
    if degrees == 0:
        return "Its motor moves all of it: play. " if made.is_driven else "Nothing of it is free. "
    return f"It can move in {degrees} way{'s' if degrees > 1 else ''}. "


def _kept(state: PolyhedronState) -> str:
    """Return how long a motion is recorded and what shows it again; "" where none is."""
    times = recorded_times(state)
    if len(times) < 2:
        return ""
    return f" {times[-1] - times[0]:.1f} s are recorded: “Replay” shows them again."


def _beginning(held: Drag) -> Place:
    return float(held.path.x[0]), float(held.path.y[0])


def _grabbed(state: PolyhedronState, made: Moving, held: Drag) -> Grab:
    """Return what this drag holds: chosen at its beginning, and kept to its end."""
    begin = _beginning(held)
    grab = state.grab
    if grab is not None and grab.begin == begin and grab.body in made.numbers:
        return grab
    body, vertex = _nearest(state, made, held.camera, np.array(begin))
    return Grab(begin, body.id, vertex)


def _deeper(grab: Grab, made: Moving, held: Drag, seconds: float) -> Grab:
    """Return the grab as far along the view as keys have taken it: Shift away, Ctrl nearer."""
    if held.shift == held.ctrl:
        return grab
    way = made.extent * seconds
    return replace(grab, depth=grab.depth + (way if held.shift else -way))


def _pressed(path: Stroke) -> float:
    """Return how much firmer the pen presses than when it touched down, -1 … 1."""
    if not path.has_pressure:
        return 0.0
    first = float(np.median(path.pressure[:SETTLING]))
    more = float(np.mean(path.pressure[-SETTLING:])) - first
    return float(np.sign(more)) * max(abs(more) - UNMEANT, 0.0)


def _nearest(
    state: PolyhedronState, made: Moving, camera: Camera, place: Array
) -> tuple[Body | Followed, int]:
    """Return the corner that is seen nearest to a place, with its body."""
    best: tuple[float, str, int] | None = None
    for body_id in made.numbers:
        seen = camera.project(moved_vertices(state, made, body_id))[0]
        away = np.linalg.norm(seen - place, axis=1)
        away = np.where(np.isfinite(away), away, np.inf)
        number = int(np.argmin(away))
        if best is None or away[number] < best[0]:
            best = float(away[number]), body_id, number
    if best is None or best[0] > 2.0 * REACH:
        raise UserError("There is no corner here. Pull at a corner.")
    node: Body | Followed = state.node(best[1])
    return node, best[2]


def _pull(made: Moving, motion: Motion, grab: Grab, held: Drag) -> Pull | None:
    number = made.numbers[grab.body]
    holders = made.machine.holders[number]
    if grab.vertex >= len(holders) or grab.vertex in made.machine.shapes[number].anchors:
        raise UserError("This corner is held. Pull at another one, or touch it to let it go.")
    place = made.machine.moved(number, motion)[grab.vertex]
    target = held.camera.on_plane(held.path.points[-1:], place, held.camera.axes[2])[0]
    if not np.isfinite(target).all():
        raise UserError("The mechanism lies behind the eye. Turn the view and pull again.")
    away = held.camera.axes[2] * (grab.depth + made.extent * _pressed(held.path))
    mass = float(made.machine.assembly.masses.sum())
    stiffness = mass * (2.0 * np.pi / PERIOD) ** 2
    return Pull(
        int(holders[grab.vertex]),
        made.machine.local(number, grab.vertex),
        (target + away) * METRE,
        stiffness,
        2.0 * float(np.sqrt(stiffness * mass)),
        STRONGEST * mass * 9.81,
    )
