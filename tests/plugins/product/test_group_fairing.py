"""Groups faired together: against known surfaces, and what must stay where it is."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.shaping.group_fairing import FairedNet, faired
from bozzetto_product.shaping.outline_normals import rejoined
from tests.plugins.product.known_surfaces import points_of
from tests.plugins.product.noisy_sheets import NoisySheet, sheets

MIRROR = Reflection(Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
PRODUCT = ProductModeler()


@cache
def example(noise: float = 0.02, seed: int = 1) -> NoisySheet:
    return list(sheets(noise, seed))[2]


def let_go(sheet: NoisySheet, share: float) -> FairedNet:
    return faired(sheet.net, sheet.loops, sheet.members, share, MIRROR)


def error(sheet: NoisySheet, found: FairedNet) -> float:
    fills = fill_net(found.net, sheet.loops)
    points = np.concatenate([points_of(fills[k]) for k in sorted(sheet.members)])
    return float(sheet.surface.distance(points).mean()) / sheet.diagonal


@pytest.mark.parametrize("noise", [0.02, 0.04])
def test_curves_that_are_let_go_leave_the_true_surface(noise: float) -> None:
    sheet = example(noise)
    errors = [error(sheet, let_go(sheet, share)) for share in (0.0, 0.5, 1.0)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.25)
    assert errors[2] <= 1e-3


def test_surfaces_between_curves_that_are_let_go_are_one_surface_however_these_bend() -> None:
    """Curves on a surface that wind in it tell nothing about how it leaves them."""
    torus = list(sheets(0.05, 1))[1]
    found = let_go(torus, 1.0)
    assert error(torus, found) <= 1e-4
    for number in found.moved:
        told = found.net.edges[number].normals
        assert told is not None
        true = torus.surface.normal(found.net.edges[number].spline.value(told.parameters))
        assert np.abs((told.normals * true).sum(axis=1)).min() > 1.0 - 1e-6
    assert all(edge.normals is None for edge in let_go(torus, 0.9).net.edges)


def test_only_curves_within_the_group_move_and_joints_stay_joined() -> None:
    sheet = example()
    found = let_go(sheet, 0.7)
    uses = [edge for k in sheet.members for edge, _ in sheet.loops[k]]
    assert found.moved == {edge for edge in uses if uses.count(edge) == 2}
    assert found.whole
    for number, (before, after) in enumerate(zip(sheet.net.edges, found.net.edges, strict=True)):
        assert (after is before) == (number not in found.moved)
        ends = found.net.nodes[[after.start, after.end]]
        np.testing.assert_array_equal(after.spline.control_points[[0, -1]], ends)


def test_what_is_let_go_stays_when_let_go_again() -> None:
    sheet = example()
    once = let_go(sheet, 1.0)
    again = faired(once.net, sheet.loops, sheet.members, 1.0, MIRROR)
    for number in once.moved:
        one, two = (net.edges[number].spline.sampled(33) for net in (once.net, again.net))
        np.testing.assert_allclose(one, two, atol=1e-4 * sheet.diagonal)


def test_a_crease_within_a_group_stays() -> None:
    sheet = example()
    inner = sorted(let_go(sheet, 1.0).moved)
    edges = tuple(
        replace(edge, crease=1.0) if number in inner else edge
        for number, edge in enumerate(sheet.net.edges)
    )
    found = faired(replace(sheet.net, edges=edges), sheet.loops, sheet.members, 1.0, MIRROR)
    assert not found.moved
    assert not found.whole


def test_a_ring_of_surfaces_has_no_single_outline() -> None:
    sheet = example()
    ring = frozenset(range(len(sheet.loops))) - sheet.members
    found = faired(sheet.net, sheet.loops, ring, 1.0, MIRROR)
    assert not found.moved
    assert not found.whole


def test_pieces_make_the_curve_that_they_were_cut_from() -> None:
    spline = example().net.edges[0].spline
    begin, end = spline.range
    cut = [begin + share * (end - begin) for share in (0.2, 0.55)]
    again = rejoined(spline.split(*cut))
    at = np.linspace(begin, end, 101)
    shift = again.range[0] - begin
    np.testing.assert_allclose(again.value(at + shift), spline.value(at), atol=1e-12)


def grouped(share: float) -> ProductState:
    """A bent sheet of three by two surfaces with a bump in the middle of two curves."""
    rows = []
    for k, x in enumerate((0.0, 40.0, 80.0, 120.0)):
        bump = 6.0 if k == 1 else 0.0
        places = [
            [x, float(y), float(0.002 * x * (120 - x) + bump * np.sin(np.pi * y / 80))]
            for y in range(0, 81, 4)
        ]
        rows.append({"name": f"across{k}", "points": places})
    for name, y in (("near", 0.0), ("middle", 40.0), ("far", 80.0)):
        xs = np.linspace(0, 120, 31)
        top = [6.0 * np.exp(-(((x - 40) / 12) ** 2)) if name == "middle" else 0.0 for x in xs]
        places = [(x, y, 0.002 * x * (120 - x) + h) for x, h in zip(xs, top, strict=True)]
        rows.append({"name": name, "points": [list(map(float, place)) for place in places]})
    state = product_of_network({"network": {"curves": rows}, "unit": "mm"})
    group = CurveGroup(state.unused_id(), "Hood", let_go=share)
    nodes = tuple(
        replace(node, within=group.id) if isinstance(node, Patch) else node for node in state.nodes
    )
    return replace(state, nodes=(*nodes, group))


def test_the_recipe_keeps_what_was_drawn_and_the_result_is_fair() -> None:
    state = grouped(1.0)
    result = PRODUCT.solve(state, Job())
    drawn = {curve.id: curve for curve in state.of_kind(Curve)}
    names = {drawn[each].name for each in result.let_go}
    assert names == {"across1", "across2", "middle"}
    lifted = next(curve for curve in result.curves if curve.name == "across1")
    before, after = drawn[lifted.id].spline, lifted.spline
    assert before.sampled(65)[:, 2].max() > 12.0
    height = after.sampled(65)
    np.testing.assert_allclose(height[:, 2], 0.002 * height[:, 0] * (120 - height[:, 0]), atol=0.5)
    assert len(PRODUCT.report(state, result, Job())["patches"]) == 6
    assert PRODUCT.solve(grouped(0.0), Job()).let_go == frozenset()


def test_a_group_that_cannot_be_faired_is_told() -> None:
    state = grouped(1.0)
    curves = [
        replace(node, edge="crease") if isinstance(node, Curve) else node for node in state.nodes
    ]
    state = replace(state, nodes=tuple(curves))
    result = PRODUCT.solve(state, Job())
    assert not result.let_go
    assert any("Hood" in caution.message for caution in PRODUCT.cautions(state, result))
