"""Bodies of sheet that fold at hinges: at which edge, and what of them stands still then."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.mechanism.pieces import rigid_faces, sides_of
from bozzetto_polyhedron.model.fittings import Anchor, Fitting, Hinge
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.aiming import Aim, corner_spot
from bozzetto_polyhedron.solve.followed import Sources
from bozzetto_polyhedron.solve.moving import Moving, moving

LOW: Final = 0.01
"""Height above the lowest corner, in extents, at which a corner is low, too; three corners that are
held lie as far from one line."""

FOLDED: Final = 0.05
"""Distance of an axis from an edge, in extents of the body, at which it is drawn along the edge."""


def fold_at(made: Moving, begin: Aim, end: Aim) -> tuple[int, int] | None:
    """Return the corners of an edge along which an axis is drawn and a body can fold.

    One end may be beyond the body.
    """
    number = made.number_of(begin.spot.body)
    if number is None or end.spot.body not in ("", begin.spot.body):
        return None
    shape = made.machine.shapes[number]
    if shape.moves not in ("plates", "whole") or shape.triangles is not None:
        return None
    places = np.stack((begin.place, end.place))
    away = np.linalg.norm(shape.vertices - places[:, None], axis=2)
    one, other = (int(corner) for corner in away.argmin(axis=1))
    edge = (min(one, other), max(one, other))
    sides = [pair for rings in shape.faces for pair in sides_of(rings)]
    if one == other or sides.count((one, other)) != 1 or sides.count((other, one)) != 1:
        return None
    along = shape.vertices[other] - shape.vertices[one]
    apart = places - shape.vertices[one]
    share = (apart @ along / (along @ along))[:, None]
    extent = float(np.linalg.norm(np.ptp(shape.vertices, axis=0)))
    if float(np.linalg.norm(apart - share * along, axis=1).max()) > FOLDED * extent:
        return None
    if shape.moves == "plates" and shape.folds is None:
        return one, other
    folds = shape.folds or frozenset()
    now, then = (rigid_faces(shape.faces, each).max() for each in (folds, folds | {edge}))
    return (one, other) if edge in folds or then > now else None


def with_largest_held(state: PolyhedronState, sources: Sources, body: Body) -> PolyhedronState:
    """Return the state with three low corners of the heaviest piece of a body held.

    As it is where the body moves as bars or plates, or anything of it is held or joined otherwise.
    """
    fittings = (each for each in state.of_kind(Fitting) if not isinstance(each, Hinge))
    joined = any(body.id in (each.begin.body, each.end.body) for each in fittings)
    hinged = any(
        body.id in (each.begin.body, each.second) and each.begin.body != each.second
        for each in state.of_kind(Hinge)
    )
    made = moving(state, sources)
    number = made.number_of(body.id)
    if number is None or body.moves != "whole" or body.anchors or joined or hinged:
        return state
    shape, plates = made.machine.shapes[number], made.machine.plates[number]
    heaviest = max(set(plates.tolist()), key=lambda piece: made.machine.assembly.masses[piece])
    own, others = (
        {
            corner
            for rings, piece in zip(shape.faces, plates, strict=True)
            if bool(piece == heaviest) is heavy
            for ring in rings
            for corner in ring
        }
        for heavy in (True, False)
    )
    free = np.array(sorted(own - others), np.intp)
    three = _spread(shape.vertices[free])
    anchors = tuple(Anchor(corner_spot(state, body, shape.vertices[free[k]])) for k in three)
    return replace(state.with_node(replace(body, anchors=anchors)), selected=state.selected)


def _spread(points: Array) -> list[int]:
    """Return the numbers of three low points that are not in a line; fewer where there are none."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    for among in (
        np.flatnonzero(points[:, 2] <= points[:, 2].min(initial=np.inf) + LOW * extent),
        np.arange(len(points)),
    ):
        if len(among) < 3:
            continue
        first = points[among] - points[among[0]]
        far = int(np.linalg.norm(first, axis=1).argmax())
        aside = np.linalg.norm(np.cross(first, first[far]), axis=1)
        if aside.max() > LOW * extent**2:
            return [int(among[0]), int(among[far]), int(among[int(aside.argmax())])]
    return []
