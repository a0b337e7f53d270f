"""Loops found by themselves: on known networks, drawn ones, and while a network grows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto_product.loops.boundaries import boundary_of, loop_of
from bozzetto_product.loops.finding import FoundLoops, find_loops
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.network.cutting import net_of
from bozzetto_product.network.net import Loop, Net
from tests.plugins.product.drawn_networks import DRAWN, sheet
from tests.plugins.product.random_networks import cells, faulty, quilt, tube
from tests.plugins.product.sketched_network import PLANE, Score, Sketch, edge_set

Names = frozenset[frozenset[tuple[str, int, bool]]]


def _score(sketch: Sketch) -> Score:
    net = sketch.net()
    return Score.of(map(edge_set, find_loops(net).loops), sketch.truth(net, strict=False))


def _names(net: Net, loops: tuple[Loop, ...]) -> Names:
    pieces = [(each.curve, each.piece, each.mirrored) for each in net.edges]
    return frozenset(frozenset(pieces[edge] for edge, _ in loop) for loop in loops)


def _moved(curves: list[Curve], turn: np.ndarray, scale: float = 1.0) -> list[Curve]:
    return [
        replace(
            c,
            spline=Spline(
                c.spline.knots, scale * c.spline.control_points @ turn.T, c.spline.closed
            ),
        )
        for c in curves
        if c.spline
    ]


@pytest.mark.parametrize(("rows", "columns"), [(2, 2), (5, 5), (3, 8), (14, 14)])
def test_a_sheet_is_found_whole_and_its_rim_is_left_open(rows: int, columns: int) -> None:
    sketch = sheet(rows, columns)
    net = sketch.net()
    found = {edge_set(loop) for loop in find_loops(net).loops}
    assert found == set(sketch.truth(net))


def test_all_patches_of_the_utah_teapot_are_found() -> None:
    score = _score(DRAWN["teapot"]())
    assert score.right == score.meant == 32
    assert score.wrong == 0


@pytest.mark.parametrize("seed", [1001, 1002])
@pytest.mark.parametrize("make", [cells, quilt, tube])
def test_unseen_networks_are_found(make: Callable[[int], Sketch], seed: int) -> None:
    assert _score(make(seed)).f1 > 0.9


@pytest.mark.slow
def test_drawn_networks_and_their_faults_are_found_as_asked() -> None:
    scores = [_score(make()) for make in DRAWN.values()]
    for name, make in DRAWN.items():
        seed = 1000 + sum(map(ord, name))
        scores.append(_score(faulty(make(), seed, noise=0.01)))
        scores.append(_score(faulty(make(), seed, noise=0.01, missing=0.03, over=0.15)))
    assert np.median([each.f1 for each in scores]) >= 0.92
    assert sum(each.right for each in scores) >= 0.85 * sum(each.meant for each in scores)
    wrong = sum(each.wrong for each in scores)
    assert wrong <= 0.07 * (wrong + sum(each.right for each in scores))


@pytest.mark.parametrize("name", ["mouse", "car", "sheet"])
def test_the_same_loops_turned_and_a_thousand_times_larger(name: str) -> None:
    curves, joints = DRAWN[name]().built()
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    plain = [replace(each, mirrored=False) for each in curves]
    plane = replace(PLANE, point=(0.0, 1e5, 0.0))
    large = replace(PLANE, point=(0.0, 1e8, 0.0))
    net = net_of(plain, joints, plane)
    moved = net_of(_moved(plain, turn, 1000.0), joints, large)
    assert _names(net, find_loops(net).loops) == _names(moved, find_loops(moved).loops)


@pytest.mark.parametrize("name", ["mouse", "helmet", "iron"])
def test_the_same_loops_in_any_order_and_twice(name: str) -> None:
    curves, joints = DRAWN[name]().built()
    net = net_of(curves, joints, PLANE)
    found = find_loops(net)
    assert find_loops(net).loops == found.loops
    random = np.random.default_rng(8)
    order = random.permutation(len(curves))
    other = net_of([curves[k] for k in order], joints[::-1], PLANE)
    assert _names(net, found.loops) == _names(other, find_loops(other).loops)


@pytest.mark.parametrize("name", sorted(DRAWN))
def test_laws_of_every_answer(name: str) -> None:
    net = DRAWN[name]().net()
    found = find_loops(net)
    _check(net, found)
    sets = {edge_set(loop) for loop in found.loops}
    use = np.bincount([edge for loop in found.loops for edge, _ in loop], minlength=len(net.edges))
    assert use.max() <= 2
    for each in sets:
        if all(net.edges[edge].twin >= 0 for edge in each):
            assert frozenset(net.edges[edge].twin for edge in each) in sets


def _check(net: Net, found: FoundLoops) -> None:
    assert len({edge_set(loop) for loop in found.loops}) == len(found.loops)
    assert len(found.costs) == len(found.likely_open) == len(found.loops)
    assert np.isfinite(found.costs).all()
    assert np.isfinite(found.candidate_costs).all()
    for loop in found.candidates:
        edges = [(net.edges[e], on) for e, on in loop]
        ends = [(e.start, e.end) if on else (e.end, e.start) for e, on in edges]
        assert all(a[1] == b[0] for a, b in zip(ends, ends[1:] + ends[:1], strict=True))


@pytest.mark.parametrize("seed", [11, 12])
@pytest.mark.parametrize("name", ["mouse", "chair", "sandal"])
def test_what_is_confirmed_never_changes_while_the_network_grows(name: str, seed: int) -> None:
    curves, joints = DRAWN[name]().built()
    order = np.random.default_rng(seed).permutation(len(curves))
    kept: list[tuple] = []
    for count in range(len(curves) // 2, len(curves) + 1):
        here = [curves[k] for k in sorted(order[:count])]
        net = net_of(here, joints, PLANE)
        fixed = [loop_of(net, boundary) for boundary in kept]
        assert None not in fixed
        found = find_loops(net, fixed=[each for each in fixed if each])
        assert list(found.loops[: len(fixed)]) == fixed
        kept = [boundary_of(net, loop) for loop in found.loops]


@pytest.mark.parametrize("name", ["mouse", "vase"])
def test_what_is_rejected_does_not_come_back(name: str) -> None:
    net = DRAWN[name]().net()
    rejected = list(find_loops(net).loops[::3])
    for _ in range(3):
        found = find_loops(net, rejected=rejected)
        sets = {edge_set(loop) for loop in found.loops}
        assert not sets & {edge_set(loop) for loop in rejected}
        assert {edge_set(loop) for loop in rejected} <= {
            edge_set(loop) for loop in found.candidates
        }
        rejected += found.loops[:2]


def test_a_loop_that_is_fixed_takes_the_room_of_others() -> None:
    net = DRAWN["sheet"]().net()
    found = find_loops(net)
    chosen = {edge_set(loop) for loop in found.loops}
    other = next(loop for loop in found.candidates if edge_set(loop) not in chosen)
    again = find_loops(net, fixed=[other, found.loops[0]])
    assert again.loops[:2] == (other, found.loops[0])
    assert again.likely_open[:2] == (False, False)


def test_the_mouth_of_a_bottle_is_told_and_a_button_is_not() -> None:
    bottle = DRAWN["bottle"]()
    net = bottle.net()
    found = find_loops(net)
    marked = [
        edge_set(loop) for loop, open_ in zip(found.loops, found.likely_open, strict=True) if open_
    ]
    assert len(marked) == 2
    heights = [{float(net.nodes[net.edges[edge].start, 2]) for edge in each} for each in marked]
    assert sorted(map(list, heights)) == [[0.0], [165.0]]
    remote = find_loops(DRAWN["remote"]().net())
    assert not any(
        told for loop, told in zip(remote.loops, remote.likely_open, strict=True) if len(loop) == 1
    )


def test_one_two_and_no_curves() -> None:
    ring = Spline.uniform([(5, 1, 0), (5, 0, 1), (5, -1, 0), (5, 0, -1)], closed=True)
    alone = net_of([Curve("ring", spline=ring)], [], PLANE)
    assert find_loops(alone).loops == (((0, True),),)
    line = net_of(
        [Curve("line", spline=Spline.uniform([(0, 0, 0), (1, 0, 0), (2, 1, 0), (3, 0, 0)]))],
        [],
        PLANE,
    )
    assert find_loops(line).loops == ()
    assert find_loops(net_of([], [], PLANE)).loops == ()
    lens = Sketch()
    lens.node(a=(0, 0, 0), b=(10, 0, 0))
    lens.curve("a", (5, 2, 0), "b")
    lens.curve("a", (5, -2, 1), "b")
    assert len(find_loops(lens.net()).loops) == 1


def test_a_step_may_stop_the_search() -> None:
    def stop() -> None:
        raise TimeoutError

    with pytest.raises(TimeoutError):
        find_loops(DRAWN["sheet"]().net(), checkpoint=stop)


def test_whatever_is_drawn_gives_an_answer() -> None:
    random = np.random.default_rng(4)
    for _ in range(12):
        curves = [
            Curve(
                f"c{k}",
                spline=Spline.uniform(random.normal(size=(4, 3)).round(0), closed=bool(k % 2)),
            )
            for k in range(9)
        ]
        curves = [each for each in curves if each.spline]
        joints = [
            Joint(f"j{k}", tuple(_meeting(random) for _ in range(int(random.integers(1, 4)))))
            for k in range(12)
        ]
        net = net_of(curves, joints, PLANE)
        assert np.isfinite(net.nodes).all()
        _check(net, find_loops(net))


def _meeting(random: np.random.Generator) -> Meeting:
    at = float(random.choice([0, 0.3, 0.5, 1]))
    return Meeting(f"c{random.integers(10)}", at, bool(random.integers(2)))


def test_no_loop_closes_a_flat_sheet_unless_it_is_fixed() -> None:
    """Two surfaces in a plane and the loop round both would be a body without inside."""
    s = Sketch()
    s.node(a=(0, 0, 0), b=(60, 0, 0), c=(60, 40, 0), d=(0, 40, 0), e=(30, 0, 0), f=(30, 40, 0))
    for way in ("a e", "e b", "b c", "c f", "f d", "d a", "e f"):
        s.curve(way)
    net = s.net()
    found = {edge_set(loop) for loop in find_loops(net).loops}
    assert found == {frozenset((0, 6, 4, 5)), frozenset((1, 2, 3, 6))}
    rim: Loop = tuple((edge, True) for edge in range(6))
    assert edge_set(find_loops(net, fixed=[rim]).loops[0]) == frozenset(range(6))


@pytest.mark.parametrize("height", [2.0, 4.0, 6.0])
def test_a_curve_across_an_area_of_a_round_shape_makes_two_of_it(height) -> None:
    """The loop round both would close them to a body of less than a tenth of its width."""
    s = Sketch()
    s.node(a=(0, 0, 0), b=(80, 0, 0), c=(80, 80, 0), d=(0, 80, 0), e=(40, 0, 0), f=(40, 80, 0))
    for way in ("a e", "e b", "b c", "c f", "f d", "d a"):
        s.curve(way)
    s.curve("e", (40, 40, height), "f")
    found = {edge_set(loop) for loop in find_loops(s.net()).loops}
    assert found == {frozenset((0, 6, 4, 5)), frozenset((1, 2, 3, 6))}


def test_what_is_higher_than_a_tenth_of_its_width_gets_its_bottom() -> None:
    s = Sketch()
    s.node(a=(0, 0, 0), b=(80, 0, 0), c=(80, 80, 0), d=(0, 80, 0), e=(40, 0, 0), f=(40, 80, 0))
    for way in ("a e", "e b", "b c", "c f", "f d", "d a"):
        s.curve(way)
    s.curve("e", (40, 40, 30), "f")
    assert len(find_loops(s.net()).loops) == 3


BOX = {
    name: np.array(place, float)
    for name, place in {
        "a": (0, 0, 0),
        "b": (3, 0, 0),
        "c": (3, 2, 0),
        "d": (0, 2, 0),
        "e": (0, 0, 1),
        "f": (3, 0, 1),
        "g": (3, 2, 1),
        "h": (0, 2, 1),
    }.items()
}


def _sides_of_a_box(*sides: str, bow: float) -> Sketch:
    """Return sides of a box, each four names, with edges that bow outward."""
    sketch, drawn = Sketch(), set()
    sketch.node(**{name: BOX[name] for name in sorted(set("".join(sides)))})
    middle = np.mean(list(BOX.values()), axis=0)
    for side in sides:
        for one, other in zip(side, side[1:] + side[0], strict=True):
            if frozenset(one + other) not in drawn:
                drawn.add(frozenset(one + other))
                half = 0.5 * (BOX[one] + BOX[other])
                sketch.curve(one, half + bow * (half - middle), other)
        sketch.face(" ".join(side))
    return sketch


@pytest.mark.parametrize("bow", [0.0, 0.1, 0.4])
@pytest.mark.parametrize(
    "sides",
    [
        ("abcd", "abfe"),
        ("abcd", "abfe", "bcgf"),
        ("abcd", "abfe", "bcgf", "cdhg"),
        ("abfe", "bcgf", "cdhg", "daeh", "efgh"),
    ],
    ids=["two", "three", "four", "five"],
)
def test_a_box_that_is_half_drawn_is_not_closed(sides: tuple[str, ...], bow: float) -> None:
    """What is there is found at once; a sixth side that five leave is a box's, and is closed."""
    sketch = _sides_of_a_box(*sides, bow=bow)
    net = sketch.net()
    found = {edge_set(loop) for loop in find_loops(net).loops}
    truth = set(sketch.truth(net))
    assert truth <= found
    extra = sorted(len(each) for each in found - truth)
    assert extra == ([4] if len(sides) == 5 else [])


def test_the_two_sides_of_a_cushion_in_halves_are_a_body() -> None:
    """Its corners have two edges each, but the halves that meet there are one over the other."""
    sketch = Sketch()
    sketch.node(a=(-2, -1, 0), b=(0, -1, 0), c=(2, -1, 0), d=(2, 1, 0), e=(0, 1, 0), f=(-2, 1, 0))
    for one, other in ("ab", "bc", "cd", "de", "ef", "fa"):
        sketch.curve(one, other)
    sketch.curve("b", (0, 0, 0.7), "e", name="above")
    sketch.curve("b", (0, 0, -0.7), "e", name="below")
    loops = find_loops(sketch.net()).loops
    assert len({edge_set(loop) for loop in loops}) == 4


@pytest.mark.parametrize("thickness", [0.2, 1.0, 30.0])
@pytest.mark.parametrize("bow", [0.0, 8.0])
def test_a_plate_is_a_body_however_thin(thickness: float, bow: float) -> None:
    """Walls stand all round it, flat or bent; a sheet that is divided has none."""
    sketch = Sketch()
    sketch.node(a=(0, 0, 0), b=(100, 0, 0), c=(100, 60, 0), d=(0, 60, 0))
    up = (0, 0, thickness)
    for low, high in zip("abcd", "efgh", strict=True):
        sketch.node(**{high: np.add(sketch.nodes[low], up)})
    for row in ("abcd", "efgh"):
        for first, last in zip(row, row[1:] + row[0], strict=True):
            middle = 0.5 * np.add(sketch.nodes[first], sketch.nodes[last])
            over = (0, 0, bow if abs(sketch.nodes[first][0] - sketch.nodes[last][0]) > 50 else 0)
            sketch.curve(first, middle + over, last)
    for pair in ("a e", "b f", "c g", "d h"):
        sketch.curve(pair)
    net = sketch.net()
    counts = [sum(edge in edge_set(loop) for loop in find_loops(net).loops) for edge in range(12)]
    assert counts == [2] * 12
    assert len(find_loops(net).loops) == 6
