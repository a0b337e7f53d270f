"""Blends on closed forms: what they promise, and what the usual ones do instead."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from bozzetto_silhouette.implicit.blend import flipped, smooth_maximum, summed
from bozzetto_silhouette.implicit.implicit_solid import Sample

Points = NDArray[np.float64]
Blend = Callable[[Sample, Sample, float], Sample]

RADIUS, REACH = 0.3, 0.3
POINTS = np.random.default_rng(3).uniform(-1.5, 1.5, (3000, 3))


def capsule(points: Points, start: tuple, end: tuple, radius: float = RADIUS) -> Sample:
    a, b = np.array(start, float), np.array(end, float)
    along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    away = points - (a + along[:, None] * (b - a))
    length = np.linalg.norm(away, axis=1)
    return Sample(radius - length, -away / np.maximum(length, 1e-300)[:, None])


def left(points: Points) -> Sample:
    return capsule(points, (-1.0, 0, 0), (0.4, 0, 0))


def right(points: Points) -> Sample:
    return capsule(points, (-0.4, 0, 0), (1.0, 0, 0))


def upright(points: Points) -> Sample:
    return capsule(points, (0, 0, 0), (0, 1.4, 0))


def plain_smooth_maximum(a: Sample, b: Sample, k: float) -> Sample:
    excess = np.maximum(k - np.abs(a.value - b.value), 0.0)
    return Sample(np.maximum(a.value, b.value) + excess**2 / (4 * k), a.gradient)


def pasko(a: Sample, b: Sample, k: float) -> Sample:
    union = a.value + b.value + np.hypot(a.value, b.value)
    return Sample(union + 0.5 * k / (1 + (a.value / k) ** 2 + (b.value / k) ** 2), a.gradient)


def compact(a: Sample, b: Sample, k: float) -> Sample:
    union = a.value + b.value + np.hypot(a.value, b.value)
    r2 = np.minimum((a.value / k) ** 2 + (b.value / k) ** 2, 1.0)
    return Sample(union + 0.5 * k * (1 - r2) ** 3 / (1 + r2), a.gradient)


def height(blend: Blend, first, second, way: tuple[float, float, float]) -> float:
    """Where the surface is on a ray from the origin, in radii."""

    def value(t: float) -> float:
        point = t * np.array([way])
        return float(blend(first(point), second(point), REACH).value[0])

    return float(brentq(value, 0.5 * RADIUS, 4.0 * RADIUS)) / RADIUS


def test_no_bulge_where_limbs_overlap_in_line() -> None:
    assert height(smooth_maximum, left, right, (0, 1, 0)) == pytest.approx(1.0, abs=0.02)
    assert height(smooth_maximum, left, right, (0, 0.6, 0.8)) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("other", [plain_smooth_maximum, pasko, compact, summed])
def test_the_usual_blends_do_bulge(other: Blend) -> None:
    assert height(other, left, right, (0, 1, 0)) > 1.15


def test_the_back_of_a_junction_stays_flat() -> None:
    assert height(smooth_maximum, left, upright, (0, -1, 0)) == pytest.approx(1.0, abs=0.05)
    assert height(smooth_maximum, left, upright, (0, 0, 1)) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("blend", [smooth_maximum, summed])
class TestLaws:
    def test_order_does_not_matter(self, blend: Blend) -> None:
        one = blend(left(POINTS), upright(POINTS), REACH)
        other = blend(upright(POINTS), left(POINTS), REACH)
        assert np.allclose(one.value, other.value)
        assert np.allclose(one.gradient, other.gradient)

    def test_never_less_than_the_union(self, blend: Blend) -> None:
        a, b = left(POINTS), upright(POINTS)
        assert (blend(a, b, REACH).value >= np.maximum(a.value, b.value) - 1e-12).all()

    def test_a_small_reach_is_the_union(self, blend: Blend) -> None:
        a, b = left(POINTS), upright(POINTS)
        union = np.maximum(a.value, b.value)
        result = blend(a, b, 1e-9).value
        assert np.array_equal(result > 1e-8, union > 1e-8)
        outside = np.minimum(a.value, b.value) < 0.0
        assert result[outside] == pytest.approx(union[outside], abs=1e-8)

    def test_far_from_one_of_them_the_other_is_as_it_was(self, blend: Blend) -> None:
        a, b = left(POINTS), upright(POINTS)
        far = (b.value < -REACH) & (a.value > b.value + REACH)
        result = blend(a, b, REACH)
        assert far.sum() > 100
        assert np.array_equal(result.value[far], a.value[far]) or np.allclose(
            result.value[far], a.value[far], atol=1e-14
        )
        assert np.allclose(result.gradient[far], a.gradient[far])

    def test_everything_scales(self, blend: Blend) -> None:
        a, b = left(POINTS), upright(POINTS)
        small = [Sample(1e-3 * s.value, s.gradient) for s in (a, b)]
        assert blend(*small, 1e-3 * REACH).value == pytest.approx(
            1e-3 * blend(a, b, REACH).value, rel=1e-9, abs=1e-15
        )

    def test_the_gradient_points_where_the_value_grows(self, blend: Blend) -> None:
        def value(points: Points) -> Points:
            return blend(left(points), upright(points), REACH).value

        h = 1e-6
        numeric = np.stack(
            [(value(POINTS + h * e) - value(POINTS - h * e)) / (2 * h) for e in np.eye(3)], axis=1
        )
        result = blend(left(POINTS), upright(POINTS), REACH)
        near = np.abs(result.value) < 0.05
        lengths = np.linalg.norm(numeric, axis=1) * np.linalg.norm(result.gradient, axis=1)
        cosine = (numeric * result.gradient).sum(axis=1)[near] / lengths[near]
        assert np.quantile(cosine, 0.02) > 0.95

    def test_hostile_values_stay_finite(self, blend: Blend) -> None:
        value = np.array([0.0, 1e-300, -1e-300, 1e12, -1e12, 1.0])
        for shift in range(len(value)):
            a = Sample(value, np.zeros((6, 3)))
            b = Sample(np.roll(value, shift), np.zeros((6, 3)))
            result = blend(a, b, 1e-3)
            assert np.isfinite(result.value).all()
            assert np.isfinite(result.gradient).all()


def test_flipped_twice_is_the_same() -> None:
    a = left(POINTS)
    twice = flipped(flipped(a))
    assert np.array_equal(twice.value, a.value)
    assert np.array_equal(twice.gradient, a.gradient)
