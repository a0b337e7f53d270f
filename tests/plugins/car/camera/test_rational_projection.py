"""Pictures of cubics as rational cubics: against the camera's own projection."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from bozzetto_car.camera.rational_projection import Pictured, camera_matrix
from tests.plugins.car.traced_car import curve, view

KINDS: tuple[Literal["perspective", "orthographic"], ...] = ("perspective", "orthographic")
EDGE = np.array([[1200.0, 700, 900], [1600, 760, 960], [2100, 800, 950], [2500, 830, 930]])


@pytest.mark.parametrize("kind", KINDS)
def test_places_are_those_that_the_camera_projects(kind: Literal["perspective"]) -> None:
    for azimuth in (-150.0, 30.0, 75.0):
        camera = view(azimuth, 17.0, kind)
        pictured = Pictured.of(camera_matrix(camera), EDGE)
        wanted = camera.project(curve(EDGE, 31))[0]
        assert np.abs(pictured.laid_out(30) - wanted).max() < 1e-8
        assert np.abs(pictured.places(np.linspace(0, 1, 31)) - wanted).max() < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_rates_are_derivatives(kind: Literal["perspective"]) -> None:
    pictured = Pictured.of(camera_matrix(view(40.0, 17.0, kind)), EDGE)
    t = np.linspace(0.05, 0.95, 19)
    places, speed, w = pictured.rates(t)
    change = pictured.places(t + 1e-6) - pictured.places(t - 1e-6)
    assert np.abs(speed - change / 2e-6).max() < 1e-3
    assert np.array_equal(places, pictured.places(t))
    assert (w > 0.0).all()


def test_what_is_behind_the_eye_is_infinite() -> None:
    camera = view(0.0, 0.0)
    eye = np.array(camera.eye)
    way = np.array([2000.0, 90.0, 0.0])
    through = np.linspace(eye + way, eye - way, 4)
    places = Pictured.of(camera_matrix(camera), through).laid_out(20)
    assert np.isfinite(places[:9]).all()
    assert np.isinf(places[12:]).all()
