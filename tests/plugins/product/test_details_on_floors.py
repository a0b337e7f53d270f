"""Details on the floors of others, and cuts over their rims."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import decode_document, encode_document
from bozzetto.geometry import Solid
from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto.plugin import Job
from bozzetto.plugin.host.registry import Registry
from bozzetto.view import Camera
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.model.details import Detail
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.detail import with_detail_drawn
from tests.plugins.product.detail_kit import ball, body, loop_around, manifold, with_detail
from tests.plugins.product.detail_kit import solved as solved_state
from tests.plugins.product.test_details_over_edges import volume
from tests.plugins.product.test_network_file import box

WHOLE = 100.0 * 60.0 * 40.0
"""Volume of the box, mm³; its top is at 40 mm."""

TURN = 0.013 + np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
CAMERA = Camera(eye=(160.0, -120.0, 190.0), target=(50.0, 30.0, 36.0))


def disc(radius: float, x: float = 50.0, scale: float = 1.0) -> list[list[float]]:
    """A circle on the top of the box."""
    rows = (x + radius * np.cos(TURN), 30.0 + radius * np.sin(TURN), np.full(len(TURN), 40.0))
    return (scale * np.column_stack(rows)).tolist()


POCKET = {"kind": "in", "depth": 4.0, "outlines": [disc(20.0)]}


def drawn_state(*details: dict[str, Any], scale: float = 1.0) -> ProductState:
    network = box(scale)
    network["network"]["details"] = [{"draft": 0.0, **detail} for detail in details]
    return product_of_network(network)


def solved(*details: dict[str, Any], scale: float = 1.0) -> tuple[ProductResult, Solid]:
    """The box with details whose walls stand upright, in millimetres."""
    state = drawn_state(*details, scale=scale)
    result = solve_product(state, Job())
    (solid,) = shapes_of(state, result).solids
    return result, solid


def problems(result: ProductResult) -> list[str]:
    return [one.problem for one in result.detailed.details]


@pytest.mark.parametrize(
    ("inner", "taken"),
    [
        ({"kind": "in", "depth": 3.0}, 64.0 * 3.0),
        ({"kind": "raised", "depth": 3.0}, -64.0 * 3.0),
        ({"kind": "raised", "depth": 7.0}, -64.0 * 7.0),
        ({"kind": "button", "depth": 3.0, "gap": 1.0}, (64.0 - 49.0) * 3.0),
        ({"kind": "cut"}, 64.0 * 36.0),
        ({"kind": "split"}, 0.0),
    ],
)
def test_what_lies_on_the_floor_of_a_pocket_has_its_volume(
    inner: dict[str, Any], taken: float
) -> None:
    result, solid = solved(POCKET, {**inner, "outlines": [disc(8.0)]})
    assert problems(result) == ["", ""]
    assert solid.exact is not None
    assert solid.exact.is_closed
    assert solid.exact.largest_gap() <= solid.exact.tolerance
    # Triangles of circles are a little smaller.
    assert WHOLE - volume(solid) == pytest.approx(np.pi * (400.0 * 4.0 + taken), rel=1e-3)
    whole = manifold(solid.mesh)
    assert whole.genus() == (1 if inner["kind"] == "cut" else 0)


def test_it_says_nothing_in_which_order_details_inside_one_another_were_drawn() -> None:
    rows = [
        POCKET,
        {"kind": "in", "depth": 3.0, "outlines": [disc(12.0)]},
        {"kind": "raised", "depth": 2.0, "outlines": [disc(6.0)]},
    ]
    found = [solved(*order) for order in itertools.permutations(rows)]
    assert all(problems(result) == ["", "", ""] for result, _ in found)
    volumes = [volume(solid) for _, solid in found]
    assert np.ptp(volumes) <= 1e-6
    assert WHOLE - volumes[0] == pytest.approx(np.pi * (1600.0 + 144.0 * 3.0 - 72.0), rel=1e-3)


@pytest.mark.slow
def test_a_thousand_times_as_large_is_the_same() -> None:
    _, small = solved(POCKET, {"kind": "raised", "depth": 2.0, "outlines": [disc(8.0)]})
    _, large = solved(
        {"kind": "in", "depth": 4000.0, "outlines": [disc(20.0, scale=1000.0)]},
        {"kind": "raised", "depth": 2000.0, "outlines": [disc(8.0, scale=1000.0)]},
        scale=1000.0,
    )
    assert volume(large) / 1e9 == pytest.approx(volume(small), rel=1e-6)


@pytest.mark.parametrize("kind", ["cut", "split"])
def test_cuts_and_splits_go_over_rims_whose_walls_lean(kind: str) -> None:
    """Half of the round lies in the pocket, half beside."""
    rim = {"kind": kind, "outlines": [disc(8.0, x=70.0)], "draft": 5.0}
    result, solid = solved({**POCKET, "draft": 5.0}, rim)
    assert problems(result) == ["", ""]
    assert solid.exact is not None
    assert solid.exact.is_closed
    alone = WHOLE - volume(solved({**POCKET, "draft": 5.0})[1])
    through = WHOLE - volume(solved({**rim, "outlines": [disc(8.0, x=85.0)]})[1])
    both = WHOLE - volume(solid)
    if kind == "split":
        assert both == pytest.approx(alone, rel=1e-3)
    else:
        assert both > alone + 0.9 * through
        assert both < alone + through
        assert manifold(solid.mesh).genus() == 1


def test_what_has_a_floor_is_told_over_a_rim_and_leaves_the_other_as_it_is() -> None:
    result, solid = solved(POCKET, {"kind": "in", "depth": 1.0, "outlines": [disc(8.0, x=70.0)]})
    assert result.detailed.details[0].problem == ""
    assert "another detail" in result.detailed.details[1].problem
    assert WHOLE - volume(solid) == pytest.approx(1600.0 * np.pi, rel=1e-3)


def seen_round(radius: float, height: float) -> np.ndarray:
    """A circle above the middle of the box as it is seen, px."""
    turn = np.linspace(0.0, 2.0 * np.pi, 120)
    rows = (50.0 + radius * np.cos(turn), 30.0 + radius * np.sin(turn), np.full(120, height))
    return np.asarray(CAMERA.project(np.column_stack(rows))[0])


def pen(points: np.ndarray) -> Stroke:
    return Stroke(points[:, 0], points[:, 1], CAMERA)


def test_a_button_is_drawn_in_a_pocket_where_the_pen_was() -> None:
    """Of the surface above the place seen under the pen is 7 mm beside."""
    pocket = {"kind": "in", "depth": 6.0, "draft": 4.0, "outlines": [disc(20.0)]}
    state = drawn_state(pocket)
    ink = seen_round(8.0, 34.0)
    state = with_detail_drawn(state, [pen(ink)])
    result = solve_product(state, Job())
    assert problems(result) == ["", ""]
    outline = result.detailed.details[1].outlines[0]
    assert np.abs(outline[:, 2] - 34.0).max() < 1e-6
    assert distances_to_polyline(CAMERA.project(outline)[0], ink).max() < 1.2


def test_what_was_drawn_in_a_pocket_goes_along_and_stays_when_the_pocket_goes() -> None:
    state = with_detail_drawn(drawn_state(POCKET), [pen(seen_round(8.0, 36.0))])
    pocket, button = state.of_kind(Detail)
    deeper = state.with_node(replace(pocket, depth=6.0))
    alone = replace(state, nodes=tuple(node for node in state.nodes if node.id != pocket.id))
    for changed, height in ((deeper, 34.0), (alone, 40.0)):
        result = solve_product(changed, Job())
        assert set(problems(result)) == {""}
        (one,) = (one for one in result.detailed.details if one.detail.id == button.id)
        assert np.abs(one.outlines[0][:, 2] - height).max() < 1e-6
        assert np.abs(one.outlines[0].mean(axis=0)[:2] - (50.0, 30.0)).max() < 0.3


def test_details_on_floors_come_back_from_documents_to_the_last_bit() -> None:
    state = with_detail_drawn(drawn_state(POCKET), [pen(seen_round(8.0, 36.0))])
    made = Model("m", "Box", "bozzetto.product", state, state_version=ProductModeler.state_version)
    content = encode_document(Document((made,)))
    (again,) = decode_document(content, Registry())[0].models
    assert encode_document(Document((again,))) == content
    for one, other in zip(
        solve_product(state, Job()).detailed.details,
        solve_product(again.state, Job()).detailed.details,
        strict=True,
    ):
        np.testing.assert_array_equal(one.outlines[0], other.outlines[0])


@pytest.mark.slow
@pytest.mark.parametrize("place", [(20.0, 20.0, 30.0), (1.0, 30.0, 18.0)])
def test_on_a_ball_a_boss_stands_on_the_floor_of_a_mirrored_pocket(
    place: tuple[float, float, float],
) -> None:
    """The heights of what is seen, against the ball's middle."""
    state = with_detail(ball(), [loop_around(ball(), place, 9.0)], kind="in", depth=2.0)
    state = with_detail(state, [loop_around(ball(), place, 5.0)], kind="raised", depth=0.7)
    result = solved_state(state)
    assert problems(result) == ["", ""]
    (shell,) = result.detailed.changed
    heights = sorted(
        float(np.linalg.norm(face.surface.value(*np.mean(face.surface.ranges, axis=1)[:, None])))
        for face, owner in zip(shell.faces, shell.owners, strict=True)
        if owner.floor is not None
    )
    assert heights == pytest.approx([38.0, 38.7], abs=0.02)
    made = body(state)
    assert made.exact.is_closed
    assert made.exact.largest_gap() <= made.exact.tolerance
    assert manifold(made.mesh).genus() == 0
    mirrored = replace(
        state,
        nodes=tuple(replace(n, mirrored=True) if isinstance(n, Detail) else n for n in state.nodes),
    )
    assert problems(solved_state(mirrored)) == [""] * 4


def over_a_rim(seed: int) -> tuple[list[str], Solid, str]:
    """A cut or a split about a place of the rim of a pocket, all sizes at random."""
    rng = np.random.default_rng(seed)
    radius, turn, size = rng.uniform(10.0, 20.0), rng.uniform(0.0, 6.28), rng.uniform(2.0, 7.0)
    x, y = 45.0 + radius * np.cos(turn), 30.0 + radius * np.sin(turn)
    turns = rng.uniform(0.0, 6.28) + np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    wave = size * (1.0 + 0.1 * np.cos(3.0 * turns + rng.uniform(0.0, 6.28)))
    rows = (x + wave * np.cos(turns), y + wave * np.sin(turns), np.full(len(turns), 40.0))
    kind = str(rng.choice(["cut", "split"]))
    pocket = {
        "kind": str(rng.choice(["in", "raised"])),
        "depth": float(rng.uniform(1.0, 6.0)),
        "draft": float(rng.uniform(2.0, 12.0)),
        "outlines": [disc(float(radius), x=45.0)],
    }
    over = {"kind": kind, "draft": float(rng.uniform(0.0, 3.0))}
    result, solid = solved(pocket, {**over, "outlines": [np.column_stack(rows).tolist()]})
    return problems(result), solid, kind


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(91_000, 91_016))
def test_cuts_over_rims_anywhere_are_closed_bodies(seed: int) -> None:
    said, solid, kind = over_a_rim(seed)
    assert said == ["", ""]
    assert solid.exact is not None
    assert solid.exact.is_closed
    assert solid.exact.largest_gap() <= solid.exact.tolerance
    assert manifold(solid.mesh).genus() == (1 if kind == "cut" else 0)
