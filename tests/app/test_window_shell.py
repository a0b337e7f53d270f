"""The window for tests of plugins: drawn, dragged, tapped and read in few words."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bozzetto.errors import UserError
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene.display_list import Lines
from bozzetto.testing import Pen
from bozzetto.view import standard_view
from bozzetto_app.testing import WindowShell
from bozzetto_app.testing.window_shell import CANVAS
from tests import linked_boxes, plugin_package, spring

DOCS = Path(__file__).resolve().parents[2] / "docs"
EXAMPLE = DOCS / "examples" / "bozzetto_ribbon"
PEN = Pen()


@pytest.fixture
def ribbons(qapp, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLE)
    shell = WindowShell(Registry(extra=["bozzetto_ribbon"]), tmp_path)
    shell.open("ribbon")
    yield shell
    shell.close()
    for name in [name for name in sys.modules if name.partition(".")[0] == "bozzetto_ribbon"]:
        del sys.modules[name]


def test_a_ribbon_is_drawn_moved_and_taken_away(ribbons):
    canvas = ribbons.window.canvas
    assert (canvas.width(), canvas.height()) == CANVAS
    assert ribbons.hint.startswith("Draw a stroke")
    assert ribbons.state is None
    ribbons.draw(PEN.along([(300, 450), (900, 450)]))
    (band,) = ribbons.state.bands
    assert len(ribbons.shapes().surfaces) == 1
    ribbons.take("move")
    assert ribbons.hint.startswith("Drag the dot")
    ribbons.drag("0", PEN.along([(300, 440), (300, 350)]))
    (moved,) = ribbons.state.bands
    assert moved.shift[2] > 0.0
    assert moved.stroke == band.stroke
    with pytest.raises(UserError, match="there are: 0"):
        ribbons.drag("7", PEN.along([(0, 0), (9, 9)]))
    ribbons.press("Ctrl+Z")
    assert ribbons.state.bands == (band,)
    ribbons.take("erase")
    ribbons.tap(600, 200)
    assert "no ribbon here" in " ".join((*ribbons.notices, ribbons.hint))
    ribbons.tap(600, 450)
    assert ribbons.state.bands == ()
    ribbons.undo()
    assert ribbons.state.bands == (band,)


def test_a_preview_is_seen_while_the_pen_is_down(ribbons):
    ribbons.draw(PEN.along([(300, 450), (700, 500)]), lift=False)

    def preview():
        return [
            i for layer in ribbons.shown().layers if layer.name == "preview" for i in layer.items
        ]

    ribbons.wait_until(lambda: bool(preview()))
    assert isinstance(preview()[0], Lines)


def test_the_hand_presses_as_the_pen_does(ribbons):
    ribbons.draw(PEN.but(pressure=(0.1, 0.9)).along([(300, 450), (900, 450)]))
    pressure = ribbons.state.bands[0].stroke.pressure
    assert pressure[0] == pytest.approx(0.1, abs=0.02)
    assert pressure[-1] == pytest.approx(0.9, abs=0.02)


def test_views_parameters_and_files(ribbons):
    ribbons.look("top")
    seen = ribbons.session.view.camera
    assert seen.axes == pytest.approx(standard_view(seen, "top").axes)
    ribbons.draw(PEN.along([(300, 450), (900, 450)]))
    ribbons.set(width=21.0)
    before = ribbons.state
    assert before.width == 21.0
    ribbons.reopen()
    assert ribbons.state == before
    assert ribbons.state is not before
    ribbons.set(width=-1.0)
    assert "Width" in ribbons.notices[-1]
    assert ribbons.state == before


HOVERING = """
import numpy as np
from bozzetto.plugin import Tap, Tool, hookimpl
from bozzetto.scene import Layer, Points, Scene
from tests.spring import Springs

class Near(Tool):
    id, title, hint, gesture, hovers = "near", "Near", "Touch.", "tap", True

    def preview(self, state, gesture, context):
        place = gesture.camera.on_plane([(gesture.x, gesture.y)], (0, 0, 0), (0, 1, 0))
        return Scene((Layer("near", (Points(place.astype(np.float32)),)),))

class Hovering(Springs):
    def tools(self):
        return (*super().tools(), Near())

@hookimpl
def bozzetto_modelers():
    return [Hovering()]
"""


@pytest.fixture
def moving(qapp, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path / "packages")
    plugin_package.write(tmp_path / "packages", "moving_balls", spring.MANIFEST, HOVERING)
    linked_boxes.write_package(tmp_path / "packages", "following_boxes")
    shell = WindowShell(Registry(extra=["moving_balls", "following_boxes"]), tmp_path)
    yield shell
    shell.close()
    for name in ("moving_balls", "following_boxes"):
        sys.modules.pop(name, None)


def test_what_plays_is_waited_for_and_stopped(moving):
    moving.open(spring.MODELER)
    moving.draw(PEN.along([(600, 450), (600, 300)]))
    hung = moving.state
    moving.take("pull")
    moving.press("P")
    moving.wait_until(lambda: moving.state.steps > 3)
    moving.press("P")
    assert moving.state.clock > 0.0
    moving.undo()
    assert moving.state == hung
    moving.take("near")
    moving.hover(500, 400)
    (near,) = [layer for layer in moving.shown().layers if layer.name == "near"]
    pixels, _ = moving.session.view.camera.project(near.items[0].points)
    assert pixels[0] == pytest.approx((500.0, 400.0), abs=0.5)


def test_an_object_is_followed_and_chosen(moving):
    moving.open(linked_boxes.MODELER)
    moving.draw(PEN.circle())
    moving.set(edge=20.0)
    body = moving.model
    moving.use(linked_boxes.MODELER)
    follower = moving.model
    assert follower.id != body.id
    assert follower.state.sources == (body.id,)
    before = moving.shapes().solids[0].mesh.bounds
    moving.choose(body.id)
    moving.set(edge=40.0)
    assert moving.state != body.state
    moving.choose(follower.id)
    assert moving.state == follower.state
    assert abs(moving.shapes().solids[0].mesh.bounds - before).max() > 1.0


def test_every_method_is_explained():
    guide = (DOCS / "plugin-authors-guide.md").read_text("utf-8")
    table = guide.partition("| `window` | |")[2].partition("```")[0]
    for name in vars(WindowShell):
        if not name.startswith("_"):
            assert f"`{name}" in table, name
