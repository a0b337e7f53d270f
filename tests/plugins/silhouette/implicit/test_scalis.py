"""The kernel and the weights against independent oracles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import nnls

from bozzetto_silhouette.implicit.scalis import (
    Segments,
    iso_value,
    pairs_within_reach,
    segment_integrals,
)
from bozzetto_silhouette.implicit.weight_fit import non_negative_least_squares
from bozzetto_silhouette.outline.medial_axis import Skeleton


@pytest.mark.parametrize("sigma", [1.25, 1.4, 2.0])
def test_iso_value_is_the_integral_over_an_endless_cylinder(sigma: float) -> None:
    limit = np.sqrt(sigma**2 - 1)
    exact, _ = quad(lambda s: (1 - (1 + s * s) / sigma**2) ** 3, -limit, limit)
    assert iso_value(sigma) == pytest.approx(exact, rel=1e-12)


def _oracle(p: np.ndarray, z2: float, segments: Segments, k: int) -> float:
    def kernel(t: float) -> float:
        tau = segments.radius[k] + segments.slope[k] * t
        q = segments.start[k] + t * segments.direction[k]
        r2 = float(((p - q) ** 2).sum()) + z2
        return max(0.0, 1.0 - r2 / (segments.sigma * tau) ** 2) ** 3 / tau

    return quad(kernel, 0.0, segments.length[k], limit=400, epsabs=1e-11)[0]


def test_integral_against_quadrature() -> None:
    random = np.random.default_rng(1)
    worst = 0.0
    for _ in range(12):
        nodes = np.column_stack([random.uniform(-1, 1, (2, 2)), random.uniform(0.1, 0.6, 2)])
        segments = Segments.of(Skeleton(nodes, np.array([[0, 1]])), 1.4, 1e-3)
        xy = random.uniform(-1.5, 1.5, (25, 2))
        z2 = random.uniform(0.0, 0.3, 25)
        pairs = pairs_within_reach(xy, segments)
        value, _ = segment_integrals(segments, pairs, z2)
        found = np.zeros(25)
        found[pairs.point] = value
        exact = [_oracle(p, h, segments, 0) for p, h in zip(xy, z2, strict=True)]
        worst = max(worst, float(np.abs(found - exact).max()))
    assert worst < 5e-6


def test_derivative_by_the_squared_height() -> None:
    nodes = np.array([[0.0, 0.0, 0.3], [1.0, 0.0, 0.2]])
    segments = Segments.of(Skeleton(nodes, np.array([[0, 1]])), 1.4, 1e-3)
    xy = np.array([[0.5, 0.05], [0.1, 0.1], [0.9, -0.1]])
    pairs = pairs_within_reach(xy, segments)
    z2, h = np.array([0.01, 0.02, 0.005]), 2e-3
    _, slope = segment_integrals(segments, pairs, z2, slope=True)
    ahead, _ = segment_integrals(segments, pairs, z2 + h)
    back, _ = segment_integrals(segments, pairs, z2 - h)
    assert slope == pytest.approx((ahead - back) / (2 * h), rel=5e-3)


def test_no_pair_is_missed() -> None:
    random = np.random.default_rng(2)
    nodes = np.column_stack([random.uniform(0, 1, (30, 2)), random.uniform(0.01, 0.1, 30)])
    edges = np.column_stack([np.arange(29), np.arange(1, 30)])
    segments = Segments.of(Skeleton(nodes, edges), 1.4, 1e-3)
    xy = random.uniform(-0.2, 1.2, (300, 2))
    found = np.zeros((300, 29))
    pairs = pairs_within_reach(xy, segments)
    found[pairs.point, pairs.segment] = segment_integrals(segments, pairs)[0]
    exact = np.array([[_oracle(p, 0.0, segments, k) for k in range(29)] for p in xy[:40]])
    assert np.abs(found[:40] - exact).max() < 1e-4 * exact.max()
    assert (np.diff(pairs.point) >= 0).all()


def test_block_pivoting_is_non_negative_least_squares() -> None:
    random = np.random.default_rng(0)
    for count in (1, 4, 40, 90):
        for _ in range(5):
            a, b = random.normal(size=(2 * count, count)), random.normal(size=2 * count)
            exact, _ = nnls(a, b)
            assert non_negative_least_squares(a.T @ a, a.T @ b) == pytest.approx(exact, abs=1e-7)
