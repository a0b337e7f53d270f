"""Faces with holes: found, filled once, switched by touches, mirrored, handed over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_product.fill.plane_fill import PlaneFill
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.names import piece_names
from bozzetto_product.loops.boundaries import boundary_of, loop_of, mirrored_boundary
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.loops.picking import loops_at
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.network.outlines import outlines_of, reversed_loop, rim_edges
from bozzetto_product.operations.boundaries import outlines_of_boundary
from bozzetto_product.operations.fillet import fillet
from bozzetto_product.operations.pieces import delete_curves, split_curve
from bozzetto_product.solve.bodies import joined_patches
from bozzetto_product.solve.found_patches import found_loops, switched, with_patches_found
from bozzetto_product.solve.solver import net_of_state
from tests.plugins.product.detail_kit import manifold
from tests.plugins.product.holed_plates import FEATURES, plate, random_plate, regular
from tests.plugins.product.sketched_network import PLANE, Sketch
from tests.plugins.product.test_rough_files import facts, solved, turned

BOX = np.array([(-40.0, -30.0), (40.0, -30.0), (40.0, 30.0), (-40.0, 30.0)])
SEEDS = (7101, *(pytest.param(seed, marks=pytest.mark.long) for seed in (7102, 7103, 7104)))
"""The first in the default run: the others are the same law again, at seconds each."""


def square(x, y, half):
    return regular(4, (x, y), half * np.sqrt(2.0), 0.25 * np.pi)


def faces_of(result):
    """Return the outlines of each surface, as names of curves."""
    names = piece_names(result.net, result.curves)
    return {
        frozenset(
            frozenset(names[edge] for edge, _ in outline)
            for outline in outlines_of(result.net, one.loop)
        )
        for one in result.filled
    }


def volume_of(result):
    (part,) = joined_patches(result.filled)
    assert part.closed
    return manifold(part.mesh).volume()


# -- closed forms ----------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_plate_has_one_face_round_all_of_its_bores(count):
    holes = [("bore", square(-30.0 + 15.0 * k, -10.0 + 5.0 * k, 4.0), 0.0, 0.0)
             for k in range(count)]  # fmt: skip
    made = plate(BOX, 10.0, holes)
    result, told = solved(made.facts())
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    assert not told["warnings"]
    assert volume_of(result) == pytest.approx((4800.0 - 64.0 * count) * 10.0, rel=1e-6)
    assert sum(row["area_mm2"] for row in told["patches"]) == pytest.approx(made.area, rel=1e-6)


@pytest.mark.parametrize("kind", FEATURES)
@pytest.mark.parametrize("bend", [0.0, pytest.param(12.0, marks=pytest.mark.long)])
def test_each_kind_of_hole_has_the_volume_that_it_has(kind, bend):
    corners = regular(4, (5.0, -3.0), 12.0, 0.3)
    made = plate(BOX, 10.0, [(kind, corners, bend, 4.0)])
    result, told = solved(made.facts())
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    assert not told["warnings"]
    assert volume_of(result) == pytest.approx(made.volume, rel=2e-4 if bend else 1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_plates_in_any_place_are_what_they_are(seed):
    made = random_plate(seed)
    result, told = solved(made.facts(turned(seed)))
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    assert not told["warnings"]
    assert volume_of(result) == pytest.approx(made.volume, rel=5e-4)
    for one in result.filled:
        rims = outlines_of(result.net, one.loop)
        assert len(one.fill.brep.faces[0].loops) == len(rims) or not len(rims) > 1


@pytest.mark.parametrize("scale", [1e-3, pytest.param(1e3, marks=pytest.mark.long)])
def test_size_and_the_order_of_curves_change_nothing(scale):
    made = random_plate(7110)
    _, one = solved(made.facts())
    given = made.facts(turned(3), scale)
    np.random.default_rng(3).shuffle(given["network"]["curves"])
    _, two = solved(given)

    def named(told):
        return {frozenset(loop) for loop in told["loops"]}

    assert named(one) == named(two)
    assert two["closed"]


# -- what is no hole -------------------------------------------------------------------------


def test_a_loop_on_a_face_from_which_nothing_leaves_stays_a_surface_on_it():
    made = plate(BOX, 10.0, [])
    made.ring("h", square(0.0, 0.0, 5.0), 0.0, 10.0)
    result, _ = solved(made.facts())
    areas = sorted(one.fill.area for one in result.filled)
    assert len(areas) == 7
    assert areas[0] == pytest.approx(100.0, rel=1e-6)
    assert areas[-1] == pytest.approx(4800.0, rel=1e-6)


def test_a_box_over_a_face_that_it_does_not_touch_is_no_hole():
    made = plate(BOX, 10.0, [])
    other = plate(square(0.0, 0.0, 5.0), 3.0, [])
    curves = dict(made.curves) | {
        f"x{name}": points + np.array((0.0, 0.0, 10.5)) for name, points in other.curves.items()
    }
    result, told = solved(facts(curves))
    assert len(result.filled) == 12
    assert all(len(outlines_of(result.net, one.loop)) == 1 for one in result.filled)
    assert told["closed"]


def test_a_hole_that_touches_the_outline_is_left_as_it_is():
    made = plate(BOX, 10.0, [])
    made.wall("h", regular(4, (35.0, 0.0), 5.0), 0.0, 0.0, 10.0)
    result, _ = solved(made.facts())
    assert all(len(outlines_of(result.net, one.loop)) == 1 for one in result.patches)


# -- touches ---------------------------------------------------------------------------------


def bored() -> ProductState:
    return product_of_network(plate(BOX, 10.0, [("bore", square(0, 0, 8), 0.0, 0.0)]).facts())


def touched(state, x, y):
    """Return the state after a touch from above."""
    net = net_of_state(state)
    (meant, *_) = loops_at(net, found_loops(state, net), (x, y, 500.0), (0.0, 0.0, -1.0))
    return switched(state, net, meant)


def outline_counts(state):
    net = net_of_state(state)
    result = ProductModeler().solve(state, Job())
    return sorted(len(outlines_of(net, one.loop)) for one in result.filled), result.is_closed


def test_a_touch_in_a_hole_makes_it_a_surface_and_another_one_a_hole_again():
    state = bored()
    assert outline_counts(state) == ([1] * 8 + [2, 2], True)
    filled = touched(state, 0.0, 0.0)
    assert outline_counts(filled) == ([1] * 10 + [2], True)
    again = touched(filled, 0.0, 0.0)
    assert outline_counts(again) == ([1] * 8 + [2, 2], True)
    assert len(again.rejected) == 1


@pytest.mark.parametrize("touches", [1, 2])
def test_what_a_person_said_of_a_hole_stays_while_the_network_grows(touches):
    state = bored()
    for _ in range(touches):
        state = touched(state, 0.0, 0.0)
    counts, _ = outline_counts(state)
    more = with_patches_found(state)
    assert outline_counts(more)[0] == counts
    assert {node.id for node in more.nodes} == {node.id for node in state.nodes}


def test_a_hole_in_the_core_of_a_groove_is_switched_in_the_core():
    holes = [("groove", square(0, 0, 12), 0.0, 4.0), ("bore", square(0, 0, 2), 0.0, 0.0)]
    state = product_of_network(plate(BOX, 10.0, holes).facts())
    assert outline_counts(state) == ([1] * 16 + [2] * 4, True)
    filled = touched(state, 0.0, 0.0)
    assert outline_counts(filled) == ([1] * 18 + [2] * 3, True)
    assert outline_counts(touched(filled, 0.0, 0.0)) == outline_counts(state)


def test_a_hole_that_was_a_surface_is_one_again_when_that_is_deleted():
    state = bored()
    filled = touched(state, 0.0, 0.0)
    fresh = {node.id for node in filled.nodes} - {node.id for node in state.nodes}
    nodes = tuple(node for node in filled.nodes if node.id not in fresh)
    deleted = ProductModeler().with_parts(filled, nodes, "")
    assert outline_counts(deleted) == outline_counts(state)


def test_a_face_that_is_switched_off_comes_back_with_its_holes():
    state = bored()
    gone = touched(state, 30.0, 20.0)
    assert outline_counts(gone) == ([1] * 8 + [2], False)
    assert outline_counts(with_patches_found(gone))[0] == [1] * 8 + [2]
    assert outline_counts(touched(gone, 30.0, 20.0)) == ([1] * 8 + [2, 2], True)


def test_a_confirmed_face_gets_no_hole_by_itself():
    state = bored()
    net = net_of_state(state)
    nodes = tuple(
        replace(node, confirmed=True, boundary=boundary_of(net, outlines_of(net, loop)[0]))
        if isinstance(node, Patch)
        and len(outlines_of(net, loop := loop_of(net, node.boundary))) > 1
        else node
        for node in state.nodes
    )
    state = with_patches_found(replace(state, nodes=nodes))
    assert outline_counts(state)[0][-1] == 1


def test_a_face_that_gets_a_hole_keeps_its_name_and_colour():
    before, after = product_of_network(plate(BOX, 10.0, []).facts()), bored()
    names = {curve.id: curve.name for curve in before.of_kind(Curve)}
    known = tuple(
        replace(
            node,
            id=f"before {node.id}",
            color=(9, 8, 7),
            boundary=loop_by_names(after, [names[run.curve] for run in node.boundary]),
        )
        for node in before.of_kind(Patch)
    )
    grown = with_patches_found(replace(after, nodes=(*after.of_kind(Curve), *known)))
    assert outline_counts(grown) == outline_counts(after)
    holed = [node for node in grown.of_kind(Patch) if len(node.boundary) == 8]
    assert len(holed) == 2
    assert all(node.color == (9, 8, 7) for node in holed)
    assert {node.id for node in known} <= {node.id for node in grown.nodes}


def loop_by_names(state, names):
    net = net_of_state(state)
    by_id = {curve.id: curve.name for curve in state.of_kind(Curve)}
    for loop in find_loops(net).candidates:
        if {by_id[net.edges[edge].curve] for edge, _ in loop} == set(names):
            return boundary_of(net, loop)
    raise AssertionError(names)


# -- loops with several outlines ----------------------------------------------------------------


def test_boundaries_keep_all_outlines():
    state = bored()
    net = net_of_state(state)
    for loop in find_loops(net).loops:
        found = loop_of(net, boundary_of(net, loop))
        assert found is not None
        assert [set(one) for one in outlines_of(net, found)] == [
            set(one) for one in outlines_of(net, loop)
        ]
        assert reversed_loop(net, reversed_loop(net, loop)) == loop
        assert mirrored_boundary(mirrored_boundary(boundary_of(net, loop))) == boundary_of(
            net, loop
        )


def test_an_outline_that_came_apart_is_told():
    state = bored()
    net = net_of_state(state)
    holed = next(one for one in find_loops(net).loops if len(outlines_of(net, one)) > 1)
    boundary = boundary_of(net, holed)
    assert loop_of(net, boundary[:-1]) is None
    assert loop_of(net, boundary[1:]) is None


def test_loops_that_are_turned_are_turned_with_their_holes():
    net = net_of_state(bored())
    loops = find_loops(net).loops
    made = orient_loops(net, [reversed_loop(net, loops[0]), *loops[1:]])
    assert made.loops == orient_loops(net, loops).loops
    assert made.closed == (True,)


# -- mirrored ----------------------------------------------------------------------------------


def mirrored_plate() -> ProductState:
    """A plate across the plane, with a bore on each side of it and one through it."""
    sketch = Sketch(mirror=True)
    for low, z in (("", 0.0), ("t", 10.0)):
        sketch.node(**{f"a{low}": (-50, 30, z), f"b{low}": (50, 30, z)})
        sketch.node(**{f"p{low}": (-30, 8, z), f"q{low}": (-10, 8, z)})
        sketch.node(**{f"r{low}": (-10, 22, z), f"s{low}": (-30, 22, z)})
        sketch.node(**{f"u{low}": (20, 5, z), f"v{low}": (30, 5, z)})
        for pair in ("ab", "pq", "qr", "rs", "sp", "uv"):
            sketch.curve(f"{pair[0]}{low} {pair[1]}{low}")
        for one in "abuv":
            sketch.curve(f"{one}{low} {one}{low}'", across=True)
    for one in "abpqrsuv":
        sketch.curve(f"{one} {one}t")
    curves, joints = sketch.built()
    nodes = tuple(replace(curve, name=curve.id) for curve in curves)
    return with_patches_found(ProductState(nodes=nodes, joints=tuple(joints), symmetry=PLANE))


def test_holes_on_both_sides_of_a_plane_of_symmetry():
    state = mirrored_plate()
    result = ProductModeler().solve(state, Job())
    assert result.is_closed
    assert volume_of(result) == pytest.approx((6000.0 - 2 * 280.0 - 100.0) * 10.0, rel=1e-6)
    counts = sorted(len(outlines_of(result.net, one.loop)) for one in result.filled)
    assert counts[-2:] == [4, 4]
    touching = touched(state, -20.0, 15.0)
    assert outline_counts(touching)[0][-2:] == [2, 4]
    assert outline_counts(touched(touching, -20.0, -15.0)) == outline_counts(state)


def test_faces_with_holes_that_are_images_of_one_another_are_so_to_the_last_bit():
    sketch = Sketch(mirror=True)
    base = {"a": (-20, 10), "b": (20, 12), "c": (22, 50), "d": (-18, 47)}
    hole = {"p": (-8, 22), "q": (9, 20), "r": (7, 38), "s": (-5, 36)}
    for low, z in (("", 0.0), ("t", 7.0)):
        for name, (x, y) in (base | hole).items():
            sketch.node(**{f"{name}{low}": (x, y, z)})
        for pair in ("ab", "bc", "cd", "da", "pq", "qr", "rs", "sp"):
            sketch.curve(f"{pair[0]}{low} {pair[1]}{low}")
    for name in base | hole:
        sketch.curve(f"{name} {name}t")
    curves, joints = sketch.built()
    nodes = tuple(replace(curve, name=curve.id) for curve in curves)
    state = with_patches_found(ProductState(nodes=nodes, joints=tuple(joints), symmetry=PLANE))
    result = ProductModeler().solve(state, Job())
    assert result.is_closed
    holed = [one for one in result.filled if len(outlines_of(result.net, one.loop)) == 2]
    assert [one.mirrored for one in holed] == [False, True] * 2
    for one, image in zip(holed[::2], holed[1::2], strict=True):
        assert isinstance(image.fill, PlaneFill)
        rows = [
            {tuple(row) for edge in fill.brep.edges for row in (edge.control_points * way).tolist()}
            for fill, way in ((one.fill, (1, -1, 1)), (image.fill, (1, 1, 1)))
        ]
        assert rows[0] == rows[1]
        assert one.fill.area == pytest.approx(image.fill.area, rel=1e-6)
        assert rim_edges(result.net, one.loop).isdisjoint(rim_edges(result.net, image.loop))


# -- shaping -----------------------------------------------------------------------------------


def test_a_detail_is_carved_beside_a_hole():
    given = plate(BOX, 10.0, [("bore", square(-15, 0, 8), 0.0, 0.0)]).facts()
    outline = [(20, -5, 10), (30, -5, 10), (30, 5, 10), (20, 5, 10)]
    given["network"]["details"] = [
        {"outlines": [outline], "kind": "in", "depth": 2.0, "draft": 0.0}
    ]
    result, told = solved(given)
    assert told["details"][0]["carved"]
    (shell,) = result.detailed.changed
    assert shell.is_closed


def test_pressure_and_strokes_leave_a_face_with_holes_as_it_is_and_that_is_told():
    given = plate(BOX, 10.0, [("bore", square(0, 0, 8), 0.0, 0.0)]).facts()
    _, plain = solved(given)
    top = next(row for row in plain["patches"] if row["holes"] and "ot0" in row["curves"])
    given["network"]["pressure"] = {" ".join(top["curves"]): 0.3}
    result, told = solved(given)
    assert told["closed"]
    assert [sentence for sentence in told["warnings"] if "has holes" in sentence]
    assert volume_of(result) == pytest.approx((4800.0 - 256.0) * 10.0, rel=1e-6)


def test_surfaces_as_in_the_paper_leave_it_out_and_say_so():
    state = replace(bored(), surfaces="paper")
    result = ProductModeler().solve(state, Job())
    assert sum(one.surface is None for one in result.patches) == 2
    assert all("no holes" in one.problem for one in result.patches if one.surface is None)


# -- files and edits ---------------------------------------------------------------------------


def test_loops_of_a_report_give_the_same_surfaces_in_a_file():
    given = random_plate(7103).facts()
    result, told = solved(given)
    given["network"]["loops"] = told["loops"]
    again, twice = solved(given)
    assert faces_of(again) == faces_of(result)
    assert twice["closed"]
    for one, two in zip(told["patches"], twice["patches"], strict=True):
        assert [set(hole) for hole in one["holes"]] == [set(hole) for hole in two["holes"]]


def test_a_deleted_curve_of_a_hole_takes_the_hole_and_its_walls_along():
    state = bored()
    name = next(curve.id for curve in state.of_kind(Curve) if curve.name == "a.t0")
    less = delete_curves(state, name)
    assert outline_counts(less)[0] == [1] * 8 + [2]
    assert outline_counts(with_patches_found(less))[0] == [1] * 8 + [2]


def sheet_with_a_hole():
    curves = {f"o{k}": [BOX[k], BOX[(k + 1) % 4]] for k in range(4)}
    inner = square(5.0, -4.0, 10.0)
    curves |= {f"h{k}": [inner[k], inner[(k + 1) % 4]] for k in range(4)}
    given = facts({name: np.column_stack((row, (2.0, 2.0))) for name, row in curves.items()})
    given["network"]["loops"] = [list(curves)[::-1]]
    return given


def test_a_sheet_with_a_hole_is_named_by_all_of_its_curves():
    result, told = solved(sheet_with_a_hole())
    (one,) = result.filled
    assert isinstance(one.fill, PlaneFill)
    (hole,) = told["patches"][0]["holes"]
    assert set(hole) == {"h0", "h1", "h2", "h3"}
    assert one.fill.area == pytest.approx(4400.0, rel=1e-6)
    assert len(told["open_edges"]) == 8
    assert one.fill.quality_p5 > 0.3


@pytest.mark.parametrize("pair", [("h0", "h1"), ("h3", "h0"), ("o0", "o1"), ("o3", "o0")])
def test_a_rounded_corner_of_any_outline_stays_in_it(pair):
    state = product_of_network(sheet_with_a_hole())
    ids = [next(c.id for c in state.of_kind(Curve) if c.name == name) for name in pair]
    (joint,) = (
        joint.id for joint in state.joints if {meet.curve for meet in joint.meetings} == set(ids)
    )
    made, _ = fillet(state, joint, *ids, 3.0)
    (patch,) = made.of_kind(Patch)
    assert sorted(map(len, outlines_of_boundary(patch.boundary))) == [4, 5]
    (one,) = ProductModeler().solve(made, Job()).filled
    away = (4.0 - np.pi) * 9.0 / 4.0
    assert one.fill.area == pytest.approx(
        4400.0 + away * (1 if pair[0][0] == "h" else -1), rel=1e-4
    )


def test_a_split_curve_of_a_hole_stays_in_its_outline():
    state = bored()
    name = next(curve.id for curve in state.of_kind(Curve) if curve.name == "a.t0")
    made, _ = split_curve(state, name, [0.4])
    assert outline_counts(made) == outline_counts(state)


@pytest.mark.parametrize("digits", [3, pytest.param(5, marks=pytest.mark.long)])
def test_rounded_points_of_a_leaning_plate_have_holes_as_well(digits):
    made = random_plate(7120)
    given = made.facts(turned(7120))
    for row in given["network"]["curves"]:
        row["points"] = np.round(row["points"], digits).tolist()
    result, told = solved(given)
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    assert all(one.fill is not None for one in result.patches)
