"""Strips: where bodies are blended two by two no solids are united, and the shape is the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.geometry import Placement
from bozzetto.plugin.cache import forget_all
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.model.state import Operation, SilhouetteState
from bozzetto_silhouette.numerics.grouping import face_neighbours
from bozzetto_silhouette.solids import boolean, fillet, lump, strip_borders, strip_closing
from bozzetto_silhouette.solids.assembly import Assembly
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import combined, meshed
from bozzetto_silhouette.solids.evaluate import assembly_of, tree_body
from bozzetto_silhouette.solids.on_surface import settled
from bozzetto_silhouette.solids.strip_rings import Ring, zipped
from tests.plugins.silhouette import bodies as b
from tests.plugins.silhouette.solids.figures_creases import sharp_edges
from tests.plugins.silhouette.solids.random_trees import random_tree

CELLS = 48


def united(whole: Assembly, monkeypatch: pytest.MonkeyPatch) -> Body:
    """The same by a union of solids."""
    with monkeypatch.context() as patch:
        patch.setattr(boolean, "contacts", lambda *_: None)
        return meshed(whole)


@pytest.mark.parametrize(
    ("operation", "blend"),
    [("add", 0.2), ("add", 0.5), ("add", 1.0), ("merge", 0.2), ("merge", 0.5)],
)
@pytest.mark.parametrize("small", [12.0, 40.0])
def test_two_bodies_need_no_union(
    monkeypatch: pytest.MonkeyPatch, operation: Operation, blend: float, small: float
) -> None:
    one, other = b.ball(resolution=CELLS), b.ball(50.0, small, CELLS, "b")

    def never(*_: object) -> None:
        raise AssertionError("solids were united")

    with monkeypatch.context() as patch:
        patch.setattr(lump, "is_union", never)
        patch.setattr(fillet, "extracted", never)
        whole = combined(one, other, operation, blend)
    assert whole is not None
    b.assert_sound(whole)
    assert b.genus(whole) == 0
    off = np.abs(whole.implicit.value(whole.vertices)) / one.step
    assert np.quantile(off, 0.99) < 0.03
    with monkeypatch.context() as patch:
        patch.setattr(boolean, "contacts", lambda *_: None)
        again = combined(one, other, operation, blend)
    assert again is not None
    assert b.volume(whole) == pytest.approx(b.volume(again), rel=1e-3)
    _, nearest = cKDTree(again.vertices).query(whole.vertices)
    gap = whole.vertices - again.vertices[nearest]
    beside = np.abs(np.einsum("ij,ij->i", gap, again.normals[nearest]))
    assert np.quantile(beside, 0.98) < 0.15 * one.step


def test_an_end_within_two_bodies_is_not_left_to_strips(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three bodies that meet in one place are united by themselves; the fourth is not."""
    some: list[int] = []
    unions: list[object] = []
    restricted, union_mesh = boolean.restricted, boolean.union_mesh

    def counted(implicit, bodies):
        some.append(len(bodies))
        return restricted(implicit, bodies)

    monkeypatch.setattr(boolean, "restricted", counted)
    monkeypatch.setattr(
        boolean, "union_mesh", lambda lumps: unions.append(lumps) or union_mesh(lumps)
    )
    trunk = b.ball(resolution=CELLS)
    limbs = [
        b.ball(55.0, 12.0, CELLS, f"n{k}").placed(b.turn("z", angle))
        for k, angle in enumerate((0.0, 20.0, 110.0, 170.0, 230.0, 290.0))
    ]
    whole = Assembly.of(trunk)
    for limb in limbs:
        joined = boolean.joined(whole, Assembly.of(limb), "add", 0.5)
        assert joined is not None
        whole = joined
    body = meshed(whole)
    assert some == [3]
    assert len(unions) == 1
    b.assert_sound(body)
    assert topology_of(body.vertices, body.faces).components == 1
    off = np.abs(body.implicit.value(body.vertices)) / body.step
    assert np.quantile(off, 0.99) < 0.15
    # Every vertex knows the part that it is nearest to.
    for k, limb in enumerate(limbs):
        tip = 66.0 * limb.vertices.mean(axis=0) / np.linalg.norm(limb.vertices.mean(axis=0))
        nearest = np.linalg.norm(body.vertices - tip, axis=1).argmin()
        assert body.sources[body.origins[nearest]] == f"n{k}"


def test_limbs_that_do_not_meet_come_in_any_order() -> None:
    trunk = b.ball(resolution=CELLS)
    limbs = [b.ball(52.0, 14.0, CELLS, f"n{k}").placed(b.turn("z", 60.0 * k)) for k in range(6)]
    found = []
    for order in (range(6), (3, 0, 5, 1, 4, 2)):
        whole = Assembly.of(trunk)
        for k in order:
            joined = boolean.joined(whole, Assembly.of(limbs[k]), "add", 0.5)
            assert joined is not None
            whole = joined
        found.append(meshed(whole))
    forth, back = found
    assert np.allclose(forth.vertices, back.vertices, rtol=0.0, atol=1e-9)
    assert np.array_equal(forth.faces, back.faces)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 112))
def test_random_trees_are_what_their_union_is(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    whole = assembly_of(random_tree(seed, 6), 64)
    assert whole is not None
    new, old = meshed(whole), united(whole, monkeypatch)
    b.assert_sound(new)
    one, other = (topology_of(some.vertices, some.faces) for some in (new, old))
    assert (one.components, one.genus) == (other.components, other.genus)
    assert one.volume == pytest.approx(other.volume, rel=1e-3)
    assert len(sharp_edges(new)[0]) <= len(sharp_edges(old)[0]) + 10


def test_a_tree_after_a_change_is_the_same_as_from_nothing() -> None:
    state = random_tree(7, 6)
    before = tree_body(state, CELLS)
    changed = state.with_node(replace(state.nodes[0], inflation=1.1))
    one = tree_body(changed, CELLS)
    back = tree_body(state, CELLS)
    forget_all()
    other = tree_body(SilhouetteState(changed.nodes), CELLS)
    assert before is not None
    assert back is not None
    assert one is not None
    assert other is not None
    assert np.array_equal(before.vertices, back.vertices)
    assert b.volume(one) == pytest.approx(b.volume(other), rel=1e-9)


@pytest.mark.parametrize("seed", range(71400, 71404))
def test_what_is_near_a_border_is_known_as_if_all_were_looked_at(seed: int) -> None:
    """Around a vertex called inner no face is left out, and each face has all its neighbours."""
    body, random = b.ball(0.0, 50.0, 32), np.random.default_rng(seed)
    faces, count = body.faces.astype(np.intp), len(body.vertices)
    middles = body.vertices[faces].mean(axis=1)
    gone = np.zeros(len(faces), bool)
    for place in middles[random.integers(len(faces), size=3)]:
        gone |= np.linalg.norm(middles - place, axis=1) < random.uniform(2.0, 30.0)
    near = strip_borders.NearFaces.of(faces, gone, count)
    around = near.inner[faces].any(axis=1)
    assert np.array_equal(near.rows, np.flatnonzero(around))
    both = np.zeros((2, count), bool)
    both[0, faces[gone]] = both[1, faces[~gone]] = True
    assert near.inner[both.all(axis=0)].all()
    every = face_neighbours(faces, count)[near.rows]
    known = near.beside >= 0
    assert np.array_equal(near.rows[near.beside[known]], every[known])
    inner = near.inner[near.faces]
    assert known[inner & inner[:, [1, 2, 0]]].all()


def test_normals_are_those_that_are_asked_and_cost_no_place() -> None:
    one, random = b.ball(0.0, 50.0, 32), np.random.default_rng(71410)
    vertices = one.vertices + random.normal(0.0, 0.02, one.vertices.shape)
    number, spacing = random.integers(-1, 3, len(vertices)), np.full(len(vertices), one.step)
    facing = random.random(len(vertices)) < 0.3
    places, normals = settled(vertices, number, spacing, facing, one.implicit)
    every, known = settled(vertices, number, spacing, number >= 0, one.implicit)
    assert np.array_equal(places, every)
    asked = facing & (number >= 0)
    assert np.array_equal(normals[asked], known[asked])
    assert not normals[~asked].any()
    assert np.abs(one.implicit.value(places[number >= 0])).max() < 1e-3 * one.step
    assert np.array_equal(places[number < 0], vertices[number < 0])


def test_rows_of_any_numbers_of_points_are_joined_without_a_gap() -> None:
    random = np.random.default_rng(3)
    for _ in range(50):
        counts = random.integers(3, 40, (2, 3))
        rings = []
        for radius, some in zip((1.0, 2.0), counts, strict=True):
            along = [np.sort(np.append(0.0, random.uniform(0.0, 1.0, n - 1))) for n in some]
            rows = [
                radius * np.stack([np.cos(6.283 * s), np.sin(6.283 * s), 0.0 * s], axis=1)
                for s in along
            ]
            rings.append(Ring.of(rows)._replace(along=np.concatenate(along)))
        one, other = rings
        first = np.arange(len(one.points))
        second = len(first) + np.arange(len(other.points))
        faces = zipped(one, first, other, second)
        assert len(faces) == len(first) + len(second)
        ends = np.stack([faces, faces[:, [1, 2, 0]]], axis=2).reshape(-1, 2)
        edges = {tuple(edge) for edge in ends.tolist()}
        assert len(edges) == len(ends)
        border = {edge for edge in edges if edge[::-1] not in edges}
        inner = {(b_, a) for a, b_ in zip(first.tolist(), one.after.tolist(), strict=True)}
        outer = set(zip(second.tolist(), second[other.after].tolist(), strict=True))
        assert border == inner | outer


def test_points_that_turn_back_do_not_run_along_a_row() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    row = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = angle / (2.0 * np.pi)
    names = np.arange(len(row))

    def joined(points: np.ndarray) -> list[np.ndarray] | None:
        """The triangles between a row and points that run along it from the other side."""
        other = strip_closing.LastRow(points[::-1], along, len(row) + np.arange(len(points)))
        return strip_closing.closed([strip_closing.LastRow(row, along, names)], [other])

    faces = joined(1.1 * np.roll(row, 7, axis=0))
    assert faces is not None
    edges = np.stack([faces[0], faces[0][:, [1, 2, 0]]], axis=2).reshape(-1, 2)
    border = [edge for edge in edges.tolist() if edge[::-1] not in edges.tolist()]
    assert len(faces[0]) == len(border) == 2 * len(row), "each point of both rows once"
    # No triangle reaches farther along the rows than from one point to the next.
    ends = np.vstack([row, np.roll(row, 7, axis=0)[::-1]])
    reach = np.linalg.norm(ends[edges[:, 0]] - ends[edges[:, 1]], axis=1)
    assert reach.max() < 1.01 * np.linalg.norm(row[1] - row[0])
    assert joined(row[::-1]) is None
    half = np.concatenate([row[:12], row[10:0:-1]])
    assert joined(half) is None


def test_a_gap_is_bridged_where_parts_merge_and_not_where_they_are_added() -> None:
    one, other = b.ball(resolution=CELLS), b.ball(102.0, 50.0, CELLS, "b")
    merged, added = combined(one, other, "merge", 0.5), combined(one, other, "add", 0.5)
    assert merged is not None
    assert added is not None
    assert topology_of(merged.vertices, merged.faces).components == 1
    assert topology_of(added.vertices, added.faces).components == 2
    apart = other.placed(Placement(offset=(40.0, 0.0, 0.0)))
    far = combined(one, apart, "merge", 0.5)
    assert far is not None
    assert topology_of(far.vertices, far.faces).components == 2
