"""Views through a sketch: where they go when the sketch gets another camera, and what is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto.scene import Picture
from bozzetto.testing import same
from bozzetto.view import Camera
from bozzetto.view.eye_fixed_motion import aimed, enlarged
from bozzetto_car.body.build import body_of
from bozzetto_car.camera.sketch_camera import SketchCamera, upright_camera
from bozzetto_car.marking.next_mark import asked_of
from bozzetto_car.modeler import Car
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.view.view_advice import (
    advice_following,
    advice_on,
    camera_looked_through,
    view_after,
)
from tests.plugins.car.penned import (
    CANVAS,
    CONTEXT,
    blank,
    followed,
    guided,
    places_of,
    tapped,
    through,
    view_of,
)
from tests.plugins.car.sketched import PICTURE

FRONT = view_of(40.0)


def advised(state, camera):
    return advice_on(state, body_of(state), camera)


@pytest.fixture(scope="module")
def known():
    return guided(FRONT, 9)


def nudged(state, by=(8.0, -5.0)):
    """One mark more, a little off, so that the camera changes."""
    asked = asked_of(state, body_of(state).solved)
    return tapped(state, asked.place + np.array(by))


def panned(camera: Camera) -> Camera:
    """Zoomed in, and moved, as a hand does it over a sketch."""
    if camera.kind == "orthographic":
        move = (300.0, 0.0, 200.0)
        return replace(
            camera, height=0.4 * camera.height,
            eye=tuple(np.add(camera.eye, move)), target=tuple(np.add(camera.target, move)),
        )  # fmt: skip
    ahead = np.subtract(camera.target, camera.eye) + np.array([100.0, 250.0, -80.0])
    return aimed(enlarged(camera, 2.5), ahead, (0.4 * CANVAS[0], 0.6 * CANVAS[1]))


# -- windows ---------------------------------------------------------------------------------------


def sketch_cameras():
    away = (-3500.0, 5000.0, 2400.0)
    lens = Camera(eye=away, target=(2400.0, 0.0, 700.0), fov_y=28.0, viewport=PICTURE)
    flat = Camera("orthographic", away, (2400.0, 0.0, 700.0), height=3900.0, viewport=PICTURE)
    return {
        "flat": upright_camera(PICTURE),
        "perspective": SketchCamera(lens),
        "cropped": SketchCamera(lens, (130.0, -70.0)),
        "orthographic": SketchCamera(flat, (40.0, 25.0)),
    }


@pytest.mark.parametrize("name", ["flat", "perspective", "cropped", "orthographic"])
def test_the_window_of_a_view_gives_the_view_back(name):
    sketch_camera = sketch_cameras()[name]
    for camera in (sketch_camera.view(CANVAS), panned(sketch_camera.view(CANVAS))):
        again = sketch_camera.windowed(CANVAS, sketch_camera.window(camera))
        grid = np.stack(np.meshgrid([0.0, 400.0, 987.0], [0.0, 300.0, 727.0]), axis=-1)
        there = sketch_camera.seen_at(camera, grid.reshape(-1, 2))
        assert sketch_camera.seen_at(again, grid.reshape(-1, 2)) == pytest.approx(there, abs=1e-6)
        assert sketch_camera.is_seen_through(again)


@pytest.mark.parametrize("first", ["flat", "perspective", "cropped", "orthographic"])
@pytest.mark.parametrize("second", ["flat", "perspective", "orthographic"])
def test_another_camera_shows_the_same_window(first, second):
    old, new = sketch_cameras()[first], sketch_cameras()[second]
    camera = panned(old.view(CANVAS))
    window = old.window(camera)
    made = new.windowed(CANVAS, window)
    assert new.is_seen_through(made)
    middle, upper = np.array(CANVAS) / 2.0, np.array([CANVAS[0] / 2.0, 0.0])
    assert new.seen_at(made, [middle])[0] == pytest.approx(window[0], abs=1e-6)
    reach = np.linalg.norm(new.seen_at(made, [upper])[0] - window[0])
    assert reach == pytest.approx(np.linalg.norm(window[1] - window[0]), rel=0.03)


# -- going along -----------------------------------------------------------------------------------


def test_a_view_through_the_sketch_is_pinned(known):
    for camera in (through(known), panned(through(known))):
        advice = advised(known, camera)
        assert advice.pinned
        assert not advice.follow
        assert advice.better is None
        assert advice.message == ""


def test_the_view_goes_along_with_a_mark_that_moves_the_camera(known):
    camera = panned(through(known))
    assert advised(known, camera).pinned
    before = body_of(known).sketch_cameras["one"].window(camera)
    state = nudged(known)
    sketch_camera = body_of(state).sketch_cameras["one"]
    assert not sketch_camera.is_seen_through(camera)
    there = view_after(known, state, camera)
    assert sketch_camera.is_seen_through(there)
    assert sketch_camera.window(there)[0] == pytest.approx(before[0], abs=1e-6)
    after = advised(state, there)
    assert after.pinned
    assert not after.follow
    assert view_after(known, state, there) is None


def test_advice_on_a_preview_goes_along_and_solves_nothing(known, monkeypatch):
    car, before = Car(), body_of(known)
    camera = panned(through(known))
    window = before.sketch_cameras["one"].window(camera)
    picture = Picture.of(np.full((40, 60, 4), 200, np.uint8), "sketch")
    drawn = known.with_node(replace(known.sketch, picture=picture))
    longer = replace(drawn, length=1.05 * before.dimensions.length, lock=True)
    body = car.solve(longer, Job(quality="preview"))
    scenes = car.scene(longer, body)  # all that the program asks for before
    monkeypatch.setattr("bozzetto_car.body.build.solve_car", None)
    advice = car.advice_on_result(longer, body, camera, (before,))
    assert advice.follow
    assert advice.pinned
    assert body.sketch_cameras["one"].window(advice.better)[0] == pytest.approx(window[0], abs=1e-6)
    at_rest = car.advice_on_result(longer, body, advice.better, (before,))
    assert at_rest.pinned
    assert not at_rest.follow
    thin = {layer.name: layer for layer in at_rest.scene.layers}
    assert "body" in thin, "what is shown over the sketch is the preview, not the car before"
    shown = next(layer for layer in scenes.layers if layer.name == "body")
    (item,) = thin["body"].items
    rows = np.concatenate([own.mesh.vertices for own in shown.items])
    assert len(rows) == len(item.mesh.vertices)
    assert np.array_equal(np.unique(rows, axis=0), np.unique(item.mesh.vertices, axis=0))


@pytest.mark.parametrize("moved", [False, True])
def test_advice_on_a_result_is_the_advice_on_its_state(known, moved):
    camera = panned(through(known))
    state = nudged(known) if moved else known
    told = Car().advice_on_result(state, body_of(state), camera, (body_of(known),))
    along = view_after(known, state, camera)
    plain = advised(state, along or camera)
    assert (told.level, told.message, told.pinned) == (plain.level, plain.message, plain.pinned)
    assert same(told.scene, plain.scene)
    assert (told.better if moved else None) == along


def test_two_cars_do_not_know_of_each_other(known):
    """Sketches of two cars may have one id and one size: the answer for one is its own."""
    camera = panned(through(known))
    other = nudged(known)
    before = advised(other, camera)
    advised(known, camera)
    again = advised(other, camera)
    assert not before.pinned
    assert same(before, again)


def test_the_sixth_mark_brings_the_view_from_the_sheet_to_the_camera_found():
    state = guided(FRONT, 5)
    camera = panned(through(state))
    assert camera.kind == "orthographic"
    assert advised(state, camera).pinned
    window = body_of(state).sketch_cameras["one"].window(camera)
    truth = places_of(FRONT)
    six = tapped(state, truth[asked_of(state, body_of(state).solved).node])
    assert body_of(six).solved.placed["one"].is_known
    there = followed(six, camera, state)
    sketch_camera = body_of(six).sketch_cameras["one"]
    assert sketch_camera.is_seen_through(there)
    assert sketch_camera.window(there)[0] == pytest.approx(window[0], abs=1e-6)
    # Undo, and the view is back where it was.
    back = followed(state, there, six)
    assert body_of(state).sketch_cameras["one"].window(back) == pytest.approx(
        window, rel=0.03, abs=10.0
    )


def test_a_view_that_was_turned_is_left_alone(known):
    camera = through(known)
    advised(known, camera)
    turned = replace(camera, eye=tuple(np.add(camera.eye, (300.0, 200.0, 0.0))))
    state = nudged(known)
    advice = advised(state, turned)
    assert not advice.pinned
    assert not advice.follow
    assert body_of(state).sketch_cameras["one"].is_seen_through(advice.better)
    assert {layer.name for layer in advice.scene.layers if not layer.items} >= {"sketch", "marks"}


def test_what_is_called_better_is_at_rest(known):
    """Else the view would go on for ever."""
    aside = replace(through(known), eye=(9000.0, 9000.0, 3000.0))
    for state in (blank(), known, nudged(known)):
        better = advised(state, aside).better
        assert advised(state, better).pinned
        assert not advised(state, better).follow


def test_a_sketch_that_is_chosen_comes_into_view(known):
    side = view_of(-90.0)
    marks = tuple(Mark(n, *p) for n, p in places_of(side).items() if not n.endswith(".R"))
    second = Sketch(id="two", name="Side", width=PICTURE[0], height=PICTURE[1], marks=marks)
    both = known.with_node(second)
    assert both.selected == "two"
    first_view = through(replace(both, selected="one"))
    advised(replace(both, selected="one"), first_view)
    advice = advised(both, first_view)
    assert advice.follow
    assert body_of(both).sketch_cameras["two"].is_seen_through(advice.better)
    # While something else is chosen, such as a styling curve, nothing moves.
    assert not advised(replace(both, selected="curve"), advice.better).follow


def test_a_view_through_a_sketch_that_has_gone_comes_back_to_the_one_that_is_left(known):
    side = view_of(-90.0)
    marks = tuple(Mark(n, *p) for n, p in places_of(side).items() if not n.endswith(".R"))
    second = Sketch(id="two", name="Side", width=PICTURE[0], height=PICTURE[1], marks=marks)
    both = known.with_node(second)
    before, after = body_of(both), body_of(known)
    there = before.sketch_cameras["two"].view(CANVAS)
    advice = advice_following(known, after, there, [before])
    assert advice.follow
    assert after.sketch_cameras[known.sketch.id].is_seen_through(advice.better)
    # Who has looked elsewhere meanwhile stays there, and so does a view of a sketch that is left.
    assert not advice_following(
        known, after, replace(there, eye=tuple(np.add(there.eye, (300.0, 200.0, 0.0)))), [before]
    ).follow
    assert not advice_following(known, after, there, []).follow
    assert not advice_following(both, before, there, [after]).follow


def test_a_picture_that_comes_in_is_where_better_leads():
    picture = Picture.of(np.full((40, 60, 4), 200, np.uint8), "sketch")
    state = Car().add_picture(CarState(), picture, CONTEXT)
    camera = CONTEXT.camera
    advice = advised(state, camera)
    sketch_camera = body_of(state).sketch_cameras[state.sketch.id]
    assert sketch_camera.is_seen_through(advice.better)
    corners = advice.better.project(sketch_camera.lifted([(0, 0), (60, 0), (0, 40), (60, 40)]))[0]
    assert ((corners >= 0.0) & (corners <= camera.viewport)).all()


# -- what is said ----------------------------------------------------------------------------------


def test_through_its_sketch_the_body_is_so_thin_that_the_drawing_shows(known):
    picture = Picture.of(np.full((40, 60, 4), 200, np.uint8), "sketch")
    state = known.with_node(replace(known.sketch, picture=picture))
    camera = through(state)

    def body(state, camera):
        layers = [one for one in advised(state, camera).scene.layers if one.name == "body"]
        return [item.opacity for layer in layers for item in layer.items]

    (thin,) = body(state, camera)
    assert 0.0 < thin < 0.5
    assert body(replace(state, shading="zebra"), camera) == []
    assert body(known, camera) == [], "without a picture there is nothing to see below"
    aside = replace(camera, eye=(9000.0, 9000.0, 3000.0))
    assert body(state, aside) == []


def test_asked_again_it_shows_the_very_same_items(known):
    """A view that goes along asks twice about each frame: the sheet is drawn once."""
    picture = Picture.of(np.full((40, 60, 4), 200, np.uint8), "sketch")
    state = known.with_node(replace(known.sketch, picture=picture))
    one, other = (advised(state, through(state)).scene.layers for _ in range(2))
    assert {layer.name for layer in one} == {"body", "wheels", "network", "handles"}
    assert [layer.items for layer in one] == [layer.items for layer in other]
    revealed = advised(replace(state, revealed="C3"), through(state)).scene.layers
    changed = [a.name for a, b in zip(one, revealed, strict=True) if a.items != b.items]
    assert changed == ["handles"]


def test_too_few_marks_for_a_camera_are_no_warning_but_useless_ones_are():
    assert advised(guided(FRONT, 5), through(guided(FRONT, 5))).level == "good"
    places = places_of(FRONT)
    names = ("C0", "C1", "C2", "C3", "C4", "C5", "C6")
    flat = blank()
    marks = tuple(Mark(name, *places[name]) for name in names)
    flat = flat.with_node(replace(flat.sketch, marks=marks))
    advice = advised(flat, through(flat))
    assert advice.level == "warn"
    assert "plane" in advice.message
    assert advice.pinned


def test_exchanged_sides_are_told():
    """Marks of the right side that bear the names of the left."""
    places = places_of(FRONT)
    marks = tuple(
        Mark(name[:-1] + "L" if name.endswith("R") else name, *place)
        for name, place in places.items()
        if not name.endswith("L")
    )
    state = blank().with_node(replace(blank().sketch, marks=marks))
    advice = advised(state, through(state))
    assert advice.level == "warn"
    assert "Exchange left and right" in advice.message
    assert Car().commands()[0] is not None
    titles = [command.title for command in Car().commands()]
    assert "Exchange left and right" in titles


def test_without_a_sketch_every_view_is_good():
    advice = advised(CarState(), CONTEXT.camera)
    assert (advice.level, advice.pinned, advice.better) == ("good", False, None)


def test_stands_of_other_sketches_are_not_mistaken(known):
    other = replace(known.sketch, id="other", marks=())
    assert camera_looked_through(other, body_of(known), through(known)) is None
