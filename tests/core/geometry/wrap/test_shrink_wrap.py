"""Skins over curves: laws that hold for every network, and what cannot be wrapped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import Cancelled, UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Mesh, Solid
from bozzetto.geometry.mesh_places import closest_on_triangles
from bozzetto.geometry.wrap.icosphere import edges_of, icosphere
from bozzetto.geometry.wrap.shrink_wrap import curve_distances, shrink_wrap
from bozzetto.geometry.wrap.wireframe import wireframe

Array = NDArray[np.float64]
Curves = list[Array]


def box(x: float = 2.0, y: float = 1.0, z: float = 1.0) -> Curves:
    corners = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)])
    pairs = [(a, b) for a in range(8) for b in range(a) if (corners[a] != corners[b]).sum() == 1]
    return [corners[list(pair)] for pair in pairs]


def great_circles() -> Curves:
    turn = np.linspace(0, 2 * np.pi, 121)
    circle = np.stack((np.cos(turn), np.sin(turn), 0 * turn), axis=1)
    return [circle, circle[:, [2, 0, 1]], circle[:, [1, 2, 0]]]


def angle_piece(half_width: float = 0.4) -> Curves:
    """An L: its inner edge lies in a hollow."""
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
    near = np.insert(outline, 1, -half_width, axis=1)
    far = near * (1, -1, 1)
    rims = [np.array([side[k - 1], side[k]]) for side in (near, far) for k in range(6)]
    return rims + [np.array(pair) for pair in zip(near, far, strict=True)]


def ring() -> Curves:
    turn = np.linspace(0, 2 * np.pi, 161)
    around = [
        np.stack((r * np.cos(turn), r * np.sin(turn), 0 * turn + z), axis=1)
        for r, z in ((2.6, 0.0), (2.0, 0.6), (1.4, 0.0), (2.0, -0.6))
    ]
    radius, height = 2 + 0.6 * np.cos(turn), 0.6 * np.sin(turn)
    across = [
        np.stack((radius * np.cos(at), radius * np.sin(at), height), axis=1)
        for at in np.arange(8) * np.pi / 4
    ]
    return around + across


NETWORKS = {"box": box, "circles": great_circles, "angle piece": angle_piece, "ring": ring}


def crossings(mesh: Mesh) -> int:
    """How many pairs of an edge and a triangle without common vertices cut each other."""
    from scipy.spatial import cKDTree

    places, faces = mesh.vertices.astype(float), mesh.faces.astype(np.intp)
    corners = places[faces]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max()
    edges = edges_of(faces)[0]
    ends = places[edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    found = cKDTree(centres).query_ball_point(ends.mean(axis=1), 0.5 * length + reach)
    edge = np.repeat(np.arange(len(edges)), [len(each) for each in found])
    face = np.concatenate(found).astype(np.intp)
    apart = ~(faces[face][:, :, None] == edges[edge][:, None]).any(axis=(1, 2))
    edge, face = edge[apart], face[apart]
    a, b, c = np.moveaxis(corners[face], 1, 0)
    start, along = ends[edge, 0], ends[edge, 1] - ends[edge, 0]
    normal = np.cross(b - a, c - a)
    slope = np.einsum("ij,ij->i", normal, along)
    share = np.einsum("ij,ij->i", a - start, normal) / np.where(slope == 0, np.inf, slope)
    place = start + share[:, None] * along
    inside = (slope != 0) & (share > 0) & (share < 1)
    for one, other in ((a, b), (b, c), (c, a)):
        turn = np.cross(other - one, place - one)
        inside &= np.einsum("ij,ij->i", turn, normal) > 0
    return int(inside.sum())


def size_of(curves: Curves) -> float:
    return float(np.linalg.norm(np.ptp(np.vstack(curves), axis=0)))


@pytest.mark.parametrize("level", range(5))
def test_an_icosphere_is_round_closed_and_its_own_mirror_image(level: int) -> None:
    sphere = icosphere(level)
    count = 10 * 4**level + 2
    assert len(sphere.directions) == count
    assert count - len(sphere.edges) + len(sphere.faces) == 2
    assert (sphere.directions[sphere.mirrored] == sphere.directions * (1, -1, 1)).all()
    np.testing.assert_allclose(np.linalg.norm(sphere.directions, axis=1), 1.0, rtol=1e-15)
    a, b, c = np.moveaxis(sphere.directions[sphere.faces], 1, 0)
    assert (np.einsum("ij,ij->i", a, np.cross(b, c)) > 0).all()
    assert all(
        (sphere.faces[ring] == vertex).any(axis=1).all() for vertex, ring in enumerate(sphere.rings)
    )


def test_nearest_places_of_triangles_are_those_of_a_fine_search() -> None:
    rng = np.random.default_rng(4)
    points, triangles = rng.normal(size=(60, 3)), rng.normal(size=(60, 3, 3))
    weights = closest_on_triangles(points, triangles)
    assert (weights >= -1e-12).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    found = np.linalg.norm(np.einsum("nc,ncx->nx", weights, triangles) - points, axis=1)
    steps = [(i, j, 100 - i - j) for i in range(101) for j in range(101 - i)]
    grid = np.array(steps) / 100.0
    sought = np.linalg.norm(grid @ triangles - points[:, None], axis=2).min(axis=1)
    assert (found <= sought + 1e-12).all()
    assert (found >= sought - 0.05).all()


@pytest.mark.parametrize("network", NETWORKS)
def test_every_skin_is_closed_outward_and_of_genus_nought(network: str) -> None:
    mesh = shrink_wrap(NETWORKS[network](), level=4)
    facts = check_solid(Solid(mesh))
    assert (facts.genus, facts.parts) == (0, 1)
    assert np.isfinite(mesh.vertices).all()


@pytest.mark.parametrize("network", NETWORKS)
def test_symmetric_curves_have_a_skin_that_is_symmetric_to_the_last_bit(network: str) -> None:
    vertices = shrink_wrap(NETWORKS[network](), level=4).vertices + 0.0
    image = vertices * np.float32([1, -1, 1]) + 0.0
    assert set(map(tuple, vertices.tolist())) == set(map(tuple, image.tolist()))


@pytest.mark.parametrize(
    ("network", "usual", "most", "greatest"),
    [
        ("box", 1e-6, 1e-6, 1e-5),
        ("circles", 1e-4, 3e-4, 1e-3),
        ("angle piece", 1e-6, 1e-6, 0.03),
        ("ring", 1e-4, 2e-3, 0.02),
    ],
)
def test_curves_lie_on_the_skin(network: str, usual: float, most: float, greatest: float) -> None:
    curves = NETWORKS[network]()
    far = curve_distances(curves, shrink_wrap(curves)) / size_of(curves)
    median, nearly, worst = np.quantile(far, [0.5, 0.95, 1.0])
    assert median <= usual
    assert nearly <= most
    assert worst <= greatest


@pytest.mark.parametrize("curves", [box, great_circles])
def test_a_skin_does_not_cut_itself(curves: Callable[[], Curves]) -> None:
    assert crossings(shrink_wrap(curves(), level=4)) == 0


def test_the_count_of_crossings_sees_one() -> None:
    sphere = icosphere(2)
    dented = sphere.directions.copy()
    dented[0] *= -2.0
    assert crossings(Mesh(dented.astype(np.float32), sphere.faces.astype(np.int32))) > 0


def test_a_taut_box_is_the_box() -> None:
    mesh = shrink_wrap(box(), smoothing=0.0)
    assert check_solid(Solid(mesh)).volume == pytest.approx(16.0, rel=2e-3)
    corners = {tuple(corner) for line in box() for corner in line.astype(np.float32).tolist()}
    assert corners <= set(map(tuple, mesh.vertices.tolist()))


def test_a_smooth_skin_over_great_circles_is_nearly_a_ball() -> None:
    radius = np.linalg.norm(shrink_wrap(great_circles(), smoothing=1.0).vertices, axis=1)
    assert radius.min() > 0.95
    assert radius.max() < 1.02


def test_tightness_draws_the_skin_into_hollows() -> None:
    curves = angle_piece(1.0)
    loose, tight = (
        shrink_wrap(curves, level=4, tightness=tightness, smoothing=0.0) for tightness in (0.0, 1.0)
    )
    edge = [np.array([[1.0, y, 1.0] for y in np.linspace(-0.6, 0.6, 9)])]
    middle = np.array(edge[0])

    def distance(mesh: Mesh) -> float:
        gap = np.linalg.norm(mesh.vertices[:, None].astype(float) - middle, axis=2)
        return float(gap.min(axis=0).max())

    assert distance(tight) < 0.5 * distance(loose)


def test_place_and_size_do_not_matter() -> None:
    curves = box(2.0, 1.0, 0.7)
    here = shrink_wrap(curves, level=4).vertices
    there = shrink_wrap([3.0 * line + (50.0, 0.0, -20.0) for line in curves], level=4).vertices
    np.testing.assert_allclose((there - (50.0, 0.0, -20.0)) / 3.0, here, atol=1e-5)


def test_a_turned_network_has_nearly_the_same_skin_turned() -> None:
    curves = great_circles()
    slant = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    here = shrink_wrap(curves, smoothing=0.5)
    there = shrink_wrap([line @ slant.T for line in curves], smoothing=0.5)
    gap = curve_distances([there.vertices[i : i + 1] @ slant for i in range(0, 10242, 50)], here)
    assert gap.max() < 0.02 * size_of(curves)


def test_one_side_may_be_split_otherwise_than_the_other() -> None:
    curves = great_circles()
    halved = [curves[0], curves[1], curves[2][:50], curves[2][49:]]
    assert wireframe(halved).symmetric
    assert not wireframe([*curves, np.array([[0.0, 0.2, 0.3], [0.1, 0.6, 0.2]])]).symmetric


@pytest.mark.parametrize(
    ("curves", "words"),
    [
        ([], "no curve"),
        ([np.zeros((0, 3))], "no curve"),
        ([np.ones((1, 3))], "single point"),
        ([np.array([[0, 0, 0], [1, 2, 3.0]])], "one line"),
        (great_circles()[:1], "one plane"),
        ([np.array([[0, 0, 0], [np.nan, 1, 1]])], "far too large"),
        ([np.array([[0, 0, 0], [np.inf, 1, 1]])], "far too large"),
        ([1e10 * line for line in box()], "far too large"),
        ([line + np.array([x, 0, 0]) for x in (0, 99) for line in great_circles()], "far apart"),
    ],
)
def test_what_cannot_be_wrapped_is_refused(curves: Curves, words: str) -> None:
    with pytest.raises(UserError, match=words) as refusal:
        shrink_wrap(curves)
    assert refusal.value.message.count(". ") >= 1


@pytest.mark.parametrize(
    "curves",
    [
        [np.array([[0, 0, 0], [1, 0, 0.0]]), np.array([[0, 1, 1], [0, -1, 1.0]])],
        [point[None] for point in np.random.default_rng(2).normal(size=(30, 3))],
        [line * (1, 0.1, 0.1) for line in box()],
        [line * (1, 1, 0.01) for line in great_circles()],
        [line * 1e-6 for line in box()],
        [line + np.array([x, 0, 0]) for x in (0, 5) for line in great_circles()],
        [np.random.default_rng(3).normal(size=(20_000, 3))],
    ],
    ids=["two lines", "points", "needle", "flat", "tiny", "two balls", "tangle"],
)
def test_odd_curves_have_a_closed_skin(curves: Curves) -> None:
    assert check_solid(Solid(shrink_wrap(curves, level=3))).genus == 0


def test_it_can_be_stopped_at_every_checkpoint() -> None:
    steps: list[float] = []
    shrink_wrap(box(), level=4, checkpoint=lambda done, step: steps.append(done))
    assert steps == sorted(steps)
    assert (steps[0], steps[-1]) == (0.0, 1.0)
    for stop in range(len(steps)):
        asked = iter(range(len(steps)))

        def checkpoint(done: float, step: str, asked=asked, stop=stop) -> None:  # type: ignore[no-untyped-def]
            if next(asked) == stop:
                raise Cancelled(step)

        with pytest.raises(Cancelled):
            shrink_wrap(box(), level=4, checkpoint=checkpoint)


@pytest.mark.parametrize(
    "wrong", [{"level": 2}, {"level": 7}, {"tightness": 1.1}, {"smoothing": -1}]
)
def test_parameters_have_a_range(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="a level"):
        shrink_wrap(box(), **wrong)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_million_points_are_thinned_out() -> None:
    rng = np.random.default_rng(0)
    assert check_solid(Solid(shrink_wrap([rng.normal(size=(1_000_000, 3))]))).genus == 0
