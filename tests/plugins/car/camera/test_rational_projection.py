"""Pictures of cubics as rational cubics: against the camera's own projection."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from bozzetto_car.camera.rational_projection import (
    Pictured,
    camera_matrix,
    largest_scale,
    slopes_at,
)
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
        at = pictured.passed(np.linspace(0, 1, 31))
        assert np.abs(at.places.reshape(2, -1).T - wanted).max() < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_speeds_are_derivatives(kind: Literal["perspective"]) -> None:
    pictured = Pictured.of(camera_matrix(view(40.0, 17.0, kind)), EDGE)
    t = np.linspace(0.05, 0.95, 19)
    at, before, after = (pictured.passed(t + step) for step in (0.0, -1e-6, 1e-6))
    assert np.abs(at.speeds - (after.places - before.places) / 2e-6).max() < 1e-3
    assert np.abs((at.normals * at.speeds).reshape(2, -1).sum(axis=0)).max() < 1e-9
    assert np.abs(np.hypot(*at.normals.reshape(2, -1)) - 1.0).max() < 1e-12
    assert (at.w > 0.0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_how_fast_a_place_goes_across_the_picture(kind: Literal["perspective"]) -> None:
    camera = view(40.0, 17.0, kind)
    matrix, t = camera_matrix(camera), np.linspace(0.1, 0.9, 9)
    at = Pictured.of(matrix, EDGE).passed(t)
    places, normals = curve(EDGE, 81)[8:73:8], at.normals.reshape(2, -1).T
    for axis, way in enumerate(np.eye(3) * 1e-3):
        change = (camera.project(places + way)[0] - camera.project(places - way)[0]) / 2e-3
        rates = (at.across(at.normals).T @ matrix[:, :3])[:, axis]
        assert np.abs((normals * change).sum(axis=1) - rates).max() < 1e-6
        for place, wanted in zip(places, change, strict=True):
            assert np.abs(slopes_at(matrix, place)[:, axis] - wanted).max() < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_a_handle_leads_places_as_cubics_say(kind: Literal["perspective"]) -> None:
    t, number = np.linspace(0.0, 1.0, 7), 2
    at = Pictured.of(camera_matrix(view(40.0, 17.0, kind)), EDGE).passed(t)
    moved = EDGE.copy()
    moved[number] += (0.0, 1.0, 0.0)
    led = at.led(np.array([number - 1]))[0]
    assert np.abs((curve(moved, 7) - curve(EDGE, 7))[:, 1] - led).max() < 1e-9


def test_looked_at_again_it_is_what_it_is_there() -> None:
    pictured = Pictured.of(camera_matrix(view(40.0, 17.0)), EDGE)
    t, later = np.linspace(0.0, 1.0, 11), np.linspace(0.3, 0.8, 11)
    again, fresh = pictured.passed(t), pictured.passed(later)
    again.go(later)
    for what in ("t", "places", "speeds", "w"):
        assert np.array_equal(getattr(again, what), getattr(fresh, what))


@pytest.mark.parametrize("kind", KINDS)
def test_no_place_is_beyond_a_bound_that_the_bezier_points_keep(
    kind: Literal["perspective"],
) -> None:
    rng, kept = np.random.default_rng(1), 0
    for _ in range(200):
        camera = view(rng.uniform(-180, 180), rng.uniform(-30, 60), kind)
        matrix = camera_matrix(camera)
        pictured = Pictured.of(matrix, rng.normal((2300, 0, 600), 3000, (4, 3)))
        if pictured.is_within(1500.0):
            kept += 1
            assert np.abs(pictured.laid_out(300)).max() <= 1500.0
    assert 20 < kept < 180


def test_what_is_behind_the_eye_is_infinite() -> None:
    camera = view(0.0, 0.0)
    eye = np.array(camera.eye)
    way = np.array([2000.0, 90.0, 0.0])
    through = np.linspace(eye + way, eye - way, 4)
    places = Pictured.of(camera_matrix(camera), through).laid_out(20)
    assert np.isfinite(places[:9]).all()
    assert np.isinf(places[12:]).all()


@pytest.mark.parametrize("kind", KINDS)
def test_slopes_are_derivatives_and_their_scale_is_the_largest(
    kind: Literal["perspective"],
) -> None:
    camera = view(37.0, 21.0, kind)
    rng = np.random.default_rng(0)
    for point in rng.normal((2000, 0, 700), 800, (20, 3)):
        slopes = slopes_at(camera_matrix(camera), point)
        for axis, step in enumerate(np.eye(3) * 1e-2):
            change = camera.project(point + step)[0] - camera.project(point - step)[0]
            assert np.abs(slopes[:, axis] - change[0] / 2e-2).max() < 1e-6
        assert largest_scale(slopes) == pytest.approx(np.linalg.norm(slopes, ord=2), rel=1e-12)
