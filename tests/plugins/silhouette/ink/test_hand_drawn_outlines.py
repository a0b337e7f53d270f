"""Outlines as hands and mice draw them: calm, with the corners that were drawn, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, Strokes, resample
from bozzetto.testing import Pen
from bozzetto_silhouette.ink.jitter_filter import ROUNDED_BY, ROUNDING, filtered
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.from_ink import outline_of
from tests.plugins.silhouette.ink.hand_drawn import (
    Hand,
    corners_missed,
    drawn_after,
    turns,
    unrest,
)
from tests.plugins.silhouette.outlines import COMMITTED, svg_rings

PEN = Pen()
TURN = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
EGG = np.column_stack((610.0 + 310.0 * np.cos(TURN), 450.0 + 230.0 * np.sin(TURN)))
STAR = np.array([
    (600.0 + r * np.cos(a), 450.0 + r * np.sin(a))
    for r, a in zip([310.0, 190.0] * 6, np.linspace(0.0, 2.0 * np.pi, 13), strict=False)
])  # fmt: skip


def outline(lines: list[Array]) -> Array:
    """The outline of strokes as a device gave them, px."""
    strokes = Strokes(tuple(Stroke(*line.T, PEN.camera) for line in lines))
    part = Part(strokes=strokes)
    (ring,) = outline_of(part).rings
    return PEN.camera.project(part.sheet.to_world(ring))[0]


@pytest.mark.parametrize("scale", [1.0, 1.25, 2.0])
def test_ink_of_a_mouse_is_as_calm_as_that_of_a_pen(scale: float) -> None:
    """On a screen with so many pixels for one."""
    found: dict[float, list[float]] = {}
    for grain in (0.01, 1.0 / scale):
        for seed in range(73_000, 73_012):
            random = np.random.default_rng(seed)
            meant, lines = drawn_after(random, EGG, Hand(tremor=0.3, grain=grain))
            found.setdefault(grain, []).append(unrest(meant, outline(lines)))
    pen, mouse = (np.array(each) for each in found.values())
    assert np.median(mouse) < 1.1
    assert np.median(mouse) < np.median(pen) + 0.05


def test_without_knowing_the_grain_it_would_not_be() -> None:
    calm, wrinkled = [], []
    for seed in range(73_100, 73_110):
        random = np.random.default_rng(seed)
        meant, lines = drawn_after(random, EGG, Hand(tremor=0.0, grain=1.0))
        calm.append(unrest(meant, rings_from_strokes(lines, grain=1.0)[0]))
        wrinkled.append(unrest(meant, rings_from_strokes(lines, by_hand=False)[0]))
    assert np.median(wrinkled) > 1.2 > 1.1 > np.median(calm)


def test_what_stands_out_of_the_grain_stays() -> None:
    """A tooth of 3 px on an edge, and the corners of a star."""
    size = 620.0
    teeth = resample(EGG, spacing=3.0, closed=True)
    teeth[::40] += (0.0, 3.0)
    ring = np.round(teeth) / size
    calm = filtered(ring, grain=1.0 / size)
    gap = np.hypot(*(ring[:, None] - calm[None]).transpose(2, 0, 1)).min(axis=1)
    assert gap.max() * size < ROUNDED_BY * ROUNDING + 0.5
    for seed in range(73_200, 73_206):
        meant, lines = drawn_after(np.random.default_rng(seed), STAR, Hand(grain=1.0))
        corners, lost, added = corners_missed(meant, outline(lines))
        assert corners == 6
        assert (lost, added) == (0, 0)


def test_polygons_of_whole_pixels_stay_exact() -> None:
    """A drawing of another program may have them."""
    for corners in (
        STAR.round(),
        np.array(((0.0, 0.0), (300.0, 0.0), (300.0, 200.0), (0.0, 200.0))),
    ):
        for line in (corners, resample(corners, spacing=10.0, closed=True).round()):
            closed = np.vstack((line, line[:1]))
            (plain,) = rings_from_strokes([closed])
            (known,) = rings_from_strokes([closed], grain=1.0)
            if line is corners:
                assert {tuple(p) for p in known.round(6)} == {tuple(p) for p in corners}
            gap = np.hypot(*(plain[:, None] - known[None]).transpose(2, 0, 1)).min(axis=1)
            assert gap.max() < ROUNDED_BY * ROUNDING


def test_a_round_end_that_does_not_quite_close_gets_no_spike() -> None:
    """Its two ends head for anywhere: where they would cross is no corner."""
    turn = np.linspace(0.0, np.pi, 60)
    end = np.column_stack((36.0 * np.sin(turn), 36.0 * np.cos(turn)))
    limb = np.vstack((end + np.array((900.0, 450.0)), np.array((300.0, 450.0)) - end))
    far = []
    for seed in range(73_300, 73_380):
        random = np.random.default_rng(seed)
        begin = int(random.integers(0, 40)) - 10
        ring = resample(np.roll(limb, -begin - 20, axis=0), spacing=5.5, closed=True)
        gap = int(random.integers(2, 5))
        line = ring[: len(ring) - gap] + random.normal(0.0, 0.5, (len(ring) - gap, 2))
        line[-3:] += np.linspace(0.3, 1.0, 3)[:, None] * random.normal(0.0, 4.0, 2)
        found = outline([line])
        away = np.hypot(*(found[:, None] - ring[None]).transpose(2, 0, 1)).min(axis=1)
        far.append(away.max())
    assert max(far) < 20.0  # the limb is 72 px wide
    assert np.mean(np.array(far) > 10.0) < 0.1


def test_a_short_stroke_over_a_joint_leaves_no_nick() -> None:
    for seed in range(73_400, 73_420):
        random = np.random.default_rng(seed)
        ring = resample(EGG, spacing=5.0, closed=True)
        half = len(ring) // 2
        lines = [
            ring[: half + 1],
            np.vstack((ring[half - 1 :], ring[:1])),
            ring[half - 2 : half + 3],
        ]
        lines = [line + random.normal(0.0, 0.3, line.shape) + random.normal(0.0, 1.0, 2)
                 for line in lines]  # fmt: skip
        assert turns(outline(lines))[0].max() < 30.0


def test_ends_that_pass_each_other_before_a_corner_leave_no_step() -> None:
    """A smooth joint finds too little ink there."""
    corners = np.array(((300.0, 200.0), (900.0, 200.0), (700.0, 700.0), (300.0, 700.0)))
    ring = resample(corners, spacing=1.0, closed=True)
    for seed in range(73_500, 73_560):
        random = np.random.default_rng(seed)
        line = np.roll(ring, int(random.integers(22, 30)) - 600, axis=0)
        line = np.vstack((line, line[: int(random.integers(3, 6))]))
        line = resample(line, spacing=random.uniform(5.0, 7.0))
        beside = random.choice((-1.0, 1.0)) * random.uniform(1.6, 2.6)
        line[-10:] += np.linspace(0.0, 1.0, 10)[:, None] ** 2 * (0.0, beside)
        found = outline([line + random.normal(0.0, 0.1, line.shape)])
        assert corners_missed(ring, found)[1:] == (0, 0)


def test_ends_that_meet_beside_the_tip_of_a_limb_leave_it_as_it_is() -> None:
    """Of a step between them nothing is cut off: what is left would take the tip with it."""
    (ring,) = svg_rings(COMMITTED / "horse_skimage.svg")
    ring = (ring - ring.min(axis=0)) * 620.0 / np.ptp(ring, axis=0).max() + (290.0, 140.0)
    for seed in range(124, 136):
        meant, lines = drawn_after(np.random.default_rng(seed), ring, Hand(tremor=0.3))
        ink, found = (
            np.hypot(*(meant[:, None][::4] - line[None]).transpose(2, 0, 1)).min(axis=1).max()
            for line in (np.concatenate(lines), outline(lines))
        )
        assert found < ink + 1.5, seed
