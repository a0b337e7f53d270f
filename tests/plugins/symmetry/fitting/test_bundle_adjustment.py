"""The spline fitted to all ink, against the curves that were drawn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto_symmetry.fitting.bundle_adjustment import Adjusted, Sight, adjust_bundle
from bozzetto_symmetry.fitting.space_curve import Reading
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import (
    LEFT,
    curve_sigmas,
    pair_covariances,
    plane_covariances,
)
from tests.plugins.symmetry.scenes import (
    ACROSS,
    DIAGONAL,
    FLAT,
    HALVES,
    LOOPS,
    PAIRS,
    RINGS,
    camera,
    distances,
    drawn,
    real_curves,
)

Array = np.ndarray


def percent(lengths: Array) -> Array:
    return 100.0 * lengths / DIAGONAL


def known(
    curve: Array, stereo: Stereo, random: np.random.Generator, pixels: float = 1.0
) -> tuple[Array, Array]:
    """Places as wrong as their covariances for so many pixels say, at most 4 % each."""
    near, far = stereo.project(curve), stereo.project(curve * MIRROR)
    tangents = np.gradient(far, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    spread = pair_covariances(stereo, near, far, tangents)
    stretch, axes = np.linalg.eigh(spread)
    slow = np.array([np.cos(np.linspace(0.0, random.uniform(2, 9), len(curve))) for _ in "xyz"])
    wrong = np.einsum("nij,nj->ni", axes, pixels * np.sqrt(np.maximum(stretch, 0.0)) * slow.T)
    size = np.linalg.norm(wrong, axis=1, keepdims=True)
    return curve + wrong * np.minimum(
        1.0, 0.04 * pixels * DIAGONAL / np.maximum(size, 1e-12)
    ), spread


def fitted(
    curve: Array,
    views: list[tuple[float, float]],
    noise: float = 0.0,
    seed: int = 0,
    *,
    reading: Reading = "pair",
    closed: bool = False,
    kind: str = "perspective",
    controls: str = "adaptive",
) -> Adjusted:
    """What the bundle makes of a pair (or a curve in the plane) drawn in some views."""
    random = np.random.default_rng(seed)
    sights = []
    for azimuth, elevation in views:
        stereo = Stereo(camera(azimuth, elevation, kind))
        pen = {"noise": noise, "random": random, "closed": closed}
        near = drawn(curve, stereo.camera, **pen)
        far = (drawn(curve * MIRROR, stereo.camera, **pen),) if reading == "pair" else ()
        sights.append(Sight(stereo, (near,), far, noise))
    first = sights[0].stereo
    if reading == "plane":
        pixels = sights[0].near[0]
        points, spread = first.on_plane(pixels), plane_covariances(first, pixels)
    else:
        points, spread = known(curve, first, random)
    return adjust_bundle(reading, points, spread, sights, closed=closed, controls=controls)


def fitted_across(
    half: Array, azimuth: float, noise: float = 0.0, seed: int = 0, *, ring: bool = False
) -> tuple[Adjusted, Array]:
    """The same of a curve across the plane, and the whole true curve."""
    random = np.random.default_rng(seed)
    stereo = Stereo(camera(azimuth, 20))
    whole = np.vstack([half[::-1], (half * MIRROR)[1 : -1 if ring else None]])
    ink = drawn(whole, stereo.camera, noise=noise, random=random, closed=ring)
    middle = len(half) - 1
    far = np.vstack([ink[middle:], ink[:1]]) if ring else ink[middle:]
    points, spread = known(half, stereo, random, max(0.1, noise))
    sight = Sight(stereo, (ink[: middle + 1][::-1],), (far,), noise)
    return adjust_bundle("self", points, spread, [sight], ring=ring), whole


def off(made: Adjusted, curve: Array, *, closed: bool = False) -> tuple[Array, Array]:
    """Distances of the fit from the truth, and of the truth from the fit, % of the diagonal."""
    there = distances(made.curve.spline.sampled(400), curve, closed=closed)
    back = cKDTree(made.curve.spline.sampled(8000)).query(curve)[0]
    return percent(there), percent(back)


# -- without noise -----------------------------------------------------------------------------


@pytest.mark.parametrize("azimuth", [10, 30, 60])
@pytest.mark.parametrize("name", PAIRS)
def test_exact_ink_gives_the_exact_pair_up_to_its_ends(name: str, azimuth: float) -> None:
    made = fitted(PAIRS[name], [(azimuth, 20)])
    for apart in off(made, PAIRS[name]):
        assert np.median(apart) < 0.05
        assert np.percentile(apart, 95) < 0.3
    ends = made.curve.spline.value(made.curve.spline.range)
    assert percent(np.linalg.norm(ends - PAIRS[name][[0, -1]], axis=1)).max() < 0.3


@pytest.mark.parametrize("name", PAIRS)
def test_exact_ink_in_parallel_views(name: str) -> None:
    made = fitted(PAIRS[name], [(30, 20)], kind="orthographic")
    for apart in off(made, PAIRS[name]):
        assert np.median(apart) < 0.05
        assert np.percentile(apart, 95) < 0.3


@pytest.mark.parametrize("name", LOOPS)
def test_exact_loops(name: str) -> None:
    made = fitted(LOOPS[name], [(30, 20)], closed=True)
    assert made.curve.closed
    for apart in off(made, LOOPS[name], closed=True):
        assert np.median(apart) < 0.05
        assert np.percentile(apart, 95) < 0.3


@pytest.mark.parametrize("azimuth", [30, 60])
@pytest.mark.parametrize("name", [*HALVES, *RINGS])
def test_exact_curves_across_the_plane(name: str, azimuth: float) -> None:
    ring = name in RINGS
    half = RINGS[name][:151] if ring else HALVES[name]
    made, whole = fitted_across(half, azimuth, ring=ring)
    assert made.curve.closed is ring
    there, back = off(made, whole, closed=ring)
    assert np.median(there) < 0.1
    assert np.median(back) < 0.1
    # Where a curve crosses the plane it runs along its epipolar line: the ink says little.
    points = made.curve.spline.sampled(400)
    assert (there < np.maximum(0.3, 1.5 * percent(foretold(made, points, azimuth)))).all()


@pytest.mark.parametrize("name", FLAT)
def test_exact_curves_in_the_plane(name: str) -> None:
    made = fitted(FLAT[name], [(60, 20)], reading="plane")
    for apart in off(made, FLAT[name]):
        assert apart.max() < 0.05
    assert (made.curve.spline.control_points[:, 1] == 0.0).all()


# -- laws --------------------------------------------------------------------------------------


def test_whole_curve_and_half_are_read_alike() -> None:
    half, stereo = HALVES["wavy bumper"], Stereo(camera(30, 20))
    whole = ACROSS["wavy bumper"]
    near, far = stereo.project(half), stereo.project(half * MIRROR)
    sight = Sight(stereo, (near,), (far,))
    none = np.zeros((len(half), 3, 3))
    one = adjust_bundle("self", half, none, [sight]).curve.spline
    for points in (whole, whole[::-1]):
        other = adjust_bundle("self", points, np.zeros((len(whole), 3, 3)), [sight]).curve.spline
        assert np.abs(one.sampled(50) - other.sampled(50)).max() < 1e-3 * DIAGONAL


@pytest.mark.parametrize("turned", [(1, -1), (-1, 1), (-1, -1)])
def test_sense_and_pieces_of_the_ink_do_not_matter(turned: tuple[int, int]) -> None:
    curve, stereo = PAIRS["S-wave"], Stereo(camera(30, 20))
    near, far = drawn(curve, stereo.camera), drawn(curve * MIRROR, stereo.camera)
    points, spread = known(curve, stereo, np.random.default_rng(1))
    one = adjust_bundle("pair", points, spread, [Sight(stereo, (near,), (far,))])
    pieces = (near[:160][:: turned[0]], near[140:][:: turned[0]])
    other = adjust_bundle("pair", points, spread, [Sight(stereo, pieces, (far[:: turned[1]],))])
    apart = one.curve.spline.sampled(100) - other.curve.spline.sampled(100)
    assert percent(np.linalg.norm(apart, axis=1)).max() < 0.1


def test_ink_beyond_what_is_matched_does_not_lead_the_curve_on() -> None:
    curve, stereo = PAIRS["hook"], Stereo(camera(30, 20))
    near, far = drawn(curve, stereo.camera), drawn(curve * MIRROR, stereo.camera)
    points, spread = known(curve, stereo, np.random.default_rng(1))
    made = adjust_bundle("pair", points[60:], spread[60:], [Sight(stereo, (near,), (far[60:],))])
    assert percent(distances(made.curve.spline.sampled(200), curve[60:])).max() < 0.5


def test_places_that_are_no_numbers_are_left_out() -> None:
    curve, stereo = PAIRS["hook"], Stereo(camera(30, 20))
    points, spread = known(curve, stereo, np.random.default_rng(1))
    points[50:60], spread[80:90] = np.nan, np.inf
    sight = Sight(stereo, (drawn(curve, stereo.camera),), (drawn(curve * MIRROR, stereo.camera),))
    made = adjust_bundle("pair", points, spread, [sight])
    assert np.median(off(made, curve)[0]) < 0.05


def test_seven_is_seven() -> None:
    made = fitted(PAIRS["S-wave"], [(30, 20)], controls="seven")
    assert len(made.curve.spline.control_points) == 7


def test_dots_and_curves_that_no_ink_shows_are_refused() -> None:
    stereo = Stereo(camera(30, 20))
    dot, line = np.zeros((5, 3)), np.column_stack([np.arange(5.0)] * 3)
    with pytest.raises(UserError, match="dot"):
        adjust_bundle("pair", dot, np.zeros((5, 3, 3)), [Sight(stereo, (stereo.project(line),))])
    with pytest.raises(UserError, match="No ink"):
        adjust_bundle("pair", line, np.zeros((5, 3, 3)), [])
    with pytest.raises(UserError, match="No ink"):
        adjust_bundle("pair", line, np.zeros((5, 3, 3)), [Sight(stereo, (np.zeros((4, 2)),))])


# -- with a hand's noise -----------------------------------------------------------------------


def foretold(made: Adjusted, points: Array, azimuth: float) -> Array:
    """How far off places of a curve may be for 1 px of noise, mm."""
    views = [Stereo(camera(azimuth, 20))]
    at = np.linspace(*made.curve.spline.range, len(points))
    return LEFT * curve_sigmas(views, views, points, made.curve.spline.derivative(at))


def monte_carlo(name: str, azimuth: float, trials: int) -> tuple[Array, Array]:
    """Errors (trials, places), % of the diagonal, and what was foretold."""
    curve, errors, told = PAIRS[name], [], []
    for seed in range(trials):
        made = fitted(curve, [(azimuth, 20)], 1.0, seed)
        points = made.curve.spline.sampled(60)
        errors.append(percent(distances(points[2:-2], curve)))
        told.append(percent(foretold(made, points, azimuth))[2:-2])
    return np.array(errors), np.array(told)


@pytest.mark.parametrize("name", PAIRS)
def test_a_pixel_of_noise_at_thirty_degrees(name: str) -> None:
    errors, told = monte_carlo(name, 30, 24)
    assert np.median(errors) < 0.6
    ratio = np.sqrt((errors**2).mean(axis=0) / (told**2).mean(axis=0))
    assert 0.8 < np.median(ratio) < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("azimuth", [30, 60])
def test_uncertainty_is_what_many_hands_show(name: str, azimuth: float) -> None:
    errors, told = monte_carlo(name, azimuth, 120)
    ratio = np.sqrt((errors**2).mean(axis=0) / (told**2).mean(axis=0))
    assert 0.85 < np.median(ratio) < 1.15


def test_two_views_are_better_than_each() -> None:
    curve, errors = PAIRS["S-wave"], []
    for seed in range(8):
        fits = [fitted(curve, views, 1.0, seed) for views in
                ([(30, 20)], [(60, 20)], [(30, 20), (60, 20)])]  # fmt: skip
        errors.append([np.sqrt((off(made, curve)[0] ** 2).mean()) for made in fits])
    first, second, both = np.median(errors, axis=0)
    assert both < min(first, second)


@pytest.mark.slow
def test_recorded_hands_lifted_to_space() -> None:
    curves = real_curves(30, seed=3)
    if not curves:
        pytest.skip("no recorded ink")
    errors = [
        np.median(off(fitted(curve, [(azimuth, 20)], 1.0, k), curve)[0])
        for k, curve in enumerate(curves)
        for azimuth in (25, 50)
    ]
    assert np.median(errors) < 0.5
    assert np.percentile(errors, 90) < 1.2
