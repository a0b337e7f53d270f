"""Skins as graphs, and shares that diffuse over clusters of fine ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.geometry import Rig
from bozzetto.plugin import Job
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.skin_graph import SkinGraph
from bozzetto_silhouette.rigging.weight_diffusion import FINEST, STRETCH, gentle
from tests.plugins.silhouette.rigging.characters import dense, man, state_of_rings, stretches


def tube(length=100.0, radius=10.0, around=40, along=160, lean=0.0):
    """An open tube along x, its middle at the origin; the seam of its mesh leans."""
    x = np.linspace(-length / 2, length / 2, along)
    angle = np.linspace(0.0, 2 * np.pi, around, endpoint=False)
    grid_x, grid_a = np.meshgrid(x, angle, indexing="ij")
    grid_a = grid_a + lean * grid_x / length
    vertices = np.stack([grid_x, radius * np.cos(grid_a), radius * np.sin(grid_a)], axis=-1)
    i, j = np.meshgrid(np.arange(along - 1), np.arange(around), indexing="ij")
    corner = i * around + j
    right = i * around + (j + 1) % around
    faces = np.concatenate(
        [
            np.stack([corner, right, corner + around], -1).reshape(-1, 3),
            np.stack([right, right + around, corner + around], -1).reshape(-1, 3),
        ]
    )
    return vertices.reshape(-1, 3), faces


def jump(vertices, at=0.0):
    """Shares of two joints that change where x is `at`."""
    beyond = (vertices[:, 0] > at).astype(float)
    return np.column_stack([1.0 - beyond, beyond])


def test_diffusion_over_clusters_is_that_over_the_skin():
    vertices, faces = tube()
    shares, skin = jump(vertices), SkinGraph.of(vertices, faces)
    number = skin.clusters(5.0)
    coarse = skin.of_clusters(number)
    fine = skin.diffused(shares, np.full(len(vertices), 20.0))
    rough = coarse.diffused(skin.mean(number, shares), np.full(len(coarse.places), 20.0))
    carried = skin.carried(number, coarse, 10.0, np.arange(len(vertices))) @ rough
    assert len(coarse.places) < 0.1 * len(vertices)
    assert np.abs(fine - shares).max() > 0.3
    assert np.abs(carried - fine).max() < 0.04
    assert carried.sum(axis=1) == pytest.approx(1.0)


def test_a_tube_thinner_than_a_cell_conducts_along_itself():
    vertices, faces = tube(radius=1.0, around=12, along=300)
    skin = SkinGraph.of(vertices, faces)
    number = skin.clusters(6.0)
    coarse = skin.of_clusters(number)
    fine = skin.diffused(jump(vertices), np.full(len(vertices), 20.0))
    rough = coarse.diffused(skin.mean(number, jump(vertices)), np.full(len(coarse.places), 20.0))
    assert np.abs(rough - skin.mean(number, fine)).max() < 0.04


def test_clusters_of_limbs_that_nearly_touch_are_apart():
    vertices, faces = tube()
    both = np.concatenate([vertices, vertices + np.array([0.0, 20.01, 0.0])])
    skin = SkinGraph.of(both, np.concatenate([faces, faces + len(vertices)]))
    number = skin.clusters(8.0)
    assert not set(number[: len(vertices)]) & set(number[len(vertices) :])
    table = skin.carried(number, skin.of_clusters(number), 16.0, np.arange(len(both)))
    one = np.bincount(number[: len(vertices)], minlength=table.shape[1]) > 0
    assert (table[: len(vertices)].toarray()[:, ~one] == 0.0).all()


def test_areas_and_middles_are_those_of_the_skin():
    vertices, faces = tube()
    skin = SkinGraph.of(vertices, faces)
    coarse = skin.of_clusters(skin.clusters(5.0))
    assert coarse.areas.sum() == pytest.approx(skin.areas.sum())
    assert coarse.areas @ coarse.places == pytest.approx(skin.areas @ skin.places, abs=1e-6)


@pytest.mark.parametrize("lean", [0.0, 0.7])
def test_a_jump_far_from_its_joint_is_spread_on_a_fine_skin(lean):
    vertices, faces = tube(around=60, along=240, lean=lean)
    assert len(vertices) > FINEST
    rig = Rig(
        np.array([[-50.0, 0, 0], [-30.0, 0, 0]]), np.array([-1, 0], np.int32), ("Root", "Bone")
    )
    shares = jump(vertices, at=10.0)
    skin = SkinGraph.of(vertices, faces)
    found = gentle(vertices, faces, rig, shares)
    assert skin.strain(rig, shares)[0].max() > 10.0
    assert skin.strain(rig, found)[0].max() <= STRETCH
    assert found.min() >= 0.0
    assert found.sum(axis=1) == pytest.approx(1.0)
    assert found[vertices[:, 0] < -40.0][:, 1].max() == 0.0  # what is far away stays


@pytest.mark.parametrize("seed", [31, 47])
def test_a_fine_character_does_not_tear_and_mirrors_itself(seed):
    state = replace(state_of_rings([man(20.0, seed=seed)], resolution=96), posing=True)
    modeler = Silhouette()
    solid = modeler.shapes(state, modeler.solve(state, Job("final"))).solids[0]
    vertices, skin = solid.mesh.vertices.astype(float), solid.skin
    assert len(vertices) > FINEST
    assert stretches(solid.mesh, skin).max() <= 1.0 + STRETCH
    assert skin.weights.sum(axis=1) == pytest.approx(1.0, abs=1e-6)
    weights = dense(skin)
    flip = np.array([-1.0, 1.0, 1.0])
    middle = np.array([vertices[:, 0].min() + vertices[:, 0].max(), 0.0, 0.0])
    gap, other = cKDTree(vertices).query(vertices * flip + middle)
    joint_gap, partner = cKDTree(skin.rig.joints).query(skin.rig.joints * flip + middle)
    assert gap.max() < 1e-3
    assert joint_gap.max() < 1e-2
    assert np.abs(weights[other][:, partner] - weights).max() < 1e-4
