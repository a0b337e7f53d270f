"""A sketch in space: the same picture through its camera however one turns and zooms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bozzetto.scene import Picture
from bozzetto.view import Camera
from bozzetto_car.camera.sketch_camera import SketchCamera, upright_camera
from bozzetto_car.template.loader import bundled
from tests.plugins.car.traced_car import view

CAR = bundled("sedan").positions

STANDS = {
    "perspective": SketchCamera.behind(view(40.0, 12.0), (0.0, 0.0), CAR),
    "orthographic": SketchCamera.behind(view(40.0, 12.0, "orthographic"), (0.0, 0.0), CAR),
    "cropped": SketchCamera.behind(view(140.0, 8.0), (37.5, -80.0), CAR),
    "not solved": upright_camera((900.0, 1200.0)),
}

PLACES = np.array([(0.0, 0.0), (600.0, 400.0), (1100.0, 50.0), (-300.0, 2000.0)])


@pytest.mark.parametrize("name", STANDS)
def test_pixels_survive_the_way_to_space_and_back(name: str) -> None:
    sketch_camera = STANDS[name]
    assert_allclose(sketch_camera.pixels(sketch_camera.lifted(PLACES)), PLACES, atol=1e-8)


@pytest.mark.parametrize("name", ["perspective", "orthographic", "cropped"])
def test_the_picture_hangs_behind_the_car(name: str) -> None:
    sketch_camera = STANDS[name]
    depth = sketch_camera.camera.view_space(sketch_camera.lifted(PLACES))[:, 2]
    assert np.ptp(depth) < 1e-6
    assert depth.min() > sketch_camera.camera.view_space(CAR)[:, 2].max()


@pytest.mark.parametrize("name", ["perspective", "cropped"])
def test_turning_and_zooming_about_the_eye_keeps_car_and_picture_together(name: str) -> None:
    sketch_camera = STANDS[name]
    own = sketch_camera.camera
    aside = np.add(own.target, 300.0 * own.axes[0] + 120.0 * own.axes[1])
    x, y, z = aside.tolist()
    other = replace(own, target=(x, y, z), fov_y=0.6 * own.fov_y, viewport=(700.0, 900.0))
    assert sketch_camera.is_seen_through(other)
    # Where the car is seen on the sheet, the picture shows the pixel of the very same node.
    assert_allclose(
        sketch_camera.seen_at(other, other.project(CAR)[0]), sketch_camera.pixels(CAR), atol=1e-6
    )


def test_a_step_aside_is_another_view() -> None:
    sketch_camera = STANDS["perspective"]
    x, y, z = np.add(sketch_camera.camera.eye, 10.0 * sketch_camera.camera.axes[0]).tolist()
    assert not sketch_camera.is_seen_through(replace(sketch_camera.camera, eye=(x, y, z)))
    assert not sketch_camera.is_seen_through(STANDS["orthographic"].camera)
    assert not STANDS["orthographic"].is_seen_through(view(41.0, 12.0, "orthographic"))


@pytest.mark.parametrize("name", STANDS)
@pytest.mark.parametrize("canvas", [(1600.0, 900.0), (600.0, 1400.0)])
def test_the_whole_picture_is_in_view_at_first(name: str, canvas: tuple[float, float]) -> None:
    sketch_camera = STANDS[name]
    shown = sketch_camera.view(canvas)
    assert sketch_camera.is_seen_through(shown)
    width, height = sketch_camera.camera.viewport
    corners = sketch_camera.lifted([(0, 0), (width, 0), (0, height), (width, height)])
    at = shown.project(corners)[0]
    assert at.min() >= 0.0
    assert (at <= canvas).all()
    assert (np.ptp(at, axis=0) > 0.85 * np.array(canvas)).any()


def test_the_image_is_the_picture() -> None:
    sketch_camera = STANDS["perspective"]
    pixels = np.full((80, 120, 4), 200, np.uint8)
    image = sketch_camera.image(Picture.of(pixels, "sketch"), 0.5)
    corner, across, down = (np.array(v) for v in (image.corner, image.across, image.down))
    shown = [corner, corner + across, corner + down, corner + across + down]
    assert_allclose(
        sketch_camera.camera.project(shown)[0],
        [(0, 0), (1200, 0), (0, 800), (1200, 800)],
        atol=1e-6,
    )
    assert image.opacity == 0.5
    assert image.pixels.shape == (80, 120, 4)


def test_a_sheet_behind_the_eye_has_no_pixels() -> None:
    sketch_camera = STANDS["perspective"]
    away = Camera(
        eye=sketch_camera.camera.eye, target=tuple(2.0 * np.array(sketch_camera.camera.eye))
    )
    assert np.isnan(sketch_camera.seen_at(away, [(600.0, 450.0)])).all()
