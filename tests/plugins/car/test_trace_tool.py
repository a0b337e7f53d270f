"""Edges traced through the tool: where they run, what else moves, what is kept, what is erased."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.plugin import Context, Ink
from bozzetto_car.body.build import body_of
from bozzetto_car.camera.sketch_camera import upright_camera
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.state import CarState, Mark, MovedNode, TracedEdges
from bozzetto_car.template.network import edge_called
from bozzetto_car.tools.trace_edges import TraceEdges
from tests.plugins.car.marked_car import (
    another,
    apart,
    locked_creases,
    marked,
    pen,
    with_mark_moved,
)
from tests.plugins.car.traced_car import SEEN, curve, drawn, symmetric, view
from tests.previews import preview_of

TOOL, CONTEXT = TraceEdges(), Context()


def traced(state: CarState, *strokes: Stroke) -> CarState:
    return TOOL.apply(state, Ink(strokes), CONTEXT)


def points_of(state: CarState, name: str) -> np.ndarray:
    body = body_of(state)
    return body.network.control_points[edge_called(body.template, name)]


@pytest.mark.parametrize("name", SEEN)
@pytest.mark.parametrize("state", [CarState(), marked()], ids=["template", "sketch"])
def test_an_edge_follows_the_pen_and_nothing_else_comes_apart(state: CarState, name: str) -> None:
    camera, before = view(50.0, 10.0), body_of(state)
    aim = another(before, name, 1)
    made = traced(state, pen(camera, aim))
    after = body_of(made)
    assert made.edits[-1].edges == (name,)
    assert apart(camera, points_of(made, name), aim) < 2.0
    assert np.array_equal(after.network.positions, before.network.positions)
    assert symmetric(after.network)
    assert locked_creases(after).max() <= 0.1
    assert not after.troubles


@pytest.mark.parametrize("name", SEEN)
def test_its_own_picture_changes_nothing(name: str) -> None:
    state, camera = marked(3), view(50.0, 10.0)
    state = traced(state, pen(camera, another(body_of(state), name, 2)))
    again = traced(state, pen(camera, points_of(state, name)))
    one, other = body_of(state).network, body_of(again).network
    assert np.abs(one.tangents - other.tangents).max() < 1e-6
    assert np.array_equal(one.positions, other.positions)


def test_edges_drawn_before_stay_near_their_strokes() -> None:
    """Earlier ones give way only to a neighbour drawn later, and for smooth surfaces."""
    state, camera = marked(1), view(50.0, 10.0)
    aims = {}
    for number, name in enumerate(SEEN):
        aims[name] = another(body_of(state), name, 10 + number, 0.04)
        state = traced(state, pen(camera, aims[name]))
        assert apart(camera, points_of(state, name), aims[name]) < 2.0
        assert locked_creases(body_of(state)).max() <= 0.1
    off = [apart(camera, points_of(state, name), aim) for name, aim in aims.items()]
    assert np.median(off) < 2.0


def test_a_row_of_edges_in_one_stroke_is_kept_by_name() -> None:
    state, camera = CarState(), view(70.0, 10.0)
    names = ["S2.R-S1.R", "S3.R-S2.R", "S4.R-S3.R"]
    pixels = np.concatenate([drawn(camera, points_of(state, name))[::-1] for name in names])
    bump = 12.0 * np.sin(np.linspace(0.0, np.pi, len(pixels))) ** 2
    made = traced(state, Stroke(pixels[:, 0], pixels[:, 1] - bump, camera))
    assert made.edits[-1].edges == tuple(names)
    backward = traced(state, Stroke(pixels[::-1, 0], pixels[::-1, 1] - bump[::-1], camera))
    assert np.abs(points_of(made, names[1]) - points_of(backward, names[1])).max() < 1.0


# -- on the sketch ---------------------------------------------------------------------------------


def on_sketch(state: CarState, name: str, lift: float) -> tuple[CarState, np.ndarray]:
    """An edge traced on the sketch in a window of another size, higher than it is; and where."""
    sketch_camera = body_of(state).sketch_cameras["1"]
    points = points_of(state, name).copy()
    points[1:3, 2] += lift
    return traced(state, pen(sketch_camera.view((1700.0, 700.0)), points)), sketch_camera.pixels(
        curve(points)
    )


def near(state: CarState, stem: str) -> str:
    """A node or an edge on the side that the sketch shows."""
    side = "L" if state.sketches[0].mark_of("WF.L") else "R"
    return "-".join(f"{node}.{side}" for node in stem.split("-"))


def seen_in_picture(state: CarState, name: str) -> np.ndarray:
    return body_of(state).sketch_cameras["1"].pixels(curve(points_of(state, name), 300))


def test_a_stroke_on_the_sketch_is_kept_in_pixels_of_the_picture() -> None:
    state = replace(marked(), length=4700.0, wheelbase=2750.0)
    made, pixels = on_sketch(state, near(state, "S3-S2"), 25.0)
    edit = made.edits[-1]
    assert isinstance(edit, TracedEdges)
    assert edit.sketch == "1"
    assert edit.dimensions == Dimensions()
    assert edit.strokes[0].camera == upright_camera((1200.0, 800.0)).camera
    assert np.abs(edit.strokes[0].points - pixels).max() < 1e-3


def test_a_stroke_right_after_a_mark_is_kept_where_it_was_seen_on_the_picture() -> None:
    """The view has not gone along with the mark yet: it is through the sketch as it was seen."""
    before = marked(2)
    drawn_on, pixels = on_sketch(before, near(before, "S3-S2"), 25.0)
    sketch_camera = body_of(before).sketch_cameras["1"]
    camera = sketch_camera.view((1200.0, 800.0))
    x, y = camera.project(sketch_camera.lifted(pixels))[0].T
    stroke = Stroke(x, y, camera)
    after = with_mark_moved(before, "C3", (0.0, -30.0))
    assert not body_of(after).sketch_cameras["1"].is_seen_through(camera)
    (made,) = TOOL.apply(after, Ink((stroke,)), replace(CONTEXT, seen=(before,))).edits
    assert made.sketch == "1"
    assert made.edges == drawn_on.edits[-1].edges
    assert np.abs(made.strokes[0].points - pixels).max() < 1e-3
    (aside,) = traced(after, stroke).edits  # nobody saw the car otherwise: a view from elsewhere
    assert aside.sketch == ""


@pytest.mark.parametrize("stem", ["S3-S2", "B3-B2", "S3-B3", "R2-R1"])
def test_it_stays_on_its_line_when_marks_move_the_camera(stem: str) -> None:
    state = marked(2)
    name = near(state, stem)
    made, pixels = on_sketch(state, name, 25.0)
    assert distances_to_polyline(pixels, seen_in_picture(made, name)).max() < 2.0
    for node, by in ((near(state, "S1"), (6.0, -4.0)), ("C3", (0.0, -8.0))):
        moved = with_mark_moved(made, node, by)
        inner = pixels[15:-15]  # the ends go with their nodes
        assert distances_to_polyline(inner, seen_in_picture(moved, name)).max() < 4.0
        assert np.array_equal(moved.edits, made.edits)


def test_a_replay_bends_the_same_edge_though_another_is_nearer_by_then() -> None:
    state = CarState()
    camera = view(90.0, 5.0)
    made = traced(state, pen(camera, points_of(state, "S3.R-B3.R")))
    # The post goes far ahead: the stroke now runs nearer to others, and means it all the same.
    shift = MovedNode(node="S3.R", by=(330.0, 0.0, 0.0)), MovedNode(node="B3.R", by=(330.0, 0, 0))
    later = replace(made, edits=(*shift, *made.edits))
    plain = replace(made, edits=shift)
    changed = np.abs(body_of(later).network.tangents - body_of(plain).network.tangents)
    template = body_of(state).template
    bent = {template.edge_names[e] for e in np.flatnonzero(changed.max(axis=(1, 2)) > 20.0)}
    assert "S3.R-B3.R" in bent
    assert not body_of(later).troubles


# -- what cannot be --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("edges", "words"),
    [
        (("C1-Z9",), "no edge"),
        (("S3.R-B3.R", "C1-C2"), "make no line"),
        (("C7-C8",), "far from|end-on|not in view"),
    ],
)
def test_an_edge_that_is_not_there_or_not_near_is_told(edges: tuple[str, ...], words: str) -> None:
    state, camera = CarState(), view(50.0, 10.0)
    stroke = pen(camera, points_of(state, "S3.R-B3.R"))
    state = replace(state, edits=(TracedEdges(strokes=Strokes((stroke,)), edges=edges),))
    body = body_of(state)
    (trouble,) = body.troubles
    assert trouble.number == 0
    assert re.search(words, trouble.message)
    assert np.array_equal(body.network.tangents, body_of(CarState()).network.tangents)


def test_a_sketch_that_is_gone_is_told_and_the_rest_stays() -> None:
    state = marked()
    made, _ = on_sketch(state, near(state, "S3-S2"), 25.0)
    camera = view(50.0, 10.0)
    made = traced(made, pen(camera, another(body_of(made), "C1-C2", 4)))
    gone = replace(made, nodes=(), selected="")
    (trouble,) = body_of(gone).troubles
    assert trouble.number == 0
    assert "sketch" in trouble.message
    assert not np.array_equal(
        body_of(gone).network.tangents, body_of(replace(gone, edits=())).network.tangents
    )


def test_there_is_nothing_to_trace_while_the_camera_is_unknown() -> None:
    sketch = replace(marked().sketches[0], marks=(Mark("C1", 300.0, 400.0),))
    state = CarState().with_node(sketch)
    stroke = Stroke([100.0, 400.0], [300.0, 320.0], view(50.0, 10.0))
    with pytest.raises(UserError, match="Mark its points first"):
        traced(state, stroke)
    assert not preview_of(TOOL, state, Ink((stroke,)), CONTEXT).layers


# -- preview and eraser ----------------------------------------------------------------------------


def test_the_preview_is_what_comes() -> None:
    state, camera = marked(), view(50.0, 10.0)
    stroke = pen(camera, another(body_of(state), "S3.R-S2.R", 5))
    (layer,) = preview_of(TOOL, state, Ink((stroke,)), CONTEXT).layers
    assert layer.name == "network"
    held = layer.items[-1]
    after = points_of(traced(state, stroke), "S3.R-S2.R")
    assert held.color == "accent"
    assert np.abs(held.points[[0, -1]] - after[[0, 3]]).max() < 0.01
    middle = (after[0] + 3 * after[1] + 3 * after[2] + after[3]) / 8
    assert np.abs(held.points - middle).max(axis=1).min() < 0.01


def test_the_eraser_takes_back_the_last_stroke_of_an_edge_on_either_side() -> None:
    start, camera = CarState(), view(50.0, 10.0)
    first = traced(start, pen(camera, another(body_of(start), "S3.R-S2.R", 6)))
    second = traced(first, pen(camera, another(body_of(first), "C1-C2", 7)))
    third = traced(second, pen(camera, another(body_of(second), "S3.R-S2.R", 8)))
    rub = pen(camera, points_of(third, "S3.R-S2.R"), tool="eraser")
    assert traced(third, rub).edits == second.edits
    other_side = view(-50.0, 10.0)
    rub = pen(other_side, points_of(second, "S3.L-S2.L"), tool="eraser")
    assert traced(second, rub).edits == second.edits[1:]
    with pytest.raises(UserError, match="under the eraser"):
        traced(second, pen(camera, points_of(second, "S3.R-B3.R"), tool="eraser"))
    assert not preview_of(TOOL, second, Ink((rub,)), CONTEXT).layers


def test_nodes_follow_if_that_is_wanted() -> None:
    state, camera = replace(CarState(), nodes_follow=True), view(60.0, 12.0)
    pixels = drawn(camera, points_of(state, "S3.R-S2.R")) - np.array([0.0, 14.0])
    made = traced(state, Stroke(pixels[:, 0], pixels[:, 1], camera))
    assert made.edits[-1].nodes_follow
    ends = camera.project(points_of(made, "S3.R-S2.R")[[0, 3]])[0]
    assert np.abs(ends - pixels[[0, -1]]).max() < 0.1
    assert symmetric(body_of(made).network)
