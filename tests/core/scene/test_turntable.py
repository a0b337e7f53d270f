"""Turntables: what turns stays in the picture, and turns the right way."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.scene import LIGHT, Layer, Scene, Shaded
from bozzetto.scene.turntable import MOST_PICTURES, turned, turned_pictures
from bozzetto.view import Camera
from tests.core.scene.shapes import box

SIZE = (120, 90)


def scene_of(size=(80.0, 10.0, 30.0)):
    return Scene((Layer("a", (Shaded(box(size)),)),))


def inked(pixels):
    """Which pixels are not paper."""
    paper = np.array(LIGHT.paper[:3], int)
    return np.abs(pixels[..., :3].astype(int) - paper).max(axis=2) > 12


def test_all_of_it_lies_in_every_picture():
    for pixels in turned_pictures(scene_of(), 8, size=SIZE):
        seen = inked(pixels)
        assert seen.any()
        rim = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
        assert not rim.any()


def test_half_a_turn_shows_a_box_as_before_and_a_quarter_does_not():
    whole = list(turned_pictures(scene_of(), 4, size=SIZE, view="front"))
    front, side, back, other = (inked(pixels) for pixels in whole)
    assert (front != back).mean() < 0.01
    assert (side != other).mean() < 0.01
    assert front.any(axis=0).sum() > 3 * side.any(axis=0).sum()


def test_a_camera_comes_back_and_keeps_its_distance():
    camera, middle = Camera(eye=(10.0, -500.0, 80.0)), np.array([5.0, 7.0, 9.0])
    row = [turned(camera, angle, middle) for angle in np.linspace(0.0, 2.0 * np.pi, 7)]
    away = [np.linalg.norm(np.subtract(one.eye, middle)) for one in row]
    assert away == pytest.approx([away[0]] * 7)
    assert row[-1].eye == pytest.approx(camera.eye)
    quarter = turned(Camera(eye=(0.0, -500.0, 0.0)), 0.5 * np.pi, np.zeros(3))
    assert quarter.eye == pytest.approx((500.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("count", [0, -3, MOST_PICTURES + 1])
def test_numbers_out_of_range_are_refused(count):
    with pytest.raises(UserError, match="pictures"):
        next(turned_pictures(scene_of(), count))


def test_an_empty_scene_is_paper():
    (pixels,) = turned_pictures(Scene(()), 1, size=SIZE)
    assert not inked(pixels).any()
