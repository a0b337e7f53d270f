"""Wall thickness on the sheet: measured beside the window, told with its scale, and gone again."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.scene import DARK, LIGHT, Label, Scene, Shaded
from bozzetto.scene.thickness_view import thickness_view


@pytest.fixture
def watched(canvas, monkeypatch):
    """What the viewport was told to show."""
    told = []
    viewport = canvas.viewports.current
    show = viewport.set_scene
    monkeypatch.setattr(
        viewport, "set_scene", lambda scene, **more: (told.append(scene), show(scene, **more))
    )
    return told


def is_measured(scene):
    return any(isinstance(item, Label) for _, item in scene.items())


def colors_of(scene):
    return [item.mesh.colors for _, item in scene.items() if isinstance(item, Shaded)]


def test_the_scene_is_measured_in_a_worker_and_shown_with_its_scale(
    qtbot, canvas, session, box_scene, watched
):
    session.scene.show(box_scene)
    scale = canvas.thickness_scale
    assert not scale.isVisible()
    session.view.set_shading("thickness")
    assert watched[-1] is box_scene, "as it is, until it is measured"
    assert scale.isVisible()
    assert "…" in scale.words
    qtbot.waitUntil(lambda: is_measured(watched[-1]), timeout=20_000)
    assert "100 mm" in scale.words
    expected = thickness_view(box_scene, LIGHT).scene
    np.testing.assert_array_equal(colors_of(watched[-1])[0], colors_of(expected)[0])
    picture = scale.grab().toImage()
    assert len({picture.pixel(x, 40) for x in range(0, picture.width(), 3)}) > 20
    session.view.set_shading("clay")
    assert watched[-1] is box_scene
    assert not scale.isVisible()


def test_another_scene_and_another_theme_are_measured_anew(
    qtbot, canvas, session, box_scene, watched
):
    session.view.set_shading("thickness")
    session.scene.show(box_scene)
    qtbot.waitUntil(lambda: is_measured(watched[-1]), timeout=20_000)
    light = colors_of(watched[-1])[0]
    canvas.set_palette(DARK)
    assert not is_measured(watched[-1])
    qtbot.waitUntil(lambda: is_measured(watched[-1]), timeout=20_000)
    assert (colors_of(watched[-1])[0] != light).any()
    open_box = Scene(box_scene.layers[1:])
    session.scene.show(open_box)
    qtbot.waitUntil(lambda: "closed" in canvas.thickness_scale.words, timeout=20_000)
    assert watched[-1].layers == open_box.layers
    scale = canvas.thickness_scale
    assert scale.width() > scale.fontMetrics().horizontalAdvance(scale.words), "all of it is read"


def test_while_something_is_dragged_nothing_is_measured(qtbot, canvas, session, box_scene, watched):
    session.view.set_shading("thickness")
    session.drawing.is_dragging = True
    session.scene.show(box_scene)
    qtbot.waitUntil(lambda: not canvas.viewports.thickness.busy, timeout=20_000)
    assert watched[-1] is box_scene
    session.drawing.is_dragging = False
    session.scene.show(box_scene)
    qtbot.waitUntil(lambda: is_measured(watched[-1]), timeout=20_000)
