"""Gestures into a model that was moved: what is drawn lies where the pen was."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import Context, Ink
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Lines, Shaded, located
from bozzetto.testing import Pen, Shell
from tests.core.scene.shapes import scene_of, sphere

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "bozzetto_ribbon"

TURNED = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.0, (10.0, 20.0, 30.0))
MIRRORED = Placement((-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), 0.5, (-15.0, 5.0, 40.0))


@pytest.fixture(params=[TURNED, MIRRORED], ids=["turned", "mirrored"])
def moved(request, tmp_path, monkeypatch):
    """A shell with an empty ribbon model that stands elsewhere."""
    monkeypatch.syspath_prepend(EXAMPLE)
    shell = Shell(Registry(extra=["bozzetto_ribbon"]), tmp_path)
    shell.open("ribbon")
    model = replace(shell.model, placement=request.param)
    shell.history.apply("move", shell.document.with_model(model))
    yield shell
    for name in [name for name in sys.modules if name.partition(".")[0] == "bozzetto_ribbon"]:
        del sys.modules[name]


def stroke():
    return Pen().along([(300, 450), (700, 300), (900, 500)])


def lines_of(scene):
    return [item.points for _, item in scene.items() if isinstance(item, Lines)]


def seen(shell, points):
    return shell.camera.project(points)[0]


def test_ink_in_a_moved_model_lies_under_the_pen(moved):
    moved.draw(stroke())
    (ghost,) = lines_of(moved.scene())
    drawn = stroke().points
    on_sheet = seen(moved, ghost)
    gaps = np.linalg.norm(on_sheet[:, None] - drawn[None], axis=-1).min(1)
    assert gaps.max() < 2.0, "the ribbon smooths its ink by some tenths of a pixel"
    assert np.linalg.norm(on_sheet[0] - drawn[0]) < 1e-2
    assert np.linalg.norm(on_sheet[-1] - drawn[-1]) < 1e-2


def test_the_preview_lies_where_the_result_will(moved):
    ink = Ink((stroke(),))
    (preview,) = lines_of(moved.preview(ink, tool=moved.tool(None, "ink")))
    moved.draw(stroke())
    (ghost,) = lines_of(moved.scene())
    np.testing.assert_allclose(preview, ghost, atol=1e-3)


def test_a_handle_of_a_moved_model_goes_where_the_pen_takes_it(moved):
    moved.draw(stroke())
    (handle,) = moved.handles()
    moved.drag(handle.id, Pen().along([(300, 450), (500, 200)]))
    (handle,) = moved.handles()
    np.testing.assert_allclose(seen(moved, handle.point)[0], (500, 200), atol=1e-2)


def test_a_tap_meets_what_is_seen_under_it(moved):
    moved.draw(stroke())
    with pytest.raises(UserError, match="no ribbon here"):
        moved.tap(900, 300)
    moved.tap(700, 302)
    assert not moved.shapes()


def test_ink_on_another_object_is_laid_on_its_surface(moved):
    """The scene of the context is moved too: a ray meets the same surface as in the world."""
    moved.camera = replace(moved.camera, eye=(0.0, -500.0, 100.0))
    first = moved.model
    moved.open("ribbon")
    moved.set(width=60.0)
    moved.draw(Pen(moved.camera).along([(300, 450), (900, 450)]))
    (surface,) = moved.shapes().surfaces
    moved.choose(first.id)
    moved.draw(Pen(moved.camera).along([(600, 450), (610, 450), (620, 470)]))
    start = lines_of(moved.scene())[0][0]
    assert np.linalg.norm(surface.mesh.vertices - start, axis=1).min() < 30.0
    hit = moved.context().surface_hit(moved.camera.rays([(600, 450)])).points[0]
    np.testing.assert_allclose(start, hit, atol=0.5)


@pytest.mark.parametrize("placement", [TURNED, MIRRORED], ids=["turned", "mirrored"])
def test_ink_is_projected_in_the_frame_of_the_model(placement):
    """In a moved context the same ink lies on the same places of the same surfaces."""
    world = Context(scene=scene_of(Shaded(sphere(60.0, 24)), owner="ball"))
    frame = placement.inverse()
    (run,) = world.moved(frame).project(stroke().moved(frame)).runs
    now = located(run.places, world.scene)
    assert now is not None
    assert run.places.model == "ball"
    np.testing.assert_allclose(placement.points(run.points), now.points, atol=1e-3)
    drawn = [np.interp(run.at, np.arange(len(stroke())), column) for column in stroke().points.T]
    pixels, _ = stroke().camera.project(now.points)
    np.testing.assert_allclose(pixels, np.transpose(drawn), atol=1e-2)
