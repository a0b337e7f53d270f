"""The modeler of rough skins: the contract, what it takes in and what it tells."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.storage.state_codec import decode_state, encode_state
from bozzetto.errors import Cancelled, UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Curve, Mesh, Patchwork, Shapes, Skeleton, Solid, cylinder
from bozzetto.plugin import Job
from bozzetto.testing import ModelerContract, Pen, Shell, same
from bozzetto_skin.modeler import RoughSkin, SkinState
from bozzetto_skin.reading import polylines


def _straight(start: object, end: object) -> Curve:
    return Curve(1, np.array([0.0, 0, 1, 1]), np.array([start, end], float))


def _box(x: float = 40.0, y: float = 25.0, z: float = 15.0) -> Shapes:
    corners = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)])
    pairs = [(a, b) for a in range(8) for b in range(a) if (corners[a] != corners[b]).sum() == 1]
    return Shapes(curves=tuple(_straight(corners[a], corners[b]) for a, b in pairs))


def _circle() -> Curve:
    """A circle of radius 5, rational and exact."""
    square = [[5, 0], [5, 5], [0, 5], [-5, 5], [-5, 0], [-5, -5], [0, -5], [5, -5], [5, 0]]
    points = np.column_stack((np.array(square, float), np.zeros(9)))
    knots = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], float)
    weights = np.array([1.0, np.sqrt(0.5)] * 4 + [1.0])
    return Curve(2, knots, points, weights, closed=True)


class TestSkin(ModelerContract):
    modeler = "bozzetto.skin"

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """There is nothing to draw: curves are taken; pens of two seeds take two boxes."""
        state = RoughSkin().read_shapes(_box(40.0 + 5.0 * pen.seed))
        shell.put(replace(state, detail=3))


def test_a_rational_circle_is_one() -> None:
    (line,) = polylines(Shapes(curves=(_circle(),)))
    np.testing.assert_allclose(np.linalg.norm(line, axis=1), 5.0, rtol=1e-12)
    assert np.ptp(line, axis=0)[:2].tolist() == pytest.approx([10.0, 10.0])


def test_edges_of_patches_are_curves() -> None:
    corners = np.array([[0, 0, 0], [9, 0, 0], [9, 9, 3], [0, 9, 0]], float)
    shares = np.linspace(0, 1, 4)[:, None]
    edges = [(1 - shares) * corners[k] + shares * corners[(k + 1) % 4] for k in range(4)]
    edges[2], edges[3] = edges[2][::-1], edges[3][::-1]
    patchwork = Patchwork.of_edges(np.array(edges), np.array([[0, 1, ~2, ~3]]))
    lines = polylines(Shapes(patchworks=(patchwork,)))
    assert [line[[0, -1]].tolist() for line in lines] == [
        e[[0, 3]].tolist() for e in patchwork.edges
    ]


def test_edges_of_breps_are_curves() -> None:
    lines = polylines(Shapes(breps=(cylinder((0, 0, 0), (0, 0, 10), 4.0),)))
    points = np.concatenate(lines)
    np.testing.assert_allclose(np.linalg.norm(points[:, :2], axis=1), 4.0, rtol=1e-12)
    assert set(np.unique(points[:, 2])) >= {0.0, 10.0}


@pytest.mark.parametrize(
    "shapes",
    [
        Shapes(),
        Shapes(skeletons=(Skeleton(np.eye(3), np.ones(3), np.array([[0, 1]], np.int32)),)),
        Shapes(solids=(Solid(Mesh(np.eye(3, dtype=np.float32), np.zeros((0, 3), np.int32))),)),
    ],
)
def test_without_curves_it_says_what_to_choose(shapes: Shapes) -> None:
    with pytest.raises(UserError, match="Choose an object"):
        RoughSkin().read_shapes(shapes)


def test_a_box_becomes_a_solid_that_is_told_of() -> None:
    modeler = RoughSkin()
    state = modeler.read_shapes(_box())
    result = modeler.solve(state, Job())
    (solid,) = modeler.shapes(state, result).solids
    facts = check_solid(solid)
    assert (facts.genus, facts.parts) == (0, 1)
    assert 0.9 < facts.volume / (80 * 50 * 30) < 1.3
    report = modeler.report(state, result, Job())
    assert json.loads(json.dumps(report)) == report
    assert report["curves"] == 12
    assert report["greatest_distance_percent_of_size"] < 0.01


def test_parameters_change_the_skin() -> None:
    modeler = RoughSkin()
    state = modeler.read_shapes(_box())
    fine = modeler.solve(SkinState(state.points, state.starts, detail=4), Job()).mesh
    taut = modeler.solve(SkinState(state.points, state.starts, detail=4, smoothing=0), Job()).mesh
    coarse = modeler.solve(SkinState(state.points, state.starts, detail=3), Job()).mesh
    assert fine is not None
    assert taut is not None
    assert coarse is not None
    assert len(fine.vertices) == len(taut.vertices) > len(coarse.vertices)
    assert np.ptp(fine.vertices, axis=0)[2] > np.ptp(taut.vertices, axis=0)[2]


def test_it_can_be_stopped() -> None:
    modeler = RoughSkin()
    state = modeler.read_shapes(_box())
    with pytest.raises(Cancelled):
        modeler.solve(state, Job(cancelled=lambda: True))


def test_a_stored_state_comes_back_as_it_was() -> None:
    state = RoughSkin().read_shapes(_box())
    assert same(decode_state(SkinState, encode_state(state)), state)


# -- skins that follow -----------------------------------------------------------------------------


def test_a_following_skin_is_that_of_a_copy_and_holds_no_curves() -> None:
    modeler, sources = RoughSkin(), {"one": _box(), "other": Shapes(curves=(_circle(),))}
    state = replace(modeler.follow(sources), detail=3)
    assert (len(state.points), state.sources) == (0, ("one", "other"))
    copy = replace(modeler.read_shapes(sources["one"] + sources["other"]), detail=3)
    skin, same_skin = modeler.solve(state, Job(sources=sources)), modeler.solve(copy, Job())
    assert same(modeler.shapes(state, skin), modeler.shapes(copy, same_skin))
    assert same(modeler.scene(state, skin), modeler.scene(copy, same_skin))
    assert modeler.report(state, skin, Job()) == modeler.report(copy, same_skin, Job())
    assert modeler.scene(state, None).layers == ()


@pytest.mark.parametrize(
    "ask",
    [
        lambda: RoughSkin().follow({"one": Shapes()}),
        lambda: RoughSkin().solve(SkinState(sources=("one",)), Job(sources={"one": Shapes()})),
    ],
)
def test_a_source_without_curves_says_what_to_choose(ask: Callable[[], object]) -> None:
    with pytest.raises(UserError, match="Choose an object"):
        ask()


def test_a_skin_of_version_1_is_the_same_skin() -> None:
    state = RoughSkin().read_shapes(_box())
    stored = encode_state(state)
    old = json.loads(stored.json)
    del old["sources"]
    stored = replace(stored, json=json.dumps(old).encode())
    again = decode_state(SkinState, stored, upgrade=lambda raw: RoughSkin().upgrade(raw, 1))
    assert same(again, state)
