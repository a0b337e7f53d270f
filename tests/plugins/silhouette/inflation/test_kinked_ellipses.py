"""A slip of the pen must not flatten the end of an ellipse, and a flat end must be reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights, HeightModel
from bozzetto_silhouette.inflation.variational_relief import VariationalHeights
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from tests.plugins.silhouette.inflation.kinked_ellipses import (
    LONG,
    SHORT,
    ellipse,
    end_shares,
    inflated,
    slipped,
    trembling,
)
from tests.plugins.silhouette.ink.hand_drawn import ellipse as by_hand

VOLUME = 4.0 / 3.0 * np.pi * 60.0 * 30.0 * 30.0


@pytest.mark.parametrize("heights", [VariationalHeights(), ConvolutionHeights()])
def test_an_ellipse_stays_round_whatever_slips(heights: HeightModel) -> None:
    for points in (*slipped(3, 6), *trembling(3, 3)):
        solid = inflated(points, heights)
        if isinstance(heights, VariationalHeights):
            assert min(end_shares(solid)) > 0.75
        found = measure(solid)
        assert found.volume == pytest.approx(VOLUME, rel=0.06)
        assert found.flattest > 0.85


def test_the_report_tells_of_a_flat_end() -> None:
    solid = inflated(ellipse()[0], ConvolutionHeights())
    whole = measure(solid)
    assert whole.flattest > 0.9
    x = solid.plan.points[:, 0]
    pressed = np.where(x > 40.0, 0.33, 1.0)
    flat = replace(solid, front=solid.front * pressed, back=solid.back * pressed)
    assert measure(flat).flattest < 0.7 * whole.flattest
    assert measure(flat).iou == whole.iou


@pytest.mark.parametrize("high", [1.0, 0.97, 0.9])
def test_a_disc_is_flat_nowhere(high: float) -> None:
    points = ellipse(90)[0] * (30.0 / LONG, 30.0 / SHORT * high)
    assert 0.95 < measure(inflated(points, ConvolutionHeights())).flattest < 1.1


def test_a_disc_by_hand_is_flat_nowhere() -> None:
    for seed in range(4):
        (ring,) = rings_from_strokes([by_hand(np.random.default_rng(seed), 0.5)])
        assert measure(inflated(ring, ConvolutionHeights())).flattest > 0.9


@pytest.mark.parametrize("at", [2, 157, 79])
def test_a_spike_beside_an_end_does_not_pull_it_down(at: int) -> None:
    """The axis runs on into it, past balls that get no constraint of their own."""
    points, normal = ellipse()
    points[at] += 1.15 * normal[at]
    solid = inflated(points, VariationalHeights())
    assert min(end_shares(solid)) > 0.85
    assert measure(solid).flattest > 0.9
