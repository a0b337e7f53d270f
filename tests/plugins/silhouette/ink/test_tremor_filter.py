"""Tremor: waves of a hand that neighbouring samples do not tell."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, Strokes, resample
from bozzetto.testing import Pen
from bozzetto_silhouette.ink.jitter_filter import UNNOTICED, noise_of
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from bozzetto_silhouette.ink.tremor_filter import tremor_of, without_tremor
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.from_ink import outline_of
from tests.plugins.silhouette.ink.hand_drawn import (
    Hand,
    corners_missed,
    drawn_after,
    turning,
    unrest,
)

STAR = np.array([
    (0.5 + r * np.sin(a), 0.5 - r * np.cos(a))
    for k in range(10)
    for r, a in [((0.5, 0.22)[k % 2], np.pi * k / 5.0)]
])  # fmt: skip
TURNS = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
PEAR = np.column_stack((
    0.5 + (0.26 + 0.1 * np.sin(TURNS)) * np.cos(TURNS), 0.5 - 0.48 * np.sin(TURNS)
))  # fmt: skip
SIZE = 520.0


def drawn(ring: Array, seed: int, **hand: float) -> tuple[Array, list[Array]]:
    """Return an outline 520 px long as it was meant, and its ink."""
    still = {"tremor": 0.0, "drift": 0.0, "grain": 0.01, "miss": 3.0, "pace": 0.4}
    random = np.random.default_rng(seed)
    return drawn_after(random, ring * SIZE + 100.0, Hand(**(still | hand)))  # type: ignore[arg-type]


@pytest.mark.parametrize("rate", [60.0, 120.0, 200.0])
def test_waves_go_however_often_samples_are_taken(rate: float) -> None:
    calm, as_drawn = [], []
    for seed in range(84_000, 84_008):
        meant, lines = drawn(PEAR, seed, waves=0.6, rate=rate)
        calm.append(unrest(meant, rings_from_strokes(lines)[0]))
        as_drawn.append(unrest(meant, rings_from_strokes(lines, by_hand=False)[0]))
    assert np.median(as_drawn) > 1.45
    assert np.median(calm) < 1.2


def test_a_calmer_outline_is_nearer_to_the_one_meant() -> None:
    """Not just smoother: what goes is what the hand added."""
    import shapely

    nearer = []
    for seed in range(84_100, 84_112):
        meant, lines = drawn(PEAR, seed, waves=0.8, rate=200.0)
        misses = [
            shapely.symmetric_difference(
                shapely.Polygon(meant),
                shapely.Polygon(rings_from_strokes(lines, by_hand=hand)[0]),
            ).area
            for hand in (True, False)
        ]
        nearer.append(misses[0] / misses[1])
    assert np.median(nearer) < 0.95


def test_corners_stand() -> None:
    counts = np.zeros(3, int)
    for seed in range(84_200, 84_210):
        meant, lines = drawn(STAR, seed, waves=0.6, rate=200.0)
        counts += corners_missed(meant, rings_from_strokes(lines)[0])
    corners, lost, added = counts
    assert corners == 50
    assert lost <= 1
    assert added == 0


def test_neighbouring_samples_tell_no_jitter() -> None:
    """Why a second filter is needed."""
    _, lines = drawn(PEAR, 84_300, waves=0.6, rate=200.0)
    ring = lines[0] / SIZE
    assert noise_of(ring) < 0.5 * UNNOTICED
    assert 0.3 * 0.6 / SIZE < tremor_of(ring) < 1.5 * 0.6 / SIZE


@pytest.mark.parametrize("ring", [STAR, PEAR], ids=["star", "pear"])
def test_a_still_hand_is_left_alone(ring: Array) -> None:
    smooth = resample(ring, spacing=0.004, closed=True)
    assert without_tremor(smooth) is smooth
    assert without_tremor(ring) is ring


def test_a_small_ring_tells_no_tremor() -> None:
    """A button of a figure: its form is as small as the waves would be."""
    button = 0.05 * np.column_stack((np.cos(TURNS), np.sin(TURNS)))
    bent = button * (1.0 + 0.02 * np.sin(9.0 * TURNS))[:, None]
    assert without_tremor(bent) is bent


def test_curves_of_a_file_are_as_they_were() -> None:
    """A line that waves by intent, as a cloud does finely."""
    waves = PEAR * (1.0 + 0.004 * np.sin(60.0 * TURNS))[:, None] * SIZE + 100.0
    pen = Pen()
    turned = []
    for tool in ("imported", "pen"):
        stroke = Stroke(*np.vstack((waves, waves[:1])).T, pen.camera, tool=tool)  # type: ignore[arg-type]
        (ring,) = outline_of(Part(strokes=Strokes((stroke,)))).rings
        turned.append(turning(ring))
    assert turned[0] == pytest.approx(turning(waves), rel=1e-3)
    assert turned[1] < 0.9 * turned[0]
