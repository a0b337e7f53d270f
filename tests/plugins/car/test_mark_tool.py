"""Marks set, dragged and rubbed out by hand; sides that find themselves; what is shown then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Drag, Ink, Job, Tap
from bozzetto.scene import Handle, Label, Lines
from bozzetto.view.eye_fixed_motion import aimed, enlarged
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import all_commands
from bozzetto_car.marking.next_mark import asked_of
from bozzetto_car.report import report_of
from bozzetto_car.state import CarState, Group, Mark
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import twin
from bozzetto_car.view.view_advice import advice_on
from tests.plugins.car.penned import (
    CANVAS,
    CONTEXT,
    TOOL,
    blank,
    dragged,
    guided,
    on_canvas,
    places_of,
    stroke_on,
    tapped,
    through,
    view_of,
)
from tests.previews import preview_of

FRONT_LEFT, FRONT_RIGHT, REAR_RIGHT = view_of(-45.0), view_of(40.0), view_of(140.0)
COMMANDS = {command.id: command for command in all_commands()}


@pytest.fixture(scope="module")
def marked_car():
    """Twelve marks, in the order of asking, without an error."""
    return guided(FRONT_RIGHT, 12)


def layers(scene):
    return {layer.name: layer.items for layer in scene.layers}


# -- places ----------------------------------------------------------------------------------------


def test_a_mark_is_where_the_pen_lifts(marked_car):
    for state in (blank(), marked_car):
        camera = through(state)
        for pixel in ((600.0, 400.0), (3.0, 790.0), (-240.0, 950.0)):
            made = tapped(state, pixel, camera)
            mark = made.sketch.marks[-1]
            assert (mark.u, mark.v) == pytest.approx(pixel, abs=1e-6)


def test_zoom_and_pan_about_the_eye_change_nothing(marked_car):
    camera = enlarged(through(marked_car), 6.0)
    ahead = np.subtract(camera.target, camera.eye) + np.array([150.0, 200.0, -90.0])
    camera = aimed(camera, ahead, (300.0, 500.0))
    mark = tapped(marked_car, (512.0, 333.0), camera).sketch.marks[-1]
    assert (mark.u, mark.v) == pytest.approx((512.0, 333.0), abs=1e-6)


def test_a_view_that_has_not_gone_along_yet_shows_what_it_shows(marked_car):
    """The camera of the window is that of the solve before: marks are of the picture as seen."""
    before = through(marked_car)
    old = body_of(marked_car).sketch_cameras["one"]
    asked = asked_of(marked_car, body_of(marked_car).solved)
    state = tapped(marked_car, asked.place + np.array([9.0, -6.0]), before)
    now = body_of(state).sketch_cameras["one"]
    assert not now.is_seen_through(before)
    x, y = before.project(old.lifted([(444.0, 222.0)]))[0][0].tolist()
    seen = replace(CONTEXT, seen=(marked_car,))
    mark = TOOL.apply(state, Tap(x, y, before), seen).sketch.marks[-1]
    assert (mark.u, mark.v) == pytest.approx((444.0, 222.0), abs=1e-6)
    with pytest.raises(UserError, match="T"):
        TOOL.apply(state, Tap(x, y, before), CONTEXT)


def test_marks_are_refused_where_the_sketch_is_not_seen_as_drawn(marked_car):
    camera = through(marked_car)
    aside = replace(camera, eye=tuple(np.add(camera.eye, (0.0, 400.0, 0.0))))
    with pytest.raises(UserError, match="T"):
        TOOL.apply(marked_car, Tap(300.0, 300.0, aside), CONTEXT)
    with pytest.raises(UserError, match="beside the picture"):
        tapped(blank(), (30_000.0, 0.0))
    with pytest.raises(UserError, match="no sketch"):
        TOOL.apply(CarState(), Tap(1.0, 1.0, camera), CONTEXT)


def test_a_hidden_sketch_is_not_marked(marked_car):
    """By its own eye in the list, or by that of the group it is in."""
    camera = through(marked_car)
    over = Ink((stroke_on(marked_car, camera, [(9.0, 9.0)], "eraser"),))
    alone = marked_car.with_node(replace(marked_car.sketch, visible=False))
    group = Group(id="g", name="Group", visible=False)
    within = replace(marked_car, nodes=(group, replace(marked_car.sketch, within="g")))
    for hidden in (alone, within):
        for gesture in (Tap(300.0, 300.0, camera), over):
            with pytest.raises(UserError, match="hidden"):
                TOOL.apply(hidden, gesture, CONTEXT)
            assert not preview_of(TOOL, hidden, gesture, CONTEXT).layers
        for name in ("skip", "ask-before", "not-visible"):
            with pytest.raises(UserError, match="hidden"):
                COMMANDS[name].run(hidden, CONTEXT)
        assert "hidden" in TOOL.next_step(hidden).sentence
        assert advice_on(hidden, body_of(hidden), camera).level == "good"


# -- sides -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("camera", [FRONT_LEFT, FRONT_RIGHT, REAR_RIGHT, view_of(-130.0)])
def test_nobody_has_to_think_of_left_and_right(camera):
    """Near and far are all that a person is asked; the names come out as the car has them."""
    state = guided(camera, 39)
    truth = places_of(camera)
    assert {mark.node for mark in state.sketch.marks} == set(truth)
    for mark in state.sketch.marks:
        assert (mark.u, mark.v) == pytest.approx(truth[mark.node], abs=1e-6)
    assert state.sketch.shows == ("R" if camera.eye[1] > 0.0 else "L")
    placed = body_of(state).solved.placed["one"]
    assert not placed.exchanged
    assert max(placed.missed.values()) < 1e-3


def test_sides_change_with_the_second_wheel_and_not_again():
    state = blank()
    state = tapped(state, (800.0, 600.0))  # the front wheel, on the right of the picture
    assert (state.sketch.marks[0].node, state.sketch.shows) == ("WF.L", "L")
    state = tapped(state, (300.0, 600.0))
    assert [mark.node for mark in state.sketch.marks] == ["WF.R", "WR.R"]
    assert state.sketch.shows == "R"
    assert "right side" in TOOL.next_step(state).sentence
    further = tapped(state, (900.0, 500.0))
    assert further.sketch.shows == "R"
    assert further.sketch.marks[:2] == state.sketch.marks
    # What a person exchanges stays, until they move a wheel.
    other = COMMANDS["exchange-sides"].run(further, CONTEXT)
    assert other.sketch.shows == "L"
    assert [twin(mark.node) for mark in other.sketch.marks] == [
        mark.node for mark in further.sketch.marks
    ]
    assert tapped(other, (850.0, 450.0)).sketch.shows == "L"


def test_passed_over_points_change_sides_too():
    state = COMMANDS["not-visible"].run(blank(), CONTEXT)
    assert state.sketch.skipped == ("WF.L",)
    other = replace(state.sketch, marks=(Mark("C1", 1.0, 2.0),))
    other = COMMANDS["exchange-sides"].run(state.with_node(other), CONTEXT)
    assert other.sketch.skipped == ("WF.R",)


# -- dragging --------------------------------------------------------------------------------------


def test_a_dragged_mark_is_moved_and_keeps_its_place_in_the_row(marked_car):
    node = marked_car.sketch.marks[4].node
    drag = dragged(marked_car, node, [(700.0, 300.0), (710.0, 290.0), (731.0, 277.0)])
    moved = TOOL.apply(marked_car, drag, CONTEXT)
    assert [m.node for m in moved.sketch.marks] == [m.node for m in marked_car.sketch.marks]
    assert (moved.sketch.marks[4].u, moved.sketch.marks[4].v) == pytest.approx((731.0, 277.0))
    others = [m for m in moved.sketch.marks if m.node != node]
    assert others == [m for m in marked_car.sketch.marks if m.node != node]


def touched_beside(state: CarState, node: str, off: float) -> CarState:
    """Touch the handle of a mark some pixels of the sheet beside its middle."""
    camera, mark = through(state), state.sketch.mark_of(node)
    x, y = on_canvas(state, camera, (mark.u, mark.v))
    path = np.array([(x + off, y), (x + off, y)])
    stroke = Stroke(
        x=path[:, 0],
        y=path[:, 1],
        pressure=np.full(2, 0.5),
        t=np.array([0.0, 0.01]),
        camera=camera,
        tool="pen",
    )
    return TOOL.drag(state, Drag(f"mark {node}", stroke), CONTEXT)


@pytest.mark.parametrize("off", [-9.0, 5.0, 9.0])
def test_a_point_close_to_another_mark_can_be_set(off):
    state = guided(view_of(-50.0), 9)
    due = asked_of(state, body_of(state).solved).node
    old = state.sketch.marks[0]
    made = touched_beside(state, old.node, off)
    assert made.sketch.marks[:-1] == state.sketch.marks
    assert made.sketch.marks[-1].node == due
    camera = through(state)
    places = [on_canvas(state, camera, (m.u, m.v)) for m in (old, made.sketch.marks[-1])]
    assert np.subtract(places[1], places[0]) == pytest.approx((off, 0.0), abs=1e-3)


@pytest.mark.parametrize(("number", "off"), [(0, 0.0), (0, 3.0), (-1, 3.0), (-1, 6.0), (-1, -7.0)])
def test_a_hasty_second_touch_sets_no_next_point(number, off):
    state = guided(view_of(-50.0), 9)
    assert touched_beside(state, state.sketch.marks[number].node, off) == state


def test_a_touch_beside_a_mark_changes_nothing_where_nothing_is_asked(marked_car):
    left = {*bundled("sedan").names} - {mark.node for mark in marked_car.sketch.marks}
    state = marked_car.with_node(replace(marked_car.sketch, skipped=tuple(left)))
    assert touched_beside(state, state.sketch.marks[0].node, 9.0) == state


def test_a_mark_that_is_only_touched_stays(marked_car):
    mark = marked_car.sketch.marks[3]
    assert TOOL.apply(marked_car, dragged(marked_car, mark.node, [(mark.u, mark.v)]), CONTEXT) is (
        marked_car
    )


def test_the_handle_of_something_else_is_told_and_changes_nothing(marked_car):
    drag = Drag("node C1", dragged(marked_car, "C1", [(5.0, 5.0), (60.0, 60.0)]).path)
    with pytest.raises(UserError, match="drag a mark"):
        TOOL.apply(marked_car, drag, CONTEXT)
    assert not preview_of(TOOL, marked_car, drag, CONTEXT).layers


def test_the_eraser_takes_the_marks_it_runs_over(marked_car):
    first, second = marked_car.sketch.marks[2], marked_car.sketch.marks[5]
    camera = through(marked_car)
    over = stroke_on(marked_car, camera, [(first.u, first.v), (second.u, second.v)], "eraser")
    left = TOOL.apply(marked_car, Ink((over,)), CONTEXT).sketch.marks
    gone = {m.node for m in marked_car.sketch.marks} - {m.node for m in left}
    assert {first.node, second.node} <= gone
    beside = stroke_on(marked_car, camera, [(30.0, 30.0)], "eraser")
    with pytest.raises(UserError, match="no mark under"):
        TOOL.apply(marked_car, Ink((beside,)), CONTEXT)
    with pytest.raises(UserError, match="no mark under"):
        TOOL.apply(blank(), Ink((stroke_on(blank(), camera, [(9.0, 9.0)], "eraser"),)), CONTEXT)


# -- what is shown meanwhile -----------------------------------------------------------------------


def test_the_car_moves_with_the_mark_where_the_picture_would_show_it(marked_car):
    """The window looks through the camera before; the edges are where the one after has them."""
    mark = marked_car.sketch.marks[2]
    drag = dragged(marked_car, mark.node, [(mark.u, mark.v), (mark.u + 5.0, mark.v - 4.0)])
    shown = layers(preview_of(TOOL, marked_car, drag, CONTEXT))
    assert shown["body"] == shown["wheels"] == shown["network"] == ()
    lines = np.concatenate([item.points for item in shown["car"]])
    seen = drag.camera.project(lines)[0]
    after = body_of(TOOL.apply(marked_car, drag, CONTEXT))
    sketch_camera = after.sketch_cameras["one"]
    nodes = sketch_camera.pixels(after.network.positions[after.template.edges.ravel()])
    window = body_of(marked_car).sketch_cameras["one"]
    at = drag.camera.project(window.lifted(nodes))[0]
    gaps = np.linalg.norm(at[:, None] - seen, axis=2).min(axis=1)
    assert gaps.max() < 1.0, "every end of an edge is drawn, but for how the solve was begun"
    (label,) = [i for i in shown["marks"] if isinstance(i, Label) and "px off" in i.text]
    assert label.point == pytest.approx(
        next(i.point for i in shown["marks"] if isinstance(i, Handle) and mark.node in i.id)
    )


def test_the_sixth_mark_shows_a_car_before_the_pen_is_lifted():
    state = guided(FRONT_RIGHT, 5)
    pixel = places_of(FRONT_RIGHT)["C0"]
    state = COMMANDS["skip"].run(state, CONTEXT)
    camera = through(state)
    while "WF" in TOOL.next_step(state).sentence:
        state = COMMANDS["skip"].run(state, CONTEXT)
    state = replace(state, asked="C0")
    tap = Tap(*on_canvas(state, camera, pixel), camera)
    shown = layers(preview_of(TOOL, state, tap, CONTEXT))
    assert shown["car"]
    seen = camera.project(np.concatenate([item.points for item in shown["car"]]))[0]
    assert (np.abs(seen - 0.5 * np.array(CANVAS)) < CANVAS).all(), "upon the picture"
    before = layers(preview_of(TOOL, guided(FRONT_RIGHT, 3), Tap(9.0, 9.0, camera), CONTEXT))
    assert set(before) == {"marks"}


def test_a_preview_never_fails(marked_car):
    rng = np.random.default_rng(3)
    camera = through(marked_car)
    for x, y in rng.normal(0.0, 1500.0, (12, 2)).tolist():
        preview_of(TOOL, marked_car, Tap(x, y, camera), CONTEXT)
    preview_of(TOOL, CarState(), Tap(1.0, 1.0, camera), CONTEXT)
    preview_of(TOOL, marked_car, Tap(1.0, 1.0, CONTEXT.camera), CONTEXT)
    preview_of(TOOL, marked_car, Ink((stroke_on(marked_car, camera, [(9.0, 9.0)]),)), CONTEXT)


def test_what_a_mark_is_missed_by_is_drawn_and_told():
    state = guided(FRONT_RIGHT, 20)
    marks = list(state.sketch.marks)
    wrong = next(number for number, mark in enumerate(marks) if mark.node == "C3")
    marks[wrong] = replace(marks[wrong], u=marks[wrong].u + 120.0)
    state = state.with_node(replace(state.sketch, marks=tuple(marks)))
    from bozzetto_car.view.mark_items import mark_layers

    (layer,) = mark_layers(state, body_of(state))
    (label,) = [i for i in layer.items if isinstance(i, Label) and "disagrees" in i.text]
    told = float(label.text.split(" by ")[1].removesuffix(" px"))
    assert told == pytest.approx(120.0, abs=2.0)
    assert "Windscreen, upper edge" in label.text


def test_the_direct_transform_is_shown_for_teaching(marked_car):
    """Crosses at the marks where there is no error; none with five marks, or marks in a plane."""
    from bozzetto_car.view.mark_items import mark_layers

    def crosses(state):
        state = replace(state, direct=True)
        (layer,) = mark_layers(state, body_of(state))
        return [i for i in layer.items if isinstance(i, Lines) and i.color == "ghost"]

    (found,) = crosses(marked_car)
    sketch_camera, camera = body_of(marked_car).sketch_cameras["one"], through(marked_car)
    seen = camera.project(found.points.reshape(-1, 4, 3).mean(axis=1))[0]
    marks = [(mark.u, mark.v) for mark in marked_car.sketch.marks]
    at = camera.project(sketch_camera.lifted(marks))[0]
    assert np.abs(np.sort(seen, axis=0) - np.sort(at, axis=0)).max() < 0.05
    assert crosses(guided(FRONT_RIGHT, 5)) == []


def test_the_report_takes_the_direct_transform_apart(marked_car):
    """Without an error of the hand it is the camera itself, with the car before the eye."""
    (view,) = report_of(body_of(marked_car), (), Job())["views"]
    parts = view["direct_linear_transform_parts"]
    lens = 0.5 * 800.0 / np.tan(np.radians(0.5 * FRONT_RIGHT.fov_y))
    assert parts["focal_px"] == pytest.approx([lens, lens], rel=1e-5)
    assert parts["skew_deg"] == pytest.approx(90.0, abs=1e-4)
    assert parts["principal_point_px"] == pytest.approx([600.0, 400.0], abs=0.1)
    assert parts["eye"] == pytest.approx(FRONT_RIGHT.eye, abs=1.0)
    assert parts["translation_mm"][2] > 0.0


# -- commands --------------------------------------------------------------------------------------


def test_the_last_mark_is_removed_and_asked_for_again(marked_car):
    last = marked_car.sketch.marks[-1].node
    state = COMMANDS["remove-last-mark"].run(marked_car, CONTEXT)
    assert state.sketch.marks == marked_car.sketch.marks[:-1]
    assert state.asked == last
    with pytest.raises(UserError, match="no mark to remove"):
        COMMANDS["remove-last-mark"].run(blank(), CONTEXT)


def test_points_not_visible_are_not_asked_for_until_they_are_wanted_again():
    state, template = blank(), bundled("sedan")
    first = TOOL.next_step(state).sentence
    noted = []
    for _ in range(3):
        noted.append(asked_of(state, body_of(state).solved).node)
        assert template.prompts[noted[-1]] in TOOL.next_step(state).sentence
        state = COMMANDS["not-visible"].run(state, CONTEXT)
    assert state.sketch.skipped == tuple(noted)
    assert len({*noted}) == 3
    assert COMMANDS["ask-again"].enabled(state)
    state = COMMANDS["ask-again"].run(state, CONTEXT)
    assert TOOL.next_step(state).sentence == first
    with pytest.raises(UserError, match="not visible"):
        COMMANDS["ask-again"].run(state, CONTEXT)


def test_all_marked_is_said(marked_car):
    template = bundled("sedan")
    left = set(template.names) - {mark.node for mark in marked_car.sketch.marks}
    state = marked_car.with_node(replace(marked_car.sketch, skipped=tuple(left)))
    assert TOOL.next_step(state).sentence.startswith("All points are marked")
    with pytest.raises(UserError, match="All points"):
        tapped(state, (5.0, 5.0))
    assert advice_on(state, body_of(state), through(state)).message == ""


@pytest.mark.slow
def test_whatever_a_hand_does_there_is_a_car_or_a_sentence():
    """Taps, drags, the eraser and commands at random places: never anything but a `UserError`."""
    rng = np.random.default_rng(11)
    state = blank()
    sentences = 0
    for _ in range(60):
        pixel = rng.normal((600.0, 400.0), (500.0, 400.0))
        further = pixel + rng.normal(0.0, 60.0, 2)
        names = [mark.node for mark in state.sketch.marks] or ["C0"]
        kind = rng.choice(["tap", "tap", "tap", "drag", "erase", "command"])
        try:
            if kind == "tap":
                preview_of(TOOL, state, Tap(*pixel, through(state)), CONTEXT)
                state = tapped(state, pixel)
            elif kind == "drag":
                drag = dragged(state, str(rng.choice(names)), [pixel, further])
                preview_of(TOOL, state, drag, CONTEXT)
                state = TOOL.apply(state, drag, CONTEXT)
            elif kind == "erase":
                over = stroke_on(state, through(state), [pixel, further], "eraser")
                state = TOOL.apply(state, Ink((over,)), CONTEXT)
            else:
                word = rng.choice(["skip", "ask-before", "not-visible", "ask-again",
                                   "remove-last-mark", "exchange-sides"])  # fmt: skip
                state = COMMANDS[str(word)].run(state, CONTEXT)
        except UserError:
            sentences += 1
        body = body_of(state)
        assert np.isfinite(body.network.positions).all()
        assert TOOL.next_step(state).sentence
        advice = advice_on(state, body, through(state))
        assert advice.pinned
    assert 0 < sentences < 40
    assert len(state.sketch.marks) > 8
