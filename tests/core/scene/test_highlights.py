"""Highlights of gloss, rubber and metal: where they are, and what they leave alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.scene import LIGHT, Layer, Scene, Shaded, render
from bozzetto.scene.renderer.highlights import LAMP, SHEENS, lamp_light
from bozzetto.view import Camera
from tests.core.scene.shapes import sphere

CAMERA = Camera(kind="orthographic", eye=(0.0, -500.0, 0.0), height=180.0, viewport=(240, 180))
COLOR = (60, 90, 160)


def ball(finish: str, shading: str = "clay") -> np.ndarray:
    item = Shaded(sphere(70.0, 64, normals=True), COLOR, finish=finish)
    scene = Scene((Layer("ball", (item,)),))
    return render(scene, CAMERA, LIGHT, size=(240, 180), shading=shading)[..., :3].astype(float)


def half_way(way: np.ndarray) -> np.ndarray:
    """The normal that mirrors the eye, straight in front, towards a place."""
    normal = way / np.linalg.norm(way) + (0.0, 0.0, 1.0)
    return normal / np.linalg.norm(normal)


def test_the_lamp_is_seen_where_a_mirror_shows_it() -> None:
    middle = half_way(np.array(LAMP))
    away = half_way(np.array((0.2, -0.9, 0.4)))
    behind = half_way(-np.array(LAMP) + 1e-9)
    light = lamp_light(np.stack((middle, away, behind), axis=1).astype(np.float32))
    assert light[0] == pytest.approx(1.0)
    assert light[1:].max() == 0.0


@pytest.mark.parametrize("finish", sorted(SHEENS))
def test_the_brightest_place_of_a_ball_is_the_image_of_the_lamp(finish: str) -> None:
    gain = (ball(finish) - ball("clay") * SHEENS[finish].body).sum(axis=2)
    inner = np.hypot(*(np.indices(gain.shape) - np.array([[[90]], [[120]]]))) < 60
    row, column = np.unravel_index(np.argmax(np.where(inner, gain, -np.inf)), gain.shape)
    normal = np.array((column + 0.5 - 120.0, 90.0 - row - 0.5, 0.0)) / 70.0
    normal[2] = np.sqrt(1.0 - (normal**2).sum())
    assert lamp_light(normal[:, None].astype(np.float32))[0] > 0.9


def test_the_highlight_of_metal_has_its_colour_and_that_of_gloss_has_not() -> None:
    normal = half_way(np.array(LAMP))
    row, column = round(90.0 - 70.0 * normal[1] - 0.5), round(120.0 + 70.0 * normal[0] - 0.5)
    spread = {name: np.ptp((ball(name) / ball("clay").max())[row, column]) for name in SHEENS}
    assert spread["metal"] > 1.5 * spread["gloss"]
    lights = {name: ball(name)[row, column].sum() for name in (*SHEENS, "clay")}
    assert lights["gloss"] > lights["clay"] + 100
    assert lights["rubber"] < lights["gloss"] - 100


@pytest.mark.parametrize("shading", ["zebra", "curvature", "normals", "xray"])
def test_views_that_shade_in_their_own_way_take_no_notice(shading: str) -> None:
    for finish in SHEENS:
        assert (ball(finish, shading) == ball("clay", shading)).all()


def test_clay_beside_gloss_is_as_it_was() -> None:
    left = Shaded(sphere(30.0, 32, normals=True), COLOR)
    mesh = left.mesh
    moved = replace(mesh, vertices=mesh.vertices + np.float32([80, 0, 0]))
    right = Shaded(moved, COLOR, finish="gloss")
    pair = [
        render(Scene((Layer("pair", (left, other)),)), CAMERA, LIGHT, size=(240, 180))
        for other in (right, replace(right, finish="clay"))
    ]
    assert (pair[0][:, :150] == pair[1][:, :150]).all()
    assert (pair[0][:, 170:] != pair[1][:, 170:]).any()


def test_a_finish_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="velvet"):
        Shaded(sphere(1.0, 8), finish="velvet")
