"""Places follow their surface: moved, bent, mirrored, solved again; and through a document."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.document.storage.state_codec import check_encodable, decode_state, encode_state
from bozzetto.geometry import Mesh, Placement
from bozzetto.scene import (
    Hits,
    Layer,
    Lines,
    Scene,
    Shaded,
    SurfacePlaces,
    cast_rays,
    follow,
    located,
    surface_mesh,
)
from bozzetto.scene.surface_places import topology_of
from bozzetto.view import Rays
from tests.core.scene.shapes import box, scene_of, sphere


def places_on(mesh, seed=0, count=40, **names) -> SurfacePlaces:
    """Places spread over a mesh."""
    random = np.random.default_rng(seed)
    where = {"model": "m", "layer": "l", "item": 0, **names}
    return SurfacePlaces(
        **where,
        topology=topology_of(mesh),
        faces=random.integers(0, len(mesh.faces), count),
        weights=random.dirichlet((1.0, 1.0, 1.0), count),
    )


def subdivided(mesh):
    """Every triangle in four, in another order, over vertices of its own."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    ab, bc, ca = (0.5 * (p + q) for p, q in ((a, b), (b, c), (c, a)))
    parts = [np.stack(each, 1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    corners = np.concatenate(parts)[::-1]
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


def rotation(seed):
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


EXACT = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.0, (10.0, -20.0, 30.0))
MIRROR = Placement((-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), 0.5, (-15.0, 5.0, 40.0))


# -- what was met ----------------------------------------------------------------------------------


def seen_from_in_front(scene) -> Hits:
    x, z = (axis.ravel() for axis in np.meshgrid(np.linspace(-30, 30, 13), np.linspace(-9, 9, 5)))
    origins = np.column_stack((x, np.full(len(x), -100.0), z))
    return cast_rays(scene, Rays(origins, np.tile((0.0, 1.0, 0.0), (len(x), 1))))


def test_hits_tell_what_was_met_and_where_on_it():
    items = (Lines(np.zeros((2, 3), np.float32)), Shaded(sphere(20.0)))
    scene = Scene((Layer("x", (), "a"), Layer("y", items, "b")))
    hits = seen_from_in_front(scene)
    places = hits.places(hits.hit)
    assert (places.model, places.layer, places.item) == ("b", "y", 1)
    assert hits.owners == tuple("b" if hit else "" for hit in hits.hit)
    assert surface_mesh(places, scene) is items[1].mesh
    np.testing.assert_allclose(located(places, scene).points, hits.points[hits.hit], atol=1e-9)
    np.testing.assert_array_equal(np.isnan(hits.weights[:, 0]), ~hits.hit)
    one = hits.places([int(np.flatnonzero(hits.hit)[3])])
    np.testing.assert_allclose(located(one, scene).points[0], hits.points[hits.hit][3], atol=1e-9)


def test_places_of_rays_that_met_nothing_or_two_surfaces_are_refused():
    near, far = Shaded(sphere(9.0, center=(-15, 0, 0))), Shaded(sphere(9.0, center=(15, 0, 0)))
    hits = seen_from_in_front(scene_of(near, far))
    for which in (hits.hit, np.zeros(0, int), [0], ~hits.hit):
        with pytest.raises(ValueError, match="one surface"):
            hits.places(which)


# -- following -------------------------------------------------------------------------------------


@pytest.mark.parametrize("placement", [EXACT, MIRROR], ids=["turned", "mirrored"])
def test_points_move_with_a_surface_that_is_placed(placement):
    """Placements without rounding; corners of meshes are float32."""
    mesh = box((40.0, 20.0, 10.0))
    places = places_on(mesh)
    scene = scene_of(Shaded(mesh))
    here, there = located(places, scene), located(places, scene.placed(placement))
    np.testing.assert_allclose(there.points, placement.points(here.points), atol=1e-9)
    np.testing.assert_allclose(there.normals, placement.directions(here.normals), atol=1e-9)
    assert there.places is places
    assert there.alike.all()
    assert not there.distance.any()


@given(st.integers(0, 10**6), st.floats(0.01, 100.0))
@settings(max_examples=20, deadline=None)
def test_any_placement_moves_them_but_for_the_rounding_of_corners(seed, scale):
    mesh = sphere(40.0, 12)
    offset = tuple(np.random.default_rng(seed).uniform(-500, 500, 3).tolist())
    placement = Placement(tuple(rotation(seed).ravel().tolist()), scale, offset)
    places = places_on(mesh, seed)
    moved = mesh.placed(placement)
    rounding = np.abs(moved.vertices - placement.points(mesh.vertices)).max()
    here, there = follow(places, mesh, mesh), follow(places, mesh, moved)
    assert np.abs(there.points - placement.points(here.points)).max() <= rounding + 1e-9


def test_points_of_a_bent_surface_keep_their_triangles():
    mesh = sphere(40.0, 16)
    bent = Mesh(mesh.vertices * np.float32([1, 2, 0.5]), mesh.faces)
    places = places_on(mesh)
    corners = bent.vertices[bent.faces[places.faces]].astype(float)
    expected = sum(places.weights[:, [k]] * corners[:, k] for k in range(3))
    np.testing.assert_allclose(follow(places, mesh, bent).points, expected, atol=1e-12)


def test_a_surface_with_finer_triangles_carries_them_within_rounding():
    mesh = sphere(40.0, 16)
    places = places_on(mesh)
    here, there = follow(places, mesh, mesh), follow(places, mesh, subdivided(mesh))
    np.testing.assert_allclose(there.points, here.points, atol=1e-5)
    np.testing.assert_allclose(there.distance, 0.0, atol=1e-5)
    assert there.alike.all()
    assert there.places.topology != places.topology


def test_a_surface_that_grew_tells_how_far_its_points_were_carried():
    before, after = sphere(40.0, 48), sphere(42.0, 64)
    there = follow(places_on(before), before, after)
    assert there.alike.all()
    np.testing.assert_allclose(there.distance, 2.0, atol=0.1)
    np.testing.assert_allclose(np.linalg.norm(there.points, axis=1), 42.0, atol=0.1)


def test_places_do_not_go_over_to_the_back_of_a_plate():
    thick, thin = box((40.0, 40.0, 4.0)), subdivided(box((40.0, 40.0, 1.0), (0, 0, -1.5)))
    top = follow(places_on(thick), thick, thick).normals[:, 2] > 0.5
    there = follow(places_on(thick).taken(top), thick, thin)
    np.testing.assert_allclose(there.points[:, 2], -1.0, atol=1e-6)
    np.testing.assert_allclose(there.distance, 3.0, atol=1e-6)
    low = (thin.vertices[thin.faces][:, :, 2] < -1.9).all(axis=1)
    only_bottom = Mesh(thin.vertices, thin.faces[low])
    lost = follow(places_on(thick).taken(top), thick, only_bottom)
    assert not lost.alike.any()


@given(st.integers(0, 10**6))
@settings(max_examples=10, deadline=None)
def test_twice_is_once_and_there_and_back_is_near(seed):
    before, after = sphere(40.0, 10), sphere(41.0, 14, center=(0.5, 0.0, 0.0))
    once = follow(places_on(before, seed), before, after)
    again = follow(once.places, before, after)
    np.testing.assert_array_equal(again.points, once.points)
    assert again.places is once.places
    via = follow(follow(places_on(before, seed), before, before).places, before, after)
    np.testing.assert_array_equal(via.points, once.points)


def test_a_place_on_no_face_of_the_mesh_is_refused():
    mesh, other = sphere(40.0, 8), sphere(40.0, 9)
    places = places_on(mesh)
    with pytest.raises(ValueError, match="another mesh"):
        follow(places, other, box())
    with pytest.raises(ValueError, match="gone"):
        follow(places, mesh, Mesh(np.zeros((0, 3)), np.zeros((0, 3))))
    beyond = SurfacePlaces("m", "l", 0, topology_of(mesh), [10**6], [(1, 0, 0)])
    with pytest.raises(ValueError, match="another mesh"):
        follow(beyond, mesh, mesh)


# -- in a scene ------------------------------------------------------------------------------------


def test_a_surface_that_is_gone_or_solved_anew_is_told():
    mesh, finer = sphere(40.0, 8), sphere(40.0, 9)
    places = places_on(mesh, item=1)
    spot = Lines(np.zeros((2, 3), np.float32))
    shown = Scene((Layer("l", (spot, Shaded(mesh)), "m"),))
    anew = Scene((Layer("l", (spot, Shaded(finer)), "m"),))
    assert located(places, shown) is not None
    for gone in (Scene(), shown.owned("n"), scene_of(Shaded(mesh)), scene_of(Shaded(mesh), spot)):
        assert located(places, gone) is None
        assert located(places, gone, mesh) is None
    assert located(places, anew) is None
    carried = located(places, anew, mesh)
    assert carried is not None
    assert located(carried.places, anew) is not None
    assert surface_mesh(places, anew) is finer


def test_of_layers_with_one_name_the_one_with_the_triangles_counts():
    mesh, other = sphere(40.0, 8), box()
    scene = scene_of(Shaded(other)) + scene_of(Shaded(mesh))
    hits = seen_from_in_front(scene)
    places = hits.places(hits.hit)
    assert surface_mesh(places, scene) is mesh


# -- as a value ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Inked:
    """A state that keeps places."""

    places: SurfacePlaces | None = None


def test_places_go_through_a_document():
    mesh = sphere(40.0, 8)
    state = Inked(places_on(mesh))
    check_encodable(Inked, state)
    again = decode_state(Inked, encode_state(state))
    assert again.places is not None
    was, now = follow(state.places, mesh, mesh), follow(again.places, mesh, mesh)
    np.testing.assert_array_equal(was.points, now.points)
    for name in ("model", "layer", "item", "topology"):
        assert getattr(again.places, name) == getattr(state.places, name)


@pytest.mark.parametrize(
    ("faces", "weights", "item"),
    [
        ([0, 1], [(1, 0, 0)], 0),
        ([-1], [(1, 0, 0)], 0),
        ([0], [(1.5, -0.5, 0)], 0),
        ([0], [(0.5, 0.1, 0)], 0),
        ([0], [(np.nan, 0.5, 0.5)], 0),
        ([0], [(1, 0, 0)], -1),
    ],
)
def test_numbers_that_are_no_places_are_refused(faces, weights, item):
    with pytest.raises(ValueError, match=r"place|count|finite"):
        SurfacePlaces("m", "l", item, "t", faces, weights)


def test_places_cannot_be_written_to_and_can_be_taken():
    places = places_on(sphere(3.0, 8))
    with pytest.raises(ValueError, match="read-only"):
        places.weights[0] = 0
    assert len(places.taken(slice(3, 7))) == 4
    assert len(places.taken(places.faces >= 0)) == len(places)
    assert len(places.taken(np.zeros(0, int))) == 0
