"""Pictures against closed forms, against ray casting, and against themselves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import DARK, LIGHT, Handle, Image, Label, Layer, Lines, Points, Scene, Shaded
from bozzetto.scene.picking import cast_rays
from bozzetto.scene.renderer import SHADINGS, render
from bozzetto.scene.renderer.triangle_soup import gather
from bozzetto.scene.renderer.view_transform import view_transform
from bozzetto.scene.renderer.zbuffer import blank_buffer, rasterize
from bozzetto.scene.snapshot import picture, thumbnail
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import fit, turn
from bozzetto.view.standard_views import standard_view
from tests.core.scene.shapes import box, scene_of, soup, sphere

PAPER = np.array(LIGHT.paper)
FRONT = Camera("orthographic", eye=(0, -500, 0), height=100, viewport=(120, 100))  # 1 px per mm


def shot(scene, camera=FRONT, palette=LIGHT, **options):
    return render(scene, camera, palette, **options).astype(int)


def covered(image):
    """How much of each pixel of a picture without background is opaque, 0 … 1."""
    return image[..., 3] / 255.0


def darkness(image, ink=LIGHT.ink):
    """Ink on each pixel of white paper, 0 … 1."""
    return (PAPER - image[..., :3])[..., 1] / (PAPER - ink)[1]


def sheet(size, y=0.0, center=(0.0, 0.0)):
    """A square in the plane of the front view."""
    x, z = center
    half = size / 2
    corners = [(x - half, y, z - half), (x + half, y, z - half)]
    corners += [(x + half, y, z + half), (x - half, y, z + half)]
    return Mesh(np.array(corners, np.float32), [(0, 1, 2), (0, 2, 3)])


# -- surfaces ----------------------------------------------------------------------------------


@given(st.integers(0, 10**6), st.sampled_from(["perspective", "orthographic"]), st.integers(1, 300))
@settings(max_examples=25, deadline=None)
def test_the_z_buffer_sees_what_rays_hit(seed, kind, count):
    random = np.random.default_rng(seed)
    mesh = soup(seed, count)
    eye = random.normal(size=3)
    eye *= random.uniform(1, 40) / np.linalg.norm(eye)  # also in the midst of it
    camera = Camera(kind, tuple(eye), height=30, fov_y=60, viewport=(80, 60))
    sight = view_transform(camera, 60, 80, (0, 0, 80, 60))
    triangles = gather([mesh], [None], sight)
    buffer = blank_buffer(80, 60)
    rasterize(buffer, triangles.places, triangles.faces)
    near = buffer.nearness.reshape(60, 80).astype(float)
    depth = camera.distance / near if kind == "perspective" else camera.distance - near
    y, x = np.indices((60, 80)) + 0.5
    rays = camera.rays(np.column_stack((x.ravel(), y.ravel())))
    if kind == "orthographic":  # the picture shows what lies behind the eye, too
        rays = rays._replace(origins=rays.origins - 100 * rays.directions)
    hits = cast_rays(scene_of(Shaded(mesh)), rays)
    true_depth = np.full(60 * 80, np.inf)
    true_depth[hits.hit] = camera.project(hits.points[hits.hit])[1]
    true_depth = true_depth.reshape(60, 80)
    seen = np.isfinite(near)
    # pixels whose centre lies on an edge may go either way
    agree = np.isclose(depth, true_depth, rtol=1e-4, atol=1e-3) | (~seen & np.isinf(true_depth))
    assert agree.mean() > 0.998


@pytest.mark.parametrize("antialias", [False, True])
@given(size=st.floats(3, 60), x=st.floats(-20, 20), z=st.floats(-15, 15))
@settings(max_examples=25, deadline=None)
def test_the_area_of_a_square(antialias, size, x, z):
    image = shot(
        scene_of(Shaded(sheet(size, center=(x, z)))), background=False, antialias=antialias
    )
    assert covered(image).sum() == pytest.approx(size**2, abs=(1 if antialias else 2) * size + 1)


def test_a_sphere_looks_equally_large_from_everywhere():
    mesh = sphere(30, 48)
    areas = []
    for azimuth, elevation in ((0, 0), (37, 10), (90, 50), (200, -80), (10, 90)):
        camera = turn(FRONT, azimuth, elevation)
        areas.append(covered(shot(scene_of(Shaded(mesh)), camera, background=False)).sum())
    np.testing.assert_allclose(areas, np.pi * 30**2, rtol=5e-3)


@pytest.mark.parametrize("shading", SHADINGS)
def test_the_same_input_gives_the_same_picture(shading):
    scene = everything()
    camera = fit(standard_view(Camera(viewport=(160, 120)), "three-quarter"), scene.bounds())
    first, second = (render(scene, camera, LIGHT, shading=shading) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert first.shape == (120, 160, 4)
    assert (first[..., 3] == 255).all()


def everything():
    """One of each item."""
    pixels = np.full((20, 30, 4), 200, np.uint8)
    colored = Mesh(
        sphere(8, 12, (20, 0, 20)).vertices,
        sphere(8, 12).faces,
        colors=np.tile(np.array([[255, 0, 0, 255]], np.uint8), (len(sphere(8, 12).vertices), 1)),
    )
    return scene_of(
        Shaded(sphere(15, 24)),
        Shaded(box((10, 10, 10), (-25, 0, 0)), "accent", 0.4),
        Shaded(colored),
        Image(pixels, (-30, 20, 30), (60, 0, 0), (0, 0, -60), 0.7),
        Lines([(-40, 0, 0), (0, -20, 10), (40, 0, 0)], width=np.array([1, 5, 2])),
        Lines([(-40, 5, 5), (40, 5, 5)], color="second", hidden="dashed"),
        Points([(0, -20, 0), (0, 20, 0)], "accent"),
        Handle("h", (0, 0, 25)),
        Label((10, 0, 30), "12 mm"),
    )


@pytest.mark.parametrize("scale", [1e-3, 1e6])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_the_same_shape_in_another_size_looks_the_same(kind, scale):
    def look(factor):
        mesh = box((factor, 2 * factor, factor))
        line = Lines(np.array([(-1, -1.5, 0.2), (1, -1.5, 0.2)]) * factor)
        scene = scene_of(Shaded(mesh), line)
        camera = standard_view(Camera(kind, viewport=(120, 90)), "three-quarter")
        return shot(scene, fit(camera, scene.bounds()))

    assert np.abs(look(1.0) - look(scale)).mean() < 0.1


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_inside_a_box_there_is_wall_everywhere(kind):
    camera = Camera(kind, eye=(0.3, -0.2, 0.1), target=(1, 2, 0.5), height=0.5, viewport=(90, 60))
    image = shot(scene_of(Shaded(box((10, 10, 10)))), camera, background=False)
    assert (image[..., 3] == 255).all()


def test_a_floor_under_the_eye_reaches_the_lower_edge():
    floor = Mesh(np.array([(-1e4, -1e4, 0), (1e4, -1e4, 0), (0, 2e4, 0.0)]), [(0, 1, 2)])
    camera = Camera(eye=(0, 0, 10), target=(0, 30, 10), viewport=(90, 60))
    image = shot(scene_of(Shaded(floor)), camera, background=False, antialias=False)
    assert (image[31:, :, 3] == 255).all()
    assert (image[:29, :, 3] == 0).all()
    normals = shot(scene_of(Shaded(floor)), camera, shading="normals", antialias=False)
    assert np.abs(normals[35:, :, :3] - (127.5, 255, 127.5)).max() < 1.5, "not turned over"


def test_a_back_side_is_darker_and_a_mirror_image_is_not():
    face = sheet(60)
    turned = Mesh(face.vertices, face.faces[:, ::-1])
    front, back = (shot(scene_of(Shaded(mesh)))[50, 60, 0] for mesh in (face, turned))
    assert back < 0.95 * front


def test_light_comes_from_the_upper_left():
    image = shot(scene_of(Shaded(sphere(40, 48)))).sum(-1)
    assert image[30, 40] > image[50, 60] > image[70, 80]


def test_vertex_colours_take_the_place_of_the_colour_and_are_right_in_perspective():
    corners = np.array([(-40, -60, -30), (40, 200, -30), (40, 200, 30), (-40, -60, 30.0)])
    red = np.array([0, 255, 255, 0])
    colors = np.column_stack((red, np.zeros(4), 255 - red, np.full(4, 255))).astype(np.uint8)
    mesh = Mesh(corners, [(0, 1, 2), (0, 2, 3)], colors=colors)
    camera = Camera(eye=(0, -150, 0), target=(0, 0, 0), fov_y=60, viewport=(200, 150))
    image = shot(scene_of(Shaded(mesh)), camera)
    for t in (0.2, 0.5, 0.8):
        x, y = camera.project(corners[0] + t * (corners[1] - corners[0]) + (0, 0, 30))[0][0]
        r, _, b, _ = image[int(y), int(x)]
        assert r / (r + b) == pytest.approx(t, abs=0.04)


# -- translucent -------------------------------------------------------------------------------


@given(st.floats(0.02, 0.98))
@settings(max_examples=15, deadline=None)
def test_opacity_blends_by_the_formula(opacity):
    wall = Shaded(sheet(80, y=5.0), "accent")
    pane = Shaded(sheet(60), "second")
    behind, alone = (shot(scene_of(item))[50, 60, :3] for item in (wall, pane))
    glass = Shaded(pane.mesh, "second", opacity)
    over = shot(scene_of(glass, wall))[50, 60, :3]
    np.testing.assert_allclose(over, opacity * alone + (1 - opacity) * behind, atol=1.6)
    on_paper = shot(scene_of(glass))[50, 60, :3]
    np.testing.assert_allclose(on_paper, opacity * alone + (1 - opacity) * PAPER, atol=1.6)
    clear = shot(scene_of(glass), background=False)[50, 60]
    assert clear[3] == pytest.approx(255 * opacity, abs=1)


def test_a_see_through_box_shows_back_content_and_front_whatever_the_order():
    glass = Shaded(box((60, 60, 60)), "second", 0.3)
    ball = Shaded(sphere(10, 24), "accent")
    one, other = shot(scene_of(glass, ball)), shot(scene_of(ball, glass))
    np.testing.assert_array_equal(one, other)
    front = shot(scene_of(Shaded(box((60, 60, 60)), "second")))[50, 60, :3]
    bare = shot(scene_of(ball))[50, 60, :3]
    np.testing.assert_allclose(one[50, 60, :3], 0.3 * front + 0.7 * bare, atol=3)
    # beside the ball: back over paper, then front over that
    twice = one[30, 60, :3]
    assert np.abs(twice - PAPER).sum() > np.abs(0.3 * front + 0.7 * PAPER - PAPER).sum()


def test_panes_are_laid_from_far_to_near_where_they_cross():
    def pane(slope, color):
        corners = [(-40, -40 * slope, -30), (40, 40 * slope, -30)]
        corners += [(40, 40 * slope, 30), (-40, -40 * slope, 30)]
        return Shaded(Mesh(np.array(corners, float), [(0, 1, 2), (0, 2, 3)]), color, 0.6)

    red, blue = pane(0.3, (200, 0, 0)), pane(-0.3, (0, 0, 200))
    image, swapped = shot(scene_of(red, blue)), shot(scene_of(blue, red))
    left, right = image[50, 35], image[50, 85]
    assert left[0] > left[2], "red is nearer on the left"
    assert right[2] > right[0]
    beside = np.r_[0:59, 61:120]
    np.testing.assert_array_equal(image[:, beside], swapped[:, beside])


@pytest.mark.parametrize("opacity", [0.09, 0.6])
def test_behind_a_pane_the_later_line_hides_the_earlier_one(opacity):
    pane = Shaded(sheet(80, y=-5.0), "second", opacity)
    red, green = (Lines(LINE, color=c, width=9.0) for c in ((200, 40, 40), (0, 140, 130)))
    alone, over = (shot(scene_of(pane, *lines))[50, 60] for lines in ((green,), (red, green)))
    np.testing.assert_allclose(over, alone, atol=1)


# -- lines -------------------------------------------------------------------------------------

LINE = [(-30.0, 0.0, 0.25), (30.0, 0.0, 0.25)]


@pytest.mark.parametrize("angle", [0, 17, 45, 73, 90, 130])
@pytest.mark.parametrize("width", [0.5, 1.0, 3.0, 9.0])
def test_the_ink_of_a_line_is_its_length_times_its_width(angle, width):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    ends = np.array([(-30 * c, 0, -30 * s), (30 * c, 0, 30 * s)])
    shifts = [(x, 0, z) for x in (0.1, 0.45, 0.8) for z in (0.0, 0.3, 0.65)]
    ink = np.mean([darkness(shot(scene_of(Lines(ends + s, width=width)))).sum() for s in shifts])
    assert ink == pytest.approx(60 * width + np.pi * width**2 / 4, rel=0.06)


def test_joins_are_round_and_overlaps_are_laid_once():
    knee = Lines([(-30, 0, 0), (0, 0, 0), (-30, 0, 1)], width=8, opacity=0.5)
    image = darkness(shot(scene_of(knee)))
    assert image.max() == pytest.approx(0.5, abs=0.01)
    assert image[50, 60 + 2] == pytest.approx(0.5, abs=0.01), "within the round end"
    assert image[50, 60 + 6] == 0


def test_each_polyline_begins_and_ends_for_itself():
    points = [(-30, 0, 9), (-20, 0, 9), (9, 0, 9), (20, 0, -9), (30, 0, -9)]
    image = darkness(shot(scene_of(Lines(points, [0, 2, 3], width=4))))
    expected = 2 * 10 * 4 + 3 * np.pi * 4  # two lines and a dot
    assert image.sum() == pytest.approx(expected, rel=0.05)
    assert image[30:50, 44:66].sum() == 0
    late = darkness(shot(scene_of(Lines(points, [3], width=4))))
    assert late.sum() == pytest.approx(10 * 4 + np.pi * 4, rel=0.05)


def test_width_may_change_along_a_line():
    image = darkness(shot(scene_of(Lines(LINE, width=np.array([1.0, 9.0])))))
    assert image[:, 35].sum() == pytest.approx(1 + 8 * 5.5 / 60, rel=0.1)
    assert image[:, 85].sum() == pytest.approx(1 + 8 * 55.5 / 60, rel=0.1)


def test_many_segments_are_the_same_line_as_one():
    points = np.linspace(*LINE, 61)
    one, many = (shot(scene_of(Lines(p, width=3.0))) for p in (LINE, points))
    assert np.abs(one - many).max() <= 2


def test_the_scale_of_the_screen_widens_lines():
    inked = [darkness(shot(scene_of(Lines(LINE, width=2)), scale=s)).sum() for s in (1, 2)]
    assert inked[1] == pytest.approx(4 * inked[0], rel=0.05)


WALL = Shaded(sheet(30, y=-10.0))


def test_hidden_parts_are_hidden():
    bare = shot(scene_of(WALL))
    hidden = shot(scene_of(WALL, Lines(LINE, width=3, hidden="hide")))
    behind = np.s_[36:64, 46:74]
    np.testing.assert_array_equal(hidden[behind], bare[behind])
    assert darkness(hidden)[:, 35].sum() == pytest.approx(3, rel=0.1), "beside it all is seen"


def test_faint_dashed_and_shown_parts():
    def inside(kind):
        image = shot(scene_of(WALL, Lines(LINE, width=3, hidden=kind)))
        return np.abs(image - shot(scene_of(WALL)))[40:60, 50:70].sum((0, 2))

    faint, dashed, shown = inside("faint"), inside("dashed"), inside("show")
    assert (faint > 0).all()
    assert faint.max() < 0.4 * shown.min()
    assert (dashed == 0).any()
    assert dashed.max() > faint.max()
    in_front = shot(scene_of(WALL, Lines(np.array(LINE) - (0, 30, 0), width=3)))
    np.testing.assert_array_equal(
        in_front, shot(scene_of(WALL, Lines(LINE, width=3, hidden="show")))
    )


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("antialias", [False, True])
def test_a_line_on_a_surface_is_seen_whole(kind, antialias):
    """A meridian of a sphere, up to the rim, from many sides."""
    mesh = sphere(30, 60)
    u = np.linspace(0, np.pi, 121)
    for azimuth in range(-80, 81, 20):
        a = np.radians(azimuth)
        on = 30 * np.stack((np.sin(u) * np.sin(a), -np.sin(u) * np.cos(a), np.cos(u)), 1)
        camera = Camera(kind, (0, -300, 0), height=100, fov_y=20, viewport=(240, 200))
        line = Lines(on, color=(255, 0, 0), width=1.5, hidden="hide")
        drawn = shot(scene_of(Shaded(mesh), line), camera, antialias=antialias)
        alone = shot(scene_of(line), camera)
        red = [(image[..., 0] - image[..., 1] > 60).sum() for image in (drawn, alone)]
        assert red[0] >= 0.97 * red[1]


@pytest.mark.parametrize("far", [500.0, 1e9, 1e15])
def test_a_line_behind_the_eye_or_through_it_does_no_harm(far):
    camera = Camera(eye=(0, -50, 0), viewport=(90, 60))
    through = Lines([(0, -far, -far / 100), (0, 500, 5)])
    behind = Lines([(-5, -90, 0), (5, -90, 0)])
    image = shot(scene_of(through, behind), camera)
    drawn = shot(scene_of(Lines([(0, -49.9, -0.499), (0, 500, 5)])), camera)
    assert np.abs(image - drawn).max() <= 2


def test_dots_have_their_size_and_are_hidden_too():
    dot = Points([(0.0, 0.0, 0.0)], size=12)
    assert darkness(shot(scene_of(dot))).sum() == pytest.approx(np.pi * 36, rel=0.02)
    gone = Points([(0.0, 0.0, 0.0)], size=12, hidden="hide")
    np.testing.assert_array_equal(shot(scene_of(WALL, gone)), shot(scene_of(WALL)))


def test_handles_and_labels_lie_on_top():
    scene = scene_of(WALL, Handle("h", (0, 0, 0)), Label((-24, 0, -14), "8", size=14))
    image = shot(scene)
    np.testing.assert_array_equal(image[50, 60, :3], LIGHT.accent)
    assert (np.abs(image - shot(scene_of(WALL, Handle("h", (0, 0, 0)))))[45:70, 35:55] > 60).any()


@given(st.lists(st.tuples(st.integers(-40, 40), st.integers(-30, 30), st.booleans()), max_size=9))
@settings(max_examples=25, deadline=None)
def test_handles_drawn_at_once_look_as_if_drawn_one_by_one(found):
    scene = scene_of(
        *(
            Handle("h", (0.7 * x, 0.0, 0.7 * z), "accent" if own else "second")
            for x, z, own in found
        )
    )
    at_once = shot(scene)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "bozzetto.scene.renderer.renderer._drawn_at_once",
            lambda places, gap: [[k] for k in range(len(places))],
        )
        np.testing.assert_array_equal(at_once, shot(scene))


@pytest.mark.parametrize("behind", [Lines(LINE, width=7), Points([(0.0, 0.0, 0.25)], size=9)])
def test_behind_glass_ink_is_seen_through_it(behind):
    glass = Shaded(sheet(60, y=-20.0), "second", 0.4)
    alone = shot(scene_of(Shaded(glass.mesh, "second")))[50, 60, :3]
    image = shot(scene_of(behind, glass))
    np.testing.assert_allclose(image[49, 60, :3], 0.4 * alone + 0.6 * np.array(LIGHT.ink), atol=2)
    before = Shaded(sheet(60, y=20.0), "second", 0.4)
    np.testing.assert_array_equal(shot(scene_of(behind, before))[49, 60, :3], LIGHT.ink)


# -- pictures on rectangles --------------------------------------------------------------------


def test_a_picture_hangs_the_right_way_and_is_right_in_perspective():
    pixels = np.zeros((64, 64, 4), np.uint8)
    pixels[..., 0] = np.linspace(0, 255, 64)[None, :]
    pixels[..., 1] = np.linspace(0, 255, 64)[:, None]
    pixels[..., 3] = 255
    corner, across, down = np.array((-30, 0, 30.0)), np.array((60, 120, 0)), np.array((0, 0, -60))
    camera = Camera(eye=(0, -150, 0), viewport=(200, 160))
    image = shot(scene_of(Image(pixels, tuple(corner), tuple(across), tuple(down))), camera)
    for u, v in ((0.1, 0.1), (0.5, 0.5), (0.9, 0.2), (0.3, 0.8)):
        x, y = camera.project(corner + u * across + v * down)[0][0]
        np.testing.assert_allclose(image[int(y), int(x), :2], (255 * u, 255 * v), atol=9)


def test_a_reduced_picture_is_the_mean_of_its_pixels():
    pixels = np.zeros((400, 400, 4), np.uint8)
    pixels[::2, ::2] = pixels[1::2, 1::2] = 255
    pixels[..., 3] = 255
    image = shot(scene_of(Image(pixels, (-20, 0, 20), (40, 0, 0), (0, 0, -40))))
    np.testing.assert_allclose(image[35:65, 45:75, :3], 127.5, atol=3)


# -- the whole ---------------------------------------------------------------------------------


def test_bands_do_not_show(monkeypatch):
    hollow = Shaded(sphere(30, 40)), Shaded(box((80, 60, 30), (0, 0, -20)))
    scene = everything() + scene_of(*hollow)
    camera = fit(standard_view(Camera(viewport=(300, 330)), "three-quarter"), scene.bounds())
    whole = render(scene, camera, LIGHT).astype(int)
    monkeypatch.setattr("bozzetto.scene.renderer.renderer.BAND_VALUES", 300 * 4 * 24 * 4)
    banded = render(scene, camera, LIGHT).astype(int)
    assert np.abs(whole - banded).max() <= 1


def test_the_size_follows_the_scale_and_has_a_limit():
    scene = scene_of(Shaded(sphere()))
    assert render(scene, FRONT, LIGHT, size=(30, 20), scale=1.5).shape == (30, 45, 4)
    with pytest.raises(UserError, match="too large"):
        picture(scene, size=(10**5, 10**5))
    with pytest.raises(UserError, match="at least one pixel"):
        picture(scene, size=(0, 20))
    assert thumbnail(scene, 64).shape == (64, 64, 4)


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (9, 1), (5, 3)])
def test_very_small_pictures(size):
    assert picture(everything(), size=size).shape == (size[1], size[0], 4)


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_an_empty_sheet_is_paper(palette):
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3)))
    scene = scene_of(Shaded(empty), Lines(np.zeros((0, 3))), Points(np.zeros((0, 3))))
    for nothing in (Scene(), scene):
        image = picture(nothing, palette=palette, size=(20, 10))
        assert (image == (*palette.paper, 255)).all()
        assert (picture(nothing, size=(20, 10), background=False) == 0).all()


@given(st.integers(0, 10**6), st.sampled_from(SHADINGS), st.booleans())
@settings(max_examples=40, deadline=None)
def test_no_scene_and_no_view_makes_it_stumble(seed, shading, antialias):
    """Warnings of our own are errors in tests, so no NaN is born unseen."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-3, 6)
    mesh = soup(seed, int(random.integers(1, 60)))
    vertices = mesh.vertices / 10 * size
    vertices[:: int(random.integers(2, 9))] = vertices[0]  # faces without area
    points = random.normal(0, size, (9, 3))
    points[3] = points[2]
    opacity = float(random.choice([1.0, 0.5, 0.0]))
    items = [
        Shaded(Mesh(vertices, mesh.faces), opacity=opacity),
        Lines(points, [0, 4, 5], width=random.uniform(0, 30, 9), hidden="dashed"),
        Points(points, size=float(random.uniform(0, 40))),
        Handle("h", tuple(points[0])),
        Label(tuple(points[1]), "ß\n½", size=30),
        Image(np.zeros((3, 2, 4), np.uint8), tuple(points[0]), tuple(points[1]), (0, 0, 0)),
    ]
    eye = random.normal(0, size, 3) * 10.0 ** random.uniform(-3, 1)
    kind = str(random.choice(["perspective", "orthographic"]))
    camera = Camera(
        kind, tuple(eye), tuple(points[5]), height=size, fov_y=random.uniform(5, 150),
        viewport=(41, 33),
    )  # fmt: skip
    image = render(Scene((Layer("l", tuple(items)),)), camera, DARK, shading=shading,
                   antialias=antialias)  # fmt: skip
    assert image.shape == (33, 41, 4)
