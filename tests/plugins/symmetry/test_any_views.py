"""Ink in views from anywhere: read or refused in words, without a fault and without long work."""

from __future__ import annotations

import time
from contextlib import suppress

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.view import Camera
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_strokes

WIDTH = 1200.0

MOST = 5.0
"""Processor time of one stroke, s, on any machine."""


def camera(chance: np.random.Generator) -> Camera:
    """A view of the box from within a tenth of a millimetre to ten metres."""
    target, way = chance.normal(0.0, 60.0, 3), chance.normal(0.0, 1.0, 3)
    way /= np.linalg.norm(way)
    kind = "orthographic" if chance.random() < 0.3 else "perspective"
    up = (0.0, 0.0, 1.0) if abs(way[2]) < 0.95 else (0.0, 1.0, 0.0)
    eye = target + 10.0 ** chance.uniform(-1.0, 4.0) * way
    opening, height = float(chance.uniform(5.0, 110.0)), float(10.0 ** chance.uniform(-1.0, 4.0))
    return Camera(kind, tuple(eye), tuple(target), up, opening, height, (WIDTH, 900.0))


def line(chance: np.random.Generator) -> np.ndarray:
    """A line, an arc, a scribble, a curve or a trembling upright, (n, 2) px."""
    along = np.linspace(0.0, 1.0, int(chance.integers(2, 60)))
    kind = chance.integers(5)
    start = chance.uniform(0.0, 900.0, 2)
    if kind == 0:
        return start + along[:, None] * chance.normal(0.0, 300.0, 2)
    if kind == 1:
        angle, radius = along * chance.uniform(2.0, 7.0), chance.uniform(2.0, 300.0)
        return np.c_[600 + radius * np.cos(angle), 450 + radius * np.sin(angle) * chance.random()]
    if kind == 2:
        return np.cumsum(chance.normal(0.0, 20.0, (len(along), 2)), axis=0) + 500.0
    if kind == 3:
        return start + np.c_[300.0 * along, 200.0 * along**2]
    return np.c_[600.0 + chance.normal(0.0, 0.3, len(along)), 200.0 + 500.0 * along]


@pytest.mark.parametrize("seed", range(7100, 7108))
def test_strokes_in_two_views_from_anywhere_are_read_or_refused(seed):
    chance = np.random.default_rng(seed)
    state, views = SymmetryState(), [camera(chance) for _ in range(2)]
    drawn = line(chance)
    for number in range(4):
        if number and chance.random() < 0.5:  # once more, or its mirror image on the sheet
            drawn = np.c_[
                WIDTH - drawn[:, 0] if chance.random() < 0.6 else drawn[:, 0], drawn[:, 1]
            ]
        elif number:
            drawn = line(chance)
        ink = Stroke(drawn[:, 0], drawn[:, 1], camera=views[int(chance.integers(2))])
        begun = time.thread_time()
        with suppress(UserError):
            state = add_strokes(state, (ink,))
        assert time.thread_time() - begun < MOST
