"""Stripes against mirrors computed pixel by pixel, and against what stripes are there to show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Mesh, Placement
from bozzetto.scene import DARK, LIGHT, Layer, Scene, Shaded
from bozzetto.scene.renderer import render
from bozzetto.scene.renderer.shading import fragments
from bozzetto.scene.renderer.triangle_soup import gather
from bozzetto.scene.renderer.view_transform import view_transform
from bozzetto.scene.renderer.zbuffer import blank_buffer, rasterize
from bozzetto.scene.renderer.zebra import TUBES, stripes
from bozzetto.view.camera import Camera
from tests.core.scene.shapes import scene_of, sphere

SIZE = (240, 180)


def light_on(mesh, camera):
    """The tubes' light at every pixel of a picture, NaN beside the mesh."""
    width, height = SIZE
    sight = view_transform(camera, height, width, (0, 0, width, height))
    triangles = gather([mesh], [None], sight)
    buffer = blank_buffer(width, height)
    rasterize(buffer, triangles.places, triangles.faces)
    seen = fragments(buffer.triangle, triangles, sight, tinted=False)
    picture = np.full(height * width, np.nan)
    picture[seen.pixel] = stripes(seen, sight)
    return picture.reshape(height, width)


def turned(points, degrees):
    a = np.radians(degrees)
    return np.asarray(points) @ np.array(
        [[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]]
    )


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_ball_mirrors_the_rings(kind):
    """Rays through 64 places of each pixel, mirrored in the ball they meet."""
    camera = Camera(kind, (90.0, -260.0, 70.0), fov_y=15.0, height=70.0, viewport=SIZE)
    found = light_on(sphere(25.0, 128, normals=True), camera)
    fine = 8
    y, x = (np.indices((SIZE[1] * fine, SIZE[0] * fine)).reshape(2, -1) + 0.5) / fine
    rays = camera.rays(np.column_stack((x, y)))
    along = (rays.origins * rays.directions).sum(1)
    inside = along**2 - (rays.origins**2).sum(1) + 25.0**2
    hit = inside > 0
    normal = rays.origins[hit] - (along[hit] + np.sqrt(inside[hit]))[:, None] * rays.directions[hit]
    normal /= 25.0
    gone = rays.directions[hit]
    gone = gone - 2 * (gone * normal).sum(1)[:, None] * normal
    tube = np.degrees(np.arcsin(np.clip(gone[:, 2], -1, 1))) / (180.0 / TUBES)
    light = np.full(len(x), np.nan)
    light[hit] = np.abs(tube - np.rint(tube)) < 0.25
    blocks = light.reshape(SIZE[1], fine, SIZE[0], fine).swapaxes(1, 2)
    expected = blocks.reshape(*SIZE[::-1], -1).mean(2)  # NaN on the outline
    both = np.isfinite(expected) & np.isfinite(found)
    assert both.sum() > 8_000
    assert np.abs(found - expected)[both].mean() < 0.05
    assert np.abs(found - expected)[both].max() < 0.7  # where rings are finer than two pixels


def test_the_rings_look_the_same_from_all_around():
    eye = (40.0, -300.0, 90.0)
    mesh = sphere(1.0, 64, normals=True)
    mesh = Mesh(
        mesh.vertices * np.float32([20, 33, 14]), mesh.faces, unit(mesh.vertices / (20, 33, 14))
    )
    camera = Camera(eye=eye, fov_y=16.0, viewport=SIZE)
    there = light_on(mesh, camera)
    round_ = Mesh(turned(mesh.vertices, 77), mesh.faces, turned(mesh.normals, 77))
    again = light_on(round_, replace(camera, eye=tuple(turned([eye], 77)[0])))
    assert np.nanmean(np.abs(there - again)) < 0.01
    tilted = light_on(mesh, replace(camera, eye=(40.0, -290.0, -120.0)))
    assert np.nanmean(np.abs(there - tilted)) > 0.2


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


LEAN = np.radians(50.0)
"""Of the join from the upright, so that a crease turns the mirrored sight upward or downward."""


ROUND = 500.0
"""Radius of the cylinder; the sheet is 120 long."""


def bent_sheet(crease):
    """A flat wall that goes over into a cylinder, with a crease of some degrees at the join."""
    s = np.linspace(0.0, 60.0, 121)
    angle = np.concatenate((0.0 * s, s / ROUND + np.radians(crease)))
    x = np.concatenate((s - 60.0, ROUND * (np.sin(angle[121:]) - np.sin(angle[121]))))
    y = np.concatenate((0.0 * s, ROUND * (np.cos(angle[121]) - np.cos(angle[121:]))))
    z = np.array([-40.0, 40.0])
    points = np.stack(np.broadcast_arrays(x[:, None], y[:, None], z), -1).reshape(-1, 3)
    normals = np.repeat(np.stack((np.sin(angle), -np.cos(angle), 0.0 * angle), 1), 2, axis=0)
    roll = np.array([[np.cos(LEAN), 0, -np.sin(LEAN)], [0, 1, 0], [np.sin(LEAN), 0, np.cos(LEAN)]])
    i = 2 * np.concatenate((np.arange(120), 121 + np.arange(120)))
    faces = np.concatenate((np.stack((i, i + 2, i + 1), 1), np.stack((i + 1, i + 2, i + 3), 1)))
    return Mesh(points @ roll.T, faces, normals @ roll.T)


def beside_the_join(crease):
    """Light a pixel and a half to both sides of it."""
    camera = Camera(eye=(20.0, -170.0, 0.0), fov_y=26.0, viewport=SIZE)
    light = light_on(bent_sheet(crease), camera)
    along = np.array([-np.sin(LEAN), 0.0, np.cos(LEAN)]) * np.linspace(-35, 35, 400)[:, None]
    places = camera.project(along)[0]
    off = 1.5 * np.array([np.cos(LEAN), -np.sin(LEAN)])
    inside = ((places > 4) & (places < np.array(SIZE) - 4)).all(1)
    return [light[tuple((places[inside] + s * off).astype(int).T[::-1])] for s in (-1, 1)]


def test_stripes_break_at_a_crease_and_run_on_over_a_tangent():
    left, right = beside_the_join(0.0)
    assert np.ptp(left) > 0.9  # there are stripes to be seen
    smooth = np.abs(left - right).mean()
    creased = np.abs(np.subtract(*beside_the_join(1.5))).mean()
    assert smooth < 0.15
    assert creased > 3 * smooth


def test_stripes_too_fine_to_be_seen_are_grey():
    """Twenty-four tubes, mirrored twice over, in eight pixels."""
    camera = Camera(eye=(60.0, -200.0, 40.0), fov_y=30.0, viewport=SIZE)
    light = light_on(sphere(2.5, 64, normals=True), camera)
    assert 15 < np.isfinite(light).sum() < 60
    assert np.nanmean(np.abs(light - 0.5)) < 0.1  # sharp black and white have 0.5


# -- the finish ------------------------------------------------------------------------------------

CAMERA = Camera(eye=(60.0, -200.0, 40.0), fov_y=30.0, viewport=SIZE)
BALL = sphere(30.0, 32, normals=True)


def shot(*items, palette=LIGHT, **options):
    return render(scene_of(*items), CAMERA, palette, size=SIZE, **options).astype(int)


@pytest.mark.parametrize("palette", [LIGHT, DARK])
@pytest.mark.parametrize("opacity", [1.0, 0.4])
def test_a_polished_mesh_looks_as_all_do_in_the_zebra_view(palette, opacity):
    polished = shot(Shaded(BALL, opacity=opacity, finish="zebra"), palette=palette)
    view = shot(Shaded(BALL, opacity=opacity), palette=palette, shading="zebra")
    np.testing.assert_array_equal(polished, view)
    assert np.abs(polished - shot(Shaded(BALL, opacity=opacity), palette=palette)).max() > 40


@pytest.mark.parametrize("shading", ["zebra", "curvature", "normals", "xray"])
def test_a_view_with_a_shading_of_its_own_takes_no_notice(shading):
    polished, plain = (shot(Shaded(BALL, finish=f), shading=shading) for f in ("zebra", "clay"))
    np.testing.assert_array_equal(polished, plain)


def test_a_matte_mesh_beside_a_polished_one_stays_as_it_is():
    beside = Shaded(sphere(9.0, 16, (55.0, 0.0, 30.0), normals=True), "second")
    alone = shot(beside)
    both = shot(beside, Shaded(BALL, finish="zebra"))
    x, y = CAMERA.project([(55.0, 0.0, 30.0)])[0][0].astype(int)
    window = np.s_[y - 4 : y + 5, x - 4 : x + 5]
    np.testing.assert_array_equal(both[window], alone[window])


def test_a_hint_of_the_bodys_colour_is_in_the_stripes():
    red = np.tile(np.uint8([230, 20, 20, 255]), (len(BALL.vertices), 1))
    own = shot(Shaded(Mesh(BALL.vertices, BALL.faces, BALL.normals, red), finish="zebra"))
    named = shot(Shaded(BALL, (230, 20, 20), finish="zebra"))
    np.testing.assert_allclose(own, named, atol=1)
    red_more = (own - shot(Shaded(BALL, (20, 20, 230), finish="zebra")))[90, 120]
    assert 15 < red_more[0] < 60
    assert -60 < red_more[2] < -15


def test_the_finish_goes_with_the_mesh_and_is_checked():
    scene = Scene((Layer("a", (Shaded(BALL, finish="zebra"),)),)).placed(Placement(scale=2.0))
    assert scene.layers[0].items[0].finish == "zebra"
    with pytest.raises(ValueError, match="no finish 'chrome'"):
        Shaded(BALL, finish="chrome")
