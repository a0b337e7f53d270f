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
from bozzetto.scene.surface_places import located
from bozzetto.view.camera import Camera
from tests.core.scene.shapes import box, scene_of, soup, sphere

FRONT = Camera("orthographic", eye=(0, -100, 0), height=100, viewport=(400, 400))  # 4 px per mm
SLANTED = Camera(eye=(60, -80, 50), viewport=(800, 600))


def across(y=200.0, begin=0.0, end=400.0, count=9, camera=FRONT):
    x = np.linspace(begin, end, count)
    return Stroke(x, np.full(count, y), camera)


def sheet(low, high, y=0.0, z=20.0):
    return Mesh([(low, y, -z), (high, y, -z), (high, y, z), (low, y, z)], [(0, 1, 2), (0, 2, 3)])


def whole(made):
    """The one run of a stroke that is nowhere cut."""
    (run,) = made.runs
    return run


def test_every_sample_is_kept_and_lies_on_the_surface_under_it():
    stroke = across(180.0, 150, 250, count=7, camera=SLANTED)
    made = project_stroke(stroke, scene_of(Shaded(sphere(40.0)), owner="ball"))
    run = whole(made)
    assert made.breaks == ()
    assert np.isin(np.arange(7.0), run.at).all()
    assert run.places.model == "ball"
    assert run.on_surface.all()
    assert not len(run.creases)
    radius = np.linalg.norm(run.points, axis=1)
    assert (radius <= 40 + 1e-4).all()
    assert (radius >= 40 * np.cos(np.pi / 64)).all()
    seen, _ = SLANTED.project(run.points)
    x = np.interp(run.at, np.arange(7), stroke.x)
    np.testing.assert_allclose(seen, np.column_stack((x, np.full(len(x), 180.0))), atol=1e-6)
    facing = np.einsum("nk,nk->n", run.normals, run.points - SLANTED.eye)
    assert (facing < 0).all()


def test_the_places_are_those_of_the_points():
    ball = sphere(40.0)
    scene = scene_of(Shaded(ball))
    run = whole(project_stroke(across(190.0, camera=SLANTED, begin=100, end=700), scene))
    assert run.item.mesh is ball
    corners = ball.vertices[ball.faces[run.places.faces]].astype(float)
    again = np.einsum("nc,ncx->nx", run.places.weights, corners)
    np.testing.assert_allclose(again, run.points, atol=1e-9)
    a, b, c = np.moveaxis(corners, 1, 0)
    across_faces = np.cross(b - a, c - a)
    sine = np.linalg.norm(np.cross(across_faces, run.normals), axis=1)
    assert (sine < 1e-9 * np.linalg.norm(across_faces, axis=1)).all()
    now = located(run.places, scene)
    np.testing.assert_allclose(now.points, run.points, atol=1e-9)


def test_rims_are_found_and_what_is_beside_them_is_told():
    scene = scene_of(Shaded(sheet(-30, -10)), Shaded(sheet(5, 21)))
    made = project_stroke(across(count=5), scene)
    assert [run.places.item for run in made.runs] == [0, 1]
    borders = [(80, 160), (220, 284)]
    for run, (begin, end) in zip(made.runs, borders, strict=True):
        x = run.at * 100
        assert begin <= x[0] <= begin + FINEST
        assert end - FINEST <= x[-1] <= end
    assert [each.kind for each in made.breaks] == ["silhouette"] * 3
    np.testing.assert_allclose([b.pixels for b in made.breaks], [80, 60, 116], atol=2 * FINEST)
    np.testing.assert_allclose([b.begin for b in made.breaks], [0, 1.6, 2.84], atol=1e-3)
    np.testing.assert_allclose([b.end for b in made.breaks], [0.8, 2.2, 4.0], atol=1e-3)


def test_a_rod_as_thin_as_two_pixels_is_not_jumped_over():
    """The stroke has two samples, and the rod stands 5 mm in front of the sheet."""
    scene = scene_of(Shaded(sheet(-40, 40)), Shaded(sheet(3.0, 3.5, y=-5.0)))
    made = project_stroke(across(count=2), scene)
    depths = [np.unique(run.points[:, 1]).tolist() for run in made.runs]
    assert depths == [[0.0], [-5.0], [0.0]]
    kinds = ["silhouette", "depth", "depth", "silhouette"]
    assert [each.kind for each in made.breaks] == kinds
    np.testing.assert_allclose(made.runs[1].points[[0, -1], 0], (3.0, 3.5), atol=FINEST / 4)


def profile(x, y):
    """A sheet upright on a line (x, y)."""
    rim = [(a, b, z) for z in (-20, 20) for a, b in zip(x, y, strict=True)]
    n = len(x)
    faces = [f for k in range(n - 1) for f in ((k, k + 1, n + k + 1), (k, n + k + 1, n + k))]
    return Mesh(rim, faces)


def test_a_step_within_one_mesh_is_a_break_and_a_slope_is_none():
    step = project_stroke(across(), scene_of(Shaded(profile([-40, 1, 1.0001, 40], [0, 0, 9, 9]))))
    assert len(step.runs) == 2
    assert [each.kind for each in step.breaks] == ["silhouette", "depth", "silhouette"]
    assert step.breaks[1].pixels <= FINEST
    slope = project_stroke(across(), scene_of(Shaded(profile([-40, 1, 4, 40], [0, 0, 30, 30]))))
    x, y = whole(slope).points[:, :2].T
    np.testing.assert_allclose(y, np.interp(x, [1, 4], [0, 30]), atol=1e-4)
    for corner in (1, 4):
        assert np.abs(x - corner).min() < FINEST


def test_creases_are_told_where_they_are_and_bends_of_round_bodies_are_none():
    """50 px of a sample each; the roof's ridge and the two gutters are creases of 45° and more."""
    roof = profile([-40, -20, 0, 20, 40], [0, 0, -20, 0, 0])
    run = whole(project_stroke(across(), scene_of(Shaded(roof))))
    np.testing.assert_allclose(run.creases, [2.4, 4.0, 5.6], atol=FINEST / 50)
    blunt = profile([-40, 0, 40], [0, 8, 0])  # 23°
    assert not len(whole(project_stroke(across(), scene_of(Shaded(blunt)))).creases)
    loose = Mesh(roof.vertices[roof.faces].reshape(-1, 3), np.arange(24).reshape(-1, 3))
    apart = whole(project_stroke(across(), scene_of(Shaded(loose))))
    np.testing.assert_array_equal(apart.creases, run.creases)
    cube = project_stroke(across(230, 0, 800, camera=SLANTED), scene_of(Shaded(box((60,) * 3))))
    assert len(whole(cube).creases) == 1


@pytest.mark.parametrize("camera", [FRONT, SLANTED])
@pytest.mark.parametrize("fineness", [64, 400])
def test_a_round_body_is_one_run_to_its_rim(camera, fineness):
    width, height = camera.viewport
    ball = scene_of(Shaded(sphere(20.0, fineness)))
    made = project_stroke(across(0.47 * height, 0, width, camera=camera), ball)
    run = whole(made)
    assert [each.kind for each in made.breaks] == ["silhouette"] * 2
    assert (np.diff(run.at) > 0).all()
    assert not len(run.creases)


def test_ink_steps_from_one_model_to_another():
    near, far = Shaded(box((10, 10, 30), (0, -20, 0))), Shaded(sheet(-45, 45))
    scene = Scene((Layer("a", (far,), "far"), Layer("b", (near,), "near")))
    made = project_stroke(across(), scene)
    assert [run.places.model for run in made.runs] == ["far", "near", "far"]
    assert [run.places.layer for run in made.runs] == ["a", "b", "a"]
    assert [b.kind for b in made.breaks] == ["silhouette", "depth", "depth", "silhouette"]
    hidden = project_stroke(
        across(), Scene((Layer("b", (Shaded(near.mesh, pickable=False),), "near"),))
    )
    assert hidden.runs == ()
    through = whole(project_stroke(across(), scene, models=["far"]))
    assert through.places.model == "far"
    assert project_stroke(across(), scene, models=()).runs == ()


def test_surfaces_that_touch_are_told_from_a_jump():
    made = project_stroke(across(), scene_of(Shaded(sheet(-40, 0)), Shaded(sheet(0, 40))))
    assert [each.kind for each in made.breaks] == ["silhouette", "surface", "silhouette"]


# -- beside the surface ----------------------------------------------------------------------------


def test_ink_is_continued_in_the_tangent_plane_over_a_short_gap():
    """Two flat pieces of one mesh with a slit of 8 px, seen aslant: the plane goes on."""
    plane = lambda x: 0.4 * x  # noqa: E731
    parts = [profile([a, b], [plane(a), plane(b)]) for a, b in ((-40, -1), (1, 40))]
    both = Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate((parts[0].faces, parts[1].faces + 4)),
    )
    scene = scene_of(Shaded(both))
    cut = project_stroke(across(), scene)
    assert [each.kind for each in cut.breaks] == ["silhouette"] * 3
    run = whole(project_stroke(across(), scene, bridge=9.0))
    np.testing.assert_allclose(run.points[:, 1], plane(run.points[:, 0]), atol=1e-5)
    beside = run.points[~run.on_surface, 0]
    assert (np.abs(beside) <= 1 + 1e-9).all()
    assert np.diff(run.points[:, 0]).max() < 0.3
    # Places beside the surface are those of the nearer end.
    ends = located(run.places, scene).points[~run.on_surface, 0]
    np.testing.assert_allclose(np.abs(ends), 1.0, atol=FINEST)
    assert (np.sign(ends) == np.sign(beside))[np.abs(beside) > 0.01].all()
    assert len(project_stroke(across(), scene, bridge=7.0).runs) == 2


@pytest.mark.parametrize("camera", [FRONT, Camera(eye=(20, -140, 30), viewport=(400, 400))])
def test_ink_that_runs_off_a_flat_piece_stays_in_its_plane(camera):
    slanted = Mesh(
        [(-30, -9, -20), (30, 9, -20), (30, 9, 20), (-30, -9, 20)], [[0, 1, 2], [0, 2, 3]]
    )
    stroke = across(200, 20, 380, camera=camera)
    cut = project_stroke(stroke, scene_of(Shaded(slanted)))
    wide = max(each.pixels for each in cut.breaks) + 1
    run = whole(project_stroke(stroke, scene_of(Shaded(slanted)), bridge=wide))
    assert (run.at[0], run.at[-1]) == (0.0, 8.0)
    assert not run.on_surface[[0, -1]].any()
    np.testing.assert_allclose(run.points[:, 1], 0.3 * run.points[:, 0], atol=1e-5)
    seen, _ = camera.project(run.points)
    np.testing.assert_allclose(seen[:, 1], 200.0, atol=1e-6)


def test_ink_that_runs_off_a_round_body_keeps_the_depth_of_its_rim():
    """A tangent plane seen edge-on would run off to the horizon."""
    ball = scene_of(Shaded(sphere(30.0, 200)))
    stroke = across(200, 200, 340, count=15)
    run = whole(project_stroke(stroke, ball, bridge=25.0))
    assert run.at[-1] == 14.0
    beside = run.points[~run.on_surface]
    np.testing.assert_allclose(beside[:, 1], run.points[run.on_surface][-1, 1], atol=1e-9)


def test_nothing_is_continued_from_one_surface_to_another():
    scene = scene_of(Shaded(sheet(-40, -1)), Shaded(sheet(1, 40)))
    assert len(project_stroke(across(), scene, bridge=50.0).runs) == 2
    behind = profile([-40, -1], [0, 0])
    far = profile([1, 40], [30, 30])
    both = Mesh(
        np.concatenate((behind.vertices, far.vertices)),
        np.concatenate((behind.faces, far.faces + 4)),
    )
    assert len(project_stroke(across(), scene_of(Shaded(both)), bridge=50.0).runs) == 2


# -- hostile ---------------------------------------------------------------------------------------


def test_ink_beside_everything_and_a_dot():
    nothing = project_stroke(across(), Scene(), bridge=1e9)
    assert nothing.runs == ()
    assert nothing.breaks == ((0.0, 8.0, 400.0, "silhouette"),)
    dot = Stroke([200, 200, 200], [200, 200, 200], FRONT)
    assert len(whole(project_stroke(dot, scene_of(Shaded(sheet(-9, 9))), bridge=3.0)).points) == 1
    assert project_stroke(dot, Scene()).breaks == ((0.0, 0.0, 0.0, "silhouette"),)
    with pytest.raises(UserError):
        project_stroke(Stroke([0, 1e30], [0, 0], FRONT), Scene())
    far = project_stroke(Stroke([-1e8, 1e8], [200, 200], FRONT), scene_of(Shaded(sheet(-40, 40))))
    assert all(np.isfinite(run.points).all() for run in far.runs)


@given(st.integers(0, 10**6), st.integers(1, 60), st.sampled_from([0.0, 30.0, np.inf]))
@settings(max_examples=25, deadline=None)
def test_any_soup_of_triangles(seed, count, bridge):
    random = np.random.default_rng(seed)
    stroke = Stroke(*random.uniform(0, 400, (2, 12)), FRONT)
    scene = scene_of(Shaded(soup(seed, count)))
    made = project_stroke(stroke, scene, bridge=bridge)
    for run in made.runs:
        assert np.isfinite(run.points).all()
        assert (np.diff(run.at) > 0).all()
        np.testing.assert_allclose(np.linalg.norm(run.normals, axis=1), 1.0, atol=1e-9)
        on = located(run.places, scene).points[run.on_surface]
        np.testing.assert_allclose(on, run.points[run.on_surface], atol=1e-6)
        seen, _ = FRONT.project(run.points)
        for axis, column in enumerate((stroke.x, stroke.y)):
            drawn = np.interp(run.at, np.arange(12), column)
            np.testing.assert_allclose(seen[:, axis], drawn, atol=1e-6)
    # runs and breaks cover the stroke without overlap
    ends = sorted(
        [(run.at[0], run.at[-1]) for run in made.runs] + [(b.begin, b.end) for b in made.breaks]
    )
    assert ends[0][0] == 0
    assert ends[-1][1] == 11
    np.testing.assert_allclose([e[1] for e in ends[:-1]], [e[0] for e in ends[1:]], atol=1e-9)
