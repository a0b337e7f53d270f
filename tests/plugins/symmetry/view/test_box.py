"""What is shown of the box and of the centre plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.plugin import Context
from bozzetto.scene import DARK, LIGHT, Handle, Label, Lines, Scene, Shaded
from bozzetto.scene.renderer import render
from bozzetto.view import Camera
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.view.box import BOX_TOOL, FACES, box_layers
from tests.plugins.symmetry.boxes import PLANES, STATE, tilted


def test_the_edges_are_the_box() -> None:
    (lines,) = box_layers(STATE)[0].items
    assert isinstance(lines, Lines)
    pairs = np.asarray(lines.points, float).reshape(-1, 2, 3)
    lengths = np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=1)
    assert sorted(lengths.tolist()) == [80.0] * 4 + [120.0] * 4 + [200.0] * 4
    assert len({tuple(p) for p in pairs.reshape(-1, 3).tolist()}) == 8
    assert pairs.reshape(-1, 3).mean(axis=0) == pytest.approx(STATE.centre)


def test_handles_and_dimensions_are_there_for_the_box_tool_only() -> None:
    for layer in box_layers(STATE):
        held = [item for item in layer.items if isinstance(item, Handle | Label)]
        assert bool(held) == (layer.tool == BOX_TOOL)
    (layer,) = (layer for layer in box_layers(STATE) if layer.tool)
    handles = {item.id: item.point for item in layer.items if isinstance(item, Handle)}
    assert handles["x+"] == (110.0, -5.0, 30.0)
    assert handles["z-"] == (10.0, -5.0, -10.0)
    assert set(handles) == {*FACES, "centre"}
    texts = [item.text for item in layer.items if isinstance(item, Label)]
    assert texts == ["200 mm", "120 mm", "80 mm"]


def test_the_grid_can_be_left_out() -> None:
    names = [layer.name for layer in box_layers(replace(STATE, grid=False))]
    assert names == ["box", "plane", "box handles"]


@pytest.mark.parametrize("state", [STATE, *map(tilted, PLANES)])
def test_ink_is_not_laid_on_the_box(state: SymmetryState) -> None:
    scene = Scene(box_layers(state))
    assert any(isinstance(item, Shaded) for _, item in scene.items())
    camera = Camera(eye=(500.0, -600.0, 300.0))
    rays = camera.rays(np.random.default_rng(1).uniform(0, 900, (200, 2)))
    assert not Context(scene=scene).surface_hit(rays).hit.any()


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_the_box_can_be_seen_and_stays_quiet(palette) -> None:  # type: ignore[no-untyped-def]
    camera = Camera(eye=(300.0, -600.0, 250.0), target=STATE.centre, viewport=(400.0, 300.0))
    pixels = render(Scene(box_layers(STATE)[:3]), camera, palette)[..., :3].astype(float)
    change = np.abs(pixels - palette.paper).max(axis=-1)
    assert 0.05 < (change > 8).mean() < 0.5
    assert np.median(change[change > 8]) < 60  # the tint of the plane, and thin lines
