"""Unions put together from the unions of what meets: the same solid, and less work."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Placement
from bozzetto_silhouette.inflation.manifold_check import as_manifold, topology_of
from bozzetto_silhouette.solids import lump as lumps_module
from bozzetto_silhouette.solids import union_mesh as union
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.lump import Lump, united
from bozzetto_silhouette.solids.union_mesh import UnionMesh, mesh_of, union_mesh
from tests.plugins.silhouette import bodies as b


def lump(body: Body) -> Lump:
    return Lump(body, body.bounds)


@pytest.fixture(scope="module")
def ball() -> Body:
    return b.ball(resolution=24)


def around(ball: Body, count: int, size: float, turn: float = 0.1) -> tuple[Lump, ...]:
    """A ball, and small ones around it, each half in it."""
    found = [lump(ball)]
    for angle in turn + 2.0 * np.pi * np.arange(count) / count:
        place = (50.0 * float(np.cos(angle)), 50.0 * float(np.sin(angle)), 3.0)
        found.append(lump(replace(ball, known=None).placed(Placement(scale=size, offset=place))))
    return tuple(found)


def assert_union(mesh: UnionMesh | None, lumps: tuple[Lump, ...]) -> None:
    """Closed, and the solid that manifold3d makes of all at once."""
    assert mesh is not None
    whole = united(lumps)
    assert whole is not None
    found = topology_of(mesh.vertices, mesh.faces)
    assert found.watertight
    assert found.volume == pytest.approx(whole.volume(), rel=1e-9)
    again = as_manifold(mesh.vertices, mesh.faces)
    assert (again - whole).volume() + (whole - again).volume() < 1e-6 * whole.volume()


@pytest.mark.parametrize(("count", "size"), [(1, 0.3), (3, 0.2), (5, 0.35), (9, 0.3), (12, 0.4)])
def test_it_is_the_union_of_all_at_once(ball: Body, count: int, size: float) -> None:
    lumps = around(ball, count, size)
    assert_union(union_mesh(lumps), lumps)
    assert_union(union_mesh(lumps[::-1]), lumps)


def test_faces_know_where_they_come_from(ball: Body) -> None:
    lumps = around(ball, 5, 0.2)
    mesh = union_mesh(lumps)
    assert mesh is not None
    numbers = [int(mesh_of(one.manifold).numbers[0]) for one in lumps]
    assert set(mesh.numbers) == set(numbers)
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    for number, one in zip(numbers, lumps, strict=True):
        middle, radius = one.box.mean(axis=0), 0.5 * np.ptp(one.box[:, 0])
        away = np.linalg.norm(middles[mesh.numbers == number] - middle, axis=1)
        assert away == pytest.approx(radius, rel=0.06)


def test_what_does_not_meet_the_changed_limb_is_not_united_again(
    ball: Body, monkeypatch: pytest.MonkeyPatch
) -> None:
    lumps = around(ball, 9, 0.12)
    union_mesh(lumps)
    asked: list[int] = []

    def counted(some: tuple[Lump, ...], base: object = None) -> object:
        asked.append(sum(one.manifold.num_tri() for one in some))
        return united(some, base)  # type: ignore[arg-type]

    monkeypatch.setattr(union, "united", counted)
    moved = lump(lumps[4].held.placed(Placement(offset=(0.0, 0.0, 1.0))))  # type: ignore[union-attr]
    edited = (*lumps[:4], moved, *lumps[5:])
    mesh = union_mesh(edited)
    monkeypatch.undo()
    assert_union(mesh, edited)
    assert 0 < sum(asked) < 0.8 * sum(one.manifold.num_tri() for one in edited)


def test_one_within_another_is_swallowed(ball: Body) -> None:
    lumps = around(ball, 3, 0.2)
    within = lump(lumps[2].held.placed(Placement(scale=0.5, offset=tuple(  # type: ignore[union-attr]
        0.5 * float(v) for v in lumps[2].box.mean(axis=0)))))  # fmt: skip
    assert_union(union_mesh((*lumps, within)), lumps)


def test_what_is_no_solid_gives_none(ball: Body) -> None:
    lumps = around(ball, 5, 0.2)
    torn = Lump(lumps_module.Remainder(as_manifold(ball.vertices, ball.faces[1:])), ball.bounds)
    assert union_mesh((*lumps, torn)) is None
    assert union_mesh((torn,)) is None
