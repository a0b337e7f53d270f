"""Strokes of one view come to lie in the sides that they were drawn as."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_symmetry.ink.sides import gap_between, join_ends, merge_alongside, sides_of
from bozzetto_symmetry.ink.stroke_grouping import group_strokes
from bozzetto_symmetry.ink.stroke_line import smooth_line
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry.scenes import ACROSS, LOOPS, PAIRS, camera, drawn, tremor

Array = NDArray[np.float64]

VIEWS = [(10, 15), (30, 20), (60, 30), (-40, 25)]


def strokes(inks: Sequence[Array], view: Camera) -> list[Stroke]:
    return [Stroke(ink[:, 0], ink[:, 1], view) for ink in inks]


def scribbled(pixels: Array, count: int, random: np.random.Generator) -> list[Array]:
    """Strokes over one another: 3 px of tremor, 2 px beside, in any sense."""
    return [
        (pixels + tremor(len(pixels), 3.0, random) + 1.4 * random.standard_normal(2))[
            :: random.choice((1, -1))
        ]
        for _ in range(count)
    ]


def members(inks: Sequence[Array], view: Camera) -> list[tuple[int, ...]]:
    return [side.strokes for side in sides_of(strokes(inks, view))]


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("view", [*VIEWS, (85, 10)])
def test_two_strokes_drawn_apart_stay_two_sides(
    name: str, view: tuple[float, float], noise: float
) -> None:
    seen = camera(*view)
    inks = [drawn(curve, seen, noise=noise) for curve in (PAIRS[name], PAIRS[name] * MIRROR)]
    sides = sides_of(strokes(inks, seen))
    assert [side.strokes for side in sides] == [(0,), (1,)]
    for side, ink in zip(sides, inks, strict=True):
        assert distances_to_polyline(side.pixels, ink).max() < 0.15
        assert not side.closed
        assert side.sure


def test_scribbles_fall_into_sides() -> None:
    """Three strokes a side, left and right in any order and sense: at least nine in ten."""
    random = np.random.default_rng(1)
    right = []
    for curve in PAIRS.values():
        for view in VIEWS:
            seen = camera(*view)
            both = [drawn(c, seen) for c in (curve, curve * MIRROR)]
            inks = [ink for one in both for ink in scribbled(one, 3, random)]
            order = random.permutation(6)
            lines = [smooth_line(inks[k]).pixels for k in order]
            found = [tuple(group) for group in group_strokes(lines)]
            halves = [tuple(np.flatnonzero((order < 3) == first).tolist()) for first in (True, 0)]
            right.append(found == sorted(halves))
    assert np.mean(right) >= 0.9


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("view", VIEWS[1:3])
def test_consecutive_pieces_are_one_side(name: str, view: tuple[float, float]) -> None:
    seen = camera(*view)
    one, other = (drawn(curve, seen) for curve in (PAIRS[name], PAIRS[name] * MIRROR))
    sides = sides_of(strokes([one[:120], other[:200][::-1], one[119:], other[199:]], seen))
    assert [side.strokes for side in sides] == [(0, 2), (1, 3)]
    for side, ink in zip(sides, (one, other[::-1]), strict=True):
        assert distances_to_polyline(side.pixels, ink).max() < 0.15
        assert np.linalg.norm(side.pixels[0] - ink[0]) < 1e-3


def test_settled_sides_follow_the_ink_in_the_sense_of_the_first_stroke() -> None:
    random = np.random.default_rng(7)
    seen = camera(30, 20)
    true = drawn(PAIRS["roof rail"], seen)
    other = drawn(PAIRS["roof rail"] * MIRROR, seen)
    for sense in (1, -1):
        inks = [(true + tremor(300, 1.0, random))[::sense], *scribbled(true, 3, random), other]
        side = sides_of(strokes(inks, seen))[0]
        assert side.strokes == (0, 1, 2, 3)
        assert np.sqrt(np.mean(distances_to_polyline(side.pixels, true) ** 2)) < 3.0
        begin = true[::sense][0]
        assert np.linalg.norm(side.pixels[0] - begin) < np.linalg.norm(side.pixels[-1] - begin)
        assert 0.2 < side.noise < 3.0


@pytest.mark.parametrize("name", LOOPS)
def test_loops_in_pieces_close(name: str) -> None:
    seen = camera(45, 20)
    one, other = (drawn(curve, seen, closed=True) for curve in (LOOPS[name], LOOPS[name] * MIRROR))
    sides = sides_of(strokes([one[:151], one[150:], np.vstack((other, other[:1]))], seen))
    assert [side.strokes for side in sides] == [(0, 1), (2,)]
    assert all(side.closed for side in sides)


def test_a_scribbled_arch_stays_open() -> None:
    random = np.random.default_rng(3)
    seen = camera(45, 20)
    true = drawn(PAIRS["wheel arch"], seen)
    inks = [true + tremor(300, 1.0, random) for _ in range(4)]
    opened = [side.closed for side in sides_of(strokes([*inks, inks[0] + 150.0], seen))]
    assert not opened[0]


@pytest.mark.parametrize("name", ACROSS)
def test_halves_of_a_curve_across_can_be_joined(name: str) -> None:
    seen = camera(30, 20)
    whole = drawn(ACROSS[name], seen)
    for inks in ([whole[:300], whole[299:]], [whole[:300][::-1], whole[299:]]):
        sides = sides_of(strokes(inks, seen))
        assert len(sides) == 2
        one = join_ends(*sides)
        assert one is not None
        assert distances_to_polyline(one.pixels, whole).max() < 0.2
        assert gap_between(sides[0].pixels, sides[1].pixels)[0] < 1e-3


def test_sides_that_lie_apart_are_neither_joined_nor_settled() -> None:
    seen = camera(30, 20)
    curve = PAIRS["roof rail"]
    sides = sides_of(strokes([drawn(c, seen) for c in (curve, curve * MIRROR)], seen))
    assert join_ends(*sides) is None
    assert merge_alongside(*sides) is None


def test_a_side_drawn_twice_can_be_settled() -> None:
    random = np.random.default_rng(5)
    seen = camera(30, 20)
    true = drawn(PAIRS["S-wave"], seen)
    sides = sides_of(strokes(scribbled(true, 2, random), seen), apart=True)
    assert len(sides) == 2
    one = merge_alongside(*sides)
    assert one is not None
    off = [distances_to_polyline(side.pixels, true).mean() for side in (one, *sides)]
    assert off[0] < max(off[1:])
    assert one.strokes == (0, 1)


def test_lines_that_merely_cross_are_two_groups() -> None:
    along = np.linspace(-100.0, 100.0, 101)
    lines = [np.column_stack((along, share * along)) for share in (0.4, -0.4)]
    assert group_strokes(lines) == [[0], [1]]
    third = lines[0] + (0.0, 3.0)
    assert group_strokes([lines[0], lines[1], third]) == [[0, 2], [1]]


def test_order_of_drawing_decides_which_side_is_first() -> None:
    seen = camera(30, 20)
    one, other = (drawn(c, seen) for c in (PAIRS["hook"], PAIRS["hook"] * MIRROR))
    first, second = sides_of(strokes([one, other], seen)), sides_of(strokes([other, one], seen))
    np.testing.assert_array_equal(first[0].pixels, second[1].pixels)
    np.testing.assert_array_equal(first[1].pixels, second[0].pixels)


def test_dots_are_left_out_and_nothing_else_is_refused() -> None:
    seen = camera(30, 20)
    dot, curve = np.full((3, 2), 50.0), drawn(PAIRS["hook"], seen)
    assert members([dot, curve], seen) == [(1,)]
    with pytest.raises(UserError, match="dot"):
        sides_of(strokes([dot, dot], seen))


POINTS = arrays(
    np.float32,
    st.tuples(st.integers(1, 8), st.just(2)),
    elements=st.floats(-2000, 2000, width=32),
)


@settings(max_examples=25, deadline=None)
@given(st.lists(POINTS, min_size=1, max_size=4))
def test_any_strokes_give_sides_or_say_why_not(inks: list[Array]) -> None:
    try:
        sides = sides_of(strokes(inks, camera(30, 20)))
    except UserError:
        return
    assert 1 <= len(sides) <= 2
    numbers = [k for side in sides for k in side.strokes]
    assert len(numbers) == len(set(numbers))
    for side in sides:
        assert np.isfinite(side.pixels).all()
        assert side.noise >= 0.0
