"""Strokes that join bodies: links, springs, hinges, sliders, motors; a touch asks for a trace."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context, Ink, NextStep, Tap, override
from bozzetto.view import Camera
from bozzetto_polyhedron.mechanism.assembly import square_to
from bozzetto_polyhedron.mechanism.fittings import frame_of
from bozzetto_polyhedron.mechanism.pieces import TOGETHER, Shape
from bozzetto_polyhedron.model.fittings import (
    Coil,
    Crank,
    Fitting,
    Hinge,
    Link,
    Pin,
    Slider,
    Trace,
)
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.aiming import Aim, aim_at, corner_spot
from bozzetto_polyhedron.solve.bars import is_of_bars, with_bars_at
from bozzetto_polyhedron.solve.folds import fold_at, with_largest_held
from bozzetto_polyhedron.solve.kept_poses import AT_REST
from bozzetto_polyhedron.solve.moving import TO_MOVE, Moving, has_bodies, moving, moving_bodies
from bozzetto_polyhedron.solve.picking import REACH
from bozzetto_polyhedron.solve.spots import spot_at
from bozzetto_polyhedron.tools.erase import ErasingTool

SHORT: Final = 1e-6
"""Length of a fitting, mm, below which it is none."""

INSIDE: Final = 1e-3
"""Share of a bar from its ends within which it meets another one in a corner, and crosses none."""

BESIDE: Final = 0.1
"""Distance of an axis from a body of another object, by the largest extent, that it still joins."""

ALONG: Final = 0.98
"""Cosine of the angle on the sheet within which a way is that of an edge."""

TURNS: Final = (
    "It turns about this axis: pull a corner with “Move”, or give it a motor under “Parameters”."
)

PLACES: Final = 33
"""Places along an axis at which it is looked for bodies."""


class _JoiningTool(ErasingTool):
    """A stroke from one spot to another."""

    noun: ClassVar[str]
    while_moved: ClassVar[bool] = False

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Add what this tool draws, from where each stroke begins to where it ends."""
        for stroke in ink.strokes:
            ends = [(float(x), float(y)) for x, y in stroke.points[[0, -1]]]
            state = with_bars_at(state, stroke.camera, *ends)
            made = moving_bodies(state, context.sources, "join")
            if state.moved is not None and not self.while_moved:
                raise UserError(AT_REST)
            begin, end = self._aims(state, made, stroke.camera, stroke.points[[0, -1]])
            if np.linalg.norm(end.place - begin.place) < SHORT:
                raise UserError(f"This is too short. {self.hint}")
            part = self.joined(state, made, begin, end)
            named = replace(part, id=state.unused_id(), name=state.unused_name(self.noun))
            state = state.with_node(named)
        return state

    def joined(self, state: PolyhedronState, made: Moving, begin: Aim, end: Aim) -> Fitting:
        """Return the part, without id and name."""
        raise NotImplementedError

    def _aims(
        self, state: PolyhedronState, made: Moving, camera: Camera, pixels: Array
    ) -> tuple[Aim, Aim]:
        """Return both ends; one that meets nothing is as far away as the other one."""
        first, last = (aim_at(state, made, camera, pixel) for pixel in pixels)
        known = first or last
        if known is None:
            raise UserError(f"There is no corner at either end. {self.hint}")
        if first is None:
            first = aim_at(state, made, camera, pixels[0], beside=known.place)
        if last is None:
            last = aim_at(state, made, camera, pixels[1], beside=known.place)
        if first is None or last is None:
            raise UserError("This lies behind the eye. Turn the view and draw it again.")
        return first, last

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; where nothing can be joined yet, that."""
        if not has_bodies(state) and not any(map(is_of_bars, state.shown(Body))):
            return NextStep(TO_MOVE, tool="turn")
        return NextStep(self.hint)


class _TyingTool(_JoiningTool):
    """A link or a spring between two corners, at least one of them of a body."""

    while_moved = True

    @override
    def joined(self, state: PolyhedronState, made: Moving, begin: Aim, end: Aim) -> Fitting:
        """Return what lies between two corners, as long as they are apart now."""
        if not begin.spot.body and not end.spot.body:
            raise UserError("One end must be on a body. Begin at a corner.")
        length = float(np.linalg.norm(end.place - begin.place))
        return self.tied(made, Fitting(begin=begin.spot, end=end.spot), length)

    def tied(self, made: Moving, ends: Fitting, length: float) -> Fitting:
        """Return the fitting between two ends that are so far apart, mm."""
        raise NotImplementedError


class DrawLink(_TyingTool):
    """Bars between corners, also while things move."""

    id = "link"
    title = "Link"
    icon = "icons/link.svg"
    group = "Mechanism"
    hint = "Draw from one corner to another; a bar keeps them apart."
    noun = "Link"

    @override
    def tied(self, made: Moving, ends: Fitting, length: float) -> Fitting:
        """Return a bar."""
        return Link(begin=ends.begin, end=ends.end, length=length)


class DrawSpring(_TyingTool):
    """Springs between corners, also while things move."""

    id = "spring"
    title = "Spring"
    icon = "icons/spring.svg"
    group = "Mechanism"
    hint = "Draw from one corner to another, or into the open; a spring pulls them together."
    noun = "Spring"

    @override
    def tied(self, made: Moving, ends: Fitting, length: float) -> Fitting:
        """Return a spring that is at rest now; it carries the weight with a tenth of its length."""
        weight = 9.81 * float(made.machine.assembly.masses.sum())
        stiffness = float(f"{np.clip(weight / (0.1e-3 * length), 0.01, 1e6):.2g}")
        return Coil(begin=ends.begin, end=ends.end, length=length, stiffness=stiffness)


class DrawHinge(_JoiningTool):
    """Axes of bodies, against one another or against what does not move."""

    id = "hinge"
    title = "Hinge"
    icon = "icons/hinge.svg"
    group = "Mechanism"
    hint = "Draw an axis from one place of a body to another; give it a motor under Parameters."
    noun = "Hinge"

    @override
    def _aims(
        self, state: PolyhedronState, made: Moving, camera: Camera, pixels: Array
    ) -> tuple[Aim, Aim]:
        """Return both ends; of an axis that sticks out at both, where it enters and leaves bodies.

        At the outline of a round limb that is half-way through its depth.
        """

        def met(pixel: Array) -> bool:
            return aim_at(state, made, camera, pixel) is not None

        if not any(map(met, pixels)):
            shares = np.linspace(0.0, 1.0, PLACES)[1:-1, None]
            crossed = list(filter(met, pixels[0] + shares * (pixels[1] - pixels[0])))
            if crossed:
                pixels = np.stack((crossed[0], crossed[-1]))
        return super()._aims(state, made, camera, pixels)

    @override
    def joined(self, state: PolyhedronState, made: Moving, begin: Aim, end: Aim) -> Fitting:
        """Return the axis between two bodies; of one alone, with the one that it touches.

        Along an edge at which faces of one body can turn it is a fold of that body.
        """
        if not begin.spot.body:
            begin, end = end, begin
        edge = fold_at(made, begin, end)
        if edge is not None:
            body: Body = state.node(begin.spot.body)
            number = made.number_of(body.id)
            if number is None:
                raise UserError(f"This body is gone. {self.hint}")
            one, other = (made.machine.shapes[number].vertices[corner] for corner in edge)
            ends = corner_spot(state, body, one), corner_spot(state, body, other)
            return Hinge(begin=ends[0], end=ends[1], second=body.id)
        second = end.spot.body
        if second == begin.spot.body:
            second = _neighbour(state, made, begin, end)
        return Hinge(begin=begin.spot, end=end.spot, second=second)

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Add hinges; the largest piece of a body that they fold is held, where nothing is yet."""
        drawn = super().draw(state, ink, context)
        for hinge in drawn.of_kind(Hinge):
            if hinge.second == hinge.begin.body and hinge not in state.nodes:
                drawn = with_largest_held(drawn, context.sources, drawn.node(hinge.second))
        return drawn

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; once a hinge is there, what to do with it."""
        chosen = state.chosen_of(Hinge)
        if chosen is not None and state.moved is None:
            return NextStep(TURNS, tool="move")
        return super().next_step(state)


class DrawSlider(_JoiningTool):
    """Straight guides that stand still."""

    id = "slider"
    title = "Slider"
    icon = "icons/slider.svg"
    group = "Mechanism"
    hint = "Draw from a corner along the straight way on which it may slide."
    noun = "Slider"

    @override
    def _aims(
        self, state: PolyhedronState, made: Moving, camera: Camera, pixels: Array
    ) -> tuple[Aim, Aim]:
        """Return both ends; into the open along the edge of a solid that is seen to lead there."""
        begin, end = super()._aims(state, made, camera, pixels)
        number = made.number_of(begin.spot.body)
        if number is None or end.spot.body:
            return begin, end
        shape = made.machine.shapes[number]
        if shape.moves != "whole" or not len(shape.edges):
            return begin, end
        corner = int(np.argmin(np.linalg.norm(shape.vertices - begin.place, axis=1)))
        edges = shape.edges[(shape.edges == corner).any(axis=1)]
        ways = shape.vertices[edges.sum(axis=1) - corner] - shape.vertices[corner]
        ways = np.concatenate((ways, -ways))
        seen = camera.project(np.vstack((begin.place, begin.place + ways)))[0]
        drawn, lead = pixels[1] - seen[0], seen[1:] - seen[0]
        lengths = np.maximum(np.linalg.norm(lead, axis=1), SHORT)
        likeness = lead @ drawn / (lengths * max(float(np.linalg.norm(drawn)), SHORT))
        best = int(np.argmax(likeness))
        if not likeness[best] > ALONG:
            return begin, end
        place = begin.place + ways[best] * float(np.linalg.norm(drawn)) / lengths[best]
        return begin, Aim(spot_at(place, None), place)

    @override
    def joined(self, state: PolyhedronState, made: Moving, begin: Aim, end: Aim) -> Fitting:
        """Return the guide; what slides is the corner where it begins, or a solid as a drawer."""
        number = made.number_of(begin.spot.body)
        if number is None:
            raise UserError(f"It must begin on a body. {self.hint}")
        solid = made.machine.shapes[number].moves == "whole"
        turning: Literal["free", "locked"] = "locked" if solid else "free"
        return Slider(begin=begin.spot, end=end.spot, turning=turning)


class DrawCrank(_JoiningTool):
    """Motors of bars in flat drawings."""

    id = "motor"
    title = "Motor"
    icon = "icons/motor.svg"
    group = "Mechanism"
    hint = "Draw along a bar of a flat drawing, from its axis outwards: it turns steadily."
    noun = "Motor"

    @override
    def joined(self, state: PolyhedronState, made: Moving, begin: Aim, end: Aim) -> Fitting:
        """Return the motor of the bar, against what is held or the longest other bar there."""
        number = made.number_of(begin.spot.body)
        if number is None or begin.spot.body != end.spot.body:
            raise UserError(f"Both ends must be corners of one drawing. {self.hint}")
        if made.machine.shapes[number].normal is None:
            raise UserError(
                "This is no flat drawing. Set “Moves as” to “Bars, flat as drawn”, or draw a hinge "
                "and give it a motor."
            )
        if made.machine.bar_between(number, begin.place, end.place) is None:
            raise UserError(f"There is no bar between these corners. {self.hint}")
        if frame_of(made.machine, number, begin.place, end.place, frozenset()) is None:
            raise UserError(
                "This corner hangs free. Touch it with “Move” to hold it, then draw the motor."
            )
        return Crank(begin=begin.spot, end=end.spot)


class DrawPin(ErasingTool):
    """Pins of bars that cross."""

    id = "pin"
    title = "Pin"
    icon = "icons/pin.svg"
    group = "Mechanism"
    hint = "Touch the crossing of two bars of a flat drawing, and they are pinned there."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Pin the bars under the pen."""
        if state.moved is not None:
            raise UserError(AT_REST)
        made = moving(state, context.sources)
        for body_id, number in made.numbers.items():
            shape = made.machine.shapes[number]
            if shape.normal is None:
                continue
            pixel = np.array([[tap.x, tap.y]])
            place = tap.camera.on_plane(pixel, shape.vertices[0], shape.normal)[0]
            crossing = _crossing(shape, place) if np.isfinite(place).all() else None
            if crossing is not None:
                seen = tap.camera.project(crossing[None])[0][0]
                if float(np.linalg.norm(seen - pixel[0])) <= REACH:
                    spot = spot_at(crossing, state.node(body_id))
                    named = state.unused_name("Pin")
                    return state.with_node(
                        Pin(id=state.unused_id(), name=named, begin=spot, end=spot)
                    )
        raise UserError(f"No bars cross here. {self.hint}")


class TraceCorner(ErasingTool):
    """Paths of corners."""

    id = "trace"
    title = "Trace"
    icon = "icons/trace.svg"
    group = "Mechanism"
    hint = "Touch a corner: its path is drawn while things move."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Add the trace of a corner, or choose the one that it has."""
        aim = aim_at(state, moving(state, context.sources), tap.camera, np.array([tap.x, tap.y]))
        if aim is None or not aim.spot.body:
            raise UserError("There is no corner here. Touch a corner of a body.")
        for trace in state.of_kind(Trace):
            if trace.at == aim.spot:
                return state.with_node(trace)
        name = state.unused_name("Trace")
        return state.with_node(Trace(id=state.unused_id(), name=name, at=aim.spot))


def _crossing(shape: Shape, place: Array) -> Array | None:
    """Return the crossing of two bars that is nearest to a place, (3,) mm; None without any."""
    across, up = square_to(shape.normal if shape.normal is not None else np.eye(3)[2])
    flat = shape.vertices @ np.stack((across, up)).T
    ends = flat[shape.edges]
    best, away = None, np.inf
    for one in range(len(ends)):
        for other in range(one):
            ways = np.column_stack((ends[one, 1] - ends[one, 0], ends[other, 0] - ends[other, 1]))
            if abs(np.linalg.det(ways)) < 1e-12:
                continue
            shares = np.linalg.solve(ways, ends[other, 0] - ends[one, 0])
            if (shares <= INSIDE).any() or (shares >= 1.0 - INSIDE).any():
                continue
            begin, end = shape.vertices[shape.edges[one]]
            found = begin + shares[0] * (end - begin)
            if np.linalg.norm(found - place) < away:
                best, away = found, float(np.linalg.norm(found - place))
    return best


def _neighbour(state: PolyhedronState, made: Moving, begin: Aim, end: Aim) -> str:
    """Return the id of another body that an axis touches; "" where none does.

    A drawn body is touched at a corner, any solid where the axis runs through it, and one of
    another object where it passes near: an axis is drawn on a surface, and what turns about it may
    lie behind.
    """
    along = end.place - begin.place
    extent = max(float(np.linalg.norm(np.ptp(s.vertices, axis=0))) for s in made.machine.shapes)
    shares = np.linspace(0.0, 1.0, PLACES)[:, None]
    best, away = "", BESIDE * extent
    for body_id, number in made.numbers.items():
        if body_id == begin.spot.body:
            continue
        shape = made.machine.shapes[number]
        far = np.inf
        for part in shape.parts:
            outside = (begin.place + shares * along) @ part.normals.T - part.offsets
            far = min(far, float(outside.max(axis=1).min()))
        if shape.triangles is None:
            apart = shape.vertices - begin.place
            share = np.clip(apart @ along / (along @ along), 0.0, 1.0)
            nearest = np.linalg.norm(apart - share[:, None] * along, axis=1).min()
            far = min(far, float(nearest))
        reach = TOGETHER if shape.triangles is None else BESIDE
        if far <= min(away, reach * extent):
            best, away = body_id, far
    return best
