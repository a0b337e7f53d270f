"""What is on the sheet is in view when a document comes onto it, and stays where a person looks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.document.storage.bozz_file import write_document
from bozzetto.exchange.import_file import read_drawing
from bozzetto.view import navigation
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import with_kind
from bozzetto.view.standard_views import standard_view
from bozzetto_app.canvas.framing import framed, is_in_view, points_to_frame, same_view
from bozzetto_app.session.view_state import FIRST_VIEW
from bozzetto_app.testing.stylus import Stylus

GALLERY = Path(__file__).parents[3] / "docs" / "gallery"

FAR = Camera(eye=(900.0, -40.0, 700.0), target=(800.0, 0.0, 700.0))
"""A view that shows nothing of any drawing."""

AWAY = np.array([400.0, 0.0, 0.0])
BEHIND = np.array([0.0, 900.0, 0.0])


def sees_all(window):
    session = window.session
    points = points_to_frame(session)
    assert len(points)
    return is_in_view(session.view.camera, points)


def look_away(window):
    session = window.session
    session.view.set_camera(FAR.with_viewport(*session.view.camera.viewport))
    assert not sees_all(window)


def draw_sample(window, settle, modeler="bozzetto.silhouette", number=0):
    session = window.session
    (info,) = [one for one in session.toolbox.modelers if one.id == modeler]
    session.toolbox.take_modeler(modeler)
    settle(session, window.keeper)
    session.files.exchange.import_file(info.samples[number])
    settle(session, window.keeper)
    return session.drawing.document


def test_a_point_outside_or_behind_or_a_speck_is_not_in_view():
    camera = Camera(eye=(0.0, -500.0, 0.0), target=(0.0, 0.0, 0.0), viewport=(800.0, 600.0))
    cube = np.array([(x, y, z) for x in (-50, 50) for y in (-50, 50) for z in (-50, 50)], float)
    assert is_in_view(camera, cube)
    assert not is_in_view(camera, cube + AWAY)
    assert not is_in_view(camera, cube - BEHIND), "behind the eye"
    assert not is_in_view(camera, 0.01 * cube), "a speck"
    half = np.concatenate((cube, cube + AWAY))
    assert is_in_view(camera, half, share=0.5)
    assert not is_in_view(camera, half)


@pytest.mark.parametrize("size", [(1280.0, 800.0), (800.0, 1280.0), (200.0, 160.0)])
def test_what_is_framed_is_in_view(size):
    points = np.random.default_rng(5).normal(scale=(300.0, 20.0, 90.0), size=(80, 3)) + 1000.0
    for view in ("front", "three-quarter", "top"):
        for kind in ("perspective", "orthographic"):
            camera = replace(Camera(viewport=size), kind=kind)
            camera = navigation.with_kind(camera, kind)
            assert is_in_view(framed(standard_view(camera, view), points), points)


def test_a_new_sheet_is_seen_as_the_first_one_was(make_window, settle):
    window = make_window()
    first = window.session.view.camera
    assert first == FIRST_VIEW.with_viewport(*first.viewport)
    look_away_from = FAR.with_viewport(*first.viewport)
    window.session.view.set_camera(look_away_from)
    window.session.files.new()
    settle(window.session, window.keeper)
    assert window.session.view.camera == first


@pytest.mark.parametrize("modeler", ["symmetry", "product", "car"])
def test_a_new_sheet_does_not_know_how_the_last_one_was_seen(make_window, settle, modeler):
    """Advice on the last view came late, and was followed on the new sheet."""
    session = make_window(f"bozzetto.{modeler}").session
    settle(session)
    first = session.view.camera
    below = replace(first, eye=(-300.0, -300.0, -200.0))
    flat = with_kind(standard_view(first, "three-quarter"), "orthographic")
    for view in (below, flat, replace(below, eye=(10.0, -400.0, 90.0)), FAR):
        session.view.set_camera(view.with_viewport(*first.viewport))
        session.advice.look()
        settle(session)
        session.files.new()
        settle(session)
        assert same_view(session.view.camera, first), view


@pytest.mark.parametrize("size", [(1280, 800), (800, 1280)])
def test_a_new_sheet_shows_the_whole_box_and_home_does(make_window, settle, size):
    window = make_window("bozzetto.symmetry")
    window.resize(*size)
    settle(window.session, window.keeper)
    assert sees_all(window), "at the start"
    look_away(window)
    window.session.files.new()
    settle(window.session, window.keeper)
    assert sees_all(window)
    look_away(window)
    window.canvas.views.fit()
    settle(window.session, window.keeper)
    assert sees_all(window), "Home shows the box even though nothing is drawn"


@pytest.mark.parametrize("covered", [1, 150, 276, 639])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_what_is_framed_lies_beside_what_covers_the_sheet(covered, kind):
    rng = np.random.default_rng(6)
    for view in ("front", "three-quarter", "top"):
        points = rng.normal(scale=(300.0, 120.0, 90.0), size=(80, 3)) + 1000.0
        camera = navigation.with_kind(Camera(viewport=(1280.0, 800.0)), kind)
        seen = framed(standard_view(camera, view), points, covered)
        assert is_in_view(seen, points, covered=covered)
        across = seen.project(points)[0][:, 0]
        assert across.min() - covered == pytest.approx(1280.0 - across.max(), abs=1.0)


@pytest.mark.parametrize("modeler", ["product", "symmetry"])
def test_on_a_new_sheet_the_box_lies_beside_the_strip_with_the_samples(
    make_window, settle, qtbot, modeler
):
    """Half of the rough box of a new product lay under it, where nobody could draw."""
    window = make_window()
    window.resize(1280, 800)
    window.show()
    session = window.session
    settle(session, window.keeper)
    assert window.welcome.isVisible()
    session.toolbox.take_modeler(f"bozzetto.{modeler}")
    settle(session, window.keeper)
    covered = window.welcome.width()
    points = points_to_frame(session)
    assert is_in_view(session.view.camera, points, covered=covered)
    before = session.view.camera
    window.welcome.hide()
    settle(session, window.keeper)
    assert session.view.camera == before, "nothing moves when the strip closes"
    window.canvas.views.fit()
    settle(session, window.keeper)
    assert is_in_view(session.view.camera, points)


def test_taking_another_modeler_on_a_new_sheet_shows_its_box(make_window, settle):
    window = make_window()
    window.resize(560, 900)
    window.session.files.new()
    settle(window.session, window.keeper)
    window.session.toolbox.take_modeler("bozzetto.symmetry")
    settle(window.session, window.keeper)
    assert sees_all(window)


def test_a_document_opens_in_its_own_view_if_it_is_seen_there(make_window, settle, tmp_path):
    window = make_window()
    document = draw_sample(window, settle)
    session = window.session
    window.canvas.views.look("three-quarter")
    own = navigation.orbit(session.view.camera, 40.0, 10.0)
    session.view.set_camera(own)
    assert sees_all(window)
    for name, camera in (("seen", own), ("lost", replace(FAR, viewport=own.viewport))):
        write_document(replace(document, camera=camera), tmp_path / f"{name}.bozz")
    write_document(replace(document, camera=None), tmp_path / "none.bozz")
    for name in ("seen", "lost", "none"):
        look_away(window)
        session.drawing.history.mark_saved(session.drawing.document)
        window.open(tmp_path / f"{name}.bozz")
        settle(session, window.keeper)
        assert session.drawing.title == name
        assert sees_all(window), name
        assert (session.view.camera == own) == (name == "seen")


def test_another_kind_of_camera_is_no_other_view(make_window, settle, tmp_path):
    """A modeler asks for it by itself while the shapes of an opened document still arrive."""
    window = make_window()
    session = window.session
    write_document(replace(draw_sample(window, settle), camera=None), tmp_path / "drawn.bozz")
    session.drawing.history.mark_saved(session.drawing.document)
    window.open(tmp_path / "drawn.bozz")
    settle(session, window.keeper)
    for kind, width in (("orthographic", 560), ("perspective", 480)):
        session.view.set_camera(navigation.with_kind(session.view.camera, kind))
        window.resize(width, 900)
        settle(session, window.keeper)
        assert session.view.camera.kind == kind
        assert sees_all(window), kind


def test_the_view_is_left_alone_once_the_person_has_looked_elsewhere(make_window, settle, tmp_path):
    window = make_window()
    session = window.session
    write_document(draw_sample(window, settle), tmp_path / "one.bozz")
    session.drawing.history.mark_saved(session.drawing.document)
    window.open(tmp_path / "one.bozz")
    settle(session, window.keeper)
    look_away(window)
    away = session.view.camera
    session.view.set_show_ghost_ink(False)  # another scene
    session.selection.select(None)
    settle(session, window.keeper)
    assert session.view.camera == away


def test_recovered_drawings_are_in_view_and_ink_that_waits_as_it_was_drawn(
    make_window, settle, tmp_path
):
    window = make_window()
    session = window.session
    document = replace(draw_sample(window, settle), camera=None)
    look_away(window)
    session.drawing.show(document, None, saved=False)
    settle(session, window.keeper)
    assert sees_all(window)
    (info,) = [one for one in session.toolbox.modelers if one.id == "bozzetto.silhouette"]
    strokes = read_drawing(info.samples[0]).strokes
    look_away(window)
    session.drawing.show(replace(document, models=()), None, saved=False, pending=strokes[:1])
    settle(session, window.keeper)
    drawn = strokes[0].camera
    assert session.view.camera == drawn.with_viewport(*session.view.camera.viewport)


def test_a_drawing_that_is_watched_keeps_the_view_that_it_was_drawn_in(make_window, settle):
    window = make_window()
    (info,) = [one for one in window.session.toolbox.modelers if one.id == "bozzetto.symmetry"]
    drawing = read_drawing(info.samples[0])
    window.watch(info.id, info.samples[0])
    camera = window.session.view.camera
    assert camera == drawing.camera.with_viewport(*camera.viewport)
    window.replays.stop()


def test_a_drawing_on_an_empty_sheet_is_seen_as_it_was_drawn_and_the_next_one_turns_nothing(
    make_window, settle
):
    window = make_window()
    session = window.session
    (info,) = [one for one in session.toolbox.modelers if one.id == "bozzetto.symmetry"]
    drawn_in = read_drawing(info.samples[0]).camera
    draw_sample(window, settle, "bozzetto.symmetry")
    assert sees_all(window)
    np.testing.assert_allclose(session.view.camera.axes, drawn_in.axes, atol=1e-6)
    session.view.set_camera(FAR.with_viewport(*session.view.camera.viewport))
    draw_sample(window, settle)
    assert sees_all(window)
    np.testing.assert_allclose(session.view.camera.axes, FAR.axes, atol=1e-6)


def test_what_has_no_view_of_its_own_is_seen_three_quarter(make_window, settle):
    window = make_window()
    draw_sample(window, settle, "bozzetto.product")
    assert sees_all(window)
    wanted = standard_view(FIRST_VIEW, "three-quarter").axes
    np.testing.assert_allclose(window.session.view.camera.axes, wanted, atol=1e-6)


def test_the_view_of_a_new_sheet_comes_to_rest(make_window, marks, settle):
    """What this modeler shows depends on the view: framed again and again, it ran away."""
    window = make_window("adviser.marks", extra=[marks.package])
    settle(window.session)
    shown = []
    window.session.view.camera_changed.connect(lambda: shown.append(window.session.view.camera))
    window.session.advice.look()
    settle(window.session)
    assert shown == []


def test_a_new_sheet_is_seen_from_where_the_modeler_draws_best(make_window, settle):
    session = make_window().session
    first = session.view.camera
    session.toolbox.take_modeler("bozzetto.product")
    settle(session)
    assert np.abs(session.view.camera.axes[2]).max() < 0.9  # several sides of the rough box
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    assert session.view.camera == first
    chosen = standard_view(first, "right")
    session.view.set_camera(chosen)
    session.toolbox.take_modeler("bozzetto.product")
    settle(session)
    assert session.view.camera == chosen  # a person's own choice


@pytest.mark.parametrize("view", ["first", "turned", "away"])
def test_what_a_command_puts_on_a_new_sheet_is_in_view(make_window, settle, view):
    """A bottle is higher than the box that it takes the place of.

    The person's view stays if the bottle is seen there; who looks at nothing is shown it.
    """
    window = make_window("bozzetto.product")
    window.welcome.hide()  # beside it there is room for a bottle as well
    session = window.session
    session.files.new()
    settle(session, window.keeper)
    if view == "away":
        look_away(window)
    elif view == "turned":
        session.view.set_camera(navigation.orbit(session.view.camera, 40.0, 10.0))
    camera = session.view.camera
    session.commands.run("add-bottle")
    settle(session, window.keeper)
    (model,) = session.drawing.document.models
    assert [node.kind for node in model.state.nodes] == ["bottle"]
    assert sees_all(window) is not (view == "turned")
    assert (session.view.camera == camera) is (view == "turned")
    settled = session.view.camera
    session.commands.run("add-cylinder")
    settle(session, window.keeper)
    (model,) = session.drawing.document.models
    assert [node.kind for node in model.state.nodes] == ["bottle", "cylinder"]
    assert session.view.camera == settled


def test_a_car_that_a_command_puts_on_the_sheet_is_in_view_whatever_was_pressed(
    make_window, settle
):
    """It is forty times as large as what the first view shows; a stroke was refused before."""
    window = make_window("bozzetto.car")
    session = window.session
    settle(session, window.keeper)
    Stylus(window.canvas).draw([(300, 300), (400, 340)])
    settle(session, window.keeper)
    assert not session.drawing.document.models
    session.commands.run("new-car")
    settle(session, window.keeper)
    assert len(session.drawing.document.models) == 1
    assert sees_all(window)


@pytest.mark.parametrize("yaw", [0.0, 50.0, -100.0])
def test_a_copy_comes_into_view_and_is_selected(make_window, settle, yaw):
    """The view stays where there is room for the copy."""
    window = make_window("bozzetto.silhouette")
    window.welcome.hide()
    session = window.session
    draw_sample(window, settle)
    window.canvas.views.fit()
    window.canvas.motion.finish()
    session.view.set_camera(navigation.orbit(session.view.camera, yaw, 0.0))
    settle(session, window.keeper)
    (model,) = session.drawing.document.models
    session.objects.duplicate(model.id)
    settle(session, window.keeper)
    copy = session.drawing.document.models[1]
    assert session.selection.id == copy.id
    assert sees_all(window)
    wide = navigation.zoom(session.view.camera, 0.25)
    session.view.set_camera(wide)
    session.objects.duplicate(copy.id)
    settle(session, window.keeper)
    assert session.view.camera == wide


def test_the_first_shape_tilts_where_it_is_framed(make_window, qtbot, settle):
    """The tilt began before the view had gone to the car, and ended where nothing was seen."""
    window = make_window("bozzetto.car")
    session, motion = window.session, window.canvas.motion
    motion.reduced = False
    session.commands.run("new-car")
    qtbot.waitUntil(lambda: motion.is_running, timeout=20_000)
    qtbot.waitUntil(lambda: not motion.is_running, timeout=20_000)
    settle(session, window.keeper)
    assert sees_all(window)


def test_a_second_sketch_is_seen_from_where_it_was_drawn(make_window, qtbot, settle):
    """Its picture is shown, and the first shape does not tilt instead."""
    window = make_window("bozzetto.car")
    session, motion = window.session, window.canvas.motion
    motion.reduced = False
    draw_sample(window, settle, "bozzetto.car")
    session.files.exchange.import_file(GALLERY / "car" / "sedan-2.png")
    settle(session, window.keeper)
    qtbot.waitUntil(lambda: not motion.is_running, timeout=20_000)
    settle(session, window.keeper)
    (model,) = session.drawing.document.models
    assert len(model.state.sketches) == 2
    assert session.advice.holds_eye(session.view.camera)
    assert sees_all(window)


def test_a_car_that_begins_with_a_mesh_is_in_view(make_window, settle, tmp_path):
    """It stands as a template does, and not where the mesh lay."""
    window = make_window("bozzetto.car")
    session = window.session
    file = tmp_path / "block.obj"
    corners = [(x, y, z) for x in (0, 4300) for y in (0, 1700) for z in (0, 1400)]
    faces = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    lines = [f"v {x + 9000} {z} {-y}" for x, y, z in corners] + [f"f {face}" for face in faces]
    file.write_text("\n".join(lines), "utf-8")
    session.files.exchange.import_file(file)
    settle(session, window.keeper)
    assert sees_all(window)
    session.shapes.use_chosen("bozzetto.car")
    settle(session, window.keeper)
    assert session.selection.model.modeler == "bozzetto.car"
    assert sees_all(window)
