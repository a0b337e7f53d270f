"""Holes in faces that bend: found, filled in parts, switched by touches, mirrored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto.plugin import Job
from bozzetto_product.fill import holed_fill
from bozzetto_product.fill.guide_chart import GuideChart
from bozzetto_product.fill.network_fills import guide_of
from bozzetto_product.fill.parted_fill import PartedFill
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.loops.picking import loops_at
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.network.outlines import outlines_of
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.solve.found_patches import found_loops, switched, with_patches_found
from bozzetto_product.solve.solver import net_of_state
from tests.plugins.product.holed_bends import cylinder, random_cylinder, random_top
from tests.plugins.product.holed_plates import regular
from tests.plugins.product.sketched_network import PLANE, Sketch
from tests.plugins.product.test_holes import faces_of, volume_of
from tests.plugins.product.test_rough_files import facts, solved, turned

RADIUS, HEIGHT = 20.0, 50.0
SIZE = float(np.hypot(2.0 * RADIUS, HEIGHT))
HOLE = regular(3, (2.0, 25.0), 6.0, 0.4)
SEEDS = (7301, 7302, 7303)


def body(kind="pocket", corners=HOLE, bend=6.0, depth=8.0):
    return cylinder(RADIUS, HEIGHT, 4, [(kind, 1, corners, bend, depth)])


@pytest.fixture(scope="module")
def pocket():
    """A cylinder with a round pocket, solved."""
    made = body()
    state = product_of_network(made.facts())
    result = ProductModeler().solve(state, Job())
    return made, state, result


def holed(result):
    return [one for one in result.filled if len(outlines_of(result.net, one.loop)) > 1]


def places(fill):
    """Return places all over the patches of a fill, (n, 3)."""
    u, v = (x.ravel() for x in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)))
    return np.concatenate([patch.value(u, v) for patch in fill.patches])


def off_cylinder(result):
    """Return how far the faces with holes are from the cylinder, as share of its size."""
    rows = np.concatenate([places(one.fill) for one in holed(result)])
    return float(np.abs(np.hypot(rows[:, 0], rows[:, 1]) - RADIUS).max()) / SIZE


# -- closed forms ----------------------------------------------------------------------------


def test_a_pocket_in_a_cylinder_is_a_hole_of_its_face(pocket):
    made, state, result = pocket
    assert faces_of(result) == set(made.faces)
    told = ProductModeler().report(state, result, Job())
    assert told["closed"]
    assert not told["warnings"]
    assert volume_of(result) == pytest.approx(made.volume, rel=2e-3)
    assert off_cylinder(result) < 1e-4


def test_its_parts_are_one_surface(pocket):
    _, _, result = pocket
    (one,) = holed(result)
    assert isinstance(one.fill, PartedFill)
    assert one.fill.has_holes
    assert one.fill.cut_degrees < 0.5
    assert not one.fill.folded
    assert one.fill.deviation < 1e-9 * SIZE


def test_only_edges_where_the_network_is_smooth_are_told_to_be_so(pocket):
    _, _, result = pocket
    (one,) = holed(result)
    smooth = [np.isfinite(angle) for angle in one.fill.g1_degrees]
    assert smooth == list(one.asked_smooth)
    assert sum(smooth) == 2
    assert not one.creased


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "corners", "bend"),
    [
        ("bore", regular(4, (0.0, 25.0), 5.0, 0.2), 5.0),
        ("boss", regular(4, (-3.0, 20.0), 5.0, 0.2), 0.0),
        ("pocket", regular(5, (1.0, 30.0), 10.0, 0.2), 0.0),
    ],
)
def test_each_kind_of_hole_has_the_volume_that_it_has(kind, corners, bend):
    made = body(kind, corners, bend)
    result, told = solved(made.facts())
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    assert not told["warnings"]
    assert volume_of(result) == pytest.approx(made.volume, rel=2e-3)
    assert off_cylinder(result) < 1e-4


@pytest.mark.long
@pytest.mark.parametrize("seed", SEEDS)
def test_random_cylinders_in_any_place_are_what_they_are(seed):
    made = random_cylinder(seed)
    result, told = solved(made.facts(turned(seed)))
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    assert volume_of(result) == pytest.approx(made.volume, rel=3e-3)


@pytest.mark.long
@pytest.mark.parametrize("seed", [7404, 7405])
def test_random_tops_that_bend_freely_are_closed(seed):
    made = random_top(seed)
    result, told = solved(made.facts(turned(seed)))
    assert faces_of(result) == set(made.faces)
    assert told["closed"]
    volume_of(result)
    for one in holed(result):
        assert not one.fill.folded
        assert not getattr(one.fill, "cut_degrees", 0.0) > 1.0


@pytest.mark.long
def test_size_and_the_order_of_curves_change_nothing(pocket):
    made, _, one = pocket
    given = made.facts(turned(3), 1e3)
    np.random.default_rng(3).shuffle(given["network"]["curves"])
    two, told = solved(given)
    assert faces_of(two) == faces_of(one)
    assert told["closed"]
    areas = [sum(each.fill.area for each in result.filled) for result in (one, two)]
    assert areas[1] == pytest.approx(1e6 * areas[0], rel=1e-4)


# -- what is no hole -------------------------------------------------------------------------


def test_of_a_low_boss_only_the_foot_is_a_hole():
    made = body("boss", depth=0.6)
    result, told = solved(made.facts())
    assert faces_of(result) == set(made.faces)
    assert told["closed"]


def test_a_loop_on_a_face_from_which_nothing_leaves_stays_a_surface_on_it():
    made = body()
    rim = {name: row for name, row in made.curves.items() if name[:3] not in ("a.f", "a.v")}
    result, _ = solved(facts(rim))
    assert len(result.filled) == 7
    assert not holed(result)


def test_a_hole_that_touches_the_outline_is_left_as_it_is():
    edge = RADIUS * np.sin(np.pi / 4)
    made = body("boss", np.array([(edge, 25.0), (edge - 8.0, 28.0), (edge - 8.0, 22.0)]), 0.0)
    result, _ = solved(made.facts())
    assert not holed(result)


@pytest.mark.long
def test_a_hole_is_of_the_nearer_of_two_walls():
    outer, inner = body(), cylinder(RADIUS - 0.8, HEIGHT, 4, [])
    curves = dict(outer.curves) | {f"i{name}": row for name, row in inner.curves.items()}
    result, _ = solved(facts(curves))
    (one,) = (one for one in holed(result) if isinstance(one.fill, PartedFill))
    rows = places(one.fill)
    assert np.hypot(rows[:, 0], rows[:, 1]).min() > RADIUS - 0.01


@pytest.mark.long
def test_the_inner_side_of_a_thin_wall_is_no_hole_of_the_outer_one():
    outer, inner = cylinder(RADIUS, HEIGHT, 4, []), cylinder(RADIUS - 0.4, HEIGHT - 8.0, 4, [])
    curves = dict(outer.curves)
    curves |= {f"i{name}": np.add(row, (0.0, 0.0, 4.0)) for name, row in inner.curves.items()}
    result, _ = solved(facts(curves))
    assert len(result.filled) == 12
    assert not holed(result)


# -- touches ---------------------------------------------------------------------------------


def counts_of(state):
    net = net_of_state(state)
    result = ProductModeler().solve(state, Job())
    return sorted(len(outlines_of(net, one.loop)) for one in result.filled), result.is_closed


def touched(state, origin, way):
    net = net_of_state(state)
    (meant, *_) = loops_at(net, found_loops(state, net), origin, way)
    return switched(state, net, meant)


def test_a_touch_in_a_hole_makes_it_a_surface_and_another_one_a_hole_again(pocket):
    _, state, _ = pocket
    turn = np.pi / 4 + 1.5 * np.pi / 2
    out = np.array((np.cos(turn), np.sin(turn), 0.0))
    middle = (*(2.0 * np.array((-np.sin(turn), np.cos(turn)))), 25.0)
    touch = (np.array(middle) + 500.0 * out, -out)
    assert counts_of(state) == ([1] * 9 + [2], True)
    filled = touched(state, *touch)
    assert counts_of(filled) == ([1] * 11, True)
    assert counts_of(touched(filled, *touch)) == counts_of(state)


def test_what_is_found_again_has_the_same_holes(pocket):
    _, state, result = pocket
    again = with_patches_found(state)
    assert {node.id for node in again.nodes} == {node.id for node in state.nodes}
    assert faces_of(ProductModeler().solve(again, Job())) == faces_of(result)


# -- mirrored, files -----------------------------------------------------------------------------


def mirrored_tunnel() -> ProductState:
    """A bent face and its image, and a tunnel from one to the other."""

    def on(x, z):
        return np.array((x, np.sqrt(RADIUS**2 - x**2), z))

    sketch = Sketch(mirror=True)
    rims = {"a": (12, 0), "b": (-12, 0), "c": (-12, 40), "d": (12, 40)}
    hole = {"p": (5, 14), "q": (-4, 17), "r": (1, 26)}
    for name, (x, z) in (rims | hole).items():
        sketch.node(**{name: on(x, z)})
    for pair in ("ab", "bc", "cd", "da", "pq", "qr", "rp"):
        ends = np.array([(rims | hole)[name] for name in pair], float)
        between = [on(*ends[0] + share * (ends[1] - ends[0])) for share in np.arange(1, 12) / 12]
        sketch.curve(pair[0], *between, pair[1])
    for name in hole:
        sketch.curve(f"{name} {name}'", across=True)
    curves, joints = sketch.built()
    nodes = tuple(replace(curve, name=curve.id) for curve in curves)
    return with_patches_found(ProductState(nodes=nodes, joints=tuple(joints), symmetry=PLANE))


def test_faces_that_are_images_of_one_another_are_so_to_the_last_bit():
    result = ProductModeler().solve(mirrored_tunnel(), Job())
    first, second = sorted(holed(result), key=lambda one: one.mirrored)
    assert (first.mirrored, second.mirrored) == (False, True)
    rows = [
        {
            tuple(point)
            for patch in one.fill.patches
            for point in (patch.control_points * way).reshape(-1, 3).tolist()
        }
        for one, way in ((first, (1, -1, 1)), (second, (1, 1, 1)))
    ]
    assert rows[0] == rows[1]
    assert second.fill.has_holes
    assert not np.isfinite(second.fill.g1_degrees).any()


@pytest.mark.long
def test_loops_of_a_report_give_the_same_surfaces_in_a_file(pocket):
    made, state, result = pocket
    given = made.facts()
    given["network"]["loops"] = ProductModeler().report(state, result, Job())["loops"]
    again, told = solved(given)
    assert faces_of(again) == faces_of(result)
    assert told["closed"]


def test_pressure_leaves_a_face_with_holes_as_it_is_and_that_is_told(pocket):
    _, state, result = pocket
    (one,) = holed(result)
    state = state.with_node(replace(one.patch, pressure=0.3))
    pressed = ProductModeler().solve(state, Job())
    told = ProductModeler().report(state, pressed, Job())
    assert told["closed"]
    assert [sentence for sentence in told["warnings"] if "has holes" in sentence]
    assert volume_of(pressed) == pytest.approx(volume_of(result), rel=1e-9)


@pytest.mark.parametrize(("name", "way"), [("a.t1", (0.8, 2.0, 0.0)), ("a.t0", (0.0, 0.0, 2.0))])
def test_a_curve_of_a_hole_may_be_pulled_off_the_face(name, way):
    """A corner that turned a little by it gave the face the planes of the wall, and it folded."""
    made = cylinder(RADIUS, HEIGHT, 2, [("bore", 0, regular(4, (0.0, 25.0), 5.0, 0.785), 5.0, 0.0)])
    state = product_of_network(made.facts())
    curve = next(each for each in state.of_kind(Curve) if each.name == name)
    points = curve.spline.control_points.copy()
    hump = np.sin(np.linspace(0.0, np.pi, len(points)))
    spline = Spline(curve.spline.knots, points + hump[:, None] * np.array(way))
    edited = settled_state(state.with_node(curve), {curve.id: spline})
    result = ProductModeler().solve(edited, Job())
    assert len(holed(result)) == 2
    told = ProductModeler().report(edited, result, Job())
    assert told["closed"]
    rims = {e for one in holed(result) for o in outlines_of(result.net, one.loop)[1:] for e, _ in o}
    names = {result.net.edges[edge].curve for edge in rims}
    assert curve.id in names


def test_a_hole_that_no_cut_frees_leaves_no_surface_and_that_is_told(monkeypatch):
    monkeypatch.setattr(holed_fill, "parted_region", lambda *_: [])
    state = product_of_network(body(corners=regular(3, (1.9, 24.0), 6.0, 0.4)).facts())
    result = ProductModeler().solve(state, Job())
    assert not holed(result)
    told = ProductModeler().report(state, result, Job())
    assert not told["closed"]
    assert any("no surface" in warning for warning in told["warnings"])


def test_a_chart_gives_back_the_places_of_its_surface(pocket):
    _, _, result = pocket
    loops = [one.loop for one in result.patches]
    number = next(k for k, one in enumerate(result.patches) if one in holed(result))
    guide = guide_of(result.net, loops, number)
    chart = GuideChart(guide)
    rows = places(guide)
    flat, normals = chart.feet(rows)
    back, again = chart.surface(flat)
    assert np.abs(back - rows).max() < 1e-6 * SIZE
    inner = np.linalg.norm(back - np.mean(rows, axis=0), axis=1) < 0.4 * SIZE
    assert (normals * again).sum(axis=1)[inner].min() > 1.0 - 1e-6
