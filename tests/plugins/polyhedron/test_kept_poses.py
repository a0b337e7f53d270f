"""Lines drawn on what has moved belong to the pose in which they are drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Job
from bozzetto_polyhedron.model.changes import Added
from bozzetto_polyhedron.model.fittings import Link
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.kept_poses import at_rest_here
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.fittings import DrawLink
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron import known_linkages
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.linkages import (
    FOUR_BAR,
    FOUR_BAR_LINES,
    SHEET,
    drawn,
    linkage,
    places,
    straight,
    tapped,
    with_motor,
)
from tests.plugins.polyhedron.objects import OBJECTS

FRAME = 1.0 / 60.0
BARS = {"a": (400, 600), "b": (440, 430), "c": (720, 380), "d": (770, 600)}
LINES = ("ab", "bc", "cd")


def corners(state: PolyhedronState, number: int = 0) -> np.ndarray:
    made = moving(state)
    return made.machine.moved(number, made.motion(state.moved))


def bars(state: PolyhedronState) -> np.ndarray:
    """Return the ends of bars where they are now, sorted, (e, 6) mm."""
    ends = corners(state)[moving(state).machine.shapes[0].edges]
    order = np.lexsort(ends.transpose(0, 2, 1)[..., 0].round(3).T)
    return ends[order]


def lengths(state: PolyhedronState) -> np.ndarray:
    ends = corners(state)[moving(state).machine.shapes[0].edges]
    return np.sort(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1))


def played(state: PolyhedronState, frames: int) -> PolyhedronState:
    for _ in range(frames):
        state = Move().step(state, None, FRAME, Context())
    return state


def pulled(state: PolyhedronState, begin: np.ndarray, way: np.ndarray, view=SHEET):
    for frame in range(40):
        path = np.asarray(begin) + np.linspace(0.0, 1.0, frame + 2)[:, None] * way
        state = Move().step(state, Drag("", Stroke(*path.T, view)), FRAME, Context())
    return state


def sheet_of(state: PolyhedronState) -> np.ndarray:
    return SHEET.project(corners(state))[0]


def trembling(strokes, rng) -> Strokes:
    return Strokes(
        Stroke(*(s.points + np.cumsum(rng.normal(0.0, 0.4, (len(s.x), 2)), 0)).T, SHEET)
        for s in strokes
    )


def four_bar(seed: int | None = None) -> PolyhedronState:
    state = linkage(BARS, LINES)
    if seed is not None:
        body = state.nodes[0]
        ink = trembling(body.strokes, np.random.default_rng(seed))
        state = state.with_node(replace(body, strokes=ink))
    for name in "ad":
        near = sheet_of(state)[np.linalg.norm(sheet_of(state) - BARS[name], axis=1).argmin()]
        state = Move().tap(state, tapped(near), Context())
    return with_motor(state, BARS["a"], BARS["b"])


def test_what_has_not_moved_is_left_alone() -> None:
    state = four_bar()
    assert at_rest_here(state, {}) is state


@pytest.mark.parametrize("name", ["four_bar", "jansen"])
@pytest.mark.parametrize("frames", [7, 40])
def test_the_pose_becomes_that_of_rest_and_goes_on_as_before(name: str, frames: int) -> None:
    known, _ = drawn(getattr(known_linkages, name)())
    state = played(known, frames)
    made = at_rest_here(state, {})
    assert made.moved is None
    extent = float(np.ptp(corners(state), axis=0).max())
    assert lengths(made) == pytest.approx(lengths(state), rel=1e-6)
    assert np.sort(corners(made), 0) == pytest.approx(np.sort(corners(state), 0), abs=1e-6 * extent)
    one, other = played(state, 25), played(made, 25)
    assert np.sort(corners(one), 0) == pytest.approx(np.sort(corners(other), 0), abs=1e-5 * extent)
    assert at_rest_here(made, {}) is made


@pytest.mark.parametrize("seed", range(5))
def test_bars_of_a_trembling_hand_keep_their_lengths_however_often_poses_are_kept(
    seed: int,
) -> None:
    state = four_bar(seed)
    before = lengths(state)
    for _ in range(4):
        state = at_rest_here(played(state, 5), {})
    assert lengths(state) == pytest.approx(before, rel=1e-5)
    assert len(state.nodes[0].anchors) == 2
    assert all(anchor.at is None for anchor in state.nodes[0].anchors)


def test_a_bar_is_where_it_was_drawn_and_nothing_leaps() -> None:
    state = played(four_bar(), 20)
    there = sheet_of(state)
    apart = np.linalg.norm(there - BARS["a"], axis=1)
    hinge, free = there[apart.argsort()[1]], np.array([520.0, 250.0])
    drawn_on = DrawLines().draw(state, Ink((straight(hinge, free),)), Context())
    assert len(drawn_on.of_kind(Body)) == 1
    now = sheet_of(drawn_on)
    assert len(now) == len(there) + 1
    for place in (*there, free):
        assert np.linalg.norm(now - place, axis=1).min() < 0.3
    after = played(drawn_on, 1)
    assert np.abs(np.sort(sheet_of(after), 0) - np.sort(now, 0)).max() < 8.0


def test_a_bar_between_corners_that_have_moved_is_as_long_as_they_are_apart_now() -> None:
    state = linkage({**BARS, "e": (900, 300)}, (*LINES, "ce"), "ad")
    state = pulled(state, np.array(BARS["b"]), np.array([40.0, -10.0]))
    there = sheet_of(state)
    first, last = there[there[:, 0].argsort()[[1, -1]]]
    made = DrawLines().draw(state, Ink((straight(first, last),)), Context())
    ends = sheet_of(made)[moving(made).machine.shapes[0].edges]
    found = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert len(found) == 5
    assert np.abs(found - np.linalg.norm(last - first)).min() < 0.5


def test_one_stroke_of_several_bars_goes_with_each() -> None:
    state = linkage(BARS, ())
    way = np.concatenate([np.linspace(BARS[a], BARS[b], 30) for a, b in LINES])
    body = state.nodes[0]
    state = state.with_node(replace(body, strokes=Strokes([Stroke(*way.T, SHEET)])))
    for name in "ad":
        state = Move().tap(state, tapped(BARS[name]), Context())
    state = pulled(state, np.array(BARS["b"]), np.array([-40.0, 10.0]))
    made = at_rest_here(state, {})
    assert lengths(made) == pytest.approx(lengths(state), rel=0.01)
    assert np.sort(sheet_of(made), 0) == pytest.approx(np.sort(sheet_of(state), 0), abs=1.0)


def test_a_line_on_a_solid_that_was_pulled_away_is_on_it() -> None:
    solid = OBJECTS["box"]
    ink = strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=9100)
    state = PolyhedronModeler().read_drawing(Drawing(Strokes(ink), VIEW), Context(), Job())
    start = VIEW.project(corners(state))[0][7]
    state = pulled(state, start, np.array([140.0, -60.0]), VIEW)
    there = corners(state)
    near = int((there @ VIEW.axes[2]).argmin())
    face = next(f[0] for f in moving(state).machine.shapes[0].faces if near in f[0])
    inside = VIEW.project(there[list(face)].mean(0)[None])[0][0]
    corner = VIEW.project(there)[0][near]
    stroke = straight(corner, 0.3 * corner + 0.7 * inside, VIEW)
    made = DrawLines().draw(state, Ink((stroke,)), Context())
    assert made.moved is None
    assert np.abs(corners(made) - there).max() < 1e-6 * np.ptp(there)
    (added,) = made.of_kind(Added)
    changed = solved(made.node(added.body), made).changed
    assert changed is not None
    assert np.linalg.norm(changed.points - there[near], axis=1).min() < 1e-6 * np.ptp(there)


@pytest.mark.parametrize("moves", ["links", "plates"])
def test_what_has_one_pose_at_rest_is_drawn_on_there_alone(moves: str) -> None:
    solid = OBJECTS["box"]
    ink = strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=9100)
    state = PolyhedronModeler().read_drawing(Drawing(Strokes(ink), VIEW), Context(), Job())
    state = state.with_node(replace(state.nodes[0], moves=moves))
    start = VIEW.project(corners(state))[0][7]
    state = pulled(state, start, np.array([90.0, -40.0]), VIEW)
    with pytest.raises(UserError, match="Back to rest"):
        DrawLines().draw(state, Ink((straight((100, 100), (200, 100), VIEW),)), Context())


def test_what_a_motor_swings_is_drawn_on_at_rest() -> None:
    state = with_motor(linkage(BARS, LINES, "ad"), BARS["a"], BARS["b"], drive="swing")
    with pytest.raises(UserError, match="swings"):
        at_rest_here(played(state, 9), {})


def test_bars_that_lie_along_one_another_are_not_redrawn_as_one() -> None:
    state = with_motor(linkage(FOUR_BAR, FOUR_BAR_LINES, "ad"), FOUR_BAR["a"], FOUR_BAR["b"])
    before, refused = lengths(state), 0
    for _ in range(8):
        state = played(state, 4)
        try:
            kept = lengths(at_rest_here(state, {}))
        except UserError:
            refused += 1
            with pytest.raises(UserError, match="with “Link”"):
                at_rest_here(state, {})
            ends = places(state, FOUR_BAR)
            stroke = straight(ends["b"], ends["d"])
            assert DrawLink().draw(state, Ink((stroke,)), Context()).of_kind(Link)
        else:
            assert kept == pytest.approx(before, rel=1e-5)
    assert 0 < refused < 8
