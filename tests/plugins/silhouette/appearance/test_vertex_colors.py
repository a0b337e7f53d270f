"""Colours of parts on the shape that they make together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.storage.state_codec import decode_state, encode_state, state_digest
from bozzetto.errors import Cancelled, UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto.scene import LIGHT, Image, Layer, Scene, Shaded
from bozzetto.scene.renderer import render
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.appearance.picture_projection import projection_of
from bozzetto_silhouette.appearance.surface_look import Painted, painted
from bozzetto_silhouette.model.state import Group, Part, Picture, SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.tools import all_tools
from bozzetto_silhouette.tools.paint import Paint
from bozzetto_silhouette.tools.project_picture import MOST_PIXELS, ProjectPicture

CELLS = 48
RED, BLUE, GREEN = (200, 20, 10), (10, 30, 220), (20, 160, 40)
CAMERA = Camera()


def ball(name: str, x: float, z: float, radius: float, color=None, **more) -> Part:
    angle = np.linspace(0.0, 2.0 * np.pi, 96)[:-1]
    ring = np.column_stack([x + radius * np.cos(angle), 0.0 * angle, z + radius * np.sin(angle)])
    pixels = CAMERA.project(ring)[0]
    ink = more.pop("ink", None)
    stroke = Stroke(pixels[:, 0], pixels[:, 1], CAMERA, color=ink)
    return Part(id=name, name=name, strokes=Strokes((stroke,)), color=color, **more)


def looks(*nodes: Part | Group, **more) -> Painted:
    state = SilhouetteState(nodes=nodes, **more)
    body = tree_body(state, CELLS)
    assert body is not None
    return painted(state, body)


def pair(blend: float) -> Painted:
    return looks(ball("a", -15, 0, 20, RED), ball("b", 15, 0, 20, BLUE, blend=blend))


def test_across_a_blend_colours_pass_into_each_other_and_never_back():
    mesh = pair(0.6).mesh
    x, red = mesh.vertices[:, 0], mesh.colors[:, 0].astype(float)
    assert (mesh.colors[x < -20][:, :3] == RED).all()
    assert (mesh.colors[x > 20][:, :3] == BLUE).all()
    order = np.argsort(x)
    assert np.diff(red[order]).max() < 8.0
    assert np.median(red[np.abs(x) < 1.0]) == pytest.approx((RED[0] + BLUE[0]) / 2, abs=12)
    assert len(np.unique(red)) > 20


def test_colours_meet_where_the_balls_do_whichever_comes_first():
    first = pair(0.6).mesh
    second = looks(ball("b", 15, 0, 20, BLUE), ball("a", -15, 0, 20, RED, blend=0.6)).mesh
    for mesh in (first, second):
        share = (mesh.colors[:, 0] - float(BLUE[0])) / (RED[0] - BLUE[0])
        left = mesh.vertices[:, 0] < 0.0
        assert share[left].min() > 0.4
        assert share[~left].max() < 0.6


def test_a_sharp_crease_parts_the_colours():
    look = pair(0.0)
    assert {tuple(c) for c in look.shown.colors[:, :3].tolist()} == {RED, BLUE}
    corners = look.shown.colors[look.shown.faces][:, :, :3].astype(int)
    mixed = np.ptp(corners, axis=1).any(axis=1)
    middle = look.shown.vertices[look.shown.faces].mean(axis=1)
    assert mixed.mean() < 1e-3
    far = np.abs(middle[:, 0]) > 1.0
    is_red = (corners[far] == RED).all(axis=(1, 2))
    np.testing.assert_array_equal(is_red, middle[far, 0] < 0.0)


def test_the_mesh_for_files_stays_closed_where_that_for_the_screen_is_split():
    look = pair(0.0)
    assert len(look.shown.vertices) > len(look.mesh.vertices)
    np.testing.assert_array_equal(
        look.shown.vertices[look.shown.faces], look.mesh.vertices[look.mesh.faces]
    )
    assert look.mesh.faces.max() == len(look.mesh.vertices) - 1


def test_no_colour_anywhere_leaves_the_mesh_without():
    assert looks(ball("a", 0, 0, 20), ball("b", 20, 0, 15)).mesh.colors is None


def test_a_part_without_colour_shows_that_of_the_object():
    mesh = looks(ball("a", -15, 0, 20, RED), ball("b", 15, 0, 20, blend=0.4)).mesh
    shown = mesh.colors_over((1, 2, 3))
    assert (shown[mesh.vertices[:, 0] > 20][:, :3] == (1, 2, 3)).all()
    assert (shown[mesh.vertices[:, 0] < -20][:, :3] == RED).all()


def test_ink_colours_its_part_unless_the_part_has_a_colour():
    mesh = looks(
        ball("a", -30, 0, 20, ink=GREEN), ball("b", 30, 0, 20, RED, ink=GREEN, blend=0.0)
    ).mesh
    assert (mesh.colors[mesh.vertices[:, 0] < 0][:, :3] == GREEN).all()
    assert (mesh.colors[mesh.vertices[:, 0] > 0][:, :3] == RED).all()


@pytest.mark.parametrize(("color", "wall"), [(None, RED), (BLUE, BLUE)])
@pytest.mark.parametrize("operation", ["carve", "intersect"])
def test_what_carves_colours_the_wall_only_if_it_has_a_colour(operation, color, wall):
    tool = ball("b", 25, 0, 20, color, operation=operation, blend=0.0)
    mesh = looks(ball("a", 0, 0, 20, RED), tool).mesh
    to_tool = np.abs(np.linalg.norm(mesh.vertices - (25, 0, 0), axis=1) - 20.0)
    to_body = np.abs(np.linalg.norm(mesh.vertices, axis=1) - 20.0)
    on_wall, off = (to_tool < 0.2) & (to_body > 1.5), (to_body < 0.2) & (to_tool > 1.5)
    assert on_wall.sum() > 50
    assert off.sum() > 50
    assert (mesh.colors[on_wall][:, :3] == wall).all()
    assert (mesh.colors[off][:, :3] == RED).all()


def test_colours_move_with_groups():
    moved = Placement(offset=(0.0, 0.0, 100.0))
    group = Group(id="g", name="g", pose=moved, blend=0.0)
    mesh = looks(ball("a", 0, 0, 20, RED), group, ball("b", 5, 0, 20, BLUE, within="g")).mesh
    upper = mesh.vertices[:, 2] > 50
    assert upper.any()
    assert (mesh.colors[upper][:, :3] == BLUE).all()
    assert (mesh.colors[~upper][:, :3] == RED).all()


def test_a_part_switched_off_colours_nothing():
    hidden = ball("b", 5, 0, 20, BLUE, visible=False)
    assert (looks(ball("a", 0, 0, 20, RED), hidden).mesh.colors[:, :3] == RED).all()


# -- tools --

PEN = Pen()


def scene_of_two() -> tuple[SilhouetteState, np.ndarray]:
    state = SilhouetteState(nodes=(ball("a", -30, 0, 20), ball("b", 30, 0, 20, blend=0.0)))
    middles = CAMERA.project(np.array([[-30.0, 0, 0], [30.0, 0, 0]]))[0]
    return state, middles


def test_a_tap_and_ink_paint_what_is_under_them():
    state, (left, right) = scene_of_two()
    state = replace(state, paint=GREEN)
    tapped = Paint().apply(state, Tap(*left, CAMERA), Context())
    assert [part.color for part in tapped.parts] == [GREEN, None]
    xs = np.linspace(left[0], right[0], 50)
    across = Stroke(xs, np.full(50, left[1]), CAMERA)
    both = Paint().apply(state, Ink((across,)), Context())
    assert [part.color for part in both.parts] == [GREEN, GREEN]


def test_the_other_end_and_no_paint_take_the_colour_away():
    state, (left, _) = scene_of_two()
    state = Paint().apply(state, Tap(*left, CAMERA), Context())
    rub = Stroke([left[0]] * 3, [left[1]] * 3, CAMERA, tool="eraser")
    assert Paint().apply(state, Ink((rub,)), Context()).parts[0].color is None
    bare = Paint().apply(replace(state, paint=None), Tap(*left, CAMERA), Context())
    assert bare.parts[0].color is None
    with pytest.raises(UserError, match="no paint"):
        Paint().apply(bare, Ink((rub,)), Context())


def test_paint_beside_the_shape_is_refused():
    state, _ = scene_of_two()
    for gesture in (Tap(1, 1, CAMERA), Ink((PEN.circle(30, 30, 8),))):
        with pytest.raises(UserError, match="no part"):
            Paint().apply(state, gesture, Context())
    with pytest.raises(UserError):
        Paint().apply(state, Drag("x", PEN.circle(30, 30, 8)), Context())
    with pytest.raises(UserError, match="no part"):
        Paint().apply(SilhouetteState(), Tap(1, 1, CAMERA), Context())


def underlay(height: int, width: int) -> Context:
    pixels = np.random.default_rng(3).integers(0, 256, (height, width, 4)).astype(np.uint8)
    return Context(underlay=Image(pixels, (-50, 0, 30), (100, 0, 0), (0, 0, -60)))


def test_the_underlay_becomes_the_picture_and_comes_off():
    state, _ = scene_of_two()
    context = underlay(30, 50)
    laid = ProjectPicture().apply(state, Tap(5, 5, CAMERA), context)
    np.testing.assert_array_equal(laid.picture.pixels, context.underlay.pixels)
    assert laid.picture.across == (100, 0, 0)
    off = ProjectPicture().apply(laid, Tap(5, 5, CAMERA), Context())
    assert off.picture is None
    with pytest.raises(UserError, match="no underlay"):
        ProjectPicture().apply(off, Tap(5, 5, CAMERA), Context())


@pytest.mark.parametrize(("height", "width"), [(3, 5000), (5000, 3), (2600, 1300), (1, 9000)])
def test_large_underlays_are_kept_smaller(height, width):
    laid = ProjectPicture().apply(SilhouetteState(), Tap(5, 5, CAMERA), underlay(height, width))
    rows, columns = laid.picture.pixels.shape[:2]
    assert max(rows, columns) == MOST_PIXELS
    assert rows / columns == pytest.approx(max(height / width, 1 / 2048), rel=0.5)


def test_an_underlay_without_area_is_refused():
    flat = Image(np.zeros((2, 2, 4), np.uint8), (0, 0, 0), (1, 0, 0), (2, 0, 0))
    with pytest.raises(UserError, match="no area"):
        ProjectPicture().apply(SilhouetteState(), Tap(5, 5, CAMERA), Context(underlay=flat))


def test_the_tools_are_on_the_rail():
    assert {"paint", "picture"} <= {tool.id for tool in all_tools()}


def test_picture_and_parts_together_solve_and_hand_over_a_texture():
    pixels = np.zeros((40, 80, 4), np.uint8)
    pixels[:, :40] = (250, 240, 10, 255)  # the right half is clear
    picture = Picture(pixels, (-60, 0, 30), (120, 0, 0), (0, 0, -60))
    state = SilhouetteState(
        nodes=(ball("a", -30, 0, 20), ball("b", 30, 0, 20, BLUE, blend=0.0)),
        picture=picture,
        resolution=CELLS,
    )
    modeler = Silhouette()
    result = modeler.solve(state, Job())
    mesh = result.mesh
    shown = mesh.colors_over((1, 2, 3))[:, :3]
    assert (shown[mesh.vertices[:, 0] < -12] == (250, 240, 10)).all()
    assert (shown[mesh.vertices[:, 0] > 12] == BLUE).all()
    (solid,) = modeler.shapes(state, result).solids
    assert len(solid.texture.corners) == len(solid.mesh.faces)
    plain = replace(state, picture=None)
    assert modeler.shapes(plain, modeler.solve(plain, Job())).solids[0].texture is None


def test_the_sheet_shows_a_picture_as_finely_as_files_have_it():
    """Lines of a sketch that are thinner than a triangle, as straight as they were drawn."""
    pixels = np.full((400, 400, 4), 255, np.uint8)
    pixels[::20, :, :2] = 0  # blue lines of one pixel in twenty
    pixels[1::20, :, :2] = 0
    picture = Picture(pixels, (-20, 0, 20), (40, 0, 0), (0, 0, -40))
    state = SilhouetteState(nodes=(ball("a", 0, 0, 20),), picture=picture, resolution=CELLS)
    modeler = Silhouette()
    result = modeler.solve(state, Job())
    (item,) = (one for layer in modeler.scene(state, result).layers if layer.name == "shape"
               for one in layer.items)  # fmt: skip
    assert item.texture is modeler.shapes(state, result).solids[0].texture
    assert item.mesh.colors is None
    front = standard_view(Camera("orthographic", height=44.0, viewport=(440, 440)), "front")
    seen = render(Scene((Layer("shape", (item,)),)), front, LIGHT)[120:320, 120:320].astype(float)
    x, z = np.meshgrid((np.arange(200) - 99.5) / 10.0, (99.5 - np.arange(200)) / 10.0)
    places = np.stack([x, -np.sqrt(400.0 - x * x - z * z), z], -1).reshape(-1, 3)
    coat = projection_of(picture, result.body.radius, 0.1).coat(places, places / 20.0)
    wanted = (coat.rgb[:, 0] < 128).reshape(200, 200)
    assert 0.05 < wanted.mean() < 0.15
    blue = seen[..., 2] - seen[..., 0] > 60
    assert (blue != wanted).mean() < 0.03
    vertices = Shaded(painted(state, result.body).shown)
    coarse = render(Scene((Layer("shape", (vertices,)),)), front, LIGHT)[120:320, 120:320]
    coarse = coarse.astype(float)
    assert ((coarse[..., 2] - coarse[..., 0] > 60) != wanted).mean() > 0.08


def test_a_preview_shows_the_picture_that_is_known():
    pixels = np.full((8, 8, 4), 90, np.uint8)
    picture = Picture(pixels, (-10, 0, 10), (20, 0, 0), (0, 0, -20))
    state = SilhouetteState(nodes=(ball("a", 0, 0, 20, RED),), picture=picture, resolution=32)
    modeler = Silhouette()
    assert modeler.solve(state, Job(quality="preview")).texture is None
    final = modeler.solve(state, Job())
    assert final.texture is not None
    brushed = replace(state, brush_size=3.0)
    assert modeler.solve(brushed, Job()).texture is final.texture


def test_a_second_export_has_the_texture_of_the_first_until_a_colour_changes():
    picture = Picture(np.full((8, 8, 4), 90, np.uint8), (-10, 0, 10), (20, 0, 0), (0, 0, -20))
    modeler = Silhouette()

    def texture(color):
        state = SilhouetteState(nodes=(ball("a", 0, 0, 20, color),), picture=picture, resolution=32)
        return modeler.shapes(state, modeler.solve(state, Job())).solids[0].texture

    first, again, other = (texture(color) for color in (RED, RED, BLUE))
    assert again is first
    assert (first.pixels[..., :3] == RED).all(axis=2).any()
    assert not (other.pixels[..., :3] == RED).all(axis=2).any()


def test_colouring_can_be_cancelled():
    state = SilhouetteState(nodes=(ball("a", 0, 0, 20, RED),), resolution=32)

    def stop(fraction: float, step: str) -> None:
        if step == "colours":
            raise Cancelled

    with pytest.raises(Cancelled):
        Silhouette().solve(state, Job(progress=stop))


def test_a_document_keeps_picture_and_paint():
    state = SilhouetteState(nodes=(ball("a", 0, 0, 20, RED),), paint=None)
    state = ProjectPicture().apply(state, Tap(5, 5, CAMERA), underlay(30, 50))
    kept = decode_state(SilhouetteState, encode_state(state))
    assert state_digest(kept) == state_digest(state)
    assert kept.paint is None
    assert kept.parts[0].color == RED
    np.testing.assert_array_equal(kept.picture.pixels, state.picture.pixels)
