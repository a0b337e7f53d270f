"""Trim: what nearly meets is joined, exactly, whatever the order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.cutting import net_of
from bozzetto_product.operations.curve_edits import move_joint
from bozzetto_product.operations.end_moves import moved_to_ends, similar
from bozzetto_product.operations.magnets import near_misses
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.operations.pieces import delete_curves
from bozzetto_product.operations.proposals import accept
from bozzetto_product.operations.trim import trim
from tests.plugins.product.drawn_curves import (
    MIRROR,
    SHEET,
    bow,
    grid_network,
    largest_move,
    misses,
    scaled,
    with_mirror,
)


def _curves(*splines: Spline, mirrored: bool = False) -> ProductState:
    return ProductState(
        nodes=tuple(
            Curve(id=f"c{k}", spline=spline, mirrored=mirrored) for k, spline in enumerate(splines)
        )
    )


def _line(start: tuple[float, ...], end: tuple[float, ...]) -> Spline:
    share = np.linspace(0.0, 1.0, 7)[:, None]
    return Spline.uniform(np.array(start) + share * np.subtract(end, start))


def _same(one: ProductState, other: ProductState) -> bool:
    mine, theirs = splines_of(one), splines_of(other)
    return mine.keys() == theirs.keys() and all(
        (mine[name].control_points == theirs[name].control_points).all() for name in mine
    )


@pytest.mark.parametrize("seed", [4000, 4001])
def test_a_sheet_whose_ends_miss_gets_every_corner_exactly(seed: int) -> None:
    state, corners = grid_network(seed, 1.0)
    done = trim(state, gap=2.5)
    assert len(done.state.joints) == len(corners) == len(done.joined)
    assert misses(done.state) == 0.0
    assert not done.proposals
    places = [splines_of(done.state)[j.meetings[0].curve] for j in done.state.joints]
    assert all(np.isfinite(place.control_points).all() for place in places)
    # No end goes farther than the gap.
    assert max(largest_move(state, done.state).values()) <= 2.5


def test_the_order_of_curves_does_not_matter() -> None:
    state, _ = grid_network(4002, 1.0)
    mixed = replace(state, nodes=tuple(np.random.default_rng(0).permutation(state.nodes)))
    assert _same(trim(state, gap=2.5).state, trim(mixed, gap=2.5).state)


def test_trimming_twice_changes_nothing() -> None:
    state, _ = grid_network(4003, 1.0)
    once = trim(state, gap=2.5).state
    again = trim(once, gap=2.5)
    assert again.state is once
    assert not again.joined


def test_a_network_and_its_mirror_image_are_trimmed_alike() -> None:
    state = with_mirror(grid_network(4004, 1.0)[0])
    one = splines_of(trim(state, gap=2.5).state)
    other = splines_of(trim(scaled(state, lambda x: x * MIRROR), gap=2.5).state)
    for name, spline in one.items():
        assert (spline.control_points * MIRROR == other[name].control_points).all()


def test_a_thousand_times_as_large_is_the_same_network() -> None:
    state, _ = grid_network(4005, 1.0)
    small = trim(state, gap=2.5).state
    large = trim(scaled(state, lambda x: 1000.0 * x), gap=2500.0).state
    for name, spline in splines_of(small).items():
        off = splines_of(large)[name].control_points / 1000.0 - spline.control_points
        assert np.abs(off).max() <= 1e-10
    assert [j.meetings for j in small.joints] == [j.meetings for j in large.joints]


def test_the_old_state_is_untouched() -> None:
    state, _ = grid_network(4006, 1.0)
    before = {name: spline.control_points.copy() for name, spline in splines_of(state).items()}
    trim(state, gap=2.5)
    assert all(
        (splines_of(state)[name].control_points == old).all() for name, old in before.items()
    )


def test_the_similarity_rolls_least() -> None:
    """It keeps the shape, and no other roll about the chord is nearer."""
    from scipy.spatial.transform import Rotation

    random = np.random.default_rng(4007)
    for _ in range(50):
        points = np.cumsum(random.normal(size=(7, 3)), axis=0)
        chord = np.linalg.norm(points[-1] - points[0])
        ends = points[[0, -1]] + 0.05 * chord * random.normal(size=(2, 3))
        made = similar(points, *ends)
        assert made is not None
        assert (made[[0, -1]] == ends).all()
        scale = np.linalg.norm(ends[1] - ends[0]) / chord
        before = np.linalg.norm(points[:, None] - points, axis=2)
        after = np.linalg.norm(made[:, None] - made, axis=2)
        assert np.allclose(after, scale * before, atol=1e-12 * chord)
        axis = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        least = ((made - points) ** 2).sum()
        for angle in np.linspace(-3.0, 3.0, 13):
            turn = Rotation.from_rotvec(angle * axis)
            other = ends[0] + turn.apply(made - ends[0])
            assert ((other - points) ** 2).sum() >= least - 1e-9 * chord**2


def test_a_curve_that_nearly_closes_is_bent_and_hardly_moves() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi - 0.03, 30)
    spline = Spline.uniform(50.0 * np.column_stack((np.cos(turn), np.sin(turn), 0.0 * turn)))
    gap = float(np.linalg.norm(spline.control_points[-1] - spline.control_points[0]))
    state = _curves(spline)
    done = trim(state, gap=2.0 * gap)
    (joint,) = done.state.joints
    assert len(joint.meetings) == 2
    assert misses(done.state) == 0.0
    assert max(largest_move(state, done.state).values()) <= 3.0 * gap
    far = moved_to_ends(spline, spline.control_points[0], spline.control_points[-1] + (0, 0, gap))
    assert np.linalg.norm(far.sampled(100) - spline.sampled(100), axis=1).max() <= 3.0 * gap


def test_an_end_inside_a_curve_is_carried_by_it() -> None:
    host = bow(np.array((-50.0, 0.0, 0.0)), np.array((50.0, 0.0, 0.0)), np.random.default_rng(1))
    foot = host.value([0.4])[0]
    state = trim(_curves(host, _line((*(foot + 0.4),), (0.0, 60.0, 60.0))), gap=2.0).state
    (joint,) = state.joints
    assert sorted(meet.curve for meet in joint.meetings) == ["c0", "c1"]
    assert misses(state) == 0.0
    assert (splines_of(state)["c0"].control_points == host.control_points).all()
    joined = trim(state.with_node(Curve(id="e", spline=_line((50.8, 0.3, 0), (90, 9, 9)))), gap=2.0)
    corner = next(j for j in joined.state.joints if any(m.curve == "e" for m in j.meetings))
    moved = move_joint(joined.state, corner.id, (60.0, 5.0, -10.0))
    assert misses(moved) == 0.0
    before, after = splines_of(joined.state)["c1"], splines_of(moved)["c1"]
    assert not np.allclose(before.control_points[0], after.control_points[0], atol=1e-3)


def test_an_end_near_the_mirror_plane_ends_in_it() -> None:
    state = trim(_curves(_line((0, 0.4, 0), (40, 30, 10)), mirrored=True), gap=1.0).state
    (joint,) = state.joints
    assert joint.in_plane
    assert splines_of(state)["c0"].control_points[0, 1] == 0.0


def _ring() -> Spline:
    turn = 2.0 * np.pi * (np.arange(12) + 0.3) / 12.0
    places = np.stack((40.0 * np.cos(turn), 30.0 * np.sin(turn) + 2.0, 0.0 * turn), axis=1)
    return Spline.uniform(places, closed=True)


def test_a_plane_without_mirror_images_is_a_plane_like_any_other() -> None:
    """A post that stands in the symmetry plane by chance is joined to what does not cross it."""
    beside = _curves(_line((0, 0, 0), (0, 0, 30)), _line((-20, 0.4, 0), (20, 0.3, 0.1)))
    done = trim(beside, gap=1.0).state
    (joint,) = done.joints
    assert not joint.in_plane
    assert misses(done) <= 1e-12


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_end_in_the_plane_is_joined_where_a_curve_crosses_it(mirror: bool, side: float) -> None:
    place = _ring().sampled(40001)
    place = place[np.argmin(np.abs(place[:, 1]) - side * place[:, 0])]
    state = _curves(_ring(), _line((place[0] + 0.5, 0.0, 0.3), (place[0], 0.0, 30.0)))
    done = trim(replace(state, mirror=mirror), gap=1.5).state
    (joint,) = done.joints
    assert {meet.curve for meet in joint.meetings} == {"c0", "c1"}
    assert misses(done) <= 1e-12
    end = splines_of(done)["c1"].control_points[0]
    assert np.linalg.norm(end - place) < (1e-3 if mirror else 0.6)
    assert joint.in_plane is mirror
    assert not mirror or end[1] == 0.0
    net = net_of(done.of_kind(Curve), done.joints, done.symmetry)
    assert [edge.start for edge in net.edges if edge.curve == "c0"] == [
        edge.start for edge in net.edges if edge.curve == "c1"
    ]


@pytest.mark.parametrize("past", [0.9, 1.4, 1.9])
def test_a_tail_past_a_joint_is_not_joined_to_it_by_a_later_curve(past: float) -> None:
    """A short curve does not reach the end of the tail; a long one that comes later does."""
    crossed = _line((0, 0, -past), (0, 0, 80))
    short = _line((0.2, 0, 0), (3.0, 0, 0))
    state = trim(_curves(crossed, short), gap=2.5).state
    (first,) = state.joints
    assert len(first.meetings) == 2
    later = Curve(id="later", spline=_line((0.3, 0.2, 0.1), (0, 70, 0)))
    done = trim(state.with_node(later), gap=2.5)
    (joint,) = done.state.joints
    assert sorted(meet.curve for meet in joint.meetings) == ["c0", "c1", "later"]
    assert misses(done.state) <= 1e-12
    assert max(largest_move(state, done.state).values()) <= 1e-9
    assert not done.proposals


def test_the_mirror_image_of_an_end_is_met() -> None:
    """A curve across the plane without an image meets a curve and its mirror image."""
    state = _curves(_line((0, -30.2, 0), (0, 30.1, 0)))
    side = Curve(id="s", spline=_line((0, 29.8, 0.2), (50, 30, 5)), mirrored=True)
    done = trim(state.with_node(side), gap=1.0).state
    assert len(done.joints) == 2
    assert misses(done) == 0.0
    met = {(meet.curve, meet.at, meet.mirrored) for joint in done.joints for meet in joint.meetings}
    assert met == {("c0", 0.0, False), ("c0", 1.0, False), ("s", 0.0, False), ("s", 0.0, True)}


def test_wide_gaps_are_proposed_and_done_when_accepted() -> None:
    state = _curves(_line((0, 0, 0), (40, 0, 0)), _line((42, 1, 0), (60, 40, 0)))
    asked = trim(state, gap=1.0)
    assert asked.state is state
    assert len(asked.proposals) == 1
    assert np.isclose(asked.proposals[0].distance, np.sqrt(5.0))
    done = accept(state, asked.proposals[0])
    assert len(done.joints) == 1
    assert misses(done) == 0.0
    assert accept(done, asked.proposals[0]) is done


def test_a_new_curve_comes_to_a_joint_that_stays() -> None:
    state = trim(
        _curves(_line((0, 5, 0), (40, 5, 0)), _line((40.5, 5, 0), (60, 40, 0))), gap=1.0
    ).state
    place = splines_of(state)["c0"].control_points[-1].copy()
    grown = trim(state.with_node(Curve(id="n", spline=_line((40, 5.6, 0.3), (40, 9, 50)))), gap=1.0)
    (joint,) = grown.state.joints
    assert len(joint.meetings) == 3
    assert (splines_of(grown.state)["n"].control_points[0] == place).all()
    assert misses(grown.state) == 0.0
    left = delete_curves(grown.state, "c0", "n")
    assert not left.joints


def test_offers_tell_what_nearly_meets_in_a_view() -> None:
    state = _curves(_line((0, 0, 0), (40, 0, 0)), _line((41, 0, 1), (60, 0, 40)))
    near = near_misses(state, SHEET, tolerance=12.0)
    assert {miss.proposal.meetings[0].curve for miss in near} == {"c0", "c1"}
    assert all(0.0 < miss.pixels <= 12.0 for miss in near)
    assert not near_misses(trim(state, gap=2.0).state, SHEET, tolerance=12.0)
    assert not near_misses(ProductState(), SHEET, tolerance=12.0)


def test_curves_that_cross_are_joined_where_they_cross() -> None:
    """Three lines over three others, which pass them at half a millimetre, make nine joints."""
    over = [_line((x, -40, 0.3), (x, 40, 0.3)) for x in (-20, 1, 22)]
    under = [_line((-40, y, -0.2), (40, y, -0.2)) for y in (-21, 2, 19)]
    state = _curves(*over, *under)
    done = trim(state, gap=1.0)
    assert len(done.state.joints) == 9
    assert misses(done.state) <= 1e-12
    assert max(largest_move(state, done.state).values()) <= 0.5
    net = net_of(done.state.of_kind(Curve), done.state.joints, done.state.symmetry)
    assert len(net.edges) == 24
    assert trim(done.state, gap=1.0).state is done.state
    mixed = replace(state, nodes=state.nodes[::-1])
    assert _same(trim(mixed, gap=1.0).state, done.state)


def test_curves_that_run_along_one_another_do_not_cross() -> None:
    state = _curves(_line((-40, 0, 0), (40, 0.2, 0)), _line((-30, 0.2, 0.1), (60, 0, 0)))
    assert not [j for j in trim(state, gap=0.05).state.joints if len(j.meetings) > 1]


def test_a_curve_crosses_the_mirror_image_of_another() -> None:
    state = _curves(_line((-20, 5, 0), (40, 40, 0)))
    side = Curve(id="s", spline=_line((0, -5, 0.1), (10, -40, -0.1)), mirrored=True)
    done = trim(state.with_node(side), gap=1.0).state
    (joint,) = done.joints
    assert {(meet.curve, meet.mirrored) for meet in joint.meetings} == {("c0", False), ("s", True)}
    assert misses(done) <= 1e-12


def test_a_curve_without_length_is_left_alone() -> None:
    state = _curves(Spline.uniform(np.zeros((7, 3))), Spline.uniform(np.zeros((7, 3))))
    assert all(miss.pixels == 0.0 for miss in near_misses(state, SHEET, tolerance=12.0))
    assert misses(trim(state, gap=1.0).state) == 0.0


@pytest.mark.parametrize("gap", [0.0, -1.0, np.nan, np.inf])
def test_a_gap_that_is_none_joins_nothing(gap: float) -> None:
    state, _ = grid_network(4008, 1.0, cells=1)
    assert trim(state, gap=gap).state is state
    assert trim(ProductState(), gap=1.0).state.nodes == ()


def _meets_plane(degrees: float) -> tuple[Spline, Spline]:
    """A curve that ends a little before the plane, so far off its normal: before and after."""
    slope = np.tan(np.radians(degrees))
    y = -np.linspace(40.0, 0.3, 9)
    before = Spline.uniform(np.column_stack((slope * y, y, 10.0 - y * y / 200.0)))
    (after,) = splines_of(trim(_curves(before, mirrored=True), gap=1.0).state).values()
    return before, after


@pytest.mark.parametrize("degrees", [0.0, 4.0, 11.0])
def test_an_end_nearly_square_to_the_plane_runs_on_into_its_image(degrees: float) -> None:
    before, after = _meets_plane(degrees)
    last, beside = after.control_points[-1], after.control_points[-2]
    assert last[1] == 0.0
    assert (beside[[0, 2]] == last[[0, 2]]).all()
    # Elsewhere it stays where it was drawn.
    share = np.linspace(0.0, 1.0, 60)
    moved = np.linalg.norm(after.value(share) - before.value(share), axis=1)
    assert moved[:30].max() < 0.4
    assert moved.max() < 1.0


def test_an_end_in_the_plane_stays_square_while_the_other_end_is_joined() -> None:
    """What brings the other end to a joint turns the whole curve by some degrees."""
    _, first = _meets_plane(4.0)
    ends = first.control_points[0] + np.array([(1.2, -0.3, 0.8), (30.0, -50.0, 8.0)])
    other = _line(*map(tuple, ends))
    state = trim(_curves(first, mirrored=True), gap=1.0).state
    state = state.with_node(Curve(id="late", spline=other, mirrored=True))
    done = trim(state, gap=2.0, only={"late"}).state
    assert len(done.joints) == 2
    after = splines_of(done)["c0"]
    assert not np.array_equal(after.control_points, splines_of(state)["c0"].control_points)
    last, beside = after.control_points[-1], after.control_points[-2]
    assert last[1] == 0.0
    assert (beside[[0, 2]] == last[[0, 2]]).all()


def test_an_end_that_comes_to_the_plane_at_an_angle_keeps_it() -> None:
    _, after = _meets_plane(30.0)
    way = after.control_points[-1] - after.control_points[-2]
    assert np.degrees(np.arctan2(abs(way[0]), abs(way[1]))) == pytest.approx(30.0, abs=2.0)


def test_a_curve_without_an_image_keeps_its_direction_at_the_plane() -> None:
    before, _ = _meets_plane(11.0)
    state = _curves(before, mirrored=False)
    assert _same(trim(state, gap=1.0).state, state)


def _fork(*degrees: float, gap: float = 0.4) -> ProductState:
    """A line along x to the origin, and lines on from beside it, turned from x by some degrees."""
    lines = [_line((-60.0, 0.0, 0.0), (0.0, 0.0, 0.0))]
    for k, turn in enumerate(np.radians(degrees)):
        start = np.array((gap, 0.1 * k, 0.0))
        way = np.array((np.cos(turn), 0.0, np.sin(turn)))
        lines.append(_line(tuple(start), tuple(start + 50.0 * way)))
    return _curves(*lines)


def _kink(state: ProductState, one: str, other: str) -> float:
    """Angle between the end of a curve and the start of another, degrees."""
    splines = splines_of(state)
    ways = splines[one].derivative(np.ones(1))[0], splines[other].derivative(np.zeros(1))[0]
    first, second = (way / np.linalg.norm(way) for way in ways)
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second)))


@pytest.mark.parametrize("degrees", [0.5, 7.0, 9.5])
def test_a_curve_that_goes_on_where_another_ends_runs_on_without_a_kink(degrees: float) -> None:
    state = _fork(degrees)
    done = trim(state, gap=1.0).state
    assert len(done.joints) == 1
    assert _kink(state, "c0", "c1") == pytest.approx(degrees, abs=1e-9)
    assert _kink(done, "c0", "c1") < 1e-6
    assert max(largest_move(state, done).values()) < 1.5
    assert trim(done, gap=1.0).state is done
    mixed = replace(state, nodes=state.nodes[::-1])
    assert _same(trim(mixed, gap=1.0).state, done)


def _kinked_ring(degrees: float) -> ProductState:
    """Most of a circle in one curve that ends where it begins, but for a gap, with a kink there."""
    turn = np.linspace(0.0, 2.0 * np.pi - 0.01, 15)
    points = 50.0 * np.column_stack((np.cos(turn), np.sin(turn), np.zeros(15)))
    spline = Spline.uniform(points)
    points = np.array(spline.control_points)
    back, bend = points[1] - points[0], np.radians(degrees)
    reach = np.linalg.norm(back)
    points[-2] = points[-1] - reach * np.array((0.0, np.cos(bend), np.sin(bend)))
    points[1] = points[0] + reach * np.array((0.0, 1.0, 0.0))
    return _curves(Spline(spline.knots, points))


@pytest.mark.parametrize("degrees", [1.0, 5.0, 9.0])
def test_a_ring_drawn_as_one_curve_has_no_kink_where_it_ends(degrees: float) -> None:
    state = _kinked_ring(degrees)
    done = trim(state, gap=2.0).state
    assert len(done.joints) == 1
    assert _kink(state, "c0", "c0") == pytest.approx(degrees, abs=0.5)
    assert _kink(done, "c0", "c0") < 1e-6
    assert max(largest_move(state, done).values()) < 2.0
    assert trim(done, gap=2.0).state is done


@pytest.mark.parametrize("degrees", [14.0, 60.0])
def test_a_ring_with_a_corner_keeps_it(degrees: float) -> None:
    state = _kinked_ring(degrees)
    done = trim(state, gap=2.0).state
    assert _kink(done, "c0", "c0") == pytest.approx(_kink(state, "c0", "c0"), abs=1.0)


@pytest.mark.parametrize("degrees", [(14.0,), (170.0,), (3.0, -6.0)])
def test_a_kink_that_is_meant_and_a_fork_stay(degrees: tuple[float, ...]) -> None:
    """Of two curves that both go on where one ends, neither is meant more."""
    state = _fork(*degrees)
    done = trim(state, gap=1.0).state
    assert len(done.joints) == 1
    for number, turn in enumerate(degrees, 1):
        assert _kink(done, "c0", f"c{number}") == pytest.approx(abs(turn), abs=0.6)


def test_a_curve_in_a_plane_keeps_its_direction_and_the_other_gives_way() -> None:
    state = _fork(7.0)
    first = state.of_kind(Curve)[0]
    flat = state.with_node(replace(first, plane=Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))))
    done = trim(flat, gap=1.0).state
    assert _kink(done, "c0", "c1") < 1e-6
    assert np.abs(splines_of(done)["c0"].control_points[:, 2]).max() < 1e-9
