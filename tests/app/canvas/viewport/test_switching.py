"""The same contract for both viewports; the GL half runs where there is an X display."""

from __future__ import annotations

import itertools
import os
import threading
from dataclasses import replace
from time import perf_counter, sleep

import numpy as np
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from bozzetto.errors import Cancelled
from bozzetto.geometry import Texture, frozen
from bozzetto.scene import DARK, LIGHT, Image, Layer, Lines, Points, Scene, Shaded
from bozzetto.scene.renderer import render
from bozzetto.view.camera import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_app.canvas.viewport import software
from bozzetto_app.canvas.viewport.protocol import choose_backend
from bozzetto_app.canvas.viewport.software import REST, SoftwareViewport
from tests.core.scene.shapes import scene_of, sphere

SIZE = (400, 300)


def gl_viewport():
    from bozzetto_app.canvas.viewport.opengl import GLViewport

    return GLViewport()


@pytest.fixture(
    params=[
        pytest.param(SoftwareViewport, id="software"),
        pytest.param(gl_viewport, id="gl", marks=pytest.mark.gl),
    ]
)
def make(request, qtbot):
    """Makes shown viewports of a kind."""

    def made():
        if request.param is gl_viewport and choose_backend() != "gl":
            pytest.skip("no OpenGL here; run with: xvfb-run -a pytest -m gl, QT_QPA_PLATFORM=xcb")
        viewport = request.param()
        qtbot.addWidget(viewport)
        viewport.resize(*SIZE)
        viewport.set_palette(LIGHT)
        viewport.set_style("clay", False)
        viewport.set_camera(CAMERA)
        viewport.show()
        qtbot.waitExposed(viewport)
        QApplication.processEvents()
        return viewport

    return made


CAMERA = standard_view(Camera(viewport=SIZE), "three-quarter")


def pixels(image: QImage):
    image = image.convertToFormat(QImage.Format.Format_RGBA8888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1, 4)
    return rows[..., :3].astype(float)


def pixels_of(viewport):
    """What a viewport shows, at one pixel for a pixel of the sheet."""
    return pixels(viewport.grab().scaled(*SIZE))


def at(picture, camera, point):
    (place,), _ = camera.project([point])
    x, y = np.floor(place).astype(int)
    return picture[y - 1 : y + 2, x - 1 : x + 2].mean((0, 1))


def test_a_scene_is_shown(make, box_scene):
    viewport = make()
    empty = pixels(viewport.grab())
    assert np.abs(empty - LIGHT.paper).max() <= 1
    viewport.set_scene(box_scene)
    shown = pixels(viewport.grab())
    assert (np.abs(shown - empty).max(2) > 10).mean() > 0.1
    viewport.set_scene(Scene())
    assert np.abs(pixels(viewport.grab()) - LIGHT.paper).max() <= 1


def test_the_ground_suits_the_size_that_the_viewport_got_last(make):
    viewport = make()
    viewport.set_style("clay", True)
    expected = pixels(viewport.grab())
    assert (np.abs(expected - LIGHT.paper).max(2) > 4).mean() > 0.01
    viewport.resize(8, 6)
    QApplication.processEvents()
    viewport.set_scene(Scene())
    viewport.resize(*SIZE)
    QApplication.processEvents()
    assert np.abs(pixels(viewport.grab()) - expected).mean() < 0.1


@pytest.mark.parametrize(
    "shading", ["clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"]
)
@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_colours_are_those_of_the_software_renderer(make, box_scene, shading, palette):
    viewport = make()
    viewport.set_palette(palette)
    viewport.set_style(shading, False)
    scene = Scene((Layer("box", box_scene.layers[0].items[:1]),))
    viewport.set_scene(scene)
    shown = pixels(viewport.grab())
    expected = render(scene, CAMERA, palette, size=SIZE, shading=shading)[..., :3].astype(float)
    for point in ((0, -50, 10), (10, -50, -20), (50, 10, 20), (0, 10, 50), (-30, -20, 50)):
        difference = np.abs(at(shown, CAMERA, point) - at(expected, CAMERA, point))
        assert difference.max() < 14, point  # hollows are darker in software
    assert np.abs(shown - expected).mean() < 4


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("opacity", [1.0, 0.5])
def test_a_polished_ball_is_that_of_the_software_renderer(make, palette, kind, opacity):
    viewport = make()
    camera = replace(CAMERA, kind=kind)
    viewport.set_palette(palette)
    viewport.set_camera(camera)
    ball = Shaded(sphere(70.0, 64, normals=True), "accent", opacity, finish="zebra")
    scene = Scene((Layer("ball", (ball,)),))
    viewport.set_scene(scene)
    shown = pixels(viewport.grab())
    expected = render(scene, camera, palette, size=SIZE)[..., :3].astype(float)
    on_it = np.abs(expected - palette.paper).max(2) > 20
    assert on_it.mean() > 0.1
    assert np.abs(shown - expected)[on_it].mean() < 8
    matte = Scene((Layer("ball", (replace(ball, finish="clay"),)),))
    viewport.set_scene(matte)
    assert np.abs(shown - pixels(viewport.grab()))[on_it].mean() > 25


@pytest.mark.parametrize("finish", ["gloss", "rubber", "metal"])
def test_materials_are_those_of_the_software_renderer(make, finish):
    viewport = make()
    viewport.set_palette(LIGHT)
    viewport.set_camera(CAMERA)
    ball = Shaded(sphere(70.0, 64, normals=True), (60, 90, 160), finish=finish)
    scene = Scene((Layer("ball", (ball,)),))
    viewport.set_scene(scene)
    shown = pixels(viewport.grab())
    expected = render(scene, CAMERA, LIGHT, size=SIZE)[..., :3].astype(float)
    on_it = np.abs(expected - LIGHT.paper).max(2) > 20
    assert np.abs(shown - expected)[on_it].mean() < 8


def test_a_line_behind_a_box_is_faint_and_beside_it_dark(make, box_scene):
    viewport = make()
    viewport.set_scene(box_scene)
    shown = pixels(viewport.grab())
    box_only = Scene((Layer("box", box_scene.layers[0].items[:1]),))
    viewport.set_scene(box_only)
    without = pixels(viewport.grab())
    beside, behind = (115.0, 80.0, 0.0), (0.0, 80.0, 0.0)
    strong = np.abs(at(shown, CAMERA, beside) - at(without, CAMERA, beside)).max()
    weak = np.abs(at(shown, CAMERA, behind) - at(without, CAMERA, behind)).max()
    assert strong > 80
    assert 3 < weak < 0.5 * strong


@pytest.mark.parametrize(
    ("hidden", "least", "most"), [("hide", 0, 1), ("faint", 4, 90), ("show", 80, 255)]
)
def test_how_hidden_lines_appear(make, box_scene, hidden, least, most):
    viewport = make()
    box = box_scene.layers[0].items[0]
    line = Lines(np.array([(-120, 80, 0), (120, 80, 0)], np.float32), width=4, hidden=hidden)
    viewport.set_scene(Scene((Layer("a", (box,)),)))
    without = pixels(viewport.grab())
    viewport.set_scene(Scene((Layer("a", (box, line)),)))
    place = (0.0, 80.0, 0.0)
    change = np.abs(at(pixels(viewport.grab()), CAMERA, place) - at(without, CAMERA, place)).max()
    assert least <= change <= most


def test_a_line_on_a_surface_is_not_eaten_by_it(make, box_scene):
    viewport = make()
    box = box_scene.layers[0].items[0]
    line = Lines(np.array([(-40, -50, 10), (40, -50, 10)], np.float32), width=3)
    viewport.set_scene(Scene((Layer("a", (box, line)),)))
    shown = pixels(viewport.grab())
    for x in np.linspace(-35, 35, 12):
        assert at(shown, CAMERA, (x, -50, 10)).max() < 110


def test_glass_lets_the_inside_show_through(make, box_scene):
    viewport = make()
    box = box_scene.layers[0].items[0]
    glass = Shaded(box.mesh, color="accent", opacity=0.3)
    inside = Points(np.array([(0, 0, 0)], np.float32), color=(0, 0, 255), size=12)
    viewport.set_scene(Scene((Layer("a", (glass, inside)),)))
    red, _, blue = at(pixels(viewport.grab()), CAMERA, (0, 0, 0))
    assert blue > red + 60


def test_a_new_revision_is_drawn_and_the_old_one_is_gone(make, box_scene):
    viewport = make()
    box = box_scene.layers[0].items[0]
    for color in ((200, 30, 30), (30, 30, 200)):
        viewport.set_scene(Scene((Layer("a", (Shaded(box.mesh, color=color),)),)))
        red, _, blue = at(pixels(viewport.grab()), CAMERA, (0, 0, 50))
        assert (red > blue) == (color[0] > color[2])


def test_the_live_scene_comes_and_goes(make, box_scene):
    viewport = make()
    empty = pixels(viewport.grab())
    viewport.set_live(box_scene)
    assert np.abs(pixels(viewport.grab()) - empty).max() > 30
    viewport.set_live(Scene())
    assert np.abs(pixels(viewport.grab()) - empty).max() <= 1


def test_handles_and_labels_are_shown_in_place(make, box_scene):
    viewport = make()
    viewport.set_scene(Scene((Layer("a", box_scene.layers[0].items[2:]),)))
    color = at(pixels(viewport.grab()), CAMERA, (50.0, -50.0, 50.0))
    assert np.abs(color - LIGHT.accent).max() < 12


def test_the_picture_has_the_size_of_the_widget(make, box_scene):
    viewport = make()
    viewport.set_scene(box_scene)
    viewport.resize(500, 420)
    QApplication.processEvents()
    image = viewport.grab()
    scale = viewport.devicePixelRatioF()
    assert (image.width(), image.height()) == (round(500 * scale), round(420 * scale))


def test_what_is_shown_can_be_had_at_once_and_follows(make, box_scene, qtbot):
    viewport = make()

    def follows():
        assert not viewport.shown().isNull()
        shown = pixels(viewport.shown())
        wanted = pixels(viewport.grab())
        assert shown.shape == wanted.shape
        assert np.abs(shown - wanted).mean() < 1.0

    for scene, camera in (
        (Scene(), CAMERA),
        (box_scene, CAMERA),
        (box_scene, standard_view(CAMERA, "right")),
    ):
        viewport.set_scene(scene)
        viewport.set_camera(camera)
        qtbot.waitUntil(follows, timeout=10_000)
        assert viewport.shown().cacheKey() == viewport.shown().cacheKey()


def test_the_ground_is_shown_when_asked_for(make):
    viewport = make()
    plain = pixels(viewport.grab())
    viewport.set_style("clay", True)
    assert (np.abs(pixels(viewport.grab()) - plain).max(2) > 4).mean() > 0.003
    viewport.set_style("clay", False)
    assert np.abs(pixels(viewport.grab()) - plain).max() <= 1


def test_two_viewports_live_side_by_side(make, box_scene):
    first, second = make(), make()
    first.set_scene(box_scene)
    second.set_scene(box_scene)
    one, two = pixels(first.grab()), pixels(second.grab())
    np.testing.assert_allclose(one, two, atol=2)
    first.close()
    first.deleteLater()
    QApplication.processEvents()
    np.testing.assert_allclose(pixels(second.grab()), two, atol=2)


def test_a_picture_on_a_mesh_is_shown_as_in_a_still_picture(make):
    """Both viewports, also where one mesh has a picture and others have none."""
    ball = sphere(30.0, normals=True)
    around = np.arctan2(ball.vertices[:, 1], ball.vertices[:, 0]) / (2 * np.pi) + 0.5
    up = 0.5 - ball.vertices[:, 2] / 60.0
    places = np.stack([around, up], 1)[ball.faces]
    # where the picture's sides meet
    places[..., 0] += (np.ptp(places[..., 0], axis=1) > 0.5)[:, None] * (places[..., 0] < 0.5)
    rows, columns = np.indices((256, 256))
    pixels = np.zeros((256, 256, 4), np.uint8)
    pixels[..., 0], pixels[..., 1], pixels[..., 2] = rows, 60 + (columns // 32 % 2) * 120, 40
    pixels[..., 3] = np.where(rows > 200, 0, 255)  # clear below
    item = Shaded(ball, (60, 60, 220), texture=Texture(pixels, np.clip(places, 0, 1)))
    scene = scene_of(item, Shaded(sphere(8.0, center=(0.0, -50.0, 20.0))))
    viewport = make()
    viewport.set_scene(scene)
    viewport.set_camera(CAMERA)
    shown = pixels_of(viewport)
    still = render(scene, CAMERA, LIGHT)[..., :3].astype(float)
    away = np.abs(shown - still).max(axis=2)
    assert np.quantile(away, 0.97) < 25  # one of them darkens hollows
    assert np.quantile(away[np.abs(still - LIGHT.paper).max(axis=2) > 60], 0.5) < 8


def test_what_lies_under_clear_texels_is_not_seen(make):
    """A checkerboard of clear squares, black underneath, and squares as what lies behind."""
    rows, columns = np.indices((64, 64))
    behind = (*LIGHT.paper, 255)
    board = np.zeros((64, 64, 4), np.uint8)
    board[(rows // 4 + columns // 4) % 2 == 0] = behind
    sheet = Image(frozen(board, np.uint8), (-70, 0, 60), (140, 0, 0), (0, 0, -120))
    viewport = make()
    viewport.set_camera(standard_view(CAMERA, "front"))
    viewport.set_scene(Scene((Layer("sketch", (sheet,)),)))
    assert np.abs(pixels_of(viewport) - np.array(LIGHT.paper)).max() < 4

    ball = sphere(30.0, normals=True)
    places = np.clip(0.5 + ball.vertices[:, [0, 2]] / 70.0, 0.0, 1.0)[ball.faces]
    color = (60, 60, 220)
    board[board[..., 3] > 0] = (*color, 255)
    whole = np.full_like(board, (*color, 255))
    seen = []
    for squares in (whole, board):
        viewport.set_scene(scene_of(Shaded(ball, color, texture=Texture(squares, places))))
        seen.append(pixels_of(viewport))
    assert np.abs(seen[0] - LIGHT.paper).max() > 60
    assert np.abs(seen[1] - seen[0]).max() < 8


def test_it_says_who_draws(make):
    assert make().describe()


# -- OpenGL only ---------------------------------------------------------------------------------


@pytest.mark.gl
def test_a_picture_is_uploaded_once_for_all_its_layers(qtbot, monkeypatch):
    if choose_backend() != "gl":
        pytest.skip("no OpenGL here")
    from bozzetto_app.canvas.viewport import opengl_textures as gl_textures

    uploads, deleted = [], []
    real = gl_textures.GL.glTexImage2D
    monkeypatch.setattr(
        gl_textures.GL, "glTexImage2D", lambda *given: uploads.append(given[3:5]) or real(*given)
    )
    drop = gl_textures.GL.glDeleteTextures
    monkeypatch.setattr(
        gl_textures.GL, "glDeleteTextures", lambda given: deleted.extend(given) or drop(given)
    )
    viewport = gl_viewport()
    qtbot.addWidget(viewport)
    viewport.resize(*SIZE)
    viewport.set_palette(LIGHT)
    viewport.set_camera(standard_view(CAMERA, "front"))
    viewport.show()
    qtbot.waitExposed(viewport)

    def show(*pages):
        hung = [Image(page, (-60, 0, 60), (120, 0, 0), (0, 0, -120)) for page in pages]
        viewport.set_scene(Scene(tuple(Layer("sketch", (image,)) for image in hung)))
        return pixels(viewport.grab())

    red = frozen(np.full((40, 60, 4), (250, 20, 20, 255), np.uint8), np.uint8)
    for _ in range(5):
        picture = show(red)
    assert uploads == [(60, 40)]
    middle = picture[picture.shape[0] // 2, picture.shape[1] // 2]
    np.testing.assert_allclose(middle, (250, 20, 20), atol=2)
    for k in range(40):
        page = frozen(np.full((4 + k, 6, 4), (20, 20, 250, 255), np.uint8), np.uint8)
        picture = show(red, page)
    assert len(uploads) == 41
    assert len(deleted) >= 41 - gl_textures.MOST
    middle = picture[picture.shape[0] // 2, picture.shape[1] // 2]
    np.testing.assert_allclose(middle, (20, 20, 250), atol=2)


# -- software only -----------------------------------------------------------------------------


def test_frames_are_made_beside_the_window_and_the_newest_wins(qtbot, box_scene):
    viewport = SoftwareViewport()
    qtbot.addWidget(viewport)
    viewport.resize(*SIZE)
    viewport.set_palette(LIGHT)
    viewport.set_style("clay", False)
    viewport.show()
    viewport.set_scene(box_scene)
    for name in ("front", "top", "right", "three-quarter"):
        viewport.set_camera(standard_view(CAMERA, name))
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    shown = pixels(viewport.shown())
    np.testing.assert_array_equal(shown, pixels(viewport.grab()))


def test_slow_frames_are_coarse_while_a_value_is_dragged_and_sharp_at_rest(
    qtbot, box_scene, monkeypatch
):
    viewport = shown_software(qtbot)
    with monkeypatch.context() as slow:  # as on a machine that takes 10 s for a frame
        slow.setattr(software, "perf_counter", itertools.count(0.0, 10.0).__next__)
        viewport.set_scene(box_scene)
        qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    viewport.set_scene(Scene(box_scene.layers), moving=True)
    qtbot.waitUntil(lambda: viewport.shown().width() < SIZE[0] // 2, timeout=5000)
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    assert viewport.shown().width() == SIZE[0]


def test_shapes_that_come_slowly_get_no_sharp_frame_between_them(qtbot, box_scene, monkeypatch):
    viewport = shown_software(qtbot, box_scene)
    clock, rest = 1000.0, rest_of(viewport)
    monkeypatch.setattr("bozzetto_app.canvas.viewport.software.perf_counter", lambda: clock)
    rests = []
    for wait in (0.0, 0.5, 0.7, 0.1, 30.0):
        clock += wait
        rest.stop()
        viewport.set_scene(Scene(box_scene.layers), moving=True)
        rests.append(rest.interval() / 1000.0)
    assert min(rests) == rests[0] == rests[3] == rests[4], "nothing is known of the next shape"
    assert rests[1] > 0.5
    assert rests[2] > 0.7
    rest.start(5000)
    viewport.set_scene(Scene(box_scene.layers))
    assert rest.interval() == REST, "the last shape is sharp as soon as after a turn"


def test_the_very_same_scene_is_not_drawn_again(qtbot, box_scene):
    viewport = shown_software(qtbot, box_scene)
    viewport.set_scene(box_scene)
    assert not viewport.is_waiting


def test_slow_frames_are_coarse_while_the_view_turns_and_sharp_at_rest(
    qtbot, box_scene, monkeypatch
):
    viewport = shown_software(qtbot)
    with monkeypatch.context() as slow:  # as on a machine that takes 10 s for a frame
        slow.setattr(software, "perf_counter", itertools.count(0.0, 10.0).__next__)
        viewport.set_scene(box_scene)
        qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    widths = set()
    for angle in range(10):
        viewport.set_camera(Camera(eye=(30.0 * angle, -500.0, 100.0), viewport=SIZE))
        qtbot.wait(30)
        widths.add(viewport.shown().width())
    assert SIZE[0] * 3 // 10 in widths
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    assert viewport.shown().width() == SIZE[0]


def test_frames_in_motion_are_as_fine_as_they_turn_out_to_be_fast(qtbot, monkeypatch, box_scene):
    """A frame with one sample a pixel takes a third of a sharp one, which is known after a motion.
    Within a motion no frame is finer than the one before."""
    viewport = shown_software(qtbot)
    clock, shown = 100.0, []

    def drawn(scene, camera, palette, *, size, scale, shading, antialias, checkpoint):
        nonlocal clock
        clock += 0.4 if antialias else 0.13 * scale**2
        shown.append(scale)
        width, height = (round(side * scale) for side in size)
        return np.full((height, width, 4), 255, np.uint8)

    monkeypatch.setattr("bozzetto.scene.renderer.render", drawn)
    monkeypatch.setattr(software, "perf_counter", lambda: clock)
    monkeypatch.setattr(software, "REST", 600)
    viewport.set_scene(box_scene)
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=9000)
    motions = []
    for motion in range(4):
        shown.clear()
        for angle in range(6):
            count = len(shown)
            eye = (30.0 * angle + motion, -500.0, 100.0)
            viewport.set_camera(Camera(eye=eye, viewport=SIZE))
            qtbot.waitUntil(lambda count=count: len(shown) > count, timeout=5000)
        motions.append(shown[:6])
        qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=9000)
        assert viewport.shown().width() == SIZE[0]
        assert motions[-1] == sorted(motions[-1], reverse=True)
    assert motions[0][0] == pytest.approx(software.coarseness(0.4))
    assert motions[-1][0] == pytest.approx(software.coarseness(0.13), rel=0.01)
    shown.clear()
    viewport.set_scene(Scene(box_scene.layers), moving=True)
    qtbot.waitUntil(lambda: bool(shown), timeout=5000)
    assert shown[0] == pytest.approx(motions[0][0]), "who solves the next shape comes first"


def rest_of(viewport):
    """The timer at whose end a coarse frame is made sharp."""
    (rest,) = (timer for timer in viewport.findChildren(QTimer) if timer.interval() == REST)
    return rest


def slow_render(monkeypatch, full, coarse=0.02, started=None):
    """Frames that take so many seconds, looking up every hundredth; gives what became of them.

    A worker sets `started` (an event) when it begins one.
    """
    became = []

    def drawn(scene, camera, palette, *, size, scale, shading, antialias, checkpoint):
        begun = perf_counter()
        if started is not None:
            started.set()
        try:
            while perf_counter() - begun < (full if scale == 1.0 else coarse):
                sleep(0.01)
                checkpoint()
        except Cancelled:
            became.append(("given up", scale, perf_counter() - begun))
            raise
        became.append(("shown", scale, perf_counter() - begun))
        width, height = (round(side * scale) for side in size)
        return np.full((height, width, 4), 255, np.uint8)

    monkeypatch.setattr("bozzetto.scene.renderer.render", drawn)
    return became


def shown_software(qtbot, scene=None):
    """A viewport that has painted a scene, or an empty sheet, and rests."""
    viewport = SoftwareViewport()
    qtbot.addWidget(viewport)
    viewport.resize(*SIZE)
    viewport.show()
    if scene is not None:
        viewport.set_scene(scene)
    qtbot.waitUntil(lambda: not viewport.shown().isNull(), timeout=9000)
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=9000)
    return viewport


def test_a_long_frame_is_given_up_for_a_newer_one(qtbot, monkeypatch, box_scene):
    viewport = shown_software(qtbot)
    became = slow_render(monkeypatch, full=1.2)
    viewport.set_scene(box_scene)
    qtbot.wait(300)
    assert not became, "nobody wants another one, so it goes on"
    viewport.set_palette(DARK)
    qtbot.waitUntil(lambda: bool(became), timeout=1500)
    assert became[0][0] == "given up"
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=9000)
    assert [what for what, *_ in became] == ["given up", "shown"]


def test_a_short_frame_is_shown_although_a_newer_one_is_wanted(qtbot, monkeypatch, box_scene):
    viewport = shown_software(qtbot)
    monkeypatch.setattr("bozzetto_app.canvas.viewport.software.PATIENCE", 3.0)
    started = threading.Event()
    became = slow_render(monkeypatch, full=0.1, started=started)
    viewport.set_scene(box_scene)
    qtbot.waitUntil(started.is_set, timeout=5000)
    viewport.set_palette(DARK)
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    assert [what for what, *_ in became] == ["shown", "shown"]


def test_what_changes_at_once_makes_one_frame(qtbot, monkeypatch, box_scene):
    viewport = shown_software(qtbot)
    became = slow_render(monkeypatch, full=0.1)
    viewport.set_camera(Camera(eye=(10.0, -480.0, 90.0), viewport=SIZE))
    viewport.set_scene(box_scene)
    viewport.set_live(Scene((Layer("live", (Points([(1.0, 0.0, 0.0)]),)),)))
    rest_of(viewport).stop()  # that frame is as sharp as one at rest
    assert viewport.is_waiting
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=5000)
    assert [what for what, *_ in became] == ["shown"]


def test_while_what_is_shown_changes_all_the_time_there_is_something_to_see(qtbot, monkeypatch):
    """Dragging, with a camera that rests, on a machine on which full frames take long."""
    viewport = shown_software(qtbot)
    became = slow_render(monkeypatch, full=0.5)
    for k in range(60):
        points = Points([(float(k), 0.0, 0.0)])
        viewport.set_live(Scene((Layer("live", (points,)),)))
        qtbot.wait(20)
    assert sum(frame[0] == "shown" and frame[1] < 1.0 for frame in became) >= 5
    qtbot.waitUntil(lambda: not viewport.is_waiting, timeout=9000)
    assert became[-1][:2] == ("shown", 1.0), "and at rest it is sharp"
    assert viewport.shown().width() == SIZE[0]


@pytest.mark.parametrize("asked", ["software", " Software "])
def test_the_choice_can_be_made_by_hand(qapp, monkeypatch, asked):
    monkeypatch.setenv("BOZZETTO_VIEWPORT", asked)
    assert choose_backend() == "software"


@pytest.mark.skipif(os.environ["QT_QPA_PLATFORM"] != "offscreen", reason="for screenless Qt")
def test_without_a_screen_the_software_draws(qapp, monkeypatch):
    monkeypatch.delenv("BOZZETTO_VIEWPORT", raising=False)
    assert choose_backend() == "software"


def test_a_viewport_that_was_released_still_paints(make):
    viewport = make()
    viewport.set_scene(scene_of(Shaded(sphere(30.0))))
    before = viewport.grab()
    viewport.release()
    assert viewport.grab() == before


@pytest.mark.gl
def test_what_lies_on_the_card_is_given_back(qtbot, monkeypatch):
    """Contexts share programs, buffers and pictures: closing one of them frees nothing."""
    if choose_backend() != "gl":
        pytest.skip("no OpenGL here")
    from OpenGL import GL

    programs, buffers = [], []
    make_program, make_buffers = GL.glCreateProgram, GL.glGenBuffers

    def program():
        programs.append(make_program())
        return programs[-1]

    def several(count):
        made = make_buffers(count)
        buffers.extend(int(name) for name in np.atleast_1d(made))
        return made

    monkeypatch.setattr(GL, "glCreateProgram", program)
    monkeypatch.setattr(GL, "glGenBuffers", several)
    viewport = gl_viewport()
    qtbot.addWidget(viewport)
    viewport.resize(*SIZE)
    viewport.set_palette(LIGHT)
    viewport.set_camera(CAMERA)
    viewport.show()
    qtbot.waitExposed(viewport)
    viewport.set_scene(scene_of(Shaded(sphere(30.0))))
    viewport.grab()
    assert programs
    assert buffers
    viewport.release()
    viewport.makeCurrent()
    assert not any(GL.glIsProgram(program) for program in programs)
    assert not any(GL.glIsBuffer(buffer) for buffer in buffers)
    viewport.doneCurrent()


@pytest.mark.gl
def test_what_opengl_cannot_do_is_noticed(qtbot, monkeypatch):
    """It is asked once a picture, not after each call."""
    if choose_backend() != "gl":
        pytest.skip("no OpenGL here")
    from OpenGL import GL

    from bozzetto_app.canvas.viewport.opengl_items import SurfaceItem

    viewport = gl_viewport()
    qtbot.addWidget(viewport)
    viewport.resize(*SIZE)
    viewport.set_palette(LIGHT)
    viewport.set_camera(CAMERA)
    viewport.set_scene(scene_of(Shaded(sphere(30.0))))
    with qtbot.waitSignal(viewport.proved):
        viewport.show()
    draw = SurfaceItem.passes

    def fails(item, *given):
        draw(item, *given)
        GL.glEnable(0xFFFF)

    monkeypatch.setattr(SurfaceItem, "passes", fails)
    with qtbot.waitSignal(viewport.failed) as told:
        viewport.update()
    assert "OpenGL error" in told.args[0]
