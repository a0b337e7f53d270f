"""What the places of one half say of the curve."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.interpretation.side_pairing import pairings
from bozzetto_symmetry.interpretation.triangulation import SLENDEREST, _slender, triangulate
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry import scenes as s

VIEW = s.camera(40.0, 25.0, pixels=800.0)
TURN = 2.0 * np.pi * np.arange(300) / 300


@pytest.mark.parametrize("ratio", [1.0, 1.7, 4.0, 1.0 / 3.0])
def test_an_ellipse_is_as_slender_as_its_axes_say_wherever_it_lies(ratio):
    random = np.random.default_rng(3)
    for _ in range(5):
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0][:2]
        loop = np.column_stack((ratio * np.cos(TURN), np.sin(TURN))) @ axes
        placed = random.uniform(1e-3, 1e3) * loop + random.normal(size=3)
        assert _slender(placed) == pytest.approx(abs(np.log(ratio)), abs=1e-9)


def test_a_line_is_as_slender_as_anything_and_a_dot_is_not():
    line = np.outer(np.linspace(-1.0, 1.0, 50), (3.0, 2.0, 1.0))
    assert _slender(line) == pytest.approx(np.log(SLENDEREST))
    assert _slender(np.zeros((50, 3))) == _slender(line[:2]) == 0.0


@pytest.mark.parametrize("axes", [((1, 0, 0), (0, 0, 1)), ((1, 0, 0), (0, 1, 0))])
def test_a_circle_is_larger_or_more_slender_in_the_wrong_sense(axes):
    loop = np.column_stack((np.cos(TURN), np.sin(TURN))) @ np.array(axes) * 8.0 + (10.0, 40.0, 5.0)
    stereo = Stereo(VIEW)
    found = pairings(stereo, s.drawn(loop, VIEW), s.drawn(loop * MIRROR, VIEW), closed=True)
    halves = [triangulate(stereo, each) for each in found]
    off = [float(np.median(s.distances(each.points, loop, closed=True))) for each in halves]
    right, wrong = (halves[int(k)] for k in np.argsort(off))
    assert max(off) > 10 * min(off)
    assert wrong.slender > right.slender + 0.1 or wrong.extent > 1.1 * right.extent
