"""The sheet: where ink lies in the world, and that it lies under the drawn pixels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto.plugin import Context
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto_silhouette.model.sketch_plane import Sheet, sheet_under
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.from_ink import outline_of, points_on_sheet
from tests.plugins.silhouette import outlines as o

place = st.tuples(*[st.floats(-200.0, 200.0)] * 3)
direction = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@st.composite
def cameras(draw: st.DrawFn) -> Camera:
    target, away = np.array(draw(place)), np.array(draw(direction))
    up = np.array(draw(direction))
    assume(np.linalg.norm(away) > 0.1)
    assume(np.linalg.norm(np.cross(away, up)) > 0.05)
    away *= draw(st.floats(50.0, 2000.0)) / np.linalg.norm(away)
    return Camera(
        draw(st.sampled_from(["perspective", "orthographic"])),
        tuple(target - away),
        tuple(target),
        tuple(up),
        fov_y=draw(st.floats(10.0, 90.0)),
        height=draw(st.floats(10.0, 1000.0)),
        viewport=(draw(st.floats(200.0, 3000.0)), draw(st.floats(200.0, 2000.0))),
    )


@given(cameras())
def test_what_is_drawn_lies_under_the_pen(camera: Camera) -> None:
    width, height = camera.viewport
    middle, radius = np.array([0.45 * width, 0.55 * height]), 0.3 * min(width, height)
    stroke = Pen(camera).circle(*middle, radius)
    sheet = sheet_under(stroke, Context(camera=camera))
    (points,) = points_on_sheet([stroke], sheet)
    pixels, depth = camera.project(sheet.to_world(points))
    assert pixels == pytest.approx(stroke.points, abs=1e-6 * max(width, height))
    assert (depth > 0).all()
    outline = outline_of(Part(strokes=_strokes(stroke), sheet=sheet))
    seen, _ = camera.project(sheet.to_world(outline.rings[0]))
    assert np.hypot(*(seen - middle).T) == pytest.approx(np.full(len(seen), radius), rel=0.01)


@given(cameras())
def test_the_sheet_is_parallel_to_the_screen_through_the_target(camera: Camera) -> None:
    stroke = Pen(camera).circle(*np.array(camera.viewport) / 2, 50.0)
    sheet = sheet_under(stroke, Context(camera=camera))
    right, up, forward = camera.axes
    assume(forward[1] < 0.999)
    assert sheet.normal == pytest.approx(-forward, abs=1e-9)
    assert np.array([sheet.right, sheet.up]) == pytest.approx(np.array([right, up]))
    size = np.abs(camera.eye).max() + camera.distance
    assert (np.subtract(camera.target, sheet.origin) @ forward) == pytest.approx(0, abs=1e-9 * size)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("target", [(0, 0, 0), (30, 70, -20), (0, -400, 5)])
def test_from_the_front_the_sheet_is_the_plane_of_symmetry(kind, target) -> None:
    eye = (target[0], target[1] - 500.0, target[2])
    stroke = Pen(Camera(kind, eye, target)).circle()
    ball = _ball(np.array(target))
    sheet = sheet_under(stroke, Context(camera=stroke.camera, scene=ball))
    assert sheet == Sheet()
    (points,) = points_on_sheet([stroke], sheet)
    assert (sheet.to_world(points)[:, 1] == 0).all()


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_through_what_is_under_the_first_point(kind) -> None:
    camera = Camera(kind, (500.0, 0.0, 0.0), (0.0, 0.0, 0.0), height=300.0)
    scene = _ball(np.array([-100.0, 0.0, 0.0]))  # its near side lies at x = -70
    on, off = Pen(camera).circle(550.0, 450.0, 50.0), Pen(camera).circle(300.0, 200.0, 50.0)
    assert sheet_under(on, Context(scene=scene)).origin[0] == pytest.approx(-70.0, abs=0.5)
    assert sheet_under(off, Context(scene=scene)).origin[0] == pytest.approx(0.0, abs=1e-9)


def test_a_view_along_the_sheet_is_refused_kindly() -> None:
    side = Camera("orthographic", (500.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    with pytest.raises(UserError, match="edge-on"):
        points_on_sheet([Pen(side).circle()], Sheet())


def test_object_frame_is_right_handed_and_faces_the_hand() -> None:
    assert Sheet().normal == pytest.approx([0.0, -1.0, 0.0])
    corners = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, -6.0]])
    assert Sheet().to_world(corners) == pytest.approx(corners[:, [0, 2, 1]] * [1, -1, 1])
    assert Sheet().turn(corners) == pytest.approx(Sheet().to_world(corners))
    assert Sheet().faces_as(Sheet((5.0, 90.0, 5.0)))
    assert not Sheet().faces_as(Sheet(right=(-1.0, 0.0, 0.0)))


def _strokes(*strokes):
    from bozzetto.ink import Strokes

    return Strokes(strokes)


def _ball(middle: np.ndarray) -> Scene:
    from bozzetto_silhouette.inflation.solidify import solidify
    from bozzetto_silhouette.outline.outline import outline_from_rings

    solid = solidify(outline_from_rings([o.circle(0.0, 0.0, 30.0)]), resolution=32)
    mesh = Mesh((solid.vertices + middle).astype(np.float32), solid.faces)
    return Scene((Layer("shape", (Shaded(mesh),)),))
