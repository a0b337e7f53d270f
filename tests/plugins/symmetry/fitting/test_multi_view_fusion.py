"""Several views of one curve: never worse than the best of them, better than each."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.fitting.multi_view_fusion import Estimate, fuse
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import pair_covariances
from tests.plugins.symmetry.scenes import (
    DIAGONAL,
    LOOPS,
    PAIRS,
    camera,
    distances,
    drawn,
    tremor,
)

Array = np.ndarray


def seen(
    curve: Array, azimuth: float, elevation: float, seed: int, *, closed: bool = False
) -> Estimate:
    """What one view with a pixel of noise says: both rays of every place, met in space."""
    stereo, random = Stereo(camera(azimuth, elevation)), np.random.default_rng(seed)
    near = drawn(curve, stereo.camera)
    far = drawn(curve * MIRROR, stereo.camera)
    ahead, behind = np.roll(far, -1, axis=0), np.roll(far, 1, axis=0)
    tangents = ahead - behind if closed else np.gradient(far, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    covariances = pair_covariances(stereo, near, far, tangents)
    # The first order of what the noise does: a step in the direction that the eye is blind
    # in, and one across.
    stretch, axes = np.linalg.eigh(covariances)
    for column in range(3):  # neighbouring places err alike
        signs = np.ones(len(axes))
        turned = np.einsum("ni,ni->n", axes[1:, :, column], axes[:-1, :, column]) < 0
        signs[1:] = np.cumprod(np.where(turned, -1.0, 1.0))
        axes[:, :, column] *= signs[:, None]
    noise = np.hstack([tremor(len(curve), 1.0, random, closed=closed) for _ in "ab"])[:, :3]
    wrong = np.einsum("nij,nj->ni", axes, np.sqrt(np.maximum(stretch, 0.0)) * noise)
    return Estimate(curve + wrong, covariances)


def error(points: Array, curve: Array, *, closed: bool = False) -> float:
    """Root mean square distance from the truth, % of the diagonal, without the worst tenth."""
    apart = np.sort(distances(points, curve, closed=closed))[: round(0.9 * len(points))]
    return 100.0 * float(np.sqrt((apart**2).mean())) / DIAGONAL


VIEWS = [((30, 20), (60, 20)), ((3, 20), (40, 20)), ((20, 5), (20, 70)), ((60, 20), (-40, 30))]


@pytest.mark.parametrize("views", VIEWS)
def test_two_views_are_as_good_as_the_better_one_and_mostly_better(
    views: tuple[tuple[float, float], ...],
) -> None:
    singles, both = [], []
    for curve in PAIRS.values():
        for seed in range(6):
            told = [seen(curve, *view, 10 * seed + k) for k, view in enumerate(views)]
            singles.append([error(estimate.points, curve) for estimate in told])
            both.append(error(fuse(told).points, curve))
    first, second = np.median(singles, axis=0)
    assert np.median(both) <= 1.05 * min(first, second)
    assert np.mean(np.array(both) <= 1.05 * np.min(singles, axis=1)) > 0.7


def test_views_that_complement_each_other_beat_each() -> None:
    curve, singles, both = PAIRS["S-wave"], [], []
    for seed in range(10):
        told = [seen(curve, 30, 5, 2 * seed), seen(curve, 40, 60, 2 * seed + 1)]
        singles.append([error(estimate.points, curve) for estimate in told])
        both.append(error(fuse(told).points, curve))
    assert np.median(both) < 0.9 * np.median(singles, axis=0).min()


@pytest.mark.parametrize("azimuth", [1, 3, 6])
def test_a_bad_view_does_not_ruin_a_good_one(azimuth: float) -> None:
    for name in ("hook", "wheel arch", "roof rail"):
        for seed in range(4):
            good = seen(PAIRS[name], 40, 20, 2 * seed)
            bad = seen(PAIRS[name], azimuth, 20, 2 * seed + 1)
            # The good view alone, at the places at which views are combined.
            alone = fuse([good, Estimate(good.points, 1e6 * good.covariances)])
            limit = 1.05 * error(alone.points, PAIRS[name])
            assert error(fuse([bad, good]).points, PAIRS[name]) < limit


def test_sense_and_order_do_not_matter() -> None:
    curve = PAIRS["S-wave"]
    one, other = seen(curve, 30, 20, 0), seen(curve, 60, 20, 1)
    turned = Estimate(other.points[::-1], other.covariances[::-1])
    plain = fuse([one, other])
    for told in ([one, turned], [other, one], [turned, one]):
        made = fuse(told)
        apart = distances(made.points, plain.points)
        assert np.median(apart) < 0.0005 * DIAGONAL
        assert apart.max() < 0.01 * DIAGONAL


def test_where_a_loop_begins_does_not_matter() -> None:
    curve = LOOPS["bean"]
    one, other = (seen(curve, az, 20, az, closed=True) for az in (30, 60))
    rolled = Estimate(np.roll(other.points, 70, axis=0), np.roll(other.covariances, 70, axis=0))
    plain, made = fuse([one, other], closed=True), fuse([one, rolled], closed=True)
    apart = distances(made.points, plain.points, closed=True)
    assert np.median(apart) < 0.0005 * DIAGONAL
    assert apart.max() < 0.01 * DIAGONAL
    assert error(made.points, curve, closed=True) < error(one.points, curve, closed=True)


def test_equal_estimates_halve_the_variance() -> None:
    points = PAIRS["roof rail"]
    spread = np.tile(np.diag([1.0, 4.0, 9.0]), (len(points), 1, 1))
    made = fuse([Estimate(points, spread), Estimate(points, spread)])
    assert distances(made.points, points).max() < 1e-3 * DIAGONAL
    middle = made.covariances[len(made.points) // 2]
    assert np.allclose(middle, spread[0] / 2, rtol=1e-2, atol=1e-2)


def test_each_view_is_believed_where_it_knows() -> None:
    points = np.column_stack((np.linspace(0.0, 100.0, 50), np.full(50, 30.0), np.zeros(50)))
    sure_of_y = np.tile(np.diag([1.0, 1e-2, 1e2]), (50, 1, 1))
    sure_of_z = np.tile(np.diag([1.0, 1e2, 1e-2]), (50, 1, 1))
    made = fuse(
        [
            Estimate(points + np.array((0, 0, 5)), sure_of_y),
            Estimate(points + np.array((0, 5, 0)), sure_of_z),
        ]
    )
    assert np.abs(made.points[:, 1:] - (30, 0)).max() < 0.01


def test_contradictions_make_it_less_sure() -> None:
    points = PAIRS["roof rail"]
    spread = np.tile(0.01 * np.eye(3), (len(points), 1, 1))
    agreed = fuse([Estimate(points, spread), Estimate(points, spread)])
    argued = fuse([Estimate(points, spread), Estimate(points + np.array((0, 3, 0)), spread)])
    assert np.trace(argued.covariances[50]) > 10 * np.trace(agreed.covariances[50])


def test_a_view_of_more_of_the_curve_leads_it_on() -> None:
    curve = PAIRS["roof rail"]
    spread = np.tile(np.eye(3), (len(curve), 1, 1))
    part = Estimate(curve[100:200], 0.1 * spread[100:200])
    for whole in (Estimate(curve, spread), Estimate(curve[::-1], spread)):
        made = fuse([part, whole]).points
        assert distances(curve, made).max() < 0.005 * DIAGONAL
        assert distances(made, curve).max() < 0.005 * DIAGONAL


def test_one_view_stays_as_it_is_and_no_numbers_are_left_out() -> None:
    curve = PAIRS["hook"]
    one = seen(curve, 30, 20, 0)
    assert fuse([one]) is one
    points, spread = one.points.copy(), one.covariances.copy()
    points[40:50], spread[60:70] = np.nan, np.inf
    made = fuse([Estimate(points, spread), seen(curve, 60, 20, 1)])
    assert np.isfinite(made.points).all()
    assert np.isfinite(made.covariances).all()
    nothing = Estimate(np.full((3, 3), np.nan), np.full((3, 3, 3), np.nan))
    assert np.isfinite(fuse([nothing, one]).points).all()
