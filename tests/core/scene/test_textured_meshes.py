"""Pictures wrapped around meshes, as both are seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Mesh, Placement, Texture
from bozzetto.scene import LIGHT, Layer, Scene, Shaded
from bozzetto.scene.renderer import render
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view

FRONT = standard_view(Camera(viewport=(300, 240)), "front")
SIDE = 100.0
"""Of the square in the plane y = 0, mm."""


def square(cells: int = 1, y=lambda u, v: 0.0 * u) -> tuple[Mesh, np.ndarray]:
    """A square towards the front, with the places (f, 3, 2) of its corners in a picture."""
    u, v = (a.ravel() for a in np.meshgrid(*[np.linspace(0, 1, cells + 1)] * 2))
    points = np.column_stack([(u - 0.5) * SIDE, y(u, v), (0.5 - v) * SIDE])
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    below, beside, across = a + cells + 1, a + 1, a + cells + 2
    faces = np.concatenate([np.stack(f, 1) for f in ((a, below, beside), (beside, below, across))])
    return Mesh(points.astype(np.float32), faces), np.stack([u, v], 1)[faces]


def ramps(size: int = 64) -> np.ndarray:
    """Red grows to the right, green down: linear between the middles of texels."""
    middle = (np.arange(size) + 0.5) / size * 255
    pixels = np.zeros((size, size, 4), np.uint8)
    pixels[..., 0], pixels[..., 1], pixels[..., 2:] = middle, middle[:, None], (90, 255)
    return pixels


def by_vertices(mesh: Mesh, places: np.ndarray) -> Mesh:
    """The same ramps as colours of vertices."""
    colors = np.full((len(mesh.vertices), 4), 255, np.uint8)
    colors[mesh.faces, :2] = np.rint(places * 255)
    colors[..., 2] = 90
    return replace(mesh, colors=colors)


def seen(item: Shaded, camera: Camera = FRONT, **more) -> np.ndarray:
    return render(Scene((Layer("m", (item,)),)), camera, LIGHT, **more).astype(float)


def inner(picture: np.ndarray, other: np.ndarray) -> float:
    """Largest difference of two pictures but for places near edges of what they show."""
    paper = np.abs(other[..., :3] - np.array(LIGHT.paper)).max(axis=2) < 1
    near = np.ones(paper.shape, bool)
    near[4:-4, 4:-4] = False
    for dy, dx in np.ndindex(9, 9):
        near |= np.roll(paper, (dy - 4, dx - 4), (0, 1))
    assert (~near).mean() > 0.05
    return float(np.abs(picture - other)[~near].max())


@pytest.mark.parametrize("name", ["front", "three-quarter"])
@pytest.mark.parametrize("opacity", [1.0, 0.6])
def test_two_triangles_with_a_picture_look_like_many_with_colours(name, opacity):
    """Also in perspective, where places on the sheet are not shares of those in the picture."""
    camera = standard_view(replace(FRONT, eye=(0.0, -150.0, 0.0)), name)
    (coarse, places), (fine, fine_places) = square(), square(48)
    textured = Shaded(coarse, opacity=opacity, texture=Texture(ramps(), places))
    wanted = Shaded(by_vertices(fine, fine_places), opacity=opacity)
    assert inner(seen(textured, camera), seen(wanted, camera)) < 6


def test_a_triangle_that_reaches_behind_the_eye_keeps_its_places():
    floor = Placement((1, 0, 0, 0, 0, 1, 0, -1, 0), 1.0, (0, 0, -20))  # faces up
    camera = Camera(
        "perspective", (0.0, -10.0, 5.0), (0.0, 30.0, -18.0), (0, 0, 1), viewport=(300, 240)
    )
    (coarse, places), (fine, fine_places) = square(), square(64)
    one = Shaded(coarse, texture=Texture(ramps(), places)).placed(floor)
    other = Shaded(by_vertices(fine, fine_places)).placed(floor)
    assert (coarse.placed(floor).vertices[:, 1] < -10).any(), "some corners are behind the eye"
    assert inner(seen(one, camera), seen(other, camera)) < 6


@pytest.mark.parametrize("axis", [0, 2])
def test_a_mirrored_object_has_a_mirrored_picture(axis):
    mesh, places = square(3)
    item = Shaded(mesh, texture=Texture(ramps(), places))
    across = np.eye(3)
    across[axis, axis] = -1.0
    mirror = Placement(tuple(across.ravel().tolist()))
    flipped = np.flip(seen(item), axis=1 if axis == 0 else 0)
    # Shading lights one side more: what is compared is the hue.
    ratios = [one[..., 0] / one[..., 2] for one in (seen(item.placed(mirror)), flipped)]
    assert np.ptp(ratios[1][90:150, 120:180]) > 0.3
    np.testing.assert_allclose(ratios[0][90:150, 120:180], ratios[1][90:150, 120:180], atol=0.05)


def test_where_the_picture_is_clear_the_colour_shows():
    mesh, places = square()
    pixels = ramps()
    pixels[:, 32:, 3] = 0
    half = seen(Shaded(mesh, (20, 40, 200), texture=Texture(pixels, places)))
    plain = seen(Shaded(replace(mesh, colors=np.full((4, 4), (20, 40, 200, 255), np.uint8))))
    np.testing.assert_allclose(half[90:150, 156:180], plain[90:150, 156:180], atol=2)
    assert np.abs(half[90:150, 120:144] - plain[90:150, 120:144]).min(axis=(0, 1)).max() > 30


def test_a_fine_picture_seen_small_is_its_mean():
    """Some of its texels would be a pattern that is not there."""
    mesh, places = square()
    board = np.full((1024, 1024, 4), 255, np.uint8)
    board[..., :3] = (np.indices((1024, 1024)).sum(0) % 2 * 255)[..., None]
    picture = seen(Shaded(mesh, texture=Texture(board, places)))[90:150, 120:180, :3]
    assert picture.std(axis=(0, 1)).max() < 4
    grey = seen(Shaded(replace(mesh, colors=np.full((4, 4), (127, 127, 127, 255), np.uint8))))
    np.testing.assert_allclose(picture.mean((0, 1)), grey[90:150, 120:180, :3].mean((0, 1)), atol=2)


@pytest.mark.parametrize("shading", ["curvature", "draft"])
def test_shadings_with_colours_of_their_own_show_no_picture(shading):
    mesh, places = square(4, lambda u, v: 20 * np.sin(3 * u))
    plain = Shaded(mesh)
    textured = Shaded(mesh, texture=Texture(ramps(), places))
    one, other = seen(textured, shading=shading), seen(plain, shading=shading)
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("shading", ["clay", "zebra", "normals", "xray"])
def test_beside_a_textured_mesh_others_look_as_they_did(shading):
    mesh, places = square()
    textured = Shaded(mesh, texture=Texture(ramps(), places)).placed(Placement(offset=(-400, 0, 0)))
    other = Shaded(square(5, lambda u, v: 9 * u * v)[0], "accent")
    both = Scene((Layer("m", (textured, other)),))
    alone = Scene((Layer("m", (other,)),))
    one, two = (render(scene, FRONT, LIGHT, shading=shading) for scene in (both, alone))
    np.testing.assert_allclose(one.astype(float), two.astype(float), atol=1)


def test_a_texture_for_other_faces_is_refused():
    mesh, places = square(2)
    with pytest.raises(ValueError, match="every corner of every face"):
        Shaded(mesh, texture=Texture(ramps(), places[:-1]))


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (3, 2)])
def test_tiny_pictures_are_shown(size):
    mesh, places = square()
    pixels = np.full((*size, 4), (250, 10, 10, 255), np.uint8)
    shown = seen(Shaded(mesh, texture=Texture(pixels, places)))[100:140, 130:170]
    plain = seen(Shaded(replace(mesh, colors=np.full((4, 4), (250, 10, 10, 255), np.uint8))))
    np.testing.assert_allclose(shown, plain[100:140, 130:170], atol=2)
