"""Cameras as numbers: they see what the camera sees, and their derivatives are right."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.view.calibration.normalization import Framing
from bozzetto.view.calibration.pose import PARAMETERS, Poses, rotations
from tests.core.view.marked_car import PICTURE, POINTS

FRAMING = Framing(POINTS.mean(axis=0), 1800.0, PICTURE)


def poses(rng, count, kind="perspective", cropped=True):
    strength = rng.uniform(0.2, 2.0, count) if kind == "perspective" else np.zeros(count)
    aside = rng.normal(0, 0.1, (count, 2)) * (cropped and kind == "perspective")
    return Poses(
        rotations(rng.normal(0, 1.5, (count, 3))),
        rng.normal(np.log(0.2), 0.2, count),
        rng.normal(0, 0.1, (count, 2)),
        strength,
        aside,
    )


def test_rotations_are_those_of_scipy():
    from scipy.spatial.transform import Rotation

    vectors = np.vstack((np.zeros(3), np.random.default_rng(0).normal(0, 2, (20, 3)), (1e-9, 0, 0)))
    np.testing.assert_allclose(
        rotations(vectors), Rotation.from_rotvec(vectors).as_matrix(), atol=1e-14
    )


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_pose_sees_what_its_camera_sees(kind):
    made = poses(np.random.default_rng(1), 20, kind)
    for row in range(20):
        pose = made[[row]]
        seen = pose.see(FRAMING.points(POINTS))
        camera, shift = FRAMING.camera(pose)
        places, depth = camera.project(POINTS)
        assert camera.kind == kind
        before = seen.depth[0] > 0.02
        np.testing.assert_allclose(
            FRAMING.pixels(seen.places[0])[before], (places + shift)[before], atol=1e-7
        )
        np.testing.assert_array_equal(pose.before_eye(FRAMING.points(POINTS))[0], before)
        if kind == "perspective":
            middle = camera.project(FRAMING.centroid)[1]
            np.testing.assert_allclose(seen.depth[0], depth / middle, rtol=1e-9)


def test_a_long_lens_becomes_the_orthographic_camera():
    made = poses(np.random.default_rng(2), 10, "orthographic")
    points = FRAMING.points(POINTS)
    flat = made.see(points).places
    for strength in (1e-3, 1e-6):
        near = Poses(made.turn, made.log_scale, made.offset, np.full(10, strength), made.principal)
        assert np.abs(near.see(points).places - flat).max() < strength


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_slopes_are_differences(kind):
    rng = np.random.default_rng(3)
    made = poses(rng, 6, kind)
    points = FRAMING.points(POINTS)
    slopes = np.moveaxis(made.slopes(made.see(points)), 3, 1)  # (b, n, 9, 2)
    before = made.before_eye(points)
    small = 1e-6
    for number in range(PARAMETERS):
        if kind == "orthographic" and number == 6:
            continue
        step = np.zeros((6, PARAMETERS))
        step[:, number] = small
        change = made.moved(step).see(points).places - made.moved(-step).see(points).places
        difference = change / (2 * small)
        near = before & (made.see(points).depth > 0.1)
        np.testing.assert_allclose(
            slopes[:, :, number][near], difference[near], atol=2e-5, rtol=1e-5
        )
    assert not slopes[~before].any()


def test_steps_stay_within_bounds_and_keep_the_kind():
    rng = np.random.default_rng(4)
    flat, deep = poses(rng, 3, "orthographic"), poses(rng, 3)
    for size in (-1e3, 1e3):
        far = deep.moved(np.full((3, PARAMETERS), size))
        assert (far.perspectivity > 0).all()
        assert np.isfinite(FRAMING.camera(far[[0]])[0].eye).all()
        assert not flat.moved(np.full((3, PARAMETERS), size)).perspectivity.any()


def test_pixels_there_and_back():
    places = np.random.default_rng(5).uniform(-500, 2000, (9, 2))
    np.testing.assert_allclose(FRAMING.pixels(FRAMING.marks(places)), places, atol=1e-9)
