"""Ink of a drawing, mended at a place where its lines look wrong.

What a finding tells a person to do is done to the ink: a gap is drawn over, a tick taken away, two
corners that are close are brought together, and a line that ends alone is drawn on to what it
nearly meets. Lengths are shares of the drawing's diagonal, as in `graph.health`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto_polyhedron.graph.health import CLOSE, GAP
from bozzetto_polyhedron.graph.line_graph import Finding, FindingKind, LineGraph
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.solve.kept_poses import carried
from bozzetto_polyhedron.solve.pipeline import graph_of_ink, never

MENDABLE: Final[frozenset[FindingKind]] = frozenset(
    ("gap", "tick", "close corners", "loose end", "curved stroke")
)
"""What a touch mends; of all else only a person knows what is meant."""

AHEAD: Final = np.cos(np.radians(25.0))
"""Cosine of the angle from the direction of a line within which something lies ahead of its end."""

BESIDE: Final = 0.06
"""Distance under which the end of a line belongs to a corner that lacks one, or to a line ahead."""

SAMPLES: Final = 24
"""Places along a line that is drawn across a gap."""


def mended(body: Body, graph: LineGraph, finding: Finding) -> Body:
    """Return a body whose drawing is without what a finding points at.

    Parameters
    ----------
    body : Body
        With the drawing.
    graph : LineGraph
        Its lines, with the finding in their health.
    finding : Finding
        What is to be mended.

    Raises
    ------
    UserError
        If only a person can know what is meant; with what to do.
    """
    if finding.what == "curved stroke":
        return read_round(body, finding)
    strokes, place = body.strokes, np.asarray(finding.place)
    degrees = np.bincount(graph.lines.ravel(), minlength=len(graph.places))
    loose = np.flatnonzero(degrees == 1)
    size = float(np.linalg.norm(np.ptp(graph.places, axis=0)))
    if finding.what == "tick":
        made = _without_tick(strokes, graph, place)
    elif finding.what == "gap":
        one, other = _pair_about(graph.places, loose, loose, place)
        made = Strokes((*strokes, _across(strokes, graph, one, other)))
    elif finding.what == "close corners":
        few = np.flatnonzero(degrees < 3)
        one, other = _pair_about(graph.places, few, np.arange(len(graph.places)), place)
        if degrees[one] > degrees[other]:
            one, other = other, one
        made = _with_corner_at(strokes, graph, one, graph.places[other])
    elif finding.what == "loose end":
        end = int(loose[np.linalg.norm(graph.places[loose] - place, axis=1).argmin()])
        made = _with_corner_at(strokes, graph, end, _ahead(graph, end, size))
    else:
        raise UserError(finding.sentence)
    if any(
        each.what == finding.what and np.hypot(*(np.asarray(each.place) - place)) < CLOSE * size
        for each in graph_of_ink(made, body.evidence, never).health
    ):
        raise UserError(f"This could not be mended by a touch. {finding.sentence}")
    return replace(body, strokes=made)


def read_round(body: Body, finding: Finding) -> Body:
    """Return a body in whose drawing all is round that may be, so that a curved stroke is.

    Raises
    ------
    UserError
        If it is not round even so.
    """
    made = replace(body, rounds="all")
    if any(
        each.what == "curved stroke" and each.place == finding.place
        for each in graph_of_ink(made.strokes, made.evidence, never).health
    ):
        raise UserError(f"This could not be mended by a touch. {finding.sentence}")
    return made


def _pair_about(places: Array, some: Index, others: Index, middle: Array) -> tuple[int, int]:
    """Return the two corners between which a place lies in the middle."""
    away = np.linalg.norm((places[some][:, None] + places[others]) / 2 - middle, axis=2)
    away = np.where(some[:, None] == others, np.inf, away)
    row, column = np.unravel_index(int(away.argmin()), away.shape)
    return int(some[row]), int(others[column])


def _without_tick(strokes: Strokes, graph: LineGraph, place: Array) -> Strokes:
    """Return ink without that of the line of which the middle is at a place."""
    middles = graph.places[graph.lines].mean(axis=1)
    line = int(np.linalg.norm(middles - place, axis=1).argmin())
    others = [members for number, members in enumerate(graph.strokes) if number != line]
    gone = set(graph.strokes[line]).difference(*others)
    return Strokes([stroke for number, stroke in enumerate(strokes) if number not in gone])


def _across(strokes: Strokes, graph: LineGraph, one: int, other: int) -> Stroke:
    """Return a stroke from one corner to another, as firm as the line that ends at the first."""
    x, y = np.linspace(graph.places[one], graph.places[other], SAMPLES).T
    like = strokes[next(iter(_strokes_at(graph, one)), 0)]
    pressure = np.full(SAMPLES, np.median(like.pressure)) if like.has_pressure else None
    return Stroke(x, y, like.camera, pressure=pressure)


def _strokes_at(graph: LineGraph, corner: int) -> Sequence[int]:
    """Return the strokes of a line at a corner."""
    line = int(np.flatnonzero((graph.lines == corner).any(axis=1))[0])
    return graph.strokes[line]


def _with_corner_at(strokes: Strokes, graph: LineGraph, corner: int, place: Array) -> Strokes:
    """Return ink that meets in a corner somewhere else; its lines are turned and stretched."""
    after = graph.places.copy()
    after[corner] = place
    return carried(strokes, graph, graph.places, after)


def _ahead(graph: LineGraph, end: int, size: float) -> Array:
    """Return the nearest corner at the end of a line, or else where it meets another line.

    Corners that lack a line come first, also somewhat farther ahead or aside.

    Raises
    ------
    UserError
        If nothing is near.
    """
    line = graph.lines[(graph.lines == end).any(axis=1)][0]
    start = int(line[line != end][0])
    along = graph.places[end] - graph.places[start]
    length = float(np.hypot(*along))
    along = along / length
    ways = graph.places - graph.places[end]
    away = np.linalg.norm(ways, axis=1)
    lacking = np.bincount(graph.lines.ravel(), minlength=len(away)) < 3
    ahead = ways @ along > AHEAD * away
    lacking_one = lacking & ((away < BESIDE * size) | (ahead & (away < 2.0 * GAP * size)))
    for near in (lacking_one, ahead & (away < GAP * size)):
        near[[start, end]] = False
        if near.any():
            return np.asarray(graph.places[np.where(near, away, np.inf).argmin()])
    nearest, met = BESIDE * size, None
    for one, other in graph.lines:
        if end in (one, other):
            continue
        across = graph.places[other] - graph.places[one]
        system = np.stack((along, -across), axis=1)
        if abs(float(np.linalg.det(system))) < 1e-9 * np.hypot(*across):
            continue
        far, share = np.linalg.solve(system, graph.places[one] - graph.places[end])
        if 0.0 < far < nearest and 0.0 <= share <= 1.0:
            nearest, met = float(far), graph.places[end] + far * along
    if met is None:
        raise UserError(
            "There is nothing near this end. Draw on to the next corner, or erase the line."
        )
    return np.asarray(met)
