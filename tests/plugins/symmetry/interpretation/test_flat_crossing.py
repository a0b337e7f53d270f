"""Planes of lines across the symmetry plane, where the ink may say nothing of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bozzetto.ink import Stroke
from bozzetto_symmetry.interpretation.flat_crossing import FittedPlane, aligned, doubted
from bozzetto_symmetry.interpretation.mirrored_ink import InkLine, equations
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.solve.notices import PLANES
from bozzetto_symmetry.stereo.bowed_plane import BowedPlane
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from tests.plugins.symmetry import scenes as s


def plane_told_by(columns: np.ndarray) -> FittedPlane:
    return FittedPlane(BowedPlane(0.02, 5.0, size=80.0), np.zeros(len(columns)), columns, free=2)


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
    assert aligned(None, np.empty((0, 2)), None, untold) is untold


def test_what_a_broken_camera_tells_is_nothing():
    columns = np.full((40, 5), np.nan)
    assert not plane_told_by(columns).is_told


@pytest.mark.parametrize("elevation", [4.0, 8.0, 30.0])
def test_two_hands_of_1_px_leave_the_root_of_two_however_the_plane_is_seen(elevation):
    """A level ring seen from 4° shows one half up to eleven times as long as the other, in places.

    Distances that were not weighed were 2 to 6 px off there in the very plane.
    """
    turn = 2.0 * np.pi * np.arange(400) / 400
    ring = np.column_stack((45.0 * np.cos(turn), 30.0 * np.sin(turn), np.full(400, 5.0)))
    view = s.camera(40.0, elevation, "orthographic", pixels=800.0)
    stereo, plane = Stereo(view), BowedPlane(0.5 * np.pi, 5.0, size=100.0)
    clean = view.project(ring)[0]
    squares = []
    for seed in range(40):
        pixels = clean + s.tremor(400, 1.0, np.random.default_rng(seed), closed=True)
        made = equations(stereo, pixels[3:198], InkLine.of(pixels, True), None, plane)
        assert made is not None
        squares.append(np.mean(made[0] ** 2))
    assert 1.2 < np.sqrt(np.mean(squares)) < 1.65


@pytest.mark.parametrize("seed", range(4, 8))
@pytest.mark.parametrize("lift", [2.6, 3.2])
def test_a_shallow_bow_is_upright_or_level_and_the_person_is_told(lift, seed):
    """No ink says in which plane a shallow bow lies; it is no straight bar for that."""
    across = np.linspace(-39.0, 39.0, 300)
    bow = np.column_stack((np.full(300, -20.0), across, 34.0 + lift * (1.0 - (across / 39.0) ** 2)))
    view = s.camera(38.0, 28.0, pixels=800.0)
    pixels = s.drawn(bow, view, noise=0.3, random=np.random.default_rng(seed))
    state = add_drawing(SymmetryState(), (Stroke(pixels[:, 0], pixels[:, 1], view),))
    trace = trace_of(state.curves[0], state)
    other = trace_of(replace(state.curves[0], other=True), state)
    assert trace.warnings == (PLANES,)
    assert trace.ghost is not None
    extents = [np.ptp(each.points, axis=0)[[0, 2]] for each in (trace, other)]
    assert sorted(int(np.argmax(each)) for each in extents) == [0, 1]
    assert np.max([each.min() for each in extents]) < 0.1
    upright = next(each[1] for each in extents if each[1] > each[0])
    assert upright == pytest.approx(lift, abs=0.8)


def test_a_plane_is_the_less_known_the_more_a_bow_would_explain():
    chance = np.random.default_rng(5)
    columns = chance.normal(scale=50.0, size=(40, 5))
    plane = plane_told_by(columns)
    surface = BowedPlane(0.03, 5.5, (0.1, -0.05, 0.02), size=80.0)
    bowed = FittedPlane(surface, np.zeros(40), columns, free=5)
    assert doubted(plane, None, 5.0) is plane
    doubts = [doubted(plane, bowed, gain).covariance for gain in (-30.0, 2.0, 6.0, 9.0)]
    assert np.allclose(doubts[0][:2, :2], plane.covariance, rtol=1e-3)
    for less, more in pairwise(doubts):
        assert np.linalg.eigvalsh(more - less).min() > -1e-12
    apart = surface.figures - plane.surface.figures
    half = 0.5 * bowed.covariance + 0.25 * np.outer(apart, apart)
    half[:2, :2] += 0.5 * plane.covariance
    assert np.allclose(doubts[-1], half)
