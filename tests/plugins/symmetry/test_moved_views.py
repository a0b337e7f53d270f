"""Sides that are drawn while a parallel view is moved over the sheet and enlarged."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.ink import Stroke, on_canvas
from bozzetto.view import Camera
from bozzetto.view.navigation import pan, zoom
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_strokes
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.erase import erase
from tests.plugins.symmetry import scenes as s

VIEW = s.camera(35, 20, "orthographic")


def _stroke(curve: np.ndarray, seed: int) -> Stroke:
    pixels = s.drawn(curve, VIEW, noise=0.7, random=np.random.default_rng(seed))
    return Stroke(pixels[:, 0], pixels[:, 1], VIEW)


def _moved(chance: np.random.Generator) -> Camera:
    camera = pan(VIEW, *chance.uniform(-200.0, 200.0, 2))
    return zoom(
        camera, float(np.exp(chance.uniform(-1.0, 1.5))), tuple(chance.uniform(100, 800, 2))
    )


@pytest.mark.parametrize("name", list(s.PAIRS))
def test_a_pair_is_the_same_whatever_part_of_the_sheet_was_shown(name: str) -> None:
    side, chance = s.PAIRS[name], np.random.default_rng(12001)
    ink = [_stroke(side, 12002), _stroke(side * MIRROR, 12003), _stroke(side, 12004)]
    still = moved = SymmetryState()
    for number, stroke in enumerate(ink):
        still = add_strokes(still, (stroke,))
        moved = add_strokes(moved, (on_canvas(stroke, _moved(chance)) if number else stroke,))
    assert len(still.curves) == len(moved.curves) == 1
    here, there = (trace_of(state.curves[0], state) for state in (still, moved))
    assert here.reading == there.reading == "pair"
    assert np.abs(here.points - there.points).max() < 1e-4 * s.DIAGONAL


def test_the_eraser_takes_waiting_ink_in_an_enlarged_view() -> None:
    stroke = _stroke(s.PAIRS["roof rail"], 12005)
    state = add_strokes(SymmetryState(), (stroke,))
    rubbed = on_canvas(stroke, zoom(VIEW, 2.5, (500.0, 400.0)))
    assert not erase(state, rubbed).curves
