"""Golden pictures: what the renderer drew when somebody last looked at it and found it good.

Set ``BOZZETTO_UPDATE_PICTURES=1`` to write the pictures in ``tests/data/pictures`` anew,
and look at every one before committing it. On failure the actual picture and the
difference (eightfold) are written to ``out/pictures``.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from bozzetto.geometry.mesh import Mesh
from bozzetto.images.png import write_png
from bozzetto.scene import DARK, LIGHT, Handle, Image, Lines, Points, Scene, Shaded
from bozzetto.scene.grid import ground_grid
from bozzetto.scene.renderer import render
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import fit
from bozzetto.view.standard_views import standard_view
from tests.core.scene.shapes import box, scene_of, sphere

GOLDEN = Path(__file__).parents[2] / "data" / "pictures"
OUTPUT = Path(__file__).parents[3] / "out" / "pictures"
UPDATE = "BOZZETTO_UPDATE_PICTURES"
SIZE = (400, 300)


def pear():
    """A surface of revolution with a neck, and nothing flat."""
    u, v = np.meshgrid(np.linspace(0, np.pi, 61), np.linspace(0, 2 * np.pi, 97), indexing="ij")
    r = np.sin(u) * (30 - 13 * np.cos(u) - 7 * np.cos(3 * u))
    points = np.stack((r * np.cos(v), r * np.sin(v), 55 * np.cos(u)), -1).reshape(-1, 3)
    i = (np.arange(60)[:, None] * 97 + np.arange(96)).ravel()
    faces = np.concatenate((np.stack((i, i + 97, i + 1), 1), np.stack((i + 1, i + 97, i + 98), 1)))
    return Mesh(points.astype(np.float32), faces)


def ring(radius, height, **options):
    t = np.linspace(0, 2 * np.pi, 121)
    return Lines(np.stack((radius * np.cos(t), radius * np.sin(t), height + 0 * t), 1), **options)


def still_life():
    return scene_of(
        Shaded(pear()),
        Shaded(box((40, 40, 40), (75, 0, -40))),
        Shaded(sphere(18, 40, (70, -8, -2))),
    )


def drawing():
    t = np.linspace(0, 1, 90)
    ink = np.stack((-60 + 130 * t, -60 + 0 * t, 20 * np.sin(7 * t)), 1)
    return scene_of(
        Shaded(pear()),
        Lines(ink, width=1 + 5 * np.sin(np.pi * t) ** 2),
        ring(55, 0.0, color="second", width=2, hidden="dashed"),
        ring(50, -30.0, color="accent", width=2),
        Points(ink[::15], "accent", 7),
        Handle("h", (0, -60, 45)),
    )


def see_through():
    shades = np.zeros((32, 32, 4), np.uint8)
    shades[..., :3] = (np.indices((32, 32)).sum(0) // 4 % 2 * 90 + 140)[..., None]
    shades[..., 3] = 255
    return scene_of(
        Image(shades, (-60, 60, 60), (120, 0, 0), (0, 0, -120), 0.8),
        Shaded(pear(), "accent"),
        Shaded(box((110, 110, 118)), "second", 0.25),
    )


def on_ground(scene, camera):
    return Scene((ground_grid(camera, -60.0),)) + scene


PICTURES = {
    "clay-light": (still_life, LIGHT, "clay", "perspective", True),
    "clay-dark": (still_life, DARK, "clay", "perspective", True),
    "turning": (still_life, LIGHT, "clay", "orthographic", False),
    "drawing": (drawing, LIGHT, "clay", "perspective", True),
    "see-through": (see_through, LIGHT, "clay", "perspective", True),
    "zebra": (still_life, LIGHT, "zebra", "perspective", True),
    "curvature": (drawing, DARK, "curvature", "perspective", True),
    "normals": (still_life, LIGHT, "normals", "orthographic", True),
    "xray": (drawing, LIGHT, "xray", "perspective", True),
}


@pytest.mark.parametrize("name", PICTURES)
def test_the_picture_is_as_it_was(name):
    make, palette, shading, kind, antialias = PICTURES[name]
    scene = make()
    camera = Camera(kind, viewport=SIZE)
    camera = fit(standard_view(camera, "three-quarter"), scene.bounds(), 0.02)
    actual = render(on_ground(scene, camera), camera, palette, shading=shading, antialias=antialias)
    path = GOLDEN / f"{name}.png"
    if os.environ.get(UPDATE) == "1":
        path.parent.mkdir(parents=True, exist_ok=True)
        write_png(path, actual)
    golden = read(path)
    difference = np.abs(actual.astype(int) - golden)
    if difference.mean() >= 1 or (difference.max(-1) <= 8).mean() < 0.995:
        OUTPUT.mkdir(parents=True, exist_ok=True)
        write_png(OUTPUT / f"{name}-actual.png", actual)
        shown = np.clip(8 * difference, 0, 255).astype(np.uint8)
        shown[..., 3] = 255
        write_png(OUTPUT / f"{name}-difference.png", shown)
        pytest.fail(f"{name} has changed; see {OUTPUT}, or set {UPDATE}=1 if it is meant to")


def read(path):
    from PIL import Image as Pillow

    with Pillow.open(path) as image:
        return np.asarray(image.convert("RGBA")).astype(int)
