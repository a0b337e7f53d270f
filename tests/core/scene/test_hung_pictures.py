"""Pictures on rectangles, against rays through every pixel and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.ndimage import minimum_filter

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import LIGHT, Image, Lines, Shaded
from bozzetto.scene.renderer import render
from bozzetto.scene.renderer.image_layers import blend_pictures, place_picture
from bozzetto.scene.renderer.image_warp import interpolated
from bozzetto.scene.renderer.view_transform import view_transform
from bozzetto.view.camera import Camera
from tests.core.scene.shapes import box, scene_of, sphere

SIZE = (120, 90)
WIDTH, HEIGHT = SIZE
PAPER = np.array(LIGHT.paper)
FRONT = Camera("orthographic", eye=(0, -500, 0), height=90, viewport=SIZE)  # 1 px per mm


def slopes(height=64, width=96):
    """A picture whose red is the place across and whose green is the place down."""
    pixels = np.zeros((height, width, 4), np.uint8)
    pixels[..., 0] = (np.arange(width) + 0.5) / width * 255 + 0.5
    pixels[..., 1] = ((np.arange(height) + 0.5) / height * 255 + 0.5)[:, None]
    pixels[..., 3] = 255
    return pixels


def plain(color, opacity=255):
    return np.full((8, 8, 4), (*color, opacity), np.uint8)


def upright(pixels, y=0.0, size=(60.0, 40.0), opacity=1.0):
    """A picture that faces the front view, its middle on the y axis."""
    w, h = size
    return Image(pixels, (-w / 2, y, h / 2), (w, 0.0, 0.0), (0.0, 0.0, -h), opacity)


def on_sheet(image, camera):
    return place_picture(image, view_transform(camera, HEIGHT, WIDTH, (0, 0, WIDTH, HEIGHT)))


def shown(image, camera):
    """Colours on the whole sheet, (h, w, 4)."""
    colors = np.zeros((HEIGHT, WIDTH, 4))
    hung = on_sheet(image, camera)
    if hung is not None:
        colors[hung.top : hung.bottom, hung.left : hung.right] = hung.colors
    return colors


def rays_to(image, camera, fineness=1):
    """Where rays meet a picture, in parts of its sides, (h, w, 2); NaN where they do not."""
    y, x = (np.indices((fineness * HEIGHT, fineness * WIDTH)) + 0.5) / fineness
    across, down = np.array(image.across), np.array(image.down)
    hits = camera.on_plane(
        np.column_stack((x.ravel(), y.ravel())), image.corner, np.cross(across, down)
    )
    away = hits - image.corner
    sides = np.column_stack((across, down))
    return (away @ np.linalg.pinv(sides).T).reshape(*y.shape, 2)


def random_view(seed):
    """A picture and a camera anywhere near it, also with part of it behind the eye."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-2, 5)
    across, down = random.normal(0, 60, (2, 3))
    corner = random.normal(0, 20, 3) - 0.5 * (across + down)
    eye = random.normal(size=3) * 10.0 ** random.uniform(0, 2.5)
    target = random.normal(0, 20, 3)
    image = Image(slopes(), *(tuple((size * v).tolist()) for v in (corner, across, down)))
    camera = Camera(
        str(random.choice(["perspective", "orthographic"])),
        tuple(size * eye),
        tuple(size * target),
        tuple(random.normal(size=3)),
        fov_y=random.uniform(10, 120),
        height=size * 10.0 ** random.uniform(0.5, 3),
        viewport=SIZE,
    )
    return image, camera


def widest_step(place, axis):
    """How far the picture moves from a pixel to its neighbour, to the side where it moves more."""
    steps = np.abs(np.diff(place, axis=axis))
    ends = ((0, 0),) * axis, ((0, 0),) * (place.ndim - axis - 1)
    before, after = (np.pad(steps, (*ends[0], side, *ends[1])) for side in ((1, 0), (0, 1)))
    return np.fmax(before, after)


@given(st.integers(0, 10**6))
@example(814)  # a pixel at a corner that shows a fifth of the picture across
@example(849)
@example(79503)  # strong perspective: one side of a pixel shows more than the other
@settings(max_examples=60, deadline=None)
def test_every_pixel_shows_what_its_rays_meet(seed):
    image, camera = random_view(seed)
    colors = shown(image, camera)
    fine = rays_to(image, camera, 4)
    with np.errstate(invalid="ignore"):
        met = ((fine >= 0) & (fine <= 1)).all(-1).reshape(HEIGHT, 4, WIDTH, 4).mean((1, 3))
    off = np.abs(colors[..., 3] / 255 - met)
    # a ray that hits the border itself may count or not
    assert off.max() <= 0.13
    assert (off > 0.01).sum() <= 4
    place = rays_to(image, camera)
    # over as much as a pixel shows of it, a picture may be blurred
    blur = sum(widest_step(place, axis) for axis in (0, 1))
    whole = (colors[..., 3] == 255) & np.isfinite(blur).all(-1)
    wrong = np.abs(colors[..., :2] - 255 * place)
    inside = minimum_filter(whole, 3, mode="constant")
    assert (wrong[inside] <= 4 + 255 * blur[inside]).all()
    # at the border one side of a pixel's share is missing, by a texel and by the wider of both ways
    border = whole & ~inside
    widest = (blur * (96, 64)).max(-1, keepdims=True) / (96, 64)
    assert (wrong[border] <= 8 + 255 * widest[border]).all()


@given(st.floats(0.05, 60), st.floats(0.05, 60), st.floats(0, 180), st.floats(-2, 2))
@settings(max_examples=60, deadline=None)
def test_the_border_covers_pixels_by_their_share(wide, high, angle, shift):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    across, down = wide * np.array((c, 0, s)), high * np.array((s, 0, -c))
    corner = np.array((shift, 0, 0.3 * shift)) - 0.5 * (across + down)
    pixels = plain((200, 100, 50))
    image = Image(pixels, *(tuple(v.tolist()) for v in (corner, across, down)))
    area = shown(image, FRONT)
    # the border is known to a quarter of a pixel at worst, where it runs along the samples, and
    # the share of each of its pixels to half a byte
    pixels_on_it = 3 * (wide + high) + 8
    bound = 0.25 * (wide + high) + 0.0625 + pixels_on_it * 0.5 / 255
    assert area[..., 3].sum() / 255 == pytest.approx(wide * high, abs=bound)
    solid = area[area[..., 3] == 255]
    assert (np.abs(solid[:, :3] - (200, 100, 50)) <= 1).all()


def test_very_small_pictures_have_their_area():
    for size in (0.2, 0.6, 1.3):
        for x in (-40.0, 0.3, 17.9):
            image = Image(plain((9, 9, 9)), (x, 0, 0.4), (size, 0, 0), (0, 0, -size))
            # four samples along each axis: each side is known to a quarter of a pixel
            covered = shown(image, FRONT)[..., 3].sum() / 255
            assert covered == pytest.approx(size * size, abs=0.5 * size + 0.0625)


@pytest.mark.parametrize("tilt", [0.0, 60.0, 80.0])
def test_checks_too_fine_to_see_are_grey_also_at_a_slant(tilt):
    pixels = np.zeros((1024, 1024, 4), np.uint8)
    pixels[..., 3] = 255
    pixels[np.indices((1024, 1024)).sum(0) % 2 == 0, :3] = 255
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    image = Image(pixels, (-35, -35 * s, 35 * c), (70, 0, 0), (0, 70 * s, -70 * c))
    camera = Camera(eye=(0, -120, 0), viewport=SIZE, fov_y=45)
    colors = shown(image, camera)
    solid = colors[colors[..., 3] == 255][:, :3]
    assert len(solid) > 300
    np.testing.assert_allclose(solid, 127.5, atol=6)


@given(st.integers(0, 10**6))
@settings(max_examples=60, deadline=None)
def test_square_on_and_a_little_turned_look_the_same(seed):
    """The one is scaled, the other goes through the homography."""
    random = np.random.default_rng(seed)
    pixels = np.repeat(np.repeat(random.integers(0, 256, (7, 9, 4), np.uint8), 5, 0), 5, 1)
    middle, size = random.normal(0, 25, 2), random.uniform(5, 300, 2)
    scale = np.array((1.0, -1.0)) * size
    corner = middle - 0.5 * scale
    eye = (float(random.normal()), -200.0, float(random.normal()))

    def look(turn):
        across = (size[0], 0.0, turn * size[0])
        image = Image(pixels, (corner[0], 0, corner[1]), across, (0, 0, -size[1]))
        target = (eye[0], 0.0, eye[2])
        return shown(image, Camera(("perspective", "orthographic")[seed % 2], eye, target,
                                   height=90, viewport=SIZE))  # fmt: skip

    square, turned = look(0.0), look(1.2e-3 if seed % 3 else -1.2e-3)
    # a picture made smaller is smoothed a little more by the one than by the other
    assert np.abs(square - turned).mean() < 4
    # nothing that is there for the one is missing from the other
    for one, other in ((square, turned), (turned, square)):
        assert ((one[..., 3] > 128) & (other[..., 3] == 0)).mean() < 2e-3


# -- over each other ---------------------------------------------------------------------------


def seen(*items, camera=FRONT, **options):
    return render(scene_of(*items), camera, LIGHT, **options)[HEIGHT // 2, WIDTH // 2].astype(int)


@given(st.floats(0.02, 1.0), st.integers(1, 255))
@settings(max_examples=25, deadline=None)
def test_opacity_and_alpha_blend_by_the_formula(opacity, alpha):
    share = opacity * alpha / 255
    color = np.array((200, 40, 90))
    image = upright(plain(color, alpha), opacity=opacity)
    np.testing.assert_allclose(seen(image)[:3], share * color + (1 - share) * PAPER, atol=2)
    clear = seen(image, background=False)
    assert clear[3] == pytest.approx(255 * share, abs=1.5)


@pytest.mark.parametrize("turned", [False, True])
def test_the_nearer_picture_lies_on_top_and_of_two_as_near_the_later(turned):
    red, blue = plain((200, 0, 0)), plain((0, 0, 200))
    for y, top in ((-10.0, 0), (10.0, 1), (0.0, 1)):
        pair = [upright(red, y, opacity=0.7), upright(blue, opacity=0.7)]
        if turned and y:
            pair.reverse()
            top = 1 - top
        over = (red, blue)[top] if not (turned and y) else (blue, red)[top]
        under = blue if over is red else red
        mixed = 0.7 * over[0, 0, :3] + 0.3 * (0.7 * under[0, 0, :3] + 0.3 * PAPER)
        np.testing.assert_allclose(seen(*pair)[:3], mixed, atol=2)


def test_pictures_that_cross_change_places_where_they_cross():
    def slanted(color, slope):
        return Image(plain(color), (-40, -40 * slope, 30), (80, 80 * slope, 0), (0, 0, -60), 0.8)

    red, blue = slanted((200, 0, 0), 0.3), slanted((0, 0, 200), -0.3)
    picture = render(scene_of(red, blue), FRONT, LIGHT).astype(int)
    left, right = picture[45, 35], picture[45, 85]
    assert left[0] > left[2], "red is nearer on the left"
    assert right[2] > right[0]
    beside = np.r_[0:59, 61:120]
    swapped = render(scene_of(blue, red), FRONT, LIGHT).astype(int)
    assert np.abs(picture[:, beside] - swapped[:, beside]).max() <= 1


@pytest.mark.parametrize("antialias", [False, True])
@pytest.mark.parametrize("opacity", [0.4, 1.0])
def test_a_picture_covers_what_is_behind_it_and_nothing_else(opacity, antialias):
    body = Shaded(sphere(15, 24))
    bare = seen(body, antialias=antialias)[:3]
    image = plain((30, 160, 60))
    behind = seen(upright(image, 40.0, opacity=opacity), body, antialias=antialias)[:3]
    np.testing.assert_array_equal(behind, bare)
    front = seen(upright(image, -40.0, opacity=opacity), body, antialias=antialias)[:3]
    np.testing.assert_allclose(front, opacity * image[0, 0, :3] + (1 - opacity) * bare, atol=2)


@pytest.mark.parametrize("place", [-40.0, 0.0, 40.0])
def test_between_panes_of_a_see_through_box_every_layer_blends_in_turn(place):
    """Against the same scene with the picture exchanged for a mesh of its colour's look."""
    image = upright(plain((30, 160, 60)), place, (50.0, 36.0), 0.6)
    glass = Shaded(box((40, 40, 30)), "second", 0.5)
    back, front = (
        seen(Shaded(Mesh(glass.mesh.vertices, glass.mesh.faces[part]), "second"))[:3]
        for part in (np.s_[8:10], np.s_[4:6])
    )
    layers = [(20.0, 0.5, back), (-20.0, 0.5, front), (place, 0.6, image.pixels[0, 0, :3])]
    expected = PAPER.astype(float)
    for _, share, color in sorted(layers, key=lambda layer: -layer[0]):
        expected = share * color + (1 - share) * expected
    np.testing.assert_allclose(seen(image, glass)[:3], expected, atol=2.5)
    np.testing.assert_allclose(seen(glass, image)[:3], expected, atol=2.5)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("place", [-60.0, -12.0, 0.0, 50.0])
def test_laid_before_or_after_the_bodies_pictures_look_the_same(monkeypatch, kind, place):
    """What is in front of everything is laid over the finished frame, for that is faster."""
    random = np.random.default_rng(5)
    pixels = np.repeat(np.repeat(random.integers(0, 256, (4, 6, 4), np.uint8), 8, 0), 8, 1)
    scene = scene_of(
        upright(pixels, place, (50.0, 40.0), 0.8),
        upright(pixels[::-1], place - 4.0, (20.0, 60.0), 0.6),
        Shaded(sphere(10, 24)),
        Shaded(box((30, 30, 30)), "second", 0.4),
        Lines([(-40.0, 12.0, 3.0), (40.0, 12.0, 3.0)], width=4.0),
    )
    camera = Camera(kind, (30, -140, 20), height=90, viewport=SIZE)
    one = render(scene, camera, LIGHT).astype(int)
    monkeypatch.setattr(
        "bozzetto.scene.renderer.renderer.apart", lambda pictures, corners: (pictures, ())
    )
    other = render(scene, camera, LIGHT).astype(int)
    # over the smooth rim of a body the one blends its mean, the other each of its samples
    assert np.abs(one - other).max() <= 2


def test_lines_are_not_hidden_by_pictures():
    line = Lines([(-30.0, 20.0, -0.5), (30.0, 20.0, -0.5)], width=5.0)
    np.testing.assert_array_equal(seen(line, upright(plain((250, 250, 250))))[:3], LIGHT.ink)


def test_a_body_in_front_has_a_smooth_rim_over_the_picture():
    body, image = Shaded(sphere(15, 48)), upright(plain((0, 200, 0)), 40.0, (100.0, 80.0))
    picture = render(scene_of(image, body), FRONT, LIGHT).astype(int)
    bare = render(scene_of(body), FRONT, LIGHT).astype(int)
    around = np.s_[HEIGHT // 2 - 18 : HEIGHT // 2 + 18, WIDTH // 2 - 18 : WIDTH // 2 + 18]
    share = render(scene_of(body), FRONT, LIGHT, background=False)[around][..., 3:] / 255
    assert ((share > 0.1) & (share < 0.9)).any()
    expected = bare[around][..., :3] + (1 - share) * (np.array((0, 200, 0)) - PAPER)
    np.testing.assert_allclose(picture[around][..., :3], expected, atol=2)


# -- kept --------------------------------------------------------------------------------------


def test_with_a_camera_that_rests_a_picture_is_drawn_once():
    pixels = upright(slopes()).pixels
    camera = Camera(eye=(10, -150, 0), viewport=SIZE)
    first = on_sheet(upright(pixels), camera)
    assert on_sheet(upright(pixels, opacity=0.2), camera).colors is first.colors
    assert on_sheet(upright(pixels, 5.0), camera).colors is not first.colors
    moved = Camera(eye=(10.1, -150, 0), viewport=SIZE)
    assert on_sheet(upright(pixels), moved).colors is not first.colors
    assert on_sheet(upright(pixels.copy()), camera).colors is not first.colors


def test_what_is_kept_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        on_sheet(upright(slopes()), FRONT).colors[:] = 0


# -- hostile -----------------------------------------------------------------------------------


@given(st.integers(0, 10**6))
@settings(max_examples=60, deadline=None)
def test_no_picture_and_no_view_makes_it_stumble(seed):
    """Warnings of our own are errors in tests, so no NaN is born unseen."""
    random = np.random.default_rng(seed)
    image, camera = random_view(seed)
    kind = seed % 6
    sides = {
        0: (image.corner, image.across, image.across),  # without area
        1: (image.corner, (0.0, 0.0, 0.0), image.down),
        2: (camera.eye, image.across, image.down),  # through the eye
        3: (camera.target, tuple(camera.axes[2] * 50), image.down),  # edge on
        4: (image.corner, tuple(1e-9 * np.array(image.across)), tuple(1e9 * np.array(image.down))),
        5: (image.corner, image.across, image.down),
    }[kind]
    pixels = random.integers(0, 256, (*random.integers(0, 4, 2), 4), np.uint8)
    picture = Image(pixels, *sides, float(random.choice([0.0, 0.5, 1.0, 7.0])))
    out = np.ones((HEIGHT * WIDTH, 4), np.float32)
    sight = view_transform(camera, HEIGHT, WIDTH, (0, 0, WIDTH, HEIGHT))
    blend_pictures(out, [one for one in [place_picture(picture, sight)] if one is not None], sight)
    assert np.isfinite(out).all()
    assert out.min() >= 0
    assert out[:, 3].max() <= 1.001


def test_a_picture_through_the_eye_shows_no_second_time_behind_it():
    """A floor that begins behind the eye ends at the horizon."""
    floor = Image(plain((0, 0, 0)), (-500, 500, 0), (1000, 0, 0), (0, -1000, 0))
    camera = Camera(eye=(0, 0, 10), target=(0, 30, 10), viewport=SIZE)
    alpha = shown(floor, camera)[..., 3]
    assert (alpha[: HEIGHT // 2] == 0).all()
    assert (alpha[HEIGHT // 2 + 3 :] == 255).all()


# -- given up ----------------------------------------------------------------------------------


def test_a_picture_can_be_given_up_between_stages():
    class Enough(Exception):
        pass

    calls = []

    def stop():
        calls.append(1)
        if len(calls) == 2:
            raise Enough

    scene = scene_of(upright(slopes()), Shaded(sphere(15, 24)))
    with pytest.raises(Enough):
        render(scene, FRONT, LIGHT, checkpoint=stop)
    assert len(calls) == 2


@pytest.mark.parametrize("slant", [(-1e-9, 0.0), (0.0, -1e-9), (1e-9, 0.0), (0.0, 0.0)])
def test_a_picture_square_on_fills_its_box_wherever_the_horizon_lies(slant):
    """Its first row or column is left out where the middle of the matrix was moved."""
    matrix = np.array([(1 / 96, 0.0, 0.0), (0.0, 1 / 64, 0.0), (*slant, 1.0)])
    box = (10, 8, 40, 30)
    straight = np.array([(1 / 96, 0.0, 0.0), (0.0, 1 / 64, 0.0), (0.0, 0.0, 1.0)])
    values = interpolated(slopes(), (1, 1), matrix, box)
    assert values.shape == (22, 30)
    expected = interpolated(slopes(), (1, 1), straight, box)
    gaps = values.view(np.uint8).astype(int) - expected.view(np.uint8)
    assert np.abs(gaps).max() <= 2
