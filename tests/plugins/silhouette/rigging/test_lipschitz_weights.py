"""Shares that are held to slopes which no turn tears."""

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from bozzetto.geometry import Rig
from bozzetto.plugin import Job
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.lipschitz_weights import lipschitz_weights
from bozzetto_silhouette.rigging.skin_graph import SkinGraph
from tests.plugins.silhouette.rigging.characters import dense, limb, state_of_rings, stretches
from tests.plugins.silhouette.rigging.test_skin_graph import jump, tube

STRETCH, MOST = 0.8, 4


def rig_of(places, parents):
    names = tuple(f"Bone {k}" for k in range(len(places)))
    return Rig(np.asarray(places, float), np.asarray(parents, np.int32), names)


@pytest.mark.parametrize(
    ("seed", "roots"), [*((seed, 1) for seed in range(6)), (6, 2), (7, 3), (8, 6)]
)
def test_whatever_shares_come_in_gentle_ones_come_out(seed, roots):
    random = np.random.default_rng(seed)
    vertices, faces = tube(around=int(random.integers(6, 30)), along=int(random.integers(10, 60)))
    count = roots + int(random.integers(1, 11))
    parents = [*roots * [-1], *(int(random.integers(0, k)) for k in range(roots, count))]
    rig = rig_of(random.uniform(-60, 60, (count, 3)), parents)
    sharp = random.uniform(size=(len(vertices), count)) ** 8
    shares = sharp / sharp.sum(axis=1, keepdims=True)
    skin = SkinGraph.of(vertices, faces)
    found = lipschitz_weights(skin, rig, shares, STRETCH, MOST)
    assert skin.strain(rig, shares)[0].max() > 2.0
    assert skin.strain(rig, found)[0].max() <= STRETCH
    assert found.min() >= 0.0
    assert found.sum(axis=1) == pytest.approx(1.0)
    assert (found > 0.0).sum(axis=1).max() <= MOST


def test_what_is_gentle_stays():
    vertices, faces = tube()
    rig = rig_of([[-50.0, 0, 0], [0, 0, 0]], [-1, 0])
    along = np.clip((vertices[:, 0] + 10.0) / 20.0, 0.0, 1.0)
    shares = np.column_stack([1.0 - along, along])
    found = lipschitz_weights(SkinGraph.of(vertices, faces), rig, shares, STRETCH, MOST)
    np.testing.assert_allclose(found, shares, atol=1e-4)


def test_a_jump_becomes_the_mean_of_what_shortest_ways_allow():
    vertices, faces = tube(around=9, along=24, lean=0.7)
    rig = rig_of([[-50.0, 0, 0], [-40.0, 3, 0]], [-1, 0])
    shares, skin = jump(vertices, at=10.0), SkinGraph.of(vertices, faces)
    found = lipschitz_weights(skin, rig, shares, STRETCH, MOST)
    away = np.linalg.norm(0.5 * (vertices[skin.a] + vertices[skin.b]) - rig.joints[1], axis=1)
    length = np.linalg.norm(vertices[skin.a] - vertices[skin.b], axis=1)
    slope = 0.98 * STRETCH * length / (2.0 * np.sin(np.radians(20.0)) * away)
    count = len(vertices)
    ways = dijkstra(coo_array((slope, (skin.a, skin.b)), shape=(count, count)), directed=False)
    lower = (shares[:, 1] + ways).min(axis=1)
    upper = (shares[:, 1] - ways).max(axis=1)
    assert np.abs(found[:, 1] - shares[:, 1]).max() > 0.3
    np.testing.assert_allclose(found[:, 1], 0.5 * (lower + upper), atol=2e-4)


def wheels(seed):
    """Two wheels and the bars of a frame between them: loops, and limbs that lie close."""
    random = np.random.default_rng(seed)
    hubs = np.array([[-50, 0], [50, 0]]) + random.uniform(-6, 6, (2, 2))
    rims = [
        shapely.Point(*hub).buffer(r).difference(shapely.Point(*hub).buffer(r - 5))
        for hub, r in zip(hubs, random.uniform(24, 32, 2), strict=True)
    ]
    saddle, bars = np.array([[-15, 42], [30, 46]]) + random.uniform(-5, 5, (2, 2))
    pairs = [
        (hubs[0], saddle),
        (hubs[1], bars),
        (saddle, bars),
        (hubs[0], bars),
        (hubs[0], hubs[1]),
    ]
    spokes = [
        limb((*hub, 3), (*(hub + 27 * np.array([np.cos(a), np.sin(a)])), 2))
        for hub in hubs
        for a in random.uniform(0, 2 * np.pi, 4)
    ]
    whole = shapely.unary_union([*rims, *spokes, *(limb((*a, 3), (*b, 2.5)) for a, b in pairs)])
    rounded = whole.buffer(-0.8).buffer(1.6).buffer(-0.8)
    rings = [
        rounded.exterior,
        *(ring for ring in rounded.interiors if shapely.Polygon(ring).area > 12),
    ]
    return [np.array(ring.coords)[:-1] for ring in rings]


@pytest.mark.parametrize("seed", [5, 6])
def test_what_has_many_loops_tears_nowhere(seed):
    state = state_of_rings(wheels(seed))
    modeler = Silhouette()
    solid = modeler.shapes(state, modeler.solve(state, Job("final"))).solids[0]
    assert stretches(solid.mesh, solid.skin).max() <= 1.8
    assert (dense(solid.skin) > 0.0).sum(axis=1).max() <= MOST
