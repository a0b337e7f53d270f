"""Watching a drawing, and what comes onto an empty sheet."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtGui import QImage

from bozzetto.scene.display_list import Image
from bozzetto_app.dialogs.thumbnails import thumbnail_of
from tests.app.seen import darkness, words

pytestmark = pytest.mark.slow


@pytest.fixture
def window(make_window):
    return make_window()


def test_a_drawing_is_watched_on_a_free_sheet_with_its_ink(window, qtbot, settle):
    session, canvas = window.session, window.canvas
    assert window.welcome.isVisible()
    (info,) = (one for one in session.toolbox.modelers if one.id == "bozzetto.silhouette")
    fish = next(path for path in info.samples if path.stem == "fish")
    inked = []
    window.replays.inked.connect(inked.append)
    window.replays.speed = 40.0
    window.watch(info.id, fish)
    assert not window.welcome.isVisible()
    assert not canvas.empty_hint.isVisible()
    qtbot.waitUntil(lambda: None in inked, timeout=30_000)
    places = np.concatenate([stroke.points for stroke in inked if stroke is not None])
    drawn = session.view.camera.project(inked[0].camera.on_plane(places, (0, 0, 0), (0, 1, 0)))[0]
    assert (drawn >= 0).all()
    assert (drawn <= session.view.camera.viewport).all()
    qtbot.waitUntil(lambda: bool(session.drawing.document.models), timeout=30_000)
    settle(session)
    assert not darkness(canvas.overlay).any()


def test_a_picture_to_trace_stands_on_the_ground(window, tmp_path, settle):
    picture = QImage(60, 40, QImage.Format.Format_RGB32)
    picture.fill(0x446688)
    picture.save(str(tmp_path / "side.png"))
    window.session.files.exchange.import_file(tmp_path / "side.png")
    settle(window.session)
    (image,) = (item for _, item in window.session.scene.visible.items() if isinstance(item, Image))
    low, high = window.session.scene.visible.bounds()
    np.testing.assert_allclose((low[2], low[0] + high[0]), (0, 0), atol=1e-9)
    assert image.down[2] < 0


def test_a_car_among_the_samples_shows_its_sketch_and_opens_with_it(window, settle):
    session = window.session
    (info,) = (one for one in session.toolbox.modelers if one.id == "bozzetto.car")
    (sample,) = info.samples
    shown = thumbnail_of(sample)
    assert shown is not None
    assert not shown.isNull()
    window.welcome.sample_chosen.emit(info.id, sample, "Sample")
    assert session.files.exchange.busy
    assert not window.canvas.empty_hint.isVisible(), "asks for nothing while it is read"
    settle(session)
    (model,) = session.drawing.document.models
    (sketch,) = model.state.sketches
    assert sketch.picture is not None
    assert (sketch.picture.width, sketch.picture.height) == sketch.size
    assert session.toolbox.modeler == info.id
    assert not window.welcome.isVisible()


def test_what_to_do_first_is_said_again_where_a_file_could_not_be_read(window, tmp_path, settle):
    settle(window.session)
    broken = tmp_path / "broken.json"
    broken.write_text("{")
    hint = window.canvas.empty_hint
    before = hint.text
    assert before
    window.session.files.exchange.import_file(broken)
    assert not hint.isVisible()
    settle(window.session)
    assert hint.isVisible()
    assert hint.text == before


def test_the_strip_goes_with_the_first_ink_and_leaves_room_for_the_hint(window):
    assert window.canvas.empty_hint.left == window.welcome.width()
    window.canvas.hand.ink_began.emit()
    assert not window.welcome.isVisible()
    assert window.canvas.empty_hint.left == 0


def test_the_parameters_of_a_mesh_that_was_brought_in_say_how_it_is_read(window, tmp_path, settle):
    def asks_to_draw():
        return any("Draw or choose" in said for said in words(window.docks.parameters))

    assert asks_to_draw()
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 50 0 0\nv 0 0 50\nf 1 2 3\n")
    window.session.files.exchange.import_file(tmp_path / "one.obj")
    settle(window.session)
    assert window.session.selection.id is not None
    assert not asks_to_draw()
    assert {"Up in the file", "Unit of the file"} <= set(words(window.docks.parameters))
