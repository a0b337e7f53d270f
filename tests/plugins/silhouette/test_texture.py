"""A picture on a surface, and the atlas that it is baked into."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry import Texture
from bozzetto_silhouette.appearance.picture_projection import axes_of, projection_of
from bozzetto_silhouette.appearance.texture_baking import baked
from bozzetto_silhouette.appearance.uv_charts import MOST, PADDING, laid_out
from bozzetto_silhouette.appearance.vertex_colors import Coat
from bozzetto_silhouette.model.state import Picture


def picture(pixels, corner=(-50.0, 0.0, 40.0), across=(100.0, 0, 0), down=(0, 0, -80.0)) -> Picture:
    return Picture(np.asarray(pixels, np.uint8), corner, across, down)


def noise(height: int = 64, width: int = 80, seed: int = 5) -> np.ndarray:
    """Patches of colour, opaque."""
    random = np.random.default_rng(seed)
    coarse = random.integers(0, 256, (height // 8, width // 8, 4)).astype(np.uint8)
    coarse[..., 3] = 255
    return coarse.repeat(8, axis=0).repeat(8, axis=1)


def directions(count: int, seed: int = 1) -> np.ndarray:
    normals = np.random.default_rng(seed).normal(size=(count, 3))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def turn(seed: int = 2) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def test_front_and_back_have_the_same_place_of_the_picture():
    pixels = np.zeros((10, 20, 4), np.uint8)
    pixels[:, :10], pixels[:, 10:] = (255, 0, 0, 255), (0, 0, 255, 255)
    projection = projection_of(picture(pixels), 10.0, 0.1)
    places = np.array([[-20.0, -9, 3], [-20.0, 9, 3], [20.0, -9, 3], [20.0, 9, 3]])
    normals = np.array([[0.0, -1, 0], [0, 1, 0]] * 2)
    coat = projection.coat(places, normals)
    np.testing.assert_allclose(coat.rgb, [[255, 0, 0]] * 2 + [[0, 0, 255]] * 2)
    np.testing.assert_allclose(coat.cover, 1.0)


def test_the_picture_lies_the_right_way_up():
    pixels = np.full((4, 4, 4), 255, np.uint8)
    pixels[0, 0] = (255, 0, 0, 255)  # top left as seen from the front
    coat = projection_of(picture(pixels), 1.0, 0.1).coat(
        np.array([[-37.5, 0, 30], [37.5, 0, 30], [-37.5, 0, -30]]), np.array([[0, -1.0, 0]] * 3)
    )
    np.testing.assert_allclose(coat.rgb[0], (255, 0, 0))
    np.testing.assert_allclose(coat.rgb[1:], 255)


def test_a_mirrored_picture_gives_mirrored_colours():
    pixels = noise()
    places = np.random.default_rng(4).uniform(-45, 45, (300, 3)) * (1, 0.4, 0.8)
    normals = directions(300)
    flip = np.array([-1.0, 1, 1])
    one = projection_of(picture(pixels), 12.0, 0.1).coat(places, normals)
    two = projection_of(picture(pixels[:, ::-1]), 12.0, 0.1).coat(places * flip, normals * flip)
    np.testing.assert_allclose(one.rgb, two.rgb, atol=1e-2)
    np.testing.assert_allclose(one.cover, two.cover, atol=1e-6)


def test_colours_turn_with_the_picture():
    rotation, shift = turn(), np.array([30.0, -200.0, 9.0])
    places, normals = np.random.default_rng(4).uniform(-40, 40, (300, 3)), directions(300)
    plain = picture(noise())
    turned = Picture(
        plain.pixels,
        tuple(rotation @ plain.corner + shift),
        tuple(rotation @ plain.across),
        tuple(rotation @ plain.down),
    )
    one = projection_of(plain, 12.0, 0.1).coat(places, normals)
    two = projection_of(turned, 12.0, 0.1).coat(places @ rotation.T + shift, normals @ rotation.T)
    np.testing.assert_allclose(one.rgb, two.rgb, atol=1e-2)


def test_beside_the_picture_nothing_is_covered():
    places = np.array([[-50.1, 0, 0], [50.1, 0, 0], [0, 0, 40.1], [0, 0, -40.1], [0, 0, 0]])
    coat = projection_of(picture(noise()), 1.0, 0.1).coat(places, np.array([[0, -1.0, 0]] * 5))
    np.testing.assert_array_equal(coat.cover, [0, 0, 0, 0, 1])


def test_the_paper_around_a_drawing_does_not_show_on_the_sides():
    """A red disc drawn a little smaller than the ball that it is traced by, on white paper."""
    y, x = np.mgrid[0:800, 0:1000] / 10.0 + 0.05
    pixels = np.full((800, 1000, 4), 255, np.uint8)
    pixels[np.hypot(x - 50, y - 40) < 29.5] = (200, 0, 0, 255)
    normals = directions(4000)
    coat = projection_of(picture(pixels), 30.0, 0.5).coat(30.0 * normals, normals)
    assert np.quantile(coat.rgb[:, 1], 0.99) < 40
    assert coat.rgb[:, 1].max() < 90


def test_colours_change_smoothly_from_the_front_over_the_side():
    angle = np.linspace(0.0, np.pi, 4000)
    normals = np.column_stack([np.sin(angle), -np.cos(angle), 0.0 * angle])
    smooth = np.zeros((80, 100, 4), np.uint8)
    smooth[..., 0], smooth[..., 3] = np.linspace(0, 250, 100), 255
    coat = projection_of(picture(smooth), 20.0, 0.1).coat(20.0 * normals, normals)
    assert np.abs(np.diff(coat.rgb[:, 0])).max() < 1.0


def test_what_is_transparent_lends_no_colour():
    pixels = np.zeros((40, 40, 4), np.uint8)
    pixels[..., 0] = 255  # red, and clear
    pixels[10:30, 10:30] = (0, 0, 255, 255)
    normals = directions(2000)
    coat = projection_of(picture(pixels), 30.0, 0.5).coat(30.0 * normals, normals)
    rgba, cover = coat.bytes()
    assert (rgba[cover > 1][:, 0] <= 1).all()
    assert 0 < (cover > 0).mean() < 1


HOSTILE = {
    "one pixel": picture(np.full((1, 1, 4), 255)),
    "one row": picture(np.full((1, 3000, 4), 255)),
    "one column": picture(np.full((3000, 1, 4), 255)),
    "clear": picture(np.zeros((9, 9, 4))),
    "a line": picture(noise(), across=(1.0, 2.0, 3.0), down=(2.0, 4.0, 6.0)),
    "a point": picture(noise(), across=(0.0, 0.0, 0.0), down=(0.0, 0.0, 0.0)),
    "askew": picture(noise(), across=(90.0, 10.0, 30.0), down=(10.0, 3.0, -70.0)),
    "tiny": picture(noise(), across=(1e-9, 0, 0), down=(0, 0, -1e-9)),
    "huge": picture(noise(), across=(1e9, 0, 0), down=(0, 0, -1e9)),
    "far": picture(noise(), corner=(1e12, 1e12, 1e12)),
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("radius", [1e-6, 30.0, 1e7])
def test_odd_pictures_give_colours_all_the_same(name, radius):
    normals = directions(200)
    coat = projection_of(HOSTILE[name], radius, 0.5).coat(radius * normals, normals)
    assert np.isfinite(coat.rgb).all()
    assert ((coat.cover >= 0) & (coat.cover <= 1 + 1e-6)).all()
    assert (coat.rgb <= 255.0 * coat.cover[:, None] + 1e-2).all()
    np.testing.assert_allclose(
        axes_of(HOSTILE[name]) @ axes_of(HOSTILE[name]).T, np.eye(3), atol=1e-9
    )


# -- the atlas --


def torus(nu: int = 60, nv: int = 30) -> tuple[np.ndarray, np.ndarray]:
    u, v = np.meshgrid(
        np.arange(nu) * 2 * np.pi / nu, np.arange(nv) * 2 * np.pi / nv, indexing="ij"
    )
    r = 30 + 9 * np.cos(v)
    vertices = np.stack((r * np.cos(u), 9 * np.sin(v), r * np.sin(u)), -1).reshape(-1, 3)
    return vertices, wrapped(nu, nv)[:, ::-1]


def wrapped(nu: int, nv: int) -> np.ndarray:
    i, j = np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij")
    a, b = (i * nv + j).ravel(), ((i + 1) % nu * nv + j).ravel()
    c, d = ((i + 1) % nu * nv + (j + 1) % nv).ravel(), (i * nv + (j + 1) % nv).ravel()
    return np.vstack((np.c_[a, b, c], np.c_[a, c, d])).astype(np.int32)


def ramp(turns: float = 2.5) -> tuple[np.ndarray, np.ndarray]:
    """A band that winds up: seen from above it covers itself, and hangs together."""
    angle = np.linspace(0.0, 2 * np.pi * turns, 200)
    vertices = np.stack(
        [
            np.stack((r * np.cos(angle), 2.5 * angle, r * np.sin(angle)), 1)
            for r in (10.0, 30.0)
        ],
        axis=1,
    ).reshape(-1, 3)  # fmt: skip
    k = 2 * np.arange(len(angle) - 1)
    faces = np.vstack((np.c_[k, k + 1, k + 3], np.c_[k, k + 3, k + 2]))
    return vertices, faces.astype(np.int32)


def rubble(count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Triangles in all directions, some without area, on top of each other."""
    random = np.random.default_rng(8)
    vertices = random.normal(size=(3 * count, 3)) * 5 + random.normal(size=(count, 3)).repeat(3, 0)
    vertices[:30] = vertices[0]
    vertices[30:60, 2] = 0.0
    return vertices, np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


SHAPES = {"torus": torus, "ramp": ramp, "rubble": rubble}


@pytest.mark.parametrize("name", SHAPES)
def test_no_texel_is_used_twice(name):
    """Brute force, face by face: no middle of a texel lies inside two of them."""
    vertices, faces = SHAPES[name]()
    layout = laid_out(vertices, faces, np.eye(3), 2.0)
    width, height = layout.size
    used = np.zeros((height, width), int)
    for corners in layout.places:
        low = np.floor(corners.min(axis=0)).astype(int)
        high = np.ceil(corners.max(axis=0)).astype(int)
        x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
        signs = []
        for k in range(3):
            (ax, ay), (bx, by) = corners[k], corners[(k + 1) % 3]
            signs.append((bx - ax) * (y - ay) - (by - ay) * (x - ax))
        inside = np.all(np.array(signs) > 1e-9, axis=0) | np.all(np.array(signs) < -1e-9, axis=0)
        used[low[1] : high[1], low[0] : high[0]] += inside
    assert used.max() == 1


@pytest.mark.parametrize("name", SHAPES)
def test_everything_lies_within_the_atlas(name):
    vertices, faces = SHAPES[name]()
    layout = laid_out(vertices, faces, np.eye(3), 1.0)
    assert layout.places.min() >= PADDING
    assert (layout.places.max(axis=(0, 1)) <= np.array(layout.size) - PADDING).all()


@pytest.mark.parametrize("density", [1e-9, 1.0, 50.0, 1e12])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_an_atlas_is_never_too_large(density, scale):
    vertices, faces = torus(24, 12)
    layout = laid_out(vertices * scale, faces, np.eye(3), density)
    for side in layout.size:
        assert side <= MOST
        assert side & (side - 1) == 0


def lookup(texture: Texture, places: np.ndarray) -> np.ndarray:
    """Bilinear, as graphics cards do it."""
    height, width = texture.pixels.shape[:2]
    x, y = (places * (width, height) - 0.5).T
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - left)[:, None], (y - top)[:, None]
    grid = texture.pixels.astype(float)
    upper = grid[top, left] * (1 - fx) + grid[top, left + 1] * fx
    lower = grid[top + 1, left] * (1 - fx) + grid[top + 1, left + 1] * fx
    return upper * (1 - fy) + lower * fy


@pytest.mark.parametrize("turned", [False, True])
def test_what_is_baked_is_what_was_painted(turned):
    """Also on the edges of charts, where a texel of another one would show."""
    vertices, faces = torus()
    axes = turn() if turned else np.eye(3)

    def color(points: np.ndarray) -> np.ndarray:
        return 127.5 + 127.5 * np.sin(points / np.array([9.0, 7.0, 11.0]))

    def paint(face: np.ndarray, weights: np.ndarray, detail: float) -> Coat:
        points = np.einsum("nk,nkd->nd", weights, vertices[faces[face]])
        return Coat(color(points), np.ones(len(face)))

    texture = baked(vertices, faces, axes, 8.0, paint)
    random = np.random.default_rng(6)
    face = random.integers(0, len(faces), 20_000)
    weights = random.dirichlet([0.4, 0.4, 0.4], len(face))  # many close to edges and corners
    points = np.einsum("nk,nkd->nd", weights, vertices[faces[face]])
    places = np.einsum("nk,nkd->nd", weights, texture.corners[face].astype(float))
    off = np.abs(lookup(texture, places)[:, :3] - color(points)).max(axis=1)
    assert np.quantile(off, 0.99) < 3.0
    assert off.max() < 14.0
    assert (texture.pixels[..., 3] == 255).all()


def test_faces_thinner_than_a_texel_have_their_colour():
    vertices, faces = torus()
    texture = baked(
        vertices, faces, np.eye(3), 0.1,
        lambda face, weights, detail: Coat(np.full((len(face), 3), 77.0), np.ones(len(face))),
    )  # fmt: skip
    assert (texture.pixels[..., :3] == 77).all()
