"""What a pixel is worth in space: against hands that err many times, and where nothing is known."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bozzetto.view import Camera
from bozzetto_symmetry.interpretation.side_pairing import pairings
from bozzetto_symmetry.interpretation.stereo_triangulation import triangulate
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import (
    ANYWHERE,
    curve_sigmas,
    heat,
    pair_covariances,
    plane_covariances,
    sigmas,
)
from tests.plugins.symmetry.scenes import DIAGONAL, FLAT, PAIRS, camera, densely, drawn

Array = NDArray[np.float64]
Kind = Literal["perspective", "orthographic"]
KINDS: tuple[Kind, ...] = ("perspective", "orthographic")
AZIMUTHS = (2, 5, 10, 20, 30, 45, 60, 75, 88)
ORDINARY = ("roof rail", "S-wave", "hook")


def pair(stereo: Stereo, curve: Array) -> tuple[Array, Array, Array]:
    """Both images of a curve, and the directions of the second."""
    near, far = stereo.project(curve), stereo.project(curve * MIRROR)
    tangents = np.gradient(far, axis=0)
    return near, far, tangents / np.linalg.norm(tangents, axis=1, keepdims=True)


def partners(stereo: Stereo, near: Array, far: Array, tangents: Array) -> Array:
    """Where lines through a place and the vanishing point cross lines along the far curve."""
    ones = np.ones((len(near), 1))
    epipolar = np.cross(np.hstack((near, ones)), stereo.vanishing_point)
    along = np.cross(np.hstack((far, ones)), np.hstack((tangents, 0.0 * ones)))
    crossing = np.cross(epipolar, along)
    return np.asarray(crossing[:, :2] / crossing[:, 2:])


def erring(
    stereo: Stereo, near: Array, far: Array, tangents: Array, hand: float, trials: int
) -> Array:
    """Mean square error (mm² per px²) of hands that miss both curves by so much, px."""
    random = np.random.default_rng(1)
    truth = stereo.intersected(near, far)
    normals = np.column_stack((-tangents[:, 1], tangents[:, 0]))
    total = np.zeros(len(near))
    for _ in range(trials):
        missed = near + hand * random.standard_normal(near.shape)
        shifted = far + hand * random.standard_normal((len(far), 1)) * normals
        made = stereo.intersected(missed, partners(stereo, missed, shifted, tangents))
        total += ((made - truth) ** 2).sum(axis=1)
    return total / trials / hand**2


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_hands_err_by_what_is_predicted(azimuth: float, kind: Kind) -> None:
    stereo = Stereo(camera(azimuth, 20, kind))
    both = pair(stereo, PAIRS["roof rail"])
    predicted = sigmas(pair_covariances(stereo, *both))
    ratio = np.sqrt(erring(stereo, *both, hand=0.02, trials=300)) / predicted
    assert 0.98 < np.median(ratio) < 1.02
    assert 0.9 < np.percentile(ratio, 5)
    assert np.percentile(ratio, 95) < 1.1


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PAIRS)
def test_hands_whose_sides_are_matched_err_by_what_is_predicted(name: str, kind: Kind) -> None:
    """A tremor of 1 px on either side, partners found by the ink alone; per 50th of the curve."""
    view, curve = camera(30, 20, kind), PAIRS[name]
    stereo, fine = Stereo(view), densely(curve)
    tangents = np.gradient(fine, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    tree = cKDTree(fine)
    missed, predicted = np.zeros((2, 50))
    for seed in range(16):
        random = np.random.default_rng(seed)
        near, far = (
            drawn(side, view, noise=1.0, random=random) for side in (curve, curve * MIRROR)
        )
        made = triangulate(stereo, pairings(stereo, near, far)[0])
        distance, nearest = map(np.asarray, tree.query(made.points))
        along = tangents[nearest]
        across = np.trace(made.covariances, axis1=1, axis2=2) - np.einsum(
            "ni,nij,nj->n", along, made.covariances, along
        )
        known = across < (0.02 * DIAGONAL) ** 2
        part = nearest[known] * 50 // len(fine)
        np.add.at(missed, part, distance[known] ** 2)
        np.add.at(predicted, part, across[known])
    assert (predicted > 0.0).mean() > 0.9
    ratio = np.sqrt(missed[predicted > 0.0] / predicted[predicted > 0.0])
    assert 0.85 < np.median(ratio) < 1.15


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PAIRS)
def test_covariances_are_those_of_finite_differences(name: str, kind: Kind) -> None:
    stereo = Stereo(camera(35, 25, kind))
    near, far, tangents = pair(stereo, PAIRS[name])
    normals = np.column_stack((-tangents[:, 1], tangents[:, 0]))
    step = 1e-4
    moves = [((step, 0.0), 0.0), ((0.0, step), 0.0), ((0.0, 0.0), step)]
    columns = []
    for move, shift in moves:
        ahead, behind = (
            stereo.intersected(
                near + sign * np.array(move),
                partners(
                    stereo, near + sign * np.array(move), far + sign * shift * normals, tangents
                ),
            )
            for sign in (1.0, -1.0)
        )
        columns.append((ahead - behind) / (2.0 * step))
    slopes = np.stack(columns, axis=2)
    expected = slopes @ np.swapaxes(slopes, 1, 2)
    made = pair_covariances(stereo, near, far, tangents)
    known = sigmas(expected) < 0.2 * DIAGONAL
    assert known.mean() > 0.95
    error = np.abs(made - expected).max(axis=(1, 2)) / np.trace(expected, axis1=1, axis2=2)
    assert error[known].max() < 1e-3
    assert np.median(error) < 1e-6


def test_a_view_along_the_plane_is_eight_times_worse() -> None:
    medians = []
    for azimuth in (2, 30):
        stereo = Stereo(camera(azimuth, 20))
        both = pair(stereo, PAIRS["roof rail"])
        medians.append(float(np.median(sigmas(pair_covariances(stereo, *both)))))
    assert 6.0 < medians[0] / medians[1] < 10.0


@pytest.mark.parametrize("azimuth", [1, 3, 8, 12, 20])
@pytest.mark.parametrize("name", ORDINARY)
def test_near_the_plane_it_is_the_formula_of_a_stereo_camera(name: str, azimuth: float) -> None:
    view = camera(azimuth, 20)
    stereo = Stereo(view)
    near, far, tangents = pair(stereo, PAIRS[name])
    toward = stereo.toward_vanishing(far)
    sine = np.abs(toward[:, 0] * tangents[:, 1] - toward[:, 1] * tangents[:, 0])
    focal = 0.5 * view.viewport[1] / np.tan(np.radians(view.fov_y) / 2.0)
    distance = np.linalg.norm(PAIRS[name] - view.eye, axis=1)
    quick = distance**2 / (np.sqrt(2.0) * abs(view.eye[1]) * focal * sine)
    ratio = sigmas(pair_covariances(stereo, near, far, tangents)) / quick
    assert 0.9 < np.median(ratio) < 1.2


@pytest.mark.parametrize("kind", KINDS)
def test_a_larger_world_errs_more_and_a_larger_sheet_less(kind: Kind) -> None:
    view = camera(40, 25, kind)
    both = pair(Stereo(view), PAIRS["S-wave"])
    once = pair_covariances(Stereo(view), *both)
    known = sigmas(once) < DIAGONAL
    assert known.mean() > 0.95
    larger = replace(view, eye=tuple(3.0 * np.array(view.eye)), height=3.0 * view.height)
    assert pair_covariances(Stereo(larger), *both) == pytest.approx(9.0 * once, rel=1e-6)
    width, height = view.viewport
    sheet = Stereo(view.with_viewport(2.0 * width, 2.0 * height))
    near, far, tangents = both
    finer = pair_covariances(sheet, 2.0 * near, 2.0 * far, tangents)
    assert finer[known] == pytest.approx(0.25 * once[known], rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_mirrored_view_errs_in_the_mirrored_way(kind: Kind) -> None:
    view = camera(40, 25, kind)
    image = replace(view, eye=tuple(np.array(view.eye) * MIRROR))
    curve = PAIRS["hook"]
    made = pair_covariances(Stereo(view), *pair(Stereo(view), curve))
    other = pair_covariances(Stereo(image), *pair(Stereo(image), curve * MIRROR))
    mirrored = other * MIRROR[:, None] * MIRROR
    assert np.abs(made - mirrored).max() < 1e-6 * np.abs(made).max()


def across(covariances: Array, tangents: Array) -> Array:
    """Standard deviations across a direction."""
    unit = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
    along = np.einsum("ni,nij,nj->n", unit, covariances, unit)
    return np.asarray(np.sqrt(np.trace(covariances, axis1=1, axis2=2) - along))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PAIRS)
def test_a_curve_errs_like_its_places_across_itself(name: str, kind: Kind) -> None:
    stereo, curve = Stereo(camera(35, 25, kind)), PAIRS[name]
    tangents = np.gradient(curve, axis=0)
    expected = across(pair_covariances(stereo, *pair(stereo, curve)), tangents)
    made = curve_sigmas([stereo], [stereo], curve, tangents)
    low = expected < np.quantile(expected, 0.4)
    assert made[low] == pytest.approx(expected[low], rel=2e-3)
    assert (made <= expected * 1.002 + 1e-9).all()
    twice = curve_sigmas([stereo] * 2, [stereo] * 2, curve, 3.0 * tangents)
    assert twice[low] == pytest.approx(made[low] / np.sqrt(2.0), rel=1e-4)


@pytest.mark.parametrize("name", PAIRS)
def test_the_error_of_a_curve_grows_no_faster_than_the_way_along_it(name: str) -> None:
    stereo, curve = Stereo(camera(75, 20)), PAIRS[name]
    made = curve_sigmas([stereo], [stereo], curve, np.gradient(curve, axis=0))
    assert (np.abs(np.diff(made)) <= np.linalg.norm(np.diff(curve, axis=0), axis=1) + 1e-9).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_second_view_helps_where_the_first_one_says_little(kind: Kind) -> None:
    curve = PAIRS["S-wave"]
    tangents = np.gradient(curve, axis=0)
    one, other = Stereo(camera(3, 20, kind)), Stereo(camera(50, 20, kind))
    alone = curve_sigmas([one], [one], curve, tangents)
    good = curve_sigmas([other], [other], curve, tangents)
    both = curve_sigmas([one, other], [one, other], curve, tangents)
    singly = curve_sigmas([one, other], [], curve, tangents)
    assert (both <= np.minimum(alone, good) + 1e-9).all()
    assert np.median(both) < 0.3 * np.median(alone)
    assert (both <= singly + 1e-9).all()
    assert np.median(singly) < np.median(alone)


@pytest.mark.parametrize("kind", KINDS)
def test_a_curve_in_the_plane_errs_in_the_plane(kind: Kind) -> None:
    stereo, curve = Stereo(camera(40, 20, kind)), FLAT["roof line"]
    tangents = np.gradient(curve, axis=0)
    expected = across(plane_covariances(stereo, stereo.project(curve)), tangents)
    made = curve_sigmas([stereo], [], curve, tangents, flat=True)
    assert made == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("azimuth", "elevation"), [(0, 0), (0, 90), (90, 0), (30, 20)])
def test_no_curve_and_no_view_give_anything_but_numbers(
    azimuth: float, elevation: float, kind: Kind
) -> None:
    stereo, curve = Stereo(camera(azimuth, elevation, kind)), PAIRS["hook"]
    along = np.gradient(curve, axis=0)
    along[::3] = 0.0
    for far in ([stereo], []):
        for flat in (False, True):
            made = curve_sigmas([stereo], far, curve, along, flat=flat)
            assert np.isfinite(made).all()
            assert (made > 0.0).all()
    assert curve_sigmas([stereo], [stereo], np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("azimuth", [5, 30, 90])
def test_points_in_the_plane_err_by_what_is_predicted(azimuth: float, kind: Kind) -> None:
    stereo = Stereo(camera(azimuth, 15, kind))
    pixels = stereo.project(FLAT["roof line"])
    made = plane_covariances(stereo, pixels)
    assert (made[:, 1] == 0.0).all()
    assert (made[:, :, 1] == 0.0).all()
    random = np.random.default_rng(2)
    missed = pixels + 0.02 * random.standard_normal((300, *pixels.shape))
    found = stereo.on_plane(missed.reshape(-1, 2)).reshape(300, -1, 3)
    error = np.sqrt(((found - FLAT["roof line"]) ** 2).sum(axis=2).mean(axis=0)) / 0.02
    ratio = error / sigmas(made)
    assert 0.98 < np.median(ratio) < 1.02
    assert 0.9 < np.percentile(ratio, 5)
    assert np.percentile(ratio, 95) < 1.1


def test_the_plane_is_best_seen_from_the_side() -> None:
    spread = []
    for azimuth in (2, 5, 10, 20, 45, 90):
        stereo = Stereo(camera(azimuth, 0))
        made = plane_covariances(stereo, stereo.project(FLAT["roof line"]))
        spread.append(float(np.median(sigmas(made))))
    assert (np.diff(spread) < 0.0).all()
    assert spread[0] / spread[-1] > 15.0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("azimuth", "elevation"), [(0, 0), (0, 20), (90, 0), (90, 90), (0, -90), (1e-9, 0), (180, 3)]
)
def test_views_that_say_nothing_give_large_numbers(
    azimuth: float, elevation: float, kind: Kind
) -> None:
    stereo = Stereo(camera(azimuth, elevation, kind))
    random = np.random.default_rng(3)
    near, far = random.uniform(-100, 1300, (2, 2000, 2))
    near[:2], far[:2] = (600, 450), [(600, 450), (700, 450)]
    tangents = random.standard_normal((2000, 2))
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    tangents[:5] = 0.0
    limit = ANYWHERE * stereo.camera.visible_height
    for made in (pair_covariances(stereo, near, far, tangents), plane_covariances(stereo, near)):
        assert np.isfinite(made).all()
        assert (np.linalg.eigvalsh(made) > -1e-9 * limit**2).all()
        assert sigmas(made).max() <= 1.01 * np.sqrt(3.0) * limit


@given(
    eye=st.tuples(*[st.floats(-1e4, 1e4)] * 3),
    target=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    kind=st.sampled_from(KINDS),
    pixels=st.lists(st.tuples(*[st.floats(-5e3, 5e3)] * 4), min_size=1, max_size=8),
    angle=st.floats(0.0, 7.0),
)
@settings(max_examples=60)
def test_no_view_and_no_ink_gives_anything_but_a_number(
    eye: tuple[float, float, float],
    target: tuple[float, float, float],
    kind: Kind,
    pixels: list[tuple[float, float, float, float]],
    angle: float,
) -> None:
    if np.linalg.norm(np.subtract(eye, target)) < 1e-3:
        return
    stereo = Stereo(Camera(kind=kind, eye=eye, target=target))
    ink = np.array(pixels)
    tangents = np.tile((np.cos(angle), np.sin(angle)), (len(ink), 1))
    made = pair_covariances(stereo, ink[:, :2], ink[:, 2:], tangents)
    assert np.isfinite(made).all()
    assert (sigmas(made) > 0.0).all()
    assert np.isfinite(plane_covariances(stereo, ink[:, :2])).all()


def test_places_without_a_partner_are_unknown_and_harm_no_others() -> None:
    stereo = Stereo(camera(30, 20))
    near, far, tangents = pair(stereo, PAIRS["S-wave"])
    whole = pair_covariances(stereo, near, far, tangents)
    far, tangents = far.copy(), tangents.copy()
    far[100:120] = np.nan
    tangents[100:120] = np.nan
    made = pair_covariances(stereo, near, far, tangents)
    rest = np.r_[0:100, 120:300]
    assert (made[rest] == whole[rest]).all()
    assert (heat(sigmas(made), DIAGONAL)[100:120] == 2).all()


def test_heat_counts_in_shares_of_the_diagonal() -> None:
    percent = np.array([0.0, 0.9, 1.1, 2.6, 2.7, 80.0, np.inf, np.nan])
    assert heat(0.01 * percent * 250.0, 250.0).tolist() == [0, 0, 1, 1, 2, 2, 2, 2]
    assert heat([], 250.0).shape == (0,)
