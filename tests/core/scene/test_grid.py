"""The ground grid: round steps, in view, faint at the rim."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.scene import Lines
from bozzetto.scene.grid import STEP_PIXELS, grid_step, ground_grid
from bozzetto.view.camera import Camera
from tests.core.view.cameras import cameras


@given(cameras())
def test_the_step_is_one_two_or_five_and_neither_crowded_nor_sparse(camera):
    step = grid_step(camera)
    lead = step / 10.0 ** np.floor(np.log10(step) + 1e-9)
    assert min(abs(lead - k) for k in (1, 2, 5)) < 1e-6
    assert STEP_PIXELS * (1 - 1e-9) <= step * camera.pixels_per_mm < 2.6 * STEP_PIXELS


@given(cameras(), st.floats(-50, 50))
def test_every_line_lies_on_the_ground_at_a_whole_step(camera, height):
    step = grid_step(camera)
    lines = ground_grid(camera, height).items[0]
    assert isinstance(lines, Lines)
    assert np.abs(lines.points[:, 2] - height).max() < 1e-4 * max(1, abs(height))
    for piece in lines.pieces():
        place = lines.points[piece, :2].astype(float) / step
        fixed = place[:, np.argmin(np.ptp(place, axis=0))]
        room = 1e-6 * np.abs(place).max() + 1e-4
        assert np.abs(fixed - round(float(fixed[0]))).max() < room
        assert lines.width[piece][[0, -1]].max() == 0, "faded out at the ends"
    assert lines.width.max() <= 1.5


def test_axes_are_coloured_and_only_where_they_are():
    home = ground_grid(Camera())
    assert [item.color for item in home.items] == ["grid", "accent", "second"]
    x_axis, y_axis = home.items[1], home.items[2]
    assert np.abs(x_axis.points[:, 1]).max() == 0
    assert np.abs(y_axis.points[:, 0]).max() == 0
    away = ground_grid(Camera(eye=(1e5, -500, 0), target=(1e5, 0, 0)))
    assert [item.color for item in away.items] == ["grid", "accent"]
    assert away.items[1].points[:, 0].mean() == pytest.approx(1e5, rel=1e-2)
