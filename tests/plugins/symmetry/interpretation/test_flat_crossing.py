"""Planes of lines across the symmetry plane, where the ink may say nothing of them."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.interpretation.flat_crossing import _aligned, _Plane
from bozzetto_symmetry.stereo.bowed_plane import BowedPlane


def plane_told_by(columns: np.ndarray) -> _Plane:
    return _Plane(BowedPlane(0.02, 5.0, size=80.0), np.zeros(len(columns)), columns, free=2)


@pytest.mark.parametrize("silent", [(0,), (1,), (0, 1)])
def test_ink_that_does_not_move_with_a_plane_does_not_tell_it(silent):
    """Its information has no inverse: `inv` raises, and a random hand came upon it."""
    chance = np.random.default_rng(3)
    columns = chance.normal(scale=50.0, size=(40, 5))
    told = plane_told_by(columns)
    assert told.is_told
    columns[:, list(silent)] = 0.0
    untold = plane_told_by(columns)
    assert not untold.is_told
    assert _aligned(None, np.empty((0, 2)), None, untold) is untold


def test_what_a_broken_camera_tells_is_nothing():
    columns = np.full((40, 5), np.nan)
    assert not plane_told_by(columns).is_told
