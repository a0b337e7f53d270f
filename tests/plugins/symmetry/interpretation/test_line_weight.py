"""Line weight as evidence of how loops stand: it helps, seldom harms, and is silent without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_symmetry.ink.sides import Side, sides_of
from bozzetto_symmetry.interpretation.line_weight import weight_prices
from bozzetto_symmetry.interpretation.side_pairing import pairings
from bozzetto_symmetry.interpretation.stereo_triangulation import triangulate
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.stereo.correspondence import Pairing
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from tests.plugins.symmetry import figures_loops as f
from tests.plugins.symmetry import scenes as s

Drawn = tuple[Stereo, tuple[Pairing, ...], Side, Side, int]


def drawn(seed: int, weight: float) -> Drawn:
    """Both loops with pressure, their matchings, and the number of the one that is right."""
    random = np.random.default_rng(seed)
    side = f.loop("ellipses", "anywhere", random)
    strokes, side = f.strokes_of(side, 1.0, False, random, weight=weight)
    stereo = Stereo.of(strokes[0].camera, SymmetryState().plane)
    one, other = sides_of(strokes, apart=True)
    found = pairings(stereo, one.pixels, other.pixels, closed=True)
    off = [
        min(
            np.median(s.distances(triangulate(stereo, each).points * way, side, closed=True))
            for way in (np.ones(3), s.MIRROR)
        )
        for each in found
    ]
    return stereo, found, one, other, int(np.argmin(off))


def for_the_right(weight: float, seeds: range) -> np.ndarray:
    gains = []
    for seed in seeds:
        stereo, found, one, other, right = drawn(seed, weight)
        prices = weight_prices(stereo, found, one, other)
        gains.append(min(price for k, price in enumerate(prices) if k != right) - prices[right])
    return np.array(gains)


def test_a_hand_that_presses_harder_on_what_is_nearer_is_read_as_it_means() -> None:
    gains = for_the_right(0.25, range(700, 708))
    assert (gains > 0.1).mean() > 0.4
    assert (gains < 0.0).mean() < 0.1


def test_a_hand_without_line_weight_is_rarely_misunderstood() -> None:
    gains = for_the_right(0.0, range(700, 708))
    assert (gains < 0.0).mean() < 0.25


def test_without_pressure_nothing_is_said() -> None:
    stereo, found, one, other, _ = drawn(700, 0.25)
    silent = replace(one, pressure=None)
    assert weight_prices(stereo, found, silent, other) == (0.0,) * len(found)
    flat = [replace(side, pressure=np.full(len(side.pixels), 0.5)) for side in (one, other)]
    assert weight_prices(stereo, found, *flat) == (0.0,) * len(found)


def test_how_firm_the_pen_is_as_a_whole_changes_nothing() -> None:
    for seed in range(700, 703):
        stereo, found, one, other, _ = drawn(seed, 0.25)
        assert one.pressure is not None
        assert other.pressure is not None
        light = replace(one, pressure=0.3 * one.pressure)
        firm = replace(other, pressure=1.4 * other.pressure)
        before = weight_prices(stereo, found, one, other)
        assert weight_prices(stereo, found, light, firm) == pytest.approx(before, abs=1e-9)


def test_the_weight_of_a_line_turned_round_speaks_for_the_other_sense() -> None:
    told = 0
    for seed in range(700, 708):
        stereo, found, one, other, right = drawn(seed, 0.25)
        wrong = [
            replace(side, pressure=2.0 * side.pressure.mean() - side.pressure)
            for side in (one, other)
            if side.pressure is not None
        ]
        prices = weight_prices(stereo, found, one, other)
        turned = weight_prices(stereo, found, *wrong)
        told += max(prices) > 0.0
        assert turned[right] >= prices[right]
    assert told > 2
