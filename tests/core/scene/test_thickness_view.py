"""Thickness in colours, against solids whose walls have closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Mesh, Placement
from bozzetto.scene import DARK, LIGHT, Label, Layer, Points, Scene, Shaded
from bozzetto.scene.snapshot import picture
from bozzetto.scene.thickness_view import (
    FINENESS,
    MIDDLE,
    THICK,
    THIN,
    thickness_colors,
    thickness_view,
)
from tests.core.scene.shapes import box, scene_of, sphere


def turned_inside_out(mesh: Mesh) -> Mesh:
    normals = None if mesh.normals is None else -mesh.normals
    return replace(mesh, faces=mesh.faces[:, ::-1], normals=normals)


def welded(mesh: Mesh) -> Mesh:
    """The ball of `shapes` has a seam and a point many times at each pole, to rounding."""
    places, which = np.unique(np.round(mesh.vertices, 4) + 0.0, axis=0, return_inverse=True)
    faces = which.ravel()[mesh.faces]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return Mesh(places.astype(np.float32), faces[whole].astype(np.int32))


def colored(view) -> list[Mesh]:
    shaded = [item for _, item in view.scene.items() if isinstance(item, Shaded)]
    return [item.mesh for item in shaded if item.mesh.colors is not None]


def color_of(thickness: float, palette=LIGHT) -> np.ndarray:
    return thickness_colors(np.array([thickness]), palette)[0]


def off(mesh: Mesh, thickness: float) -> np.ndarray:
    return np.abs(mesh.colors.astype(float) - color_of(thickness)).max(axis=1)


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_the_scale_runs_from_thin_to_thick_and_stays_there(palette) -> None:
    ends = thickness_colors(np.array([0.0, THIN, MIDDLE, THICK, np.inf]), palette)[:, :3]
    accent, clay, second = palette.accent, palette.clay, palette.second
    np.testing.assert_allclose(ends, [accent, accent, clay, second, second], atol=1e-3)
    steps = thickness_colors(np.geomspace(THIN, THICK, 40), palette)[:, :3]
    assert (np.abs(np.diff(steps, axis=0)).max(axis=1) > 0).all(), "no two steps look the same"


def test_a_plate_of_twelve_triangles_shows_its_thickness_in_the_middle() -> None:
    plate = box((40.0, 30.0, 1.0))
    view = thickness_view(scene_of(Shaded(plate)), LIGHT)
    (mesh,) = colored(view)
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)
    inside = (np.abs(mesh.vertices[:, :2]) < (19.0, 14.0)).all(axis=1)
    assert inside.sum() > 200, "flat faces are parted"
    assert off(mesh, 1.0)[inside].max() <= 1.0
    rim = (np.abs(mesh.vertices[:, 0]) == 20.0) & (np.abs(mesh.normals[:, 0]) > 0.9)
    assert off(mesh, 40.0)[rim].max() <= 1.0, "from a rim the plate is as thick as it is long"
    assert view.thinnest.thinnest == pytest.approx(1.0, rel=1e-3)


def test_parting_moves_nothing_and_leaves_no_gap() -> None:
    plate = box((40.0, 3.0, 17.0))
    (mesh,) = colored(thickness_view(scene_of(Shaded(plate)), LIGHT))
    corners = mesh.vertices[mesh.faces].astype(float)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(
        2 * (40 * 3 + 40 * 17 + 3 * 17), rel=1e-6
    )
    assert (corners * across[:, None]).sum() / 18 == pytest.approx(40 * 3 * 17, rel=1e-6)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges.max() <= 40.0 * FINENESS * (1 + 1e-6)
    _, which = np.unique(mesh.vertices, axis=0, return_inverse=True)
    ends = np.sort(np.stack((mesh.faces, np.roll(mesh.faces, 1, 1)), 2).reshape(-1, 2), axis=1)
    _, shared = np.unique(np.sort(which.ravel()[ends], axis=1), axis=0, return_counts=True)
    assert (shared == 2).all()


@pytest.mark.parametrize("wall", [0.7, 1.6, 4.0])
def test_a_hollow_ball_is_as_thick_everywhere_from_both_sides(wall) -> None:
    outer = welded(sphere(20.0, 48))
    inner = turned_inside_out(welded(sphere(20.0 - wall, 48)))
    view = thickness_view(scene_of(Shaded(outer), Shaded(inner)), LIGHT)
    meshes = colored(view)
    assert len(meshes) == 2
    for mesh in meshes:
        assert np.median(off(mesh, wall)) < 6
        assert off(mesh, wall).max() < 30
    assert view.thinnest.thinnest == pytest.approx(wall, rel=0.05)


def test_a_solid_may_be_shown_in_pieces() -> None:
    """As a product is: surfaces that share their borders to the last bit."""
    whole = box((40.0, 30.0, 1.0))
    pieces = [Shaded(replace(whole, faces=whole.faces[k : k + 2])) for k in range(0, 12, 2)]
    together = thickness_view(scene_of(Shaded(whole)), LIGHT)
    apart = thickness_view(scene_of(*pieces), LIGHT)
    assert len(colored(apart)) == 6
    assert apart.thinnest.thinnest == together.thinnest.thinnest


def test_what_is_open_has_no_thickness_and_keeps_its_colours() -> None:
    bowl = box((40.0, 30.0, 1.0))
    scene = scene_of(Shaded(replace(bowl, faces=bowl.faces[2:])))
    view = thickness_view(scene, LIGHT)
    assert view.thinnest is None
    assert view.scene.layers == scene.layers, "the very same"
    far = replace(bowl, vertices=bowl.vertices + np.float32(100))
    both = Mesh(
        np.concatenate((bowl.vertices, far.vertices)),
        np.concatenate((bowl.faces[2:], far.faces + 8)),
    )
    (mesh,) = colored(thickness_view(scene_of(Shaded(both)), LIGHT))
    assert mesh.vertices[np.unique(mesh.faces)].min() > 50, "the closed one of the two alone"


def test_helping_surfaces_and_other_models_bound_nothing() -> None:
    ball = Shaded(welded(sphere(20.0, 32)))
    inside = welded(sphere(19.0, 32))
    alone = thickness_view(scene_of(ball), LIGHT).thinnest
    assert alone.thinnest == pytest.approx(40.0, rel=0.02)
    for helper in (Shaded(inside, pickable=False), Shaded(inside, opacity=1e-3)):
        assert thickness_view(scene_of(ball, helper), LIGHT).thinnest == alone
    other = Scene((*scene_of(ball).layers, *scene_of(Shaded(inside), owner="n").layers))
    assert thickness_view(other, LIGHT).thinnest.thinnest == pytest.approx(38.0, rel=0.02)


def test_where_a_model_stands_does_not_matter() -> None:
    scene = scene_of(Shaded(box((40.0, 30.0, 1.5))))
    c, s = np.cos(0.8), np.sin(0.8)
    turn = Placement((c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0), 1.0, (7.0, -3.0, 11.0))
    here = thickness_view(scene, LIGHT).thinnest
    there = thickness_view(scene.placed(turn), LIGHT).thinnest
    assert there.thinnest == pytest.approx(here.thinnest, rel=1e-3)


def test_the_thinnest_wall_of_all_models_is_marked_where_it_is() -> None:
    thin = Shaded(replace(box((10.0, 10.0, 0.8)), normals=None))
    thick = Shaded(box((10.0, 10.0, 3.0), (30.0, 0.0, 0.0)))
    scene = Scene((Layer("a", (thick,), "a"), Layer("b", (thin,), "b")))
    view = thickness_view(scene, LIGHT)
    (dots,) = [item for _, item in view.scene.items() if isinstance(item, Points)]
    (label,) = [item for _, item in view.scene.items() if isinstance(item, Label)]
    assert label.text == "0.8 mm"
    assert np.abs(dots.points[0]) == pytest.approx((0.0, 0.0, 0.0), abs=5.0)
    assert abs(float(dots.points[0, 2])) < 0.05, "in the middle of the wall"


def test_twice_gives_the_same_picture_and_nothing_at_all_is_no_fault() -> None:
    scene = scene_of(Shaded(box((40.0, 30.0, 1.0))))
    one, two = (picture(scene, shading="thickness", size=(160, 120)) for _ in range(2))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, picture(scene, size=(160, 120)))
    assert thickness_view(Scene(), LIGHT).thinnest is None
    nothing = Shaded(Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32)))
    assert thickness_view(scene_of(nothing), LIGHT).thinnest is None
    flat = Shaded(Mesh(np.zeros((3, 3), np.float32), np.array([(0, 1, 2)])))
    assert thickness_view(scene_of(flat), LIGHT).thinnest is None


def test_what_is_no_longer_wanted_ends_wherever_it_is() -> None:
    scene, looks = scene_of(Shaded(box((40.0, 30.0, 20.0)))), []
    thickness_view(scene, LIGHT, lambda: looks.append(1))
    count = len(looks)
    assert count >= 3
    for last in range(1, count + 1):
        left = [1] * (last - 1)
        with pytest.raises(IndexError):
            thickness_view(scene, LIGHT, left.pop)
