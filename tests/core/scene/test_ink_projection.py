"""Ink on surfaces against closed forms, and on surfaces that could be jumped over."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.geometry.mesh import Mesh
from bozzetto.ink.stroke import Stroke
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto.scene.ink_projection import FINEST, project_stroke
from bozzetto.view.camera import Camera
from tests.core.scene.shapes import box, scene_of, soup, sphere

FRONT = Camera("orthographic", eye=(0, -100, 0), height=100, viewport=(400, 400))  # 4 px per mm
SLANTED = Camera(eye=(60, -80, 50), viewport=(800, 600))


def across(y=200.0, begin=0.0, end=400.0, count=9, camera=FRONT):
    x = np.linspace(begin, end, count)
    return Stroke(x, np.full(count, y), camera)


def sheet(low, high, y=0.0, z=20.0):
    return Mesh([(low, y, -z), (high, y, -z), (high, y, z), (low, y, z)], [(0, 1, 2), (0, 2, 3)])


def test_every_sample_is_kept_and_lies_on_the_surface_under_it():
    stroke = across(180.0, 150, 250, count=7, camera=SLANTED)
    made = project_stroke(stroke, scene_of(Shaded(sphere(40.0)), owner="ball"))
    whole = np.isin(np.arange(7.0), made.at)
    assert whole.all()
    assert made.pieces == (slice(0, len(made.points)),)
    assert made.gaps == ()
    assert set(made.owners) == {"ball"}
    radius = np.linalg.norm(made.points, axis=1)
    assert (radius <= 40 + 1e-4).all()
    assert (radius >= 40 * np.cos(np.pi / 64)).all()
    seen, _ = SLANTED.project(made.points)
    x = np.interp(made.at, np.arange(7), stroke.x)
    np.testing.assert_allclose(seen, np.column_stack((x, np.full(len(x), 180.0))), atol=1e-6)
    facing = np.einsum("nk,nk->n", made.normals, made.points - SLANTED.eye)
    assert (facing < 0).all()


def test_the_faces_named_hold_the_points():
    ball = sphere(40.0)
    made = project_stroke(across(190.0, camera=SLANTED, begin=100, end=700), scene_of(Shaded(ball)))
    assert all(item.mesh is ball for item in made.items)
    corners = ball.vertices[ball.faces[made.faces]].astype(float)
    for point, (a, b, c), normal in zip(made.points, corners, made.normals, strict=True):
        share = np.linalg.lstsq(np.column_stack((b - a, c - a)), point - a, rcond=None)[0]
        assert share.min() > -1e-6
        assert share.sum() < 1 + 1e-6
        assert abs((point - a) @ normal) < 1e-6


def test_rims_are_found_and_gaps_reported():
    scene = scene_of(Shaded(sheet(-30, -10)), Shaded(sheet(5, 21)))
    made = project_stroke(across(count=5), scene)
    assert len(made.pieces) == 2
    borders = [(80, 160), (220, 284)]
    assert [piece.start for piece in made.pieces] == [0, made.pieces[0].stop]
    for piece, (begin, end) in zip(made.pieces, borders, strict=True):
        x = made.at[piece] * 100
        assert begin <= x[0] <= begin + FINEST
        assert end - FINEST <= x[-1] <= end
    lengths = [gap.pixels for gap in made.gaps]
    np.testing.assert_allclose(lengths, [80, 60, 116], atol=2 * FINEST)
    np.testing.assert_allclose([g.begin for g in made.gaps], [0, 1.6, 2.84], atol=1e-3)
    np.testing.assert_allclose([g.end for g in made.gaps], [0.8, 2.2, 4.0], atol=1e-3)


def test_a_rod_as_thin_as_two_pixels_is_not_jumped_over():
    """The stroke has two samples, and the rod stands 5 mm in front of the sheet."""
    scene = scene_of(Shaded(sheet(-40, 40)), Shaded(sheet(3.0, 3.5, y=-5.0)))
    made = project_stroke(across(count=2), scene)
    depths = [np.unique(made.points[piece][:, 1]).tolist() for piece in made.pieces]
    assert depths == [[0.0], [-5.0], [0.0]]
    thin = made.points[made.pieces[1]]
    np.testing.assert_allclose(thin[[0, -1], 0], (3.0, 3.5), atol=FINEST / 4)


def test_a_step_within_one_mesh_is_a_break_and_a_slope_is_none():
    def profile(x, y):
        rim = [(a, b, z) for z in (-20, 20) for a, b in zip(x, y, strict=True)]
        n = len(x)
        faces = [f for k in range(n - 1) for f in ((k, k + 1, n + k + 1), (k, n + k + 1, n + k))]
        return Mesh(rim, faces)

    step = project_stroke(across(), scene_of(Shaded(profile([-40, 1, 1.0001, 40], [0, 0, 9, 9]))))
    assert len(step.pieces) == 2
    assert len(step.gaps) == 3
    assert step.gaps[1].pixels <= FINEST
    slope = project_stroke(across(), scene_of(Shaded(profile([-40, 1, 4, 40], [0, 0, 30, 30]))))
    assert len(slope.pieces) == 1
    x, y = slope.points[:, 0], slope.points[:, 1]
    np.testing.assert_allclose(y, np.interp(x, [1, 4], [0, 30]), atol=1e-4)
    for corner in (1, 4):
        assert np.abs(x - corner).min() < FINEST


@pytest.mark.parametrize("camera", [FRONT, SLANTED])
def test_a_round_body_is_one_piece_to_its_rim(camera):
    width, height = camera.viewport
    made = project_stroke(
        across(0.47 * height, 0, width, camera=camera), scene_of(Shaded(sphere(20.0)))
    )
    assert len(made.pieces) == 1
    assert len(made.gaps) == 2
    assert (np.diff(made.at) > 0).all()


def test_ink_steps_from_one_model_to_another():
    near, far = Shaded(box((10, 10, 30), (0, -20, 0))), Shaded(sheet(-45, 45))
    scene = Scene((Layer("a", (far,), "far"), Layer("b", (near,), "near")))
    made = project_stroke(across(), scene)
    assert [made.owners[piece.start] for piece in made.pieces] == ["far", "near", "far"]
    for piece in made.pieces:
        assert len(set(made.owners[piece])) == 1
    hidden = project_stroke(
        across(), Scene((Layer("b", (Shaded(near.mesh, pickable=False),), "near"),))
    )
    assert len(hidden.points) == 0


def test_ink_beside_everything_and_a_dot():
    nothing = project_stroke(across(), Scene())
    assert nothing.pieces == ()
    assert nothing.gaps == ((0.0, 8.0, 400.0),)
    dot = Stroke([200, 200, 200], [200, 200, 200], FRONT)
    assert project_stroke(dot, scene_of(Shaded(sheet(-9, 9)))).pieces == (slice(0, 1),)
    assert project_stroke(dot, Scene()).gaps == ((0.0, 0.0, 0.0),)
    with pytest.raises(UserError):
        project_stroke(Stroke([0, 1e30], [0, 0], FRONT), Scene())
    far = project_stroke(Stroke([-1e8, 1e8], [200, 200], FRONT), scene_of(Shaded(sheet(-40, 40))))
    assert np.isfinite(far.points).all()


@given(st.integers(0, 10**6), st.integers(1, 60))
@settings(max_examples=25, deadline=None)
def test_any_soup_of_triangles(seed, count):
    random = np.random.default_rng(seed)
    stroke = Stroke(*random.uniform(0, 400, (2, 12)), FRONT)
    made = project_stroke(stroke, scene_of(Shaded(soup(seed, count))))
    assert np.isfinite(made.points).all()
    assert (np.diff(made.at) > 0).all()
    assert [p.start for p in made.pieces][1:] == [p.stop for p in made.pieces][:-1]
    assert sum(p.stop - p.start for p in made.pieces) == len(made.points)
    # pieces and gaps cover the stroke without overlap
    ends = sorted(
        [(made.at[p.start], made.at[p.stop - 1]) for p in made.pieces]
        + [(gap.begin, gap.end) for gap in made.gaps]
    )
    assert ends[0][0] == 0
    assert ends[-1][1] == 11
    np.testing.assert_allclose([e[1] for e in ends[:-1]], [e[0] for e in ends[1:]], atol=1e-9)
