"""A mechanism at rest in the pose to which its motion has taken it.

A line that is drawn on a linkage that has moved belongs to the pose in which it is drawn: its ends
are where the bars are then. So that pose becomes the one at rest. Ink goes with its bars, solids
with their pieces, and what is fastened to them with them.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.ink import Strokes, drawn_at
from bozzetto.plugin import remembered
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.model.fittings import Anchor, Fitting, Hinge, Slider, Spot, Trace
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.same_view import camera_of
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.followed import Sources, key_of
from bozzetto_polyhedron.solve.moving import Moving, as_held, moving
from bozzetto_polyhedron.solve.pipeline import graph_of_ink, never, solved
from bozzetto_polyhedron.solve.placing import placement_of, taken_by
from bozzetto_polyhedron.solve.spots import corner_near, place_of, spot_at

AT_REST: Final = "This is drawn where everything is at rest. Choose “Back to rest” first."

SWINGS: Final = (
    "A motor swings or follows its curve from where everything is at rest, and this belongs to "
    "where it is now. Choose “Back to rest” first."
)

CROWDED: Final = (
    "Here lines lie on one another and could not be told apart. Pull them apart or choose “Back to "
    "rest”, then draw; or draw a bar from corner to corner with “Link”."
)

ROUNDS: Final = 12
"""Times that ink is brought nearer to the corners in which it is to meet, at most."""

NEAR: Final = 1e-6
"""Distance of corners from where the motion has taken them that is good enough, in extents: ink is
kept in single precision."""

QUARTER: Final = np.array([[0.0, 1.0], [-1.0, 0.0]])
"""Turns rows by a quarter."""

KEPT: Final = 2e-3
"""The same, beyond which bars would not keep their lengths; ink of several bars in one stroke comes
no nearer."""


@dataclass(frozen=True, eq=False)
class _Pose:
    """A state, its machine, and the bodies that were taken somewhere by a motion.

    Parameters
    ----------
    state : PolyhedronState
        As it was.
    made : Moving
    motion : Motion
    bodies : dict of str to Body
        Bodies that have moved, as they are where that pose is the one at rest.
    corners : dict of str to (n, 2) array
        Of flat ones where their corners are in the drawing then, px, in the order of before.
    """

    state: PolyhedronState
    made: Moving
    motion: Motion
    bodies: dict[str, Body]
    corners: dict[str, Array]

    def spot(self, spot: Spot) -> Spot:
        """Return where a spot is at rest then."""
        body = self.bodies.get(spot.body)
        if body is None or spot.body not in self.corners:
            return spot  # it stands still, or goes with the frame of its body
        before = self.state.node(spot.body)
        if spot.corner is not None:
            number = corner_near(solved(before, self.state), spot.corner)
            if number is not None:
                place = self.made.machine.moved(self.made.numbers[spot.body], self.motion)[number]
                x, y = (float(value) for value in self.corners[spot.body][number])
                return spot_at(place, body, (x, y))
        return spot_at(self.place(spot), body)

    def place(self, spot: Spot) -> Array:
        """Return where a spot has been taken, (3,) mm in the frame of the model."""
        rest, number = place_of(spot, self.state), self.made.number_of(spot.body)
        return rest if number is None else self.made.moved_place(number, rest, self.motion)

    def fitting(self, part: Fitting) -> Fitting:
        """Return what joins bodies as it does where they are now."""
        rest = place_of(part.begin, self.state), place_of(part.end, self.state)
        moved = replace(part, begin=self.spot(part.begin), end=self.spot(part.end))
        if isinstance(part, Slider):  # its line stands still
            return replace(moved, end=spot_at(self.place(part.begin) + rest[1] - rest[0], None))
        number = self.made.number_of(part.begin.body)
        if isinstance(part, Hinge) and not part.end.body and number is not None:
            piece = self.made.machine.piece_at(number, rest[0])
            way = placement_of(self.made, piece, self.motion)
            return replace(moved, end=spot_at(way.points(rest[1][None])[0], None))
        return moved


def _what_counts(state: PolyhedronState, sources: Sources) -> Hashable:
    return replace(state, grab=None, recorded=None), key_of(sources)


@remembered(limit=4, key=_what_counts)
def at_rest_here(state: PolyhedronState, sources: Sources) -> PolyhedronState:
    """Return a state whose pose at rest is the one in which everything is now.

    Motors that turn steadily go on from there.

    Parameters
    ----------
    state : PolyhedronState
        Returned as it is where nothing has moved.
    sources : Sources
        What other objects hand over.

    Raises
    ------
    UserError
        If something has moved that has but one pose at rest (bars in space, hinged plates, solids
        that were joined, pieces of other objects, what a motor swings), or if ink would be
        understood otherwise there.
    """
    if state.moved is None:
        return state
    made = moving(as_held(state), sources)
    if not all(drive.course.goes_on for _, drive in made.machine.assembly.joints.drives):
        raise UserError(SWINGS)
    pose = _Pose(state, made, made.motion(state.moved), {}, {})
    for body_id, number in made.numbers.items():
        shape = made.machine.shapes[number]
        places = made.machine.moved(number, pose.motion)
        if not np.array_equal(places, shape.vertices):
            body: Body | Followed = state.node(body_id)
            joined = body_id in made.joined.values()
            if isinstance(body, Followed) or joined or shape.moves in ("links", "plates"):
                raise UserError(AT_REST)
            if shape.moves == "flat":
                pose.bodies[body_id], pose.corners[body_id] = _redrawn(body, places)
            else:
                placement = taken_by(made, number, pose.motion).after(body.placement)
                pose.bodies[body_id] = replace(body, placement=placement)
    now = state
    for body in pose.bodies.values():
        held = tuple(Anchor(pose.spot(anchor.spot)) for anchor in body.anchors)
        now = now.with_node(replace(body, anchors=held))
    for part in state.of_kind(Fitting):
        now = now.with_node(pose.fitting(part))
    for trace in state.of_kind(Trace):
        now = now.with_node(replace(trace, at=pose.spot(trace.at)))
    return replace(now, selected=state.selected, moved=None, grab=None, recorded=None)


def _redrawn(body: Body, places: Array) -> tuple[Body, Array]:
    """Return a flat body whose corners are elsewhere, (n, 3) mm, and these in its drawing, px.

    The ink of each bar is turned with it. Where corners are found from it follows from all ink that
    meets there, so it is then brought nearer to them, step by step.
    """
    camera, graph = camera_of(body), graph_of_ink(body.strokes, body.evidence, never)
    meant: Array = camera.project(body.placement.inverse().points(places))[0]
    extent = float(np.linalg.norm(np.ptp(meant, axis=0)))
    ink, nearest = body.strokes, float("inf")
    trial = carried(body.strokes, graph, graph.places, meant)
    for _ in range(ROUNDS):
        found = graph_of_ink(trial, body.evidence, never)
        same = _same_corners(graph, found, meant)
        if same is None:
            break
        off = float(np.abs(found.places[same] - meant).max()) / extent
        if off < nearest:
            ink, nearest = trial, off
        if nearest <= NEAR:
            break
        trial = carried(trial, graph, found.places[same], meant)
    if nearest > KEPT:
        raise UserError(CROWDED)
    return replace(body, strokes=ink), meant


def carried(strokes: Strokes, graph: LineGraph, before: Array, after: Array) -> Strokes:
    """Return strokes turned and stretched with their lines, whose corners were elsewhere.

    Each point goes with the nearest line of its stroke; strays with the nearest of all lines.

    Parameters
    ----------
    strokes : Strokes
        Those of the drawing.
    graph : LineGraph
        Which lines they are.
    before, after : (n, 2) array
        Corners of the graph, px.
    """
    starts, ways = before[graph.lines[:, 0]], np.diff(before[graph.lines], axis=1)[:, 0]
    there, turned = after[graph.lines[:, 0]], np.diff(after[graph.lines], axis=1)[:, 0]
    lengths = np.maximum((ways**2).sum(axis=1), 1e-300)
    across, across_then = ways @ QUARTER, turned @ QUARTER
    made = []
    for number, stroke in enumerate(strokes):
        own = [k for k, members in enumerate(graph.strokes) if number in members]
        lines = np.array(own or range(len(graph.lines)))
        away = stroke.points[:, None] - starts[lines]
        along = (away * ways[lines]).sum(axis=2) / lengths[lines]
        aside = (away * across[lines]).sum(axis=2) / lengths[lines]
        beyond = along - np.clip(along, 0.0, 1.0)
        nearest = ((beyond**2 + aside**2) * lengths[lines]).argmin(axis=1)
        rows, line = np.arange(len(nearest)), lines[nearest]
        places = there[line] + along[rows, nearest, None] * turned[line]
        places = places + aside[rows, nearest, None] * across_then[line]
        made.append(drawn_at(stroke, places, stroke.camera))
    return Strokes(made)


def _same_corners(graph: LineGraph, other: LineGraph, meant: Array) -> Index | None:
    """Return which corner of another graph each of one is, at the places meant, (n, 2) px.

    None where the other one has not the same lines.
    """
    if len(other.places) != len(graph.places):
        return None
    found = np.linalg.norm(meant[:, None] - other.places, axis=2).argmin(axis=1)
    lines = {(min(a, b), max(a, b)) for a, b in found[graph.lines].tolist()}
    same = len(set(found.tolist())) == len(found) and lines == set(map(tuple, other.lines.tolist()))
    return found if same else None
