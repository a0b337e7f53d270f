"""What the places of one half say of the curve."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.interpretation.stereo_triangulation import SLENDEREST, slenderness

TURN = 2.0 * np.pi * np.arange(300) / 300


@pytest.mark.parametrize("ratio", [1.0, 1.7, 4.0, 1.0 / 3.0])
def test_an_ellipse_is_as_slender_as_its_axes_say_wherever_it_lies(ratio):
    random = np.random.default_rng(3)
    for _ in range(5):
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0][:2]
        loop = np.column_stack((ratio * np.cos(TURN), np.sin(TURN))) @ axes
        placed = random.uniform(1e-3, 1e3) * loop + random.normal(size=3)
        assert slenderness(placed) == pytest.approx(abs(np.log(ratio)), abs=1e-9)


def test_a_line_is_as_slender_as_anything_and_a_dot_is_not():
    line = np.outer(np.linspace(-1.0, 1.0, 50), (3.0, 2.0, 1.0))
    assert slenderness(line) == pytest.approx(np.log(SLENDEREST))
    assert slenderness(np.zeros((50, 3))) == slenderness(line[:2]) == 0.0
