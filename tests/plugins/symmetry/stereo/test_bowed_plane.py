"""Where rays meet the plane of a flat symmetric curve, and one that bows a little."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.stereo.bowed_plane import FIGURES, BowedPlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry.scenes import camera

BOWED = BowedPlane(0.8, 12.0, (0.2, -0.15, 0.1), 5.0, 80.0)
PLACES = np.random.default_rng(2).uniform(-40, 40, (50, 3))


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("surface", [BowedPlane(0.8, 12.0), BOWED])
def test_rays_meet_it_where_it_is_seen(surface: BowedPlane, kind) -> None:
    stereo = Stereo(camera(35, 20, kind, pixels=800.0))
    pixels = stereo.project(PLACES)
    points, _, _ = surface.met(stereo, pixels)
    known = np.isfinite(points).all(axis=1)
    assert known.mean() > 0.9
    np.testing.assert_allclose(surface.heights(points[known]), 0.0, atol=1e-6)
    np.testing.assert_allclose(stereo.project(points[known]), pixels[known], atol=1e-6)


def test_it_is_its_own_mirror_image() -> None:
    np.testing.assert_allclose(BOWED.heights(PLACES * MIRROR), BOWED.heights(PLACES), atol=1e-12)


def test_a_hundred_times_as_large_it_rises_a_hundred_times_as_high() -> None:
    large = BowedPlane(0.8, 1200.0, BOWED.bows, 500.0, 8000.0)
    np.testing.assert_allclose(large.heights(100.0 * PLACES), 100.0 * BOWED.heights(PLACES))


def test_its_gradients_are_those_of_its_heights() -> None:
    step = 1e-5
    slopes = [
        (BOWED.heights(PLACES + step * way) - BOWED.heights(PLACES - step * way)) / (2.0 * step)
        for way in np.eye(3)
    ]
    np.testing.assert_allclose(BOWED.gradients(PLACES), np.column_stack(slopes), atol=1e-6)


def test_a_bow_of_nothing_is_a_plane() -> None:
    stereo = Stereo(camera(35, 20, pixels=800.0))
    pixels = stereo.project(PLACES)
    shallow = BowedPlane(0.8, 12.0, (1e-12, 0.0, 0.0), 5.0, 80.0)
    for one, other in zip(
        BowedPlane(0.8, 12.0).met(stereo, pixels), shallow.met(stereo, pixels), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-6)
    assert shallow.moves(PLACES).shape == (len(PLACES), FIGURES)


def test_rays_that_nearly_run_along_it_do_not_meet_it() -> None:
    view = camera(0, 0, "orthographic", pixels=800.0)  # along −x
    points, _, _ = BowedPlane(0.5 * np.pi, 0.0).met(Stereo(view), np.array(((500.0, 300.0),)))
    assert np.isnan(points).all()
