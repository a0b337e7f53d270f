"""Rough scans: quads follow the shape and its creases, not the noise of the triangles."""

import numpy as np
import pytest

from bozzetto.geometry.quads.remeshing import quad_dominant
from bozzetto.geometry.quads.roughness import calmed, denoised
from bozzetto.geometry.quads.surface import across, edges_of, units
from tests.core.geometry.quads.test_remeshing import BOX, BOX_FACES, ball, euler, mesh_of, ring


def no_check():
    """Go on."""


def halved(places, faces, times):
    """Each triangle in four."""
    for _ in range(times):
        edges = edges_of(faces)
        middle = edges.of_side + len(places)
        places = np.concatenate((places, places[edges.ends].mean(axis=1)))
        (a, b, c), (p, q, r) = faces.T, middle.T
        faces = np.concatenate([
            np.column_stack(row) for row in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))
        ])  # fmt: skip
    return places, faces


def with_noise(places, faces, share, seed):
    """Vertices moved at random, by a share of the mean length of their edges."""
    ends = edges_of(faces).ends
    length = np.repeat(np.linalg.norm(places[ends[:, 1]] - places[ends[:, 0]], axis=1), 2)
    own = np.bincount(ends.ravel(), length) / np.bincount(ends.ravel())
    return places + share * own[:, None] * np.random.default_rng(seed).normal(size=places.shape)


@pytest.mark.parametrize(("noise", "seed"), [(0.05, 71), (0.1, 72), (0.2, 73), (0.3, 74)])
@pytest.mark.parametrize("make", [ball, ring])
def test_a_rough_scan_has_as_many_faces_as_are_wanted_most_of_them_quads(make, noise, seed):
    places, faces = halved(*make(), 2)
    rough = with_noise(places, faces, noise, seed)
    made = quad_dominant(mesh_of(rough, faces), 300)
    assert made.remeshed
    assert euler(made) == euler(quad_dominant(mesh_of(places, faces), 300))
    assert made.count == pytest.approx(300, rel=0.15)
    assert len(made.quads) > 3 * len(made.triangles)


@pytest.mark.parametrize("seed", range(81, 84))
def test_the_corners_of_a_rough_box_stay(seed):
    places, faces = halved(BOX, BOX_FACES, 5)
    made = quad_dominant(mesh_of(with_noise(places, faces, 0.1, seed), faces), 300)
    away = np.linalg.norm(made.points[None] - BOX[:, None], axis=2).min(axis=1)
    side = np.sqrt(2 * (30 * 20 + 30 * 10 + 20 * 10) / 300)
    assert made.remeshed
    assert away.max() < 0.4 * side
    assert len(made.quads) > 5 * len(made.triangles)


def test_what_is_not_rough_stays_as_it_is():
    for places, faces in (halved(*ball(), 1), halved(*ring(), 1), halved(BOX, BOX_FACES, 4)):
        assert calmed(places, faces, 300, 2.0, no_check) is places


def test_flat_faces_and_their_creases_stay_where_they_are():
    places, faces = halved(BOX, BOX_FACES, 4)
    assert np.abs(denoised(places, faces, no_check) - places).max() < 1e-12


def test_noise_is_taken_away_and_not_the_shape():
    places, faces = halved(*ball(), 2)
    rough = with_noise(places, faces, 0.1, 91)

    def turned(some):
        """The mean angle between normals of triangles and of the ball."""
        normal = units(across(some, faces))
        cosine = np.einsum("ij,ij->i", normal, units(some[faces].mean(axis=1)))
        return np.arccos(np.clip(cosine, -1.0, 1.0)).mean()

    even = denoised(rough, faces, no_check)
    assert turned(even) < 0.5 * turned(rough)
    assert np.linalg.norm(even, axis=1).mean() == pytest.approx(20.0, rel=0.01)


def test_the_size_and_the_place_of_a_scan_change_nothing():
    places, faces = halved(*ball(), 2)
    rough = with_noise(places, faces, 0.3, 92)
    calm = calmed(rough, faces, 300, 4.0, no_check)
    far = calmed(1000.0 * rough + 5.0, faces, 300, 4000.0, no_check)
    assert calm is not rough
    assert np.allclose(far, 1000.0 * calm + 5.0, rtol=0.0, atol=1e-6)


def test_teeth_that_are_larger_than_squares_are_no_roughness():
    """A ring of teeth half as high as squares are long: creases all over, and all meant."""
    turn = np.arange(240)
    away = np.where(turn % 4 < 2, 30.0, 26.0)
    angle = 2 * np.pi * turn / 240
    rim = np.column_stack((away * np.cos(angle), away * np.sin(angle)))
    places = np.vstack([np.column_stack((rim, np.full(240, z))) for z in np.linspace(0, 20, 12)])
    faces = np.array([
        face for row in range(11) for j in range(240)
        for face in (
            (row * 240 + j, row * 240 + (j + 1) % 240, row * 240 + 240 + j),
            (row * 240 + (j + 1) % 240, row * 240 + 240 + (j + 1) % 240, row * 240 + 240 + j),
        )
    ])  # fmt: skip
    assert calmed(places, faces, 400, 2.0, no_check) is places
