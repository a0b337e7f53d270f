"""A hinge along an edge of sheet folds it; a slider guides a solid as a drawer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.ink.ink_json import read_drawing
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto_polyhedron.commands.answers import next_answer
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.pieces import rigid_faces, sides_of
from bozzetto_polyhedron.model.fittings import Hinge, Slider
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.tools.fittings import DrawHinge, DrawSlider
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.figures_open_boxes import lidded_box, open_box
from tests.plugins.polyhedron.linkages import straight
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.write_samples import FOLDER, hidden_edges

MODELER = PolyhedronModeler()
SEEDS = (80_100, 80_101, 80_102)


def read(solid) -> PolyhedronState:
    vertices = fitted(solid)
    ink = strokes_of(vertices, solid.edges, hidden=hidden_edges(solid, vertices, VIEW))
    return MODELER.read_drawing(Drawing(Strokes(ink), VIEW), Context(), Job())


def shape_of(state: PolyhedronState):
    return moving(state).machine.shapes[0]


def seen(points) -> np.ndarray:
    return VIEW.project(np.atleast_2d(points))[0]


def corners(state: PolyhedronState) -> np.ndarray:
    made = moving(state)
    return made.machine.moved(0, made.motion(state.moved))


def folds(state: PolyhedronState) -> list[tuple[int, int]]:
    """Return the edges at which one hinge makes two pieces of a body."""
    faces = shape_of(state).faces
    sides = {(min(pair), max(pair)) for rings in faces for pair in sides_of(rings)}
    return [edge for edge in sorted(sides) if rigid_faces(faces, frozenset({edge})).max() == 1]


def hinged(state: PolyhedronState, edge: tuple[int, int], over: float = 0.0) -> PolyhedronState:
    """Return the state with a hinge drawn along an edge, beyond both ends by a share of it."""
    one, other = seen(shape_of(state).vertices[list(edge)])
    way = over * (other - one)
    return DrawHinge().draw(state, Ink((straight(one - way, other + way, VIEW),)), Context())


def freedoms(state: PolyhedronState) -> int:
    machine = moving(state).machine
    return mobility_of(machine.assembly, machine.rest).degrees


def pulled(state: PolyhedronState, place: np.ndarray, way: np.ndarray) -> PolyhedronState:
    for frame in range(40):
        path = place + np.linspace(0.0, 1.0, frame + 2)[:, None] * way
        state = Move().step(state, Drag("", Stroke(*path.T, VIEW)), 1 / 60, Context())
    return state


@pytest.mark.parametrize("seed", SEEDS)
def test_a_lid_turns_about_its_edge_and_the_box_stands_still(seed):
    """The hinge held all of the box in the air before, for there was no other body."""
    state = read(lidded_box(seed))
    (fold,) = folds(state)
    made = hinged(state, fold)
    (hinge,) = made.of_kind(Hinge)
    assert hinge.second == hinge.begin.body
    assert made.selected == hinge.id
    assert freedoms(made) == 1
    shape, before = shape_of(made), corners(made)
    plates = moving(made).machine.plates[0]
    alone = int(np.flatnonzero(np.bincount(plates)[plates] == 1)[0])
    lid = sorted(set(shape.faces[alone][0]) - set(fold))
    after = corners(pulled(made, seen(before[lid[0]])[0], np.array([30.0, 40.0])))
    moved = np.linalg.norm(after - before, axis=1)
    assert moved[lid].min() > 5.0
    assert np.delete(moved, lid).max() < 1e-3
    arms = [np.linalg.norm(place[lid] - place[fold[0]], axis=1) for place in (before, after)]
    assert arms[0] == pytest.approx(arms[1], rel=1e-5)


@pytest.mark.parametrize("over", [-0.1, 0.08, 0.3])
def test_the_stroke_may_be_shorter_or_longer_than_the_edge(over):
    state = read(lidded_box(SEEDS[0]))
    (fold,) = folds(state)
    exact, near = hinged(state, fold), hinged(state, fold, over)
    assert near.of_kind(Hinge) == exact.of_kind(Hinge)


def test_each_hinge_frees_one_flap():
    state = read(open_box(80_112, (0, 1, 2, 3)))
    edges = folds(state)
    assert len(edges) == 4
    for count, edge in enumerate(edges, start=1):
        state = hinged(state, edge)
        assert freedoms(state) == count
        assert len(state.nodes[0].anchors) == 3  # held once
    (first, *_) = state.of_kind(Hinge)
    assert freedoms(state.without_nodes(first.id)) == 3


def test_what_is_held_or_joined_already_is_held_no_more():
    state = read(lidded_box(SEEDS[1]))
    (fold,) = folds(state)
    low = int(np.argmin(shape_of(state).vertices[:, 2]))
    x, y = seen(shape_of(state).vertices[low])[0]
    held = Move().tap(state, Tap(float(x), float(y), VIEW), Context())
    assert len(hinged(held, fold).nodes[0].anchors) == 1


def test_no_edge_of_a_solid_folds():
    """Its hinge turns all of it, as a door does in a frame."""
    state = read(OBJECTS["box"])
    assert folds(state) == []
    edge = tuple(shape_of(state).edges[0].tolist())
    made = hinged(state, edge)
    (hinge,) = made.of_kind(Hinge)
    assert hinge.second == ""
    assert freedoms(made) == 1
    assert made.nodes[0].anchors == ()


def test_faces_that_share_other_edges_stay_one_piece():
    """A strip of three squares, and a ring of four."""
    strip = tuple(((2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1),) for k in range(3))
    assert rigid_faces(strip, None).tolist() == [0, 1, 2]
    assert rigid_faces(strip, frozenset()).tolist() == [0, 0, 0]
    assert rigid_faces(strip, frozenset({(2, 3)})).tolist() == [0, 1, 1]
    ring = (*strip, ((6, 0, 1, 7),))
    assert rigid_faces(ring, frozenset({(2, 3)})).max() == 0
    assert rigid_faces(ring, frozenset({(2, 3), (4, 5)})).tolist() == [0, 1, 0, 0]


def test_a_folded_body_is_handed_over_in_its_parts():
    state = read(lidded_box(SEEDS[2]))
    (fold,) = folds(state)
    made = hinged(state, fold)
    free = [k for k in range(len(corners(made))) if k not in fold]
    lid = max(free, key=lambda k: corners(made)[k][2])
    made = pulled(made, seen(corners(made)[lid])[0], np.array([20.0, 20.0]))
    shapes = MODELER.shapes(made, MODELER.solve(made, Job()))
    assert [brep.name for brep in shapes.breps] == ["Body 1 part 1", "Body 1 part 2"]
    assert sorted(len(brep.faces) for brep in shapes.breps) == [1, 5]
    with pytest.raises(UserError, match="Back to rest"):
        hinged(made, fold)


@pytest.mark.parametrize("name", ["box", "L"])
def test_a_solid_slides_along_the_edge_that_the_stroke_follows_and_does_not_turn(name):
    state = read(OBJECTS[name])
    shape = shape_of(state)
    for edge in shape.edges[:3]:
        begin, end = shape.vertices[edge]
        one, other = seen(np.stack((begin, end)))
        aside = np.array([[0.0, -1.0], [1.0, 0.0]]) @ (one - other) * 0.1
        stroke = straight(one, one + 1.4 * (one - other) + aside, VIEW)
        made = DrawSlider().draw(state, Ink((stroke,)), Context())
        (slider,) = made.of_kind(Slider)
        assert slider.turning == "locked"
        assert freedoms(made) == 1
        before = corners(made)
        after = corners(pulled(made, one, 0.8 * (one - other) + 4.0 * aside))
        moved = after - before
        along = (begin - end) / np.linalg.norm(begin - end)
        assert (moved @ along).min() > 5.0
        assert np.abs(moved - np.outer(moved @ along, along)).max() < 1e-3
        turning = made.with_node(replace(slider, turning="free"))
        assert freedoms(turning) == 4


def test_a_pin_of_bars_turns_where_it_slides():
    state = read(OBJECTS["box"])
    bars = state.with_node(replace(state.nodes[0], moves="links"))
    one, other = seen(shape_of(bars).vertices[shape_of(bars).edges[0]])
    made = DrawSlider().draw(bars, Ink((straight(one, 2.0 * one - other, VIEW),)), Context())
    assert made.of_kind(Slider)[0].turning == "free"


@pytest.mark.parametrize("seed", SEEDS)
def test_a_box_with_its_lid_open_stands_on_its_floor(seed):
    state = read(lidded_box(seed))
    drawn = state.with_node(replace(state.nodes[0], choice=None))
    standing = next_answer(drawn, replace(Context(), alone=True))
    heights = shape_of(standing).vertices[:, 2]
    assert heights.min() == 0.0
    assert (heights < 1e-9).sum() == 4
    assert next_answer(drawn, Context()).nodes[0].placement.is_identity


def test_a_sheet_without_a_floor_is_left_as_it_lies():
    name = "folding-screen.json"
    drawing = read_drawing((FOLDER / name).read_bytes(), name)
    state = MODELER.read_drawing(drawing, Context(), Job())
    drawn = state.with_node(replace(state.nodes[0], choice=None))
    standing = next_answer(drawn, replace(Context(), alone=True))
    assert standing.nodes[0].placement.is_identity
