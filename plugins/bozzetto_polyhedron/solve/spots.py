"""Where the spots of fittings are at rest, and which spot a place in space is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import Part
from bozzetto_polyhedron.graph.line_graph import Finding
from bozzetto_polyhedron.mechanism.assembly import GROUND
from bozzetto_polyhedron.mechanism.drives import Course, Drive, Keyed, Steady, Swing
from bozzetto_polyhedron.mechanism.fittings import Fastening, FittingKind
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.fittings import (
    Coil,
    Crank,
    Driven,
    Fitting,
    Hinge,
    Link,
    Pin,
    Place,
    Slider,
    Spot,
    Trace,
    Turning,
)
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.motor_curves import typed_keys
from bozzetto_polyhedron.model.same_view import on_sheet
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.pipeline import Solved, solved

NEAR: Final = 0.05
"""Distance from a corner to the place it was at, in extents of the drawing, beyond which the
corner is gone."""

AT_CORNER: Final = 1.0
"""Distance of a finding from a corner of the drawing, px, within which it is about that corner."""

KINDS: Final[dict[type[Fitting], FittingKind]] = {
    Link: "link",
    Coil: "spring",
    Hinge: "hinge",
    Slider: "slider",
    Crank: "crank",
    Pin: "pin",
}


def corner_near(found: Solved, place: Place) -> int | None:
    """Return the corner at a place of the drawing, px, if it is still there."""
    places = found.graph.places
    if not len(places):
        return None
    away = np.linalg.norm(places - place, axis=1)
    reach = NEAR * float(np.linalg.norm(np.ptp(places, axis=0)))
    number = int(np.argmin(away))
    return number if away[number] <= reach else None


def corner_places_at_rest(body: Body, found: Solved) -> Array:
    """Return where the corners of a drawing are in space at rest, (n, 3) mm; NaN where unknown."""
    if body.moves == "flat":
        return on_sheet(body, found.graph.places)
    if found.base is not None:
        return found.base.vertices
    if found.answer is not None:
        return body.placement.points(found.answer.vertices)
    return np.full((len(found.graph.places), 3), np.nan)


def place_of(spot: Spot, state: PolyhedronState) -> Array:
    """Return where a spot is at rest, (3,) mm in the frame of the model."""
    body = _body_of(spot, state)
    if body is None:
        return np.array(spot.point, float)
    if spot.corner is not None:
        found = solved(body, state)
        corner = corner_near(found, spot.corner)
        if corner is not None:
            return np.asarray(corner_places_at_rest(body, found)[corner])
    return np.asarray(body.placement.points(np.array([spot.point]))[0])


def spot_at(place: Array, body: Body | Followed | None, corner: Place | None = None) -> Spot:
    """Return the spot of a body, or of the ground, at a place at rest, (3,) mm in the model."""
    if body is None:
        return Spot("", _point(place))
    if isinstance(body, Followed):
        return Spot(body.id, _point(place))
    inner = body.placement.inverse().points(np.asarray(place)[None])[0]
    return Spot(body.id, _point(inner), corner)


def fastenings_of(state: PolyhedronState, numbers: dict[str, int]) -> list[Fastening]:
    """Return what joins shapes; what hangs on a body that is not there joins nothing."""
    made = []
    for fitting in state.fittings():
        second = fitting.second if isinstance(fitting, Hinge) else _second(fitting)
        ids = (fitting.begin.body, second)
        if any(each and each not in numbers for each in ids):
            continue
        first, other = (numbers[each] if each else GROUND for each in ids)
        made.append(
            Fastening(
                KINDS[type(fitting)],
                first,
                other,
                place_of(fitting.begin, state),
                place_of(fitting.end, state),
                length=fitting.length if isinstance(fitting, Link | Coil) else 0.0,
                stiffness=fitting.stiffness if isinstance(fitting, Coil) else 0.0,
                drive=drive_of(fitting) if isinstance(fitting, Driven) else None,
                turns=not isinstance(fitting, Slider) or fitting.turning == "free",
            )
        )
    return made


def hung_on(body_id: str, state: PolyhedronState) -> list[Part]:
    """Return the fittings and traces that mean nothing without a body."""
    fittings = [
        each
        for each in state.of_kind(Fitting)
        if body_id in (each.begin.body, each.end.body, getattr(each, "second", ""))
    ]
    return [*fittings, *(trace for trace in state.of_kind(Trace) if trace.at.body == body_id)]


def is_linkage(body: Body, state: PolyhedronState) -> bool:
    """Return whether a drawing is bars that move, and not the edges of a solid to come.

    Its lines may end anywhere, and corners of two lines are its joints.
    """
    if body.moves == "flat":
        return True
    return body.choice is None and bool(body.anchors or hung_on(body.id, state))


def _second(fitting: Fitting) -> str:
    return fitting.end.body if isinstance(fitting, Link | Coil) else ""


def drive_of(fitting: Driven) -> Drive | None:
    """Return what the motor of a fitting does, rad or m; None without any."""
    if not isinstance(fitting, Turning | Slider) or fitting.drive == "no":
        return None
    unit = METRE if isinstance(fitting, Slider) else float(np.radians(1.0))
    course: Course
    if fitting.drive == "curve":
        keys = tuple((time, unit * value) for time, value in typed_keys(fitting.curve))
        course = Keyed(keys, again=fitting.repeats == "again")
    elif fitting.drive == "swing":
        size = fitting.travel if isinstance(fitting, Slider) else fitting.angle
        course = Swing(unit * size, 2.0 * np.pi / fitting.period)
    else:
        course = Steady(unit * fitting.speed)
    return Drive(course, fitting.since, unit * fitting.offset, fitting.id)


def _body_of(spot: Spot, state: PolyhedronState) -> Body | None:
    bodies = {body.id: body for body in state.of_kind(Body)}
    return bodies.get(spot.body)


def _point(place: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in place)
    return x, y, z


def places_of_findings(body: Body, found: Solved, findings: Sequence[Finding]) -> Array:
    """Return where lines look wrong, (n, 3) mm, in the model's frame.

    What is wrong with a corner of a drawing that was turned into a solid is there in space, so that
    it stays on the solid when the view turns; all else is where it was drawn.

    Parameters
    ----------
    body : Body
        Whose lines they are.
    found : Solved
        What they were understood as.
    findings : sequence of Finding
        At least one.
    """
    seen = np.array([finding.place for finding in findings], float)
    places, drawn = on_sheet(body, seen), found.graph.places
    if body.choice is None or not len(drawn):
        return places
    gaps = np.linalg.norm(seen[:, None] - drawn, axis=2)
    corners = corner_places_at_rest(body, found)
    if len(corners) != len(drawn):
        return places
    there = corners[gaps.argmin(axis=1)]
    known = (gaps.min(axis=1) <= AT_CORNER) & np.isfinite(there).all(axis=1)
    return np.where(known[:, None], there, places)
