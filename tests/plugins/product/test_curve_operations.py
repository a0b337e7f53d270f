"""What can be done to curves: joints hold, surfaces keep their boundaries, the image is right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import distances_to_polyline
from bozzetto_product.loops.boundaries import loop_of
from bozzetto_product.model.curves import Curve, LaidPlaces
from bozzetto_product.model.joints import Joint, Meeting, Run
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.rough_shapes import RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.cutting import net_of
from bozzetto_product.operations.curve_edits import (
    make_in_plane,
    make_planar,
    make_symmetric,
    move_joint,
    straighten,
)
from bozzetto_product.operations.curve_meant import curve_meant, curve_under
from bozzetto_product.operations.fillet import fillet
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.operations.modify import drawn_over, modify
from bozzetto_product.operations.offset import offset_spline
from bozzetto_product.operations.pieces import (
    delete_curves,
    join_curves,
    split_curve,
    turn_curve,
)
from bozzetto_product.operations.redraw import redraw_stretch
from bozzetto_product.operations.tangents import end_direction, match_tangents
from bozzetto_product.operations.trim import trim
from bozzetto_product.projection.planes import heights
from bozzetto_product.projection.views import seen_at
from bozzetto_product.rough_shapes.shapes import rough_mesh
from bozzetto_product.solve.found_patches import with_patches_found
from tests.plugins.product.drawn_curves import MIRROR, SHEET, bow, misses, one_stroke

SIDE = SHEET.__class__(eye=(400.0, -250.0, 200.0))


def _bent(start: tuple[float, ...], end: tuple[float, ...], seed: int) -> Spline:
    return bow(np.array(start, float), np.array(end, float), np.random.default_rng(seed), 0.1)


@pytest.fixture(scope="module")
def network() -> ProductState:
    """Return four curves round a surface; one ends inside another."""
    a = _bent((-50, 4, 0), (50, 5, 0), 1)
    foot = a.value([0.45])[0]
    ends = {
        "a": a,
        "b": _bent((50.6, 5.2, 0), (60, 40, 0), 2),
        "c": _bent((*(foot + 0.4),), (20, 60, 40), 3),
        "d": _bent((59.5, 40.6, 1), (20.5, 60.5, 40.6), 4),
    }
    state = ProductState(
        nodes=tuple(Curve(id=name, name=name, spline=spline) for name, spline in ends.items())
    )
    state = trim(state, gap=3.0).state
    names = {frozenset(meet.curve for meet in joint.meetings): joint.id for joint in state.joints}
    ac, ab, bd, cd = (names[frozenset(pair)] for pair in ("ac", "ab", "bd", "cd"))
    boundary = (
        Run("a", ac, ab),
        Run("b", ab, bd),
        Run("d", bd, cd),
        Run("c", cd, ac, forward=False),
    )
    return replace(state, nodes=(*state.nodes, Patch(id="p", boundary=boundary)))


def _check(state: ProductState, patches: int = 1) -> None:
    """Joints are exact, and boundaries run head to tail over curves that meet there."""
    assert misses(state) == 0.0
    joints = {joint.id: joint for joint in state.joints}
    assert len(joints) == len(state.joints)
    boundaries = [patch.boundary for patch in state.of_kind(Patch)]
    assert len(boundaries) == patches
    for boundary in boundaries:
        for run, after in zip(boundary, (*boundary[1:], boundary[0]), strict=True):
            assert run.end == after.start
            for name in (run.start, run.end):
                assert any(meet.curve == run.curve for meet in joints[name].meetings)
    net = net_of(state.of_kind(Curve), state.joints, state.symmetry)
    for edge in net.edges:
        if edge.start >= 0:
            assert (edge.spline.control_points[0] == net.nodes[edge.start]).all()
            assert (edge.spline.control_points[-1] == net.nodes[edge.end]).all()


def _over(spline: Spline, way: tuple[float, float], camera: object = SHEET) -> np.ndarray:
    """Return ink beside the middle of a curve, px."""
    spots = seen_at(camera, spline.sampled(121))[25:95]
    return spots + np.outer(np.sin(np.linspace(0.0, np.pi, len(spots))) ** 2, way)


def test_the_network_is_sound(network: ProductState) -> None:
    _check(network)


def test_strokes_over_a_curve_bend_it_and_what_is_joined_follows(network: ProductState) -> None:
    ink = _over(splines_of(network)["a"], (0.0, -12.0))
    found = curve_meant(network, [one_stroke(ink)])
    assert found is not None
    assert (found.curve, found.mirrored) == ("a", False)
    done = modify(network, [one_stroke(ink)])
    _check(done)
    new, old = splines_of(done)["a"], splines_of(network)["a"]
    assert (new.control_points[[0, -1]] == old.control_points[[0, -1]]).all()
    away = distances_to_polyline(ink, seen_at(SHEET, new.sampled(1500)))
    assert np.percentile(away, 90) <= 1.5
    guests = [splines_of(state)["c"].control_points[0] for state in (network, done)]
    assert np.linalg.norm(guests[1] - guests[0]) > 1.0
    assert len(done.node("a").strokes) == 1
    # The network before is as it was: that is what undo goes back to.
    _check(network)


def test_strokes_along_a_curve_change_nothing(network: ProductState) -> None:
    ink = seen_at(SHEET, splines_of(network)["a"].sampled(150))
    assert modify(network, [one_stroke(ink)]) is network


def test_the_change_is_the_least_surprising() -> None:
    """Along the line of sight nothing moves."""
    state = ProductState(nodes=(Curve(id="a", spline=_bent((-50, 4, 0), (50, 5, 0), 5)),))
    done = modify(state, [one_stroke(_over(splines_of(state)["a"], (0.0, -15.0)))])
    at = np.linspace(0.0, 1.0, 80)
    old, new = splines_of(state)["a"].value(at), splines_of(done)["a"].value(at)
    depth = np.abs((new - old)[:, 1])
    assert depth.max() <= 0.1 * np.abs((new - old)[:, 2]).max()


def test_strokes_over_the_mirror_image_change_the_one_curve() -> None:
    base = Curve(id="a", spline=_bent((-50, 14, 0), (50, 25, 10), 6), mirrored=True)
    state = ProductState(nodes=(base,))
    assert base.spline is not None
    image = Spline(base.spline.knots, base.spline.control_points * MIRROR)
    ink = one_stroke(_over(image, (0.0, -14.0), SIDE), SIDE)
    done = modify(state, [ink])
    direct = modify(replace(state, nodes=(replace(base, spline=image, mirrored=False),)), [ink])
    assert curve_meant(state, [ink]).mirrored  # type: ignore[union-attr]
    assert np.allclose(
        splines_of(done)["a"].control_points * MIRROR,
        splines_of(direct)["a"].control_points,
        atol=1e-9,
    )


def test_a_planar_curve_stays_in_its_plane() -> None:
    plane = Plane((0.0, 5.0, 0.0), (0.0, 1.0, 0.0))
    state = ProductState(nodes=(Curve(id="a", spline=_bent((-50, 5, 0), (50, 5, 9), 7)),))
    flat = make_planar(state, "a", plane)
    done = modify(flat, [one_stroke(_over(splines_of(flat)["a"], (0.0, -15.0), SIDE), SIDE)])
    assert (splines_of(done)["a"].control_points[:, 1] == 5.0).all()


def test_a_stretch_is_drawn_anew_and_the_rest_stays(network: ProductState) -> None:
    ink = _over(splines_of(network)["d"], (10.0, -12.0))
    done = redraw_stretch(network, [one_stroke(ink)])
    _check(done)
    image = seen_at(SHEET, splines_of(done)["d"].sampled(1500))
    assert distances_to_polyline(ink, image)[20:-20].max() <= 1.5
    before = seen_at(SHEET, splines_of(network)["d"].sampled(121))
    assert distances_to_polyline(before[:15], image).max() <= 0.2
    assert distances_to_polyline(before[-15:], image).max() <= 0.2


def test_pieces_of_a_curve_are_the_curve(network: ProductState) -> None:
    done, names = split_curve(network, "a", [0.2, 0.7])
    assert names[0] == "a"
    assert len(names) == 3
    _check(done)
    old = splines_of(network)["a"].sampled(200)
    pieces = [splines_of(done)[name] for name in names]
    away = [np.linalg.norm(each.value(each.foot_points(old)) - old, axis=1) for each in pieces]
    assert np.min(away, axis=0).max() <= 1e-9
    assert len(done.node("p").boundary) == 5


def test_pieces_that_are_joined_again_are_one_curve(network: ProductState) -> None:
    cut, (first, second) = split_curve(network, "a", [0.7])
    done = join_curves(cut, first, 1.0, second, 0.0)
    _check(done)
    assert done.node("p").boundary == network.node("p").boundary
    new = splines_of(done)["a"].sampled(800)
    assert distances_to_polyline(splines_of(network)["a"].sampled(100), new).max() <= 1e-3


def test_a_closed_curve_is_cut_open() -> None:
    turn = 2.0 * np.pi * np.arange(8) / 8
    ring = Spline.uniform(np.column_stack((np.cos(turn), np.sin(turn), 0 * turn)) * 40, closed=True)
    state = ProductState(nodes=(Curve(id="r", spline=ring), Patch(id="p", boundary=(Run("r"),))))
    done, names = split_curve(state, "r", [0.25])
    assert names == ("r",)
    assert not splines_of(done)["r"].closed
    _check(done)
    twice, names = split_curve(state, "r", [0.25, 0.6])
    assert len(names) == 2
    _check(twice)


@pytest.mark.parametrize("ends", [(1.0, 0.0), (0.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
def test_joined_curves_run_on_without_a_kink(ends: tuple[float, float]) -> None:
    one, other = _bent((0, 0, 0), (40, 5, 0), 8), _bent((41, 5, 0), (80, 20, 10), 9)
    one = one if ends[0] == 1.0 else one.reversed()
    other = other if ends[1] == 0.0 else other.reversed()
    state = ProductState(nodes=(Curve(id="a", spline=one), Curve(id="b", spline=other)))
    done = join_curves(state, "a", ends[0], "b", ends[1])
    (curve,) = done.of_kind(Curve)
    assert curve.spline is not None
    at = np.linspace(*curve.spline.range, 4001)
    ways = curve.spline.derivative(at)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.clip((ways[1:] * ways[:-1]).sum(axis=1), -1, 1))).max() <= 0.5


def test_a_bridge_is_laid_over_a_wide_gap() -> None:
    one, other = _bent((0, 0, 0), (40, 0, 0), 10), _bent((70, 10, 0), (110, 20, 10), 11)
    state = ProductState(nodes=(Curve(id="a", spline=one), Curve(id="b", spline=other)))
    (curve,) = join_curves(state, "a", 1.0, "b", 0.0).of_kind(Curve)
    assert curve.spline is not None
    every = curve.spline.sampled(3000)
    for old in (one, other):
        assert distances_to_polyline(old.sampled(50), every).max() <= 1e-3


def test_what_a_curve_bounds_goes_with_it(network: ProductState) -> None:
    done = delete_curves(network, "b")
    _check(done, 0)
    assert {curve.id for curve in done.of_kind(Curve)} == {"a", "c", "d"}
    assert len(done.joints) == 2


def test_a_curve_turned_round_twice_is_as_before(network: ProductState) -> None:
    once = turn_curve(network, "a")
    _check(once)
    twice = turn_curve(once, "a")
    assert twice.node("p").boundary == network.node("p").boundary
    assert np.allclose(
        splines_of(twice)["a"].control_points, splines_of(network)["a"].control_points
    )


def test_a_curve_that_follows_a_surface_follows_it_turned_round_as_well() -> None:
    spline = _bent((-50, 4, 0), (50, 5, 0), 1)
    places = spline.sampled(60)
    laid = LaidPlaces("s", 60, np.arange(60), np.eye(3)[np.zeros(60, int)], places)
    state = ProductState(nodes=(Curve(id="a", spline=spline, laid=laid),))
    (turned,) = turn_curve(state, "a").of_kind(Curve)
    assert turned.laid is not None
    np.testing.assert_allclose(turned.laid.points, turned.spline.sampled(60), atol=1e-9)
    assert turned.laid.faces.tolist() == list(range(59, -1, -1))


def test_straight_planar_and_moved(network: ProductState) -> None:
    straight = straighten(network, "a")
    _check(straight)
    points = splines_of(straight)["a"].sampled(50)
    chord = points[-1] - points[0]
    assert np.linalg.norm(np.cross(points - points[0], chord), axis=1).max() <= 1e-9 * (
        chord @ chord
    )
    planar = make_planar(network, "d")
    _check(planar)
    plane = planar.node("d").plane
    assert np.abs(heights(splines_of(planar)["d"].control_points, plane)).max() <= 1e-9
    corner = next(j for j in network.joints if {m.curve for m in j.meetings} == {"a", "b"})
    moved = move_joint(network, corner.id, (55.0, -5.0, 3.0))
    _check(moved)
    assert (splines_of(moved)["a"].control_points[-1] == (55.0, -5.0, 3.0)).all()


def test_tangents_are_matched(network: ProductState) -> None:
    corner = next(j for j in network.joints if {m.curve for m in j.meetings} == {"a", "b"})
    for lead in ("", "a", "b"):
        done = match_tangents(network, corner.id, "a", "b", lead=lead)
        _check(done)
        ends = {meet.curve: meet.at for meet in corner.meetings}
        ways = [end_direction(splines_of(done)[name], ends[name]) for name in "ab"]
        assert np.linalg.norm(ways[0] + ways[1]) <= 1e-9
        if lead:
            old = splines_of(network)[lead].control_points
            assert (splines_of(done)[lead].control_points == old).all()


def test_a_corner_is_rounded_by_the_radius(network: ProductState) -> None:
    corner = next(j for j in network.joints if {m.curve for m in j.meetings} == {"a", "b"})
    done, _ = fillet(network, corner.id, "a", "b", 6.0)
    _check(done)
    assert len(done.node("p").boundary) == 5
    with pytest.raises(UserError):
        fillet(network, corner.id, "a", "b", 500.0)


def test_a_fillet_of_straight_lines_is_a_circle() -> None:
    """Between perpendicular lines it touches at the radius from the corner."""
    share = np.linspace(0.0, 1.0, 7)[:, None]
    one = Spline.uniform(share * (60.0, 0.0, 0.0))
    other = Spline.uniform(share[::-1] * (0.0, 50.0, 0.0))
    state = ProductState(
        nodes=(Curve(id="a", spline=one), Curve(id="b", spline=other)),
        joints=(Joint("j", (Meeting("a", 0.0), Meeting("b", 1.0))),),
    )
    done, name = fillet(state, "j", "a", "b", 10.0)
    assert misses(done) == 0.0
    arc = splines_of(done)[name].sampled(200)
    assert np.abs(np.linalg.norm(arc - (10.0, 10.0, 0.0), axis=1) - 10.0).max() <= 1e-5
    kept = [splines_of(done)[key] for key in ("a", "b")]
    assert np.isclose(min(kept[0].sampled(9)[:, 0]), 10.0)
    assert np.isclose(min(kept[1].sampled(9)[:, 1]), 10.0)


def test_an_offset_on_a_sphere_is_a_circle_of_latitude() -> None:
    mesh = rough_mesh(RoughShape(kind="sphere", length=100.0, width=100.0, height=100.0))
    turn = 2.0 * np.pi * np.arange(12) / 12
    ring = np.column_stack((30.0 * np.cos(turn), 30.0 * np.sin(turn), 0.0 * turn + 40.0))
    spline = Spline.uniform(ring, closed=True)
    (first,) = spline.value([0.0])
    start = np.arctan2(np.hypot(*first[:2]), first[2])
    for distance in (8.0, -8.0):
        made = offset_spline(spline, distance, mesh).sampled(200)
        angle = np.arctan2(np.hypot(made[:, 0], made[:, 1]), made[:, 2])
        # It runs counter-clockwise seen from above: the pole is on its left.
        assert np.abs(50.0 * (start - angle) - distance).max() <= 0.25


@pytest.mark.parametrize("name", ["a", "b", "c", "d"])
def test_symmetric_curves_end_in_the_plane(network: ProductState, name: str) -> None:
    state = replace(network, symmetry=Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    done = make_symmetric(state, name)
    assert misses(done) == 0.0
    flat = make_in_plane(state, name)
    assert misses(flat) == 0.0
    assert (splines_of(flat)[name].control_points[:, 0] == 0.0).all()


def test_a_curve_that_crosses_the_plane_keeps_its_longer_half() -> None:
    state = ProductState(nodes=(Curve(id="a", spline=_bent((0, -20, 0), (5, 60, 9), 12)),))
    (curve,) = make_symmetric(state, "a").of_kind(Curve)
    assert curve.mirrored
    assert curve.spline is not None
    ends = curve.spline.control_points[[0, -1], 1]
    assert 0.0 in ends
    assert np.isclose(ends.max(), 60.0)


def test_the_curve_under_the_pen(network: ProductState) -> None:
    spot = seen_at(SHEET, splines_of(network)["d"].sampled(3))[1]
    found = curve_under(network, SHEET, np.add(spot, (3.0, 0.0)))
    assert found is not None
    assert found.curve == "d"
    assert curve_under(network, SHEET, (5.0, 5.0)) is None


@pytest.mark.parametrize(
    "change",
    [
        lambda s: modify(s, [one_stroke(np.array([(5.0, 5.0), (9.0, 9.0)]))]),
        lambda s: modify(s, []),
        lambda s: redraw_stretch(s, []),
        lambda s: split_curve(s, "a", [0.0, 1.0, 7.0]),
        lambda s: split_curve(s, "none", [0.5]),
        lambda s: join_curves(s, "a", 1.0, "a", 0.0),
        lambda s: move_joint(s, s.joints[0].id, (np.nan, 0.0, 0.0)),
        lambda s: move_joint(s, "none", (0.0, 0.0, 0.0)),
        lambda s: match_tangents(s, s.joints[0].id, "b", "d"),
        lambda s: fillet(s, s.joints[0].id, "a", "b", -1.0),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_said(network: ProductState, change: object) -> None:
    with pytest.raises(UserError):
        change(network)  # type: ignore[operator]


def test_a_joint_of_a_curve_across_the_plane_takes_its_image_along() -> None:
    """An arch over the plane stands on a rail and on its mirror image: one surface, one joint."""
    plane = Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    half = [(-30.0, 40.0, 0.0), (-30.0, 35.0, 30.0), (-30.0, 12.0, 45.0)]
    arch = Spline.uniform(np.array([*half, *(np.array(half) * (1.0, -1.0, 1.0))[::-1]]))
    front = Spline.uniform(np.add(arch.control_points, (60.0, 0.0, 0.0)))
    rail = Spline.uniform(np.linspace((-30.0, 40.0, 0.0), (30.0, 40.0, 0.0), 5))
    state = ProductState(
        symmetry=plane,
        nodes=(
            Curve(id="a", spline=arch),
            Curve(id="f", spline=front),
            Curve(id="r", spline=rail, mirrored=True),
        ),
        joints=(
            Joint("j1", (Meeting("a", 0.0), Meeting("r", 0.0))),
            Joint("j2", (Meeting("f", 0.0), Meeting("r", 1.0))),
        ),
    )
    state = with_patches_found(state)
    assert len(state.of_kind(Patch)) == 1
    moved = with_patches_found(move_joint(state, "j1", (-35.0, 50.0, 4.0)))
    (patch,) = moved.of_kind(Patch)
    net = net_of(moved.of_kind(Curve), moved.joints, moved.symmetry)
    assert loop_of(net, patch.boundary) is not None
    ends = splines_of(moved)["a"].control_points[[0, -1]]
    assert (ends == ((-35.0, 50.0, 4.0), (-35.0, -50.0, 4.0))).all()


@pytest.mark.parametrize("seed", [7001, 7002])
def test_a_curve_that_is_drawn_over_again_and_again_stays_light(seed: int) -> None:
    """Thirty strokes leave it about as many control points as ten do; its ends stay."""
    random = np.random.default_rng(seed)
    first = bow(np.array((-80.0, 10.0, -20.0)), np.array((80.0, -30.0, 30.0)), random)
    spline, counts = first, []
    for _ in range(30):
        spots = seen_at(SHEET, spline.sampled(201))
        low = int(random.integers(10, 80))
        piece = spots[low : low + 90]
        share = np.linspace(0.0, np.pi, len(piece))
        ink = piece + np.outer(np.sin(share) ** 2, random.normal(0.0, 20.0, 2))
        spline = drawn_over(spline, [one_stroke(ink)], held=(True, True))
        counts.append(len(spline.control_points))
    assert counts[9] <= 32
    assert counts[29] <= 48
    assert (spline.control_points[[0, -1]] == first.control_points[[0, -1]]).all()
