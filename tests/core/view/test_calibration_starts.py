"""Starts: what a direction of sight leaves open is found in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.view.calibration.initial_guesses import resume_poses, starts
from bozzetto.view.calibration.pose import NEAREST, Poses, rotations
from tests.core.view.marked_car import POINTS

KNOWN = (POINTS - POINTS.mean(axis=0)) / 1800.0


def pose(rng, strength):
    return Poses(
        rotations(rng.normal(0, 1, (1, 3))),
        np.array([np.log(0.2)]),
        rng.normal(0, 0.1, (1, 2)),
        np.array([strength]),
        np.zeros((1, 2)),
    )


@pytest.mark.parametrize("some", [slice(None), slice(0, 9), slice(20, 30)])
def test_an_orthographic_view_is_found_at_once_from_its_direction(some):
    rng = np.random.default_rng(0)
    for _ in range(10):
        truth = pose(rng, 0.0)
        marks = truth.see(KNOWN).places[0]
        rolled = replace(
            truth,
            turn=rotations(np.array([[0.0, 0.0, rng.uniform(-3, 3)]])) @ truth.turn,
            log_scale=truth.log_scale + 0.7,
            offset=truth.offset + 0.3,
        )
        made = resume_poses(KNOWN[some], marks[some], rolled, False)
        np.testing.assert_allclose(made.turn, truth.turn, atol=1e-9)
        np.testing.assert_allclose(made.see(KNOWN).places[0], marks, atol=1e-9)


def test_a_perspective_view_is_found_nearly_from_its_direction_and_focal_length():
    rng = np.random.default_rng(1)
    for _ in range(10):
        truth = pose(rng, 0.8)
        marks = truth.see(KNOWN).places[0]
        rolled = replace(truth, turn=rotations(np.array([[0.0, 0.0, 1.0]])) @ truth.turn)
        made = resume_poses(KNOWN, marks, rolled, False)
        assert np.abs(made.see(KNOWN).places[0] - marks).max() < 0.02


def test_a_principal_point_that_was_found_stays_where_the_picture_is_cropped():
    rng = np.random.default_rng(2)
    truth = replace(pose(rng, 0.0), principal=np.array([[0.1, -0.05]]))
    marks = truth.see(KNOWN).places[0]
    kept = resume_poses(KNOWN, marks, truth, True)
    np.testing.assert_allclose(kept.principal, truth.principal)
    np.testing.assert_allclose(kept.see(KNOWN).places[0], marks, atol=1e-9)
    assert not resume_poses(KNOWN, marks, truth, False).principal.any()


def test_all_starts_are_cameras_with_the_points_before_them():
    rng = np.random.default_rng(3)
    for _ in range(10):
        made = starts(KNOWN, rng.uniform(-2, 2, (len(KNOWN), 2)))
        np.testing.assert_allclose(np.linalg.det(made.turn), 1.0)
        np.testing.assert_allclose(
            made.turn @ np.swapaxes(made.turn, 1, 2),
            np.tile(np.eye(3), (len(made), 1, 1)),
            atol=1e-9,
        )
        assert (made.see(KNOWN).depth > NEAREST).all()
        assert np.count_nonzero(made.perspectivity == 0.0) * 3 == len(made)


def test_some_start_looks_from_nearly_the_right_side():
    rng = np.random.default_rng(4)
    for _ in range(20):
        truth = pose(rng, 0.0)
        made = starts(KNOWN, truth.see(KNOWN).places[0])
        cosine = made.turn[:, 2] @ truth.turn[0, 2]
        assert np.degrees(np.arccos(cosine.max())) < 35.0
