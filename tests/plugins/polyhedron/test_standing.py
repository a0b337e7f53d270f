"""A solid stands on the ground from its first answer on; nothing moves on the sheet meanwhile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Stroke
from bozzetto.plugin import Ink, Job, Tap
from bozzetto.testing import Pen, Shell
from bozzetto.view import Camera, turn
from bozzetto.view.standard_views import standard_view
from bozzetto_polyhedron.commands.answers import mirrored_answer, next_answer
from bozzetto_polyhedron.commands.bodies import unfolded
from bozzetto_polyhedron.model.same_view import view_of
from bozzetto_polyhedron.model.state import Body, Measure, PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.picking import Touched
from bozzetto_polyhedron.tools.dimension import measured
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.turn_solid import TurnSolid
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.write_samples import hidden_edges

MODELER = PolyhedronModeler()

FRONT = Camera(kind="orthographic", height=240.0)


def _strokes(name: str, **untidy: float) -> list:
    """A known solid seen aslant, drawn on a sheet that is seen from the front."""
    solid, vertices = OBJECTS[name], fitted(OBJECTS[name])
    hidden = hidden_edges(solid, vertices, VIEW)
    made = strokes_of(vertices, solid.edges, hidden=hidden, **untidy)
    return [_seen_by(stroke, FRONT) for stroke in made]


def _seen_by(stroke: Stroke, camera: Camera) -> Stroke:
    return Stroke(stroke.x, stroke.y, camera, pressure=stroke.pressure)


def _ink(stroke: Stroke) -> Ink:
    return Ink((stroke,), committed=True)


def _drawn(shell: Shell, name: str, **untidy: float) -> PolyhedronState:
    shell.open(MODELER.id)
    shell.camera = FRONT
    shell.draw(*_strokes(name, **untidy))
    return shell.state


def _body(state: PolyhedronState) -> Body:
    return state.of_kind(Body)[0]


def _solved(state: PolyhedronState):
    return MODELER.solve(state, Job()).bodies[_body(state).id]


def _alone(shell: Shell):
    return replace(shell.context(), alone=True)


@pytest.mark.parametrize("name", ["box", "L", "house", "stairs"])
def test_a_solid_stands_and_its_picture_stays(shell, name):
    state = _drawn(shell, name, jitter=2.0, seed=13001)
    leaning = next_answer(state, shell.context())
    standing = next_answer(state, _alone(shell))
    made = _solved(standing).body
    assert made.vertices[:, 2].min() == 0.0
    (foot,) = np.flatnonzero(made.normals[:, 2] == -1.0)
    assert (np.abs(made.normals) == 1.0).any(axis=1).sum() >= 3
    assert made.offsets[foot] == 0.0
    view = view_of(_body(standing))
    seen = FRONT.project(_solved(leaning).body.vertices)[0]
    assert np.abs(view.project(made.vertices)[0] - seen).max() < 1e-6
    eye = -view.axes[2]
    assert eye[1] < 0.0  # from the front,
    assert abs(eye[0]) <= -eye[1] + 1e-9  # to within 45°


def test_the_view_goes_along_and_comes_back(shell):
    drawn = _drawn(shell, "house", jitter=2.0, seed=13002)
    standing = next_answer(drawn, _alone(shell))
    before, after = (MODELER.solve(state, Job()) for state in (drawn, standing))
    there = MODELER.advice_on_result(standing, after, FRONT, [before])
    assert there.follow
    assert there.as_drawn
    assert MODELER.advice_on_result(standing, after, there.better, [before]).follow is False
    back = MODELER.advice_on_result(drawn, before, there.better, [after])
    assert back.follow
    assert np.abs(back.better.axes - FRONT.axes).max() < 1e-12
    assert np.abs(np.subtract(back.better.eye, FRONT.eye)).max() < 1e-9
    turned = turn(FRONT, 20.0, 5.0)
    assert MODELER.advice_on_result(standing, after, turned, [before]) is None


@pytest.mark.parametrize("step", [next_answer, mirrored_answer])
def test_another_answer_stands_as_well(shell, step):
    state = next_answer(_drawn(shell, "box", jitter=1.0, seed=13003), _alone(shell))
    shown = replace(_body(state), hidden="unmarked")
    other = step(state.with_node(shown), _alone(shell))
    made = _solved(other).body
    assert made.vertices[:, 2].min() == 0.0
    assert (made.normals[:, 2] == -1.0).sum() == 1


def test_nothing_is_moved_where_anything_else_is_visible(shell):
    state = next_answer(_drawn(shell, "box"), shell.context())
    assert _body(state).placement.is_identity


def test_a_solid_by_itself_leans_no_more_when_lines_are_drawn_again(shell):
    strokes = _strokes("house", jitter=2.0, seed=13004)
    shell.open(MODELER.id)
    shell.camera = FRONT
    shell.draw(*strokes)
    state = next_answer(shell.state, _alone(shell))
    view = view_of(_body(state))
    again = [_seen_by(stroke, view) for stroke in _strokes("house", jitter=2.0, seed=13005)]
    for stroke in again[:3]:
        state = DrawLines().draw(state, _ink(stroke), replace(_alone(shell), camera=view))
    assert len(_body(state).strokes) > len(strokes)
    made = _solved(state).body
    assert (made.normals[:, 2] == -1.0).sum() == 1
    assert made.vertices[:, 2].min() == 0.0


def test_a_hand_that_is_quicker_than_the_view_draws_on_what_it_saw(shell):
    drawn = _drawn(shell, "box")
    standing = next_answer(drawn, _alone(shell))
    late = _strokes("box")[0]
    context = replace(_alone(shell), seen=(drawn,))
    made = DrawLines().draw(standing, _ink(late), context)
    assert len(made.of_kind(Body)) == 1


def test_drawings_of_the_sheet_come_along_and_others_join_them(shell):
    """A second drawing beside the first is begun before it stands, and finished after that."""
    state = _drawn(shell, "box")
    low = min(float(s.x.min()) for s in _body(state).strokes)
    aside = [(low + 1100.0, 200.0), (low + 1200.0, 300.0), (low + 1100.0, 400.0)]
    shell.run("new-body")
    shell.draw(Pen(FRONT).along(aside[:2]))
    chosen = replace(shell.state, selected=_body(shell.state).id)
    standing = next_answer(chosen, _alone(shell))
    first, second = standing.of_kind(Body)
    assert first.placement == second.placement
    assert not first.placement.is_identity
    view = view_of(second)
    more = Pen(view).along(aside[1:])
    made = DrawLines().draw(
        replace(standing, selected=second.id), _ink(more), replace(_alone(shell), camera=view)
    )
    assert [len(body.strokes) for body in made.of_kind(Body)] == [12, 2]


def test_a_linkage_drawn_flat_is_left_as_it_was_drawn(shell):
    state = _drawn(shell, "box")
    flat = replace(_body(state), moves="flat")
    made = next_answer(state.with_node(flat), _alone(shell))
    assert _body(made).placement.is_identity


def test_the_window_keeps_the_picture_and_shows_the_front(window):
    """Touch, undo, redo, the next answer: what is seen stays, what stands below it turns."""
    window.open("polyhedron")
    window.look("front")
    window.draw(*_strokes("L", jitter=1.5, seed=13006))
    drawn = window.session.view.camera
    corner = _body(window.state).strokes[0].points[0]
    window.take("turn")
    window.tap(*corner)
    window.wait_until(lambda: window.session.view.camera != drawn)
    assert not _body(window.state).placement.is_identity
    seen = window.session.view.camera
    made = _solved(window.state).body
    places = seen.project(made.vertices)[0]
    assert np.linalg.norm(places - corner, axis=1).min() < 25.0
    window.undo()
    window.wait_until(lambda: np.abs(window.session.view.camera.axes - drawn.axes).max() < 1e-9)
    window.press("Ctrl+Shift+Z")
    window.wait_until(lambda: np.abs(window.session.view.camera.axes - seen.axes).max() < 1e-9)
    window.look("front")
    window.settle()
    assert np.abs(window.session.view.camera.axes - standard_view(seen, "front").axes).max() < 1e-9


def test_a_tap_is_one_step_of_the_tool(shell):
    state = _drawn(shell, "box")
    place = _body(state).strokes[0].points[0]
    tap = Tap(float(place[0]), float(place[1]), FRONT)
    made = TurnSolid().tap(state, tap, _alone(shell))
    assert not _body(made).placement.is_identity


@pytest.mark.parametrize("factor", [0.8, 1.6])
@pytest.mark.parametrize("name", ["box", "L", "house", "stairs"])
def test_what_stands_stays_on_the_ground_when_its_height_is_typed(shell, name, factor):
    state = next_answer(_drawn(shell, name, jitter=2.0, seed=13020), _alone(shell))
    found = _solved(state)
    ends = found.base.vertices[found.graph.lines]
    upright = np.abs(np.diff(ends, axis=1)[:, 0]) > (1e-6, 1e-6, 1.0)
    number = int(np.flatnonzero((upright == (False, False, True)).all(axis=1))[0])
    typed = measured(state, Touched(_body(state), found, 0.0, number))
    length = typed.of_kind(Measure)[0]
    made = _solved(typed.with_node(replace(length, length=factor * length.length))).body
    assert made.vertices[:, 2].min() == 0.0
    assert np.abs(made.vertices[:, :2] - found.body.vertices[:, :2]).max() < 1e-9


def test_what_is_next_is_about_the_solid_where_no_part_of_it_is_chosen(shell):
    """Where the object alone was chosen, a person was told to draw every edge of a solid."""
    state = next_answer(_drawn(shell, "box", jitter=1.0, seed=13021), _alone(shell))
    said = DrawLines().next_step(state)
    assert "Turn the view" in said.sentence
    assert DrawLines().next_step(replace(state, selected="")) == said


def test_what_is_next_tells_where_the_net_is(shell):
    """It lies beside the solid, often out of sight."""
    state = next_answer(_drawn(shell, "box", jitter=1.0, seed=13022), _alone(shell))
    laid = unfolded(state, _alone(shell))
    for tool in (DrawLines(), TurnSolid()):
        assert "net lies beside it: Home" in tool.next_step(laid).sentence
        assert "net" not in tool.next_step(unfolded(laid, _alone(shell))).sentence
