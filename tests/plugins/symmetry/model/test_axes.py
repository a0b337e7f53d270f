"""Places along lines that are seen, against projection."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.view import Camera
from bozzetto_symmetry.model.axes import AXES, along, receding

RANDOM = np.random.default_rng(7)
KINDS = ("perspective", "orthographic")


def view(kind: str) -> Camera:
    eye = RANDOM.normal(size=3)
    eye *= 700.0 / np.linalg.norm(eye)
    return Camera(kind=kind, eye=tuple(eye), height=300.0)


@pytest.mark.parametrize("kind", KINDS)
def test_the_place_that_is_seen_is_found(kind: str) -> None:
    for _ in range(200):
        camera = view(kind)
        point = RANDOM.uniform(-80, 80, 3)
        way = RANDOM.normal(size=3)
        way /= np.linalg.norm(way)
        distance = RANDOM.uniform(-150, 150)
        if abs(camera.axes[2] @ way) > 0.99:
            continue
        ((pixel,), _) = camera.project(point + distance * way)
        assert along(camera, pixel, point, way) == pytest.approx(distance, abs=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_beside_the_line_counts_for_nothing(kind: str) -> None:
    camera = Camera(kind=kind, eye=(500.0, -400.0, 300.0), height=300.0)
    point, way = np.array([10.0, -20.0, 5.0]), AXES[0]
    (one, other), _ = camera.project([point, point + 60.0 * way])
    normal = np.array([one[1] - other[1], other[0] - one[0]]) / np.linalg.norm(other - one)
    for aside in (-40.0, 3.0, 25.0):
        assert along(camera, other + aside * normal, point, way) == pytest.approx(60.0)


def test_a_line_seen_as_a_point_has_no_places() -> None:
    camera = Camera(eye=(0.0, -500.0, 0.0))
    assert along(camera, (610.0, 450.0), (0.0, 10.0, 0.0), AXES[1]) is None
    assert along(camera, (610.0, 450.0), (0.0, -900.0, 0.0), AXES[0]) is None  # behind the eye


def test_beyond_the_vanishing_point_is_no_place() -> None:
    camera = Camera(eye=(-300.0, -500.0, 0.0))
    base = np.array([0.0, 0.0, -50.0])
    (near, far), _ = camera.project([base, base + 1e9 * AXES[1]])
    assert along(camera, near + 0.9 * (far - near), base, AXES[1]) is not None
    assert along(camera, near + 1.1 * (far - near), base, AXES[1]) is None


def test_what_recedes() -> None:
    camera = Camera(eye=(300.0, -500.0, 0.0))
    x, y = receding(camera, AXES[0]), receding(camera, -AXES[1])
    assert x is not None
    assert y is not None
    assert x.tolist() == [-1.0, 0.0, 0.0]  # away from an eye at positive x
    assert y.tolist() == [0.0, 1.0, 0.0]
    assert receding(camera, AXES[2]) is None  # across the line of sight
    assert receding(Camera(kind="orthographic"), AXES[1]) is None
