"""Mirrored rays against the paper's least squares, in many views."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from bozzetto.view import Camera
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

Kind = Literal["perspective", "orthographic"]

DIAGONAL = float(np.linalg.norm((200.0, 100.0, 100.0)))
RANDOM = np.random.default_rng(4)
POINTS = RANDOM.uniform((-100, 5, -50), (100, 50, 50), (50, 3))


def camera(azimuth: float, elevation: float, kind: Kind = "perspective") -> Camera:
    """A view at an angle, degrees, from the centre plane; the box is about 400 px wide."""
    a, e = np.radians((azimuth, elevation))
    eye = 3.0 * DIAGONAL * np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    return Camera(kind=kind, eye=tuple(eye), fov_y=41.11, height=550.0)


VIEWS: list[tuple[float, float, Kind]] = [
    (azimuth, elevation, kind)
    for azimuth, elevation in [(1, 10), (30, 20), (60, -40), (88, 5), (-45, 30),
                               (120, 20), (200, 60), (250, -5), (300, 80), (15, 0)]
    for kind in ("perspective", "orthographic")
]  # fmt: skip


def least_squares(stereo: Stereo, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Equations (6)–(8): three equations for two ray parameters, and the middle of both points."""
    made = []
    for o1, d1, o2, d2 in zip(*stereo.rays(near), *stereo.rays(far), strict=True):
        matrix = np.column_stack((d1, -d2 * MIRROR))
        (t, s), *_ = np.linalg.lstsq(matrix, o2 * MIRROR - o1, rcond=None)
        made.append(0.5 * (o1 + t * d1 + (o2 + s * d2) * MIRROR))
    return np.array(made)


@pytest.mark.parametrize(("azimuth", "elevation", "kind"), VIEWS)
def test_closed_form_is_least_squares(azimuth: float, elevation: float, kind: Kind) -> None:
    stereo = Stereo(camera(azimuth, elevation, kind))
    near, far = stereo.project(POINTS), stereo.project(POINTS * MIRROR)
    made = stereo.intersected(near, far)
    assert np.abs(made - POINTS).max() < 1e-9 * DIAGONAL
    assert np.abs(made - least_squares(stereo, near, far)).max() < 1e-9 * DIAGONAL


@pytest.mark.parametrize(("azimuth", "elevation", "kind"), VIEWS)
def test_mirrored_places_share_their_epipolar_line(
    azimuth: float, elevation: float, kind: Kind
) -> None:
    stereo = Stereo(camera(azimuth, elevation, kind))
    near, far = stereo.project(POINTS), stereo.project(POINTS * MIRROR)
    for one, other in zip(near, far, strict=True):
        turns = (stereo.angles(one) - stereo.angles(other)) / (2.0 * np.pi)
        rest = turns if kind == "orthographic" else turns - np.round(turns)
        assert abs(rest[0]) < 1e-9
    way, across = stereo.toward_vanishing(near), far - near
    cross = way[:, 0] * across[:, 1] - way[:, 1] * across[:, 0]
    assert np.abs(cross).max() < 1e-6


@pytest.mark.parametrize(("azimuth", "elevation", "kind"), VIEWS)
def test_pixels_per_angle_is_what_a_small_step_across_shows(
    azimuth: float, elevation: float, kind: Kind
) -> None:
    stereo = Stereo(camera(azimuth, elevation, kind))
    near = stereo.project(POINTS)
    way = stereo.toward_vanishing(near)
    step = 1e-4 * np.column_stack((-way[:, 1], way[:, 0]))
    for place, small, scale in zip(near, step, stereo.pixels_per_angle(near), strict=True):
        change = np.diff(stereo.angles(np.vstack([place - small, place + small])))[0]
        assert abs(change) * scale == pytest.approx(2e-4, rel=1e-4)


@pytest.mark.parametrize("normal", [(0, 1, 0), (1, 0, 0), (0, 0, -1), (0, -1, 0), (1, 2, -3)])
def test_any_plane_is_y_0_in_its_own_frame(normal: tuple[float, float, float]) -> None:
    plane = CentrePlane((10.0, -20.0, 5.0), normal)
    unit = np.asarray(plane.normal)
    points = POINTS + 7.0
    inside = plane.inverse.points(points)
    assert inside[:, 1] == pytest.approx((points - plane.point) @ unit)
    image = points - 2.0 * ((points - plane.point) @ unit)[:, None] * unit
    assert plane.placement.points(inside * MIRROR) == pytest.approx(image)
    view = camera(40, 25)
    stereo = Stereo.of(view, plane)
    assert stereo.project(inside) == pytest.approx(view.project(points)[0])


def test_the_ordinary_plane_moves_nothing() -> None:
    assert CentrePlane().placement.is_identity


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_no_view_warns_or_gives_infinities(kind: Kind) -> None:
    for azimuth, elevation in [(0, 0), (90, 0), (90, 90), (0, 90), (1e-7, 0), (90, 1e-9)]:
        stereo = Stereo(camera(azimuth, elevation, kind))
        pixels = RANDOM.uniform(0, 900, (200, 2))
        pixels[:3] = (600, 450)
        for values in (stereo.angles(pixels), stereo.toward_vanishing(pixels)):
            assert np.isfinite(values).all()
        made = stereo.intersected(pixels, pixels[::-1])
        assert not np.isinf(made).any()


def test_points_behind_the_eye_are_none() -> None:
    stereo = Stereo(Camera(eye=(0.0, -300.0, 0.0), target=(0.0, 0.0, 0.0)))
    crossed = stereo.intersected([(300.0, 300.0)], [(310.0, 300.0)])
    assert np.isnan(crossed).all() or crossed[0, 1] > -300.0


def test_places_on_both_sides_of_the_vanishing_point_are_no_pair() -> None:
    stereo = Stereo(camera(75, 20))
    x, y, w = stereo.vanishing_point
    way = np.array([30.0, 40.0])
    one, other = np.array([x / w, y / w]) + np.outer((1.0, -0.1), way)
    assert np.isnan(stereo.intersected([one, other], [other, one])).all()
