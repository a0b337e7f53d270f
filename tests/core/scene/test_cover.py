"""Colours that leave a share to the whole: every viewer resolves them alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Mesh, Placement
from bozzetto.scene import DARK, LIGHT, Layer, Scene, Shaded
from bozzetto.scene.renderer import render
from bozzetto.view import Camera
from bozzetto.view.navigation import fit

BASE = (90, 160, 40)


def tent() -> Mesh:
    """A roof whose vertices are covered in full, in part and not at all."""
    vertices = [[-20, 0, 0], [20, 0, 0], [0, -8, 20], [0, -8, -20]]
    colors = [[250, 0, 0, 255], [0, 0, 250, 255], [9, 9, 9, 255], [200, 200, 0, 255]]
    cover = np.uint8([255, 0, 128, 64])
    return Mesh(vertices, [[0, 2, 3], [1, 3, 2]], colors=np.uint8(colors), cover=cover)


def picture(mesh: Mesh, color, palette) -> np.ndarray:
    scene = Scene((Layer("a", (Shaded(mesh, color),)),))
    camera = fit(Camera().with_viewport(160, 120), scene.bounds())
    return render(scene, camera, palette, size=(160, 120))


@pytest.mark.parametrize("palette", [LIGHT, DARK])
@pytest.mark.parametrize("color", ["clay", BASE])
def test_a_cover_looks_as_the_mixed_colours_do(palette, color):
    mesh = tent()
    under = np.array(palette.color(color))
    share = mesh.cover[:, None] / 255.0
    mixed = np.full((4, 4), 255, np.uint8)
    mixed[:, :3] = np.rint(share * mesh.colors[:, :3] + (1 - share) * under)
    plain = replace(mesh, colors=mixed, cover=None)
    np.testing.assert_array_equal(picture(mesh, color, palette), picture(plain, color, palette))


def test_the_window_gets_the_same_colours():
    buffers = pytest.importorskip("bozzetto_app.canvas.viewport.opengl_buffers")
    mesh = tent()
    plain = replace(mesh, colors=mesh.colors_over(BASE), cover=None)
    one, two = (buffers.surface([Shaded(m, BASE)], LIGHT, "clay") for m in (mesh, plain))
    np.testing.assert_array_equal(one.vertices, two.vertices)


def test_a_cover_moves_with_its_mesh():
    mesh = tent()
    np.testing.assert_array_equal(mesh.placed(Placement(scale=2.0)).cover, mesh.cover)


@pytest.mark.parametrize("cover", [np.zeros(3, np.uint8), np.zeros((4, 1), np.uint8)])
def test_a_cover_fits_its_mesh(cover):
    with pytest.raises(ValueError, match="cover"):
        replace(tent(), cover=cover)
    with pytest.raises(ValueError, match="cover"):
        replace(tent(), colors=None)
