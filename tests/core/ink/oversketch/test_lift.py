"""The lift against a search along the ray, and its fixed points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from bozzetto.errors import UserError
from bozzetto.ink.oversketch.lift import NEAREST, lift_curve
from bozzetto.ink.oversketch.snake import oversketch_curve
from bozzetto.view.camera import Camera
from tests.core.view.cameras import cameras

VIEW = Camera(eye=(300.0, -700.0, 260.0), viewport=(1200.0, 900.0))
T = np.linspace(0, 1, 100)
ARC = np.column_stack((-90 + 180 * T, 30 * np.sin(np.pi * T), 30 + 10 * T))


@given(cameras(), st.integers(0, 999))
@settings(max_examples=80, deadline=None)
def test_a_curve_that_is_seen_where_it_was_stays(camera, seed):
    random = np.random.default_rng(seed)
    places = camera.target + 0.3 * camera.distance * random.uniform(-1, 1, (20, 3))
    pixels, _ = camera.project(places)
    size = camera.distance + np.abs(camera.target).max() + camera.height
    assert np.abs(lift_curve(places, camera, pixels) - places).max() < 1e-12 * size


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_it_is_seen_where_it_should_be_and_nothing_on_the_ray_is_nearer(kind):
    camera = replace(VIEW, kind=kind)
    random = np.random.default_rng(2)
    pixels = camera.project(ARC)[0] + random.normal(0, 20, (100, 2))
    made = lift_curve(ARC, camera, pixels)
    np.testing.assert_allclose(camera.project(made)[0], pixels, atol=1e-9)
    origins, directions = camera.rays(pixels)
    for old, new, origin, direction in zip(ARC, made, origins, directions, strict=True):
        best = minimize_scalar(lambda t, o=origin, d=direction, c=old: np.sum((o + t * d - c) ** 2))
        assert np.sum((new - old) ** 2) <= best.fun + 1e-6


def test_retracing_a_curve_gives_it_back():
    pixels, _ = VIEW.project(ARC)
    dense, _ = VIEW.project(
        np.column_stack([np.interp(np.linspace(0, 1, 991), T, c) for c in ARC.T])
    )
    made = oversketch_curve(pixels, [(dense, np.full(len(dense), 0.5))])
    diagonal = np.linalg.norm(np.ptp(ARC, axis=0))
    assert np.linalg.norm(lift_curve(ARC, VIEW, made.points) - ARC, axis=1).max() < 1e-4 * diagonal


def test_nothing_comes_to_lie_behind_the_eye():
    behind = VIEW.eye + np.array([[50.0, -400, 90], [0.0, 0, 0]])
    made = lift_curve(behind, VIEW, [[600, 450], [0, 0]])
    _, depth = VIEW.project(made)
    assert (depth > 0).all()
    np.testing.assert_allclose(
        np.linalg.norm(made - VIEW.eye, axis=1), NEAREST * VIEW.distance, rtol=1e-6
    )


def test_broken_input_is_refused():
    pixels, _ = VIEW.project(ARC)
    for bad in (np.nan, np.inf):
        with pytest.raises(UserError):
            lift_curve(np.where(T[:, None] > 0.9, bad, ARC), VIEW, pixels)
        with pytest.raises(UserError):
            lift_curve(ARC, VIEW, np.where(T[:, None] > 0.9, bad, pixels))
    with pytest.raises(UserError):
        lift_curve(np.zeros((0, 3)), VIEW, np.zeros((0, 2)))
    with pytest.raises(ValueError, match="100 nodes"):
        lift_curve(ARC, VIEW, pixels[:50])
