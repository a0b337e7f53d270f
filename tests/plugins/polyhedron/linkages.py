"""Linkages drawn flat with straight strokes, as a person draws them: px on the sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Ink, Tap
from bozzetto.view import Camera
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.tools.fittings import DrawCrank, DrawPin, DrawSlider, TraceCorner
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron.known_linkages import Linkage

SHEET = Camera()
Corners = Mapping[str, tuple[float, float]]

FOUR_BAR: Corners = {"a": (400, 600), "b": (430, 540), "c": (700, 420), "d": (780, 600)}
FOUR_BAR_LINES = ("ab", "bc", "cd")


def straight(begin: Sequence[float], end: Sequence[float], camera: Camera = SHEET) -> Stroke:
    way = np.linspace(begin, end, 30)
    return Stroke(way[:, 0], way[:, 1], camera)


def linkage(corners: Corners, lines: Sequence[str], held: str = "") -> PolyhedronState:
    """Return a flat drawing of bars; corners named in `held` are touched with the moving tool."""
    strokes = Strokes(straight(corners[line[0]], corners[line[1]]) for line in lines)
    body = Body(id="bars", name="Bars", strokes=strokes, moves="flat")
    state = PolyhedronState(nodes=(body,))
    for name in held:
        state = Move().tap(state, tapped(corners[name]), Context())
    return state


def tapped(place: Sequence[float]) -> Tap:
    return Tap(float(place[0]), float(place[1]), SHEET)


def with_motor(state: PolyhedronState, begin: Sequence[float], end: Sequence[float], **how: object):
    state = DrawCrank().draw(state, Ink((straight(begin, end),)), Context())
    return state.with_node(replace(state.node(state.selected), **how))


def drawn(known: Linkage) -> tuple[PolyhedronState, Corners]:
    """Return a known linkage as a person draws it, with the places of its corners, px."""
    corners = on_sheet(known)
    state = linkage(corners, known.bars, known.held)
    for one, other in known.pins:
        middle = np.mean([corners[name] for name in one + other], axis=0)
        state = DrawPin().tap(state, tapped(middle), Context())
    if known.guided:
        begin = np.array(corners[known.guided])
        stroke = straight(begin, np.add(begin, (60.0, 0.0)))
        state = DrawSlider().draw(state, Ink((stroke,)), Context())
    axis, end = (corners[name] for name in known.motor)
    state = with_motor(state, axis, end, **known.drive)
    return traced(state, corners[known.traced]), corners


def on_sheet(known: Linkage) -> Corners:
    """Return the corners of a linkage in the middle of the sheet, px."""
    places = np.array(list(known.corners.values()))
    low, high = places.min(axis=0), places.max(axis=0)
    scale = float(min(np.array([680.0, 540.0]) / (high - low)))
    return {
        name: tuple((place - 0.5 * (low + high)) * [scale, -scale] + [600.0, 450.0])
        for name, place in known.corners.items()
    }


def traced(state: PolyhedronState, place: Sequence[float]) -> PolyhedronState:
    return TraceCorner().tap(state, tapped(place), Context())


def played(state: PolyhedronState, seconds: float, rate: int = 60) -> PolyhedronState:
    for _ in range(round(seconds * rate)):
        state = Move().step(state, None, 1.0 / rate, Context())
    return state


def places(state: PolyhedronState, corners: Corners) -> dict[str, np.ndarray]:
    """Return where corners are now, (2,) px each."""
    made = moving(state)
    rest = SHEET.project(made.machine.shapes[0].vertices)[0]
    now = SHEET.project(made.machine.moved(0, made.motion(state.moved)))[0]
    return {
        name: now[int(np.argmin(np.linalg.norm(rest - place, axis=1)))]
        for name, place in corners.items()
    }
