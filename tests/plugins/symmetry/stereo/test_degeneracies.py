"""Pairs of rays without a point, and those with one: against rays as two lines in space."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bozzetto.view import Camera
from bozzetto_symmetry.stereo.degeneracies import (
    CAUSES,
    REMEDIES,
    SOLVABLE,
    Case,
    intersect_rays,
    reasons_of,
    special_case,
)
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry.scenes import DIAGONAL, FLAT, PAIRS, camera

Array = NDArray[np.float64]
Kind = Literal["perspective", "orthographic"]
KINDS: tuple[Kind, ...] = ("perspective", "orthographic")


def vanishing(stereo: Stereo) -> Array:
    x, y, w = stereo.vanishing_point
    return np.array([[x / w, y / w]])


def one_case(stereo: Stereo, near: Array, far: Array) -> Case:
    points, codes = intersect_rays(stereo, near, far)
    assert codes.tolist() == special_case(stereo, near, far).tolist()
    assert (np.isfinite(points).all(axis=1) == np.isin(codes, SOLVABLE)).all()
    assert (codes == codes[0]).all()
    return Case(int(codes[0]))


def test_an_ordinary_pair_is_where_it_is_drawn() -> None:
    stereo = Stereo(camera(40, 20))
    curve = PAIRS["S-wave"]
    points, codes = intersect_rays(stereo, stereo.project(curve), stereo.project(curve * MIRROR))
    assert (codes == Case.ORDINARY).all()
    assert np.abs(points - curve).max() < 1e-9 * DIAGONAL


def test_an_eye_at_infinity_is_solved_by_origins() -> None:
    stereo = Stereo(camera(40, 20, "orthographic"))
    curve = PAIRS["S-wave"]
    points, codes = intersect_rays(stereo, stereo.project(curve), stereo.project(curve * MIRROR))
    assert (codes == Case.EYE_AT_INFINITY).all()
    assert np.abs(points - curve).max() < 1e-9 * DIAGONAL


@pytest.mark.parametrize("kind", KINDS)
def test_both_sides_in_one_place_are_exactly_in_the_plane(kind: Kind) -> None:
    stereo = Stereo(camera(40, 20, kind))
    curve = FLAT["bonnet line"]
    drawn = stereo.project(curve)
    points, codes = intersect_rays(stereo, drawn, drawn)
    assert (codes == Case.IN_PLANE).all()
    assert (points[:, 1] == 0.0).all()
    assert np.abs(points - curve).max() < 1e-9 * DIAGONAL


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("elevation", [0, 35, 90, -90])
def test_an_eye_on_the_plane_sees_both_sides_alike(elevation: float, kind: Kind) -> None:
    stereo = Stereo(camera(0, elevation, kind))
    curve = PAIRS["hook"]
    drawn = stereo.project(curve), stereo.project(curve * MIRROR)
    assert one_case(stereo, *drawn) == Case.EYE_ON_PLANE
    assert one_case(stereo, drawn[0], drawn[0]) == Case.EYE_ON_PLANE


def test_a_side_through_the_vanishing_point_has_no_partner() -> None:
    stereo = Stereo(camera(60, 20))
    epipole = vanishing(stereo)
    for other in ((100.0, 100.0), (700.0, 300.0)):
        place = np.array([other])
        assert one_case(stereo, epipole, place) == Case.ONE_ALONG_NORMAL
        assert one_case(stereo, place, epipole) == Case.ONE_ALONG_NORMAL
    assert one_case(stereo, epipole, epipole) == Case.BOTH_ALONG_NORMAL


def test_parallel_rays_along_the_normal_see_left_and_right_in_one_place() -> None:
    stereo = Stereo(camera(90, 0, "orthographic"))
    drawn = stereo.project(PAIRS["hook"])
    assert one_case(stereo, drawn, drawn) == Case.BOTH_ALONG_NORMAL


def slopes(stereo: Stereo, first: float, second: float) -> tuple[Array, Array]:
    """A pair on one epipolar line whose rays rise by so much on a unit of way along the plane."""
    eye = np.array(stereo.camera.eye)
    level = -eye * (1.0, 0.0, 1.0) / np.linalg.norm(eye[[0, 2]])
    rises = [[0.0, first, 0.0], [0.0, second, 0.0]]
    one, other = (stereo.project(eye + 100.0 * (level + rise)) for rise in rises)
    return one, other


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_parallel_and_parting_rays(side: float) -> None:
    """The eye is at y > 0 for side 1: rays that fall towards the plane meet, others do not."""
    stereo = Stereo(camera(side * 40, 20))
    assert one_case(stereo, *slopes(stereo, 0.3, -0.3)) == Case.PARALLEL
    assert one_case(stereo, *slopes(stereo, 0.0, 0.0)) == Case.PARALLEL
    assert one_case(stereo, *slopes(stereo, side * 0.3, side * -0.2)) == Case.BEHIND
    assert one_case(stereo, *slopes(stereo, side * 0.2, side * 0.2)) == Case.BEHIND
    assert one_case(stereo, *slopes(stereo, side * -0.3, side * 0.2)) == Case.ORDINARY


@pytest.mark.parametrize("kind", KINDS)
def test_cases_are_those_of_two_lines_in_space(kind: Kind) -> None:
    """The nearest places of both lines by least squares, ordinary ones before both eyes."""
    random = np.random.default_rng(5)
    for azimuth, elevation in random.uniform((-180, -80), (180, 80), (40, 2)):
        stereo = Stereo(camera(azimuth, elevation, kind))
        near = random.uniform(0, 900, (20, 2))
        far = near + random.uniform(-300, 300, (20, 1)) * stereo.toward_vanishing(near)
        points, codes = intersect_rays(stereo, near, far)
        rays = (*stereo.rays(near), *stereo.rays(far))
        for point, code, o1, d1, o2, d2 in zip(points, codes, *rays, strict=True):
            (t, s), *_ = np.linalg.lstsq(np.column_stack((d1, -d2 * MIRROR)), o2 * MIRROR - o1)
            meets = kind == "orthographic" or (t > 0 and s > 0)
            assert meets == (code in SOLVABLE)
            if meets:
                assert np.abs(point - o1 - t * d1).max() < 1e-6 * (1.0 + np.abs(point).max())


@pytest.mark.parametrize("kind", KINDS)
def test_a_hundred_thousand_pairs_in_degenerate_views(kind: Kind) -> None:
    random = np.random.default_rng(6)
    angles = [0.0, 1e-12, 1e-9, 1e-7, 1e-3, 45.0, 90.0 - 1e-7, 90.0, 180.0, 270.0]
    count = 0
    for azimuth in angles:
        for elevation in (0.0, 1e-9, 20.0, 90.0, -90.0):
            stereo = Stereo(camera(azimuth, elevation, kind))
            near = random.uniform(-500, 1500, (1000, 2))
            far = near + random.uniform(-500, 500, (1000, 1)) * stereo.toward_vanishing(near)
            far[:100] = near[:100]
            near[100:110], far[105:115] = (600.0, 450.0), (600.0, 450.0)
            far[200:300] = random.uniform(-500, 1500, (100, 2))
            points, codes = intersect_rays(stereo, near, far)
            assert (np.isfinite(points).all(axis=1) == np.isin(codes, SOLVABLE)).all()
            assert not np.isinf(points).any()
            assert np.isin(codes, list(Case)).all()
            count += len(codes)
    assert count == 50_000


@given(
    eye=st.tuples(*[st.floats(-1e4, 1e4)] * 3),
    target=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    kind=st.sampled_from(KINDS),
    pixels=st.lists(st.tuples(*[st.floats(-5e3, 5e3)] * 4), min_size=0, max_size=8),
)
@settings(max_examples=60)
def test_any_view_gives_points_or_a_reason(
    eye: tuple[float, float, float],
    target: tuple[float, float, float],
    kind: Kind,
    pixels: list[tuple[float, float, float, float]],
) -> None:
    if np.linalg.norm(np.subtract(eye, target)) < 1e-3:
        return
    stereo = Stereo(Camera(kind=kind, eye=eye, target=target))
    ink = np.array(pixels).reshape(-1, 4)
    points, codes = intersect_rays(stereo, ink[:, :2], ink[:, 2:])
    known = np.isfinite(points).all(axis=1)
    assert (known == np.isin(codes, SOLVABLE)).all()
    assert bool(reasons_of(codes)) == bool((~known).any())


def test_reasons_are_told_the_commonest_first() -> None:
    assert reasons_of([0, 6, 7, 0]) == ()
    told = reasons_of([Case.BEHIND, Case.PARALLEL, 0, Case.BEHIND])
    assert told == tuple(f"{CAUSES[c]} {REMEDIES[c]}" for c in (Case.BEHIND, Case.PARALLEL))
    assert set(CAUSES) == set(REMEDIES) == set(Case) - set(SOLVABLE)
    assert reasons_of([]) == ()
