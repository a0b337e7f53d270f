"""The draft view: a mould's two halves, and walls that stick."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.scene import LIGHT
from bozzetto.scene.renderer.shading import DRAFT, draft_colors


def colors(*degrees: float, turn: float = 0.0) -> np.ndarray:
    """Of surfaces at angles to the vertical, negative where they look down."""
    angle, turned = np.radians(degrees), np.radians(turn)
    level = np.cos(angle)
    rows = np.column_stack((level * np.cos(turned), level * np.sin(turned), np.sin(angle)))
    return draft_colors(rows.astype(np.float32), LIGHT)[:, :3]


def test_halves_of_a_mould_have_their_colours_and_a_wall_warns() -> None:
    up, down, wall = colors(40.0, -40.0, 0.0)
    np.testing.assert_allclose(up, LIGHT.clay)
    np.testing.assert_allclose(down, LIGHT.second)
    np.testing.assert_allclose(wall, LIGHT.warning)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_less_draft_the_stronger_the_warning_whichever_way_it_looks(sense: float) -> None:
    steps = [sense * each for each in np.linspace(0.01, DRAFT, 12)]
    for turn in (0.0, 77.0, 200.0):
        off = np.linalg.norm(colors(*steps, turn=turn) - np.array(LIGHT.warning), axis=1)
        assert (np.diff(off) > 0.0).all()


def test_the_length_of_normals_says_nothing() -> None:
    rows = np.array([(1, 0, 0.02), (0, 1, -0.5)], np.float32)
    np.testing.assert_allclose(draft_colors(rows, LIGHT), draft_colors(7 * rows, LIGHT), atol=1e-3)
    assert np.isfinite(draft_colors(np.zeros((1, 3), np.float32), LIGHT)).all()
