"""Ink to rings: laws, joints, and what is refused and how."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_silhouette.ink.jitter_filter import filtered, noise_of
from bozzetto_silhouette.outline.outline import outline_from_rings, outline_from_strokes
from tests.plugins.silhouette import outlines as o


@pytest.mark.parametrize("name", ["heart", "key", "spider", "dice-five", "spiral", "life-ring"])
def test_exact_polygons_pass_unchanged(name: str) -> None:
    rings = o.svg_rings(o.COMMITTED / f"{name}.svg")
    drawn, exact = outline_from_strokes(rings, by_hand=False), outline_from_rings(rings)
    assert (drawn.components, drawn.genus) == (exact.components, exact.genus)
    assert o.iou(drawn, exact) > 0.9999


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r[::-1],
        lambda r: np.roll(r, len(r) // 3, axis=0),
        lambda r: np.vstack([r, r[:1]]),
        lambda r: np.repeat(r, 3, axis=0),
        lambda r: r * 1e-3,
        lambda r: r * 1e3 + 5e4,
        lambda r: o.dense(r, 0.1),
    ],
    ids=["reversed", "other start", "closed", "duplicates", "tiny", "far away", "dense"],
)
def test_the_way_it_is_sampled_does_not_matter(change) -> None:
    rings = o.svg_rings(o.COMMITTED / "key.svg")
    drawn = outline_from_strokes([change(r) for r in rings])
    wanted = outline_from_rings([change(r) for r in rings])
    assert drawn.genus == 1
    assert o.iou(drawn, wanted) > 0.999


def test_rings_nest_by_the_even_odd_rule() -> None:
    rings = [o.circle(0, 0, r) for r in (20, 50, 30, 40)] + [o.circle(200, 0, 10)]
    nested = outline_from_rings(rings)
    assert nested.components == 3
    assert nested.genus == 2
    areas = np.pi * np.array([50**2 - 40**2 + 30**2 - 20**2 + 10**2])
    assert nested.area == pytest.approx(areas.sum(), rel=2e-3)
    assert nested.polygon().is_valid


def _arc(begin: float, end: float, radius: float = 100.0) -> np.ndarray:
    angle = np.linspace(begin, end, 200) * 2 * np.pi
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize(
    "strokes",
    [
        [_arc(0.0, 0.96)],
        [_arc(0.0, 1.03)],
        [_arc(0.0, 0.5), _arc(0.5, 1.0)],
        [_arc(0.0, 0.48), _arc(1.0, 0.52)],
        [_arc(0.67, 0.98), _arc(0.34, 0.02), _arc(0.35, 0.66)],
        [_arc(0.0, 0.52), _arc(0.49, 1.02)],
    ],
    ids=["gap", "overlap", "two halves", "one reversed", "three, mixed", "overlapping halves"],
)
def test_a_circle_however_it_is_drawn(strokes) -> None:
    drawn = outline_from_strokes(strokes)
    assert len(drawn.rings) == 1
    assert o.iou(drawn, outline_from_rings([o.circle(0, 0, 100, 400)])) > 0.99


def test_spiralling_overlap_is_trimmed_at_its_crossing() -> None:
    angle = np.linspace(-0.02, 1.02, 300) * 2 * np.pi
    radius = 100 + 4 * np.cos(angle / 2.0)  # starts outside, ends inside, crosses itself never
    crossing = 100 + 3 * np.sin(4 * angle)
    for r in (radius, crossing):
        drawn = outline_from_strokes([r[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])])
        assert o.iou(drawn, outline_from_rings([o.circle(0, 0, 100, 400)])) > 0.94


def test_hooks_are_cut_off() -> None:
    line = _arc(0.0, 0.97)
    hook = line[0] + np.linspace(1, 0, 8)[:-1, None] * np.array([2.5, -0.5])
    drawn = outline_from_strokes([np.vstack([hook, line])])
    assert np.hypot(*drawn.rings[0].T).max() < 101.5


def test_figure_eight_is_refused_with_its_place() -> None:
    angle = np.linspace(0.1, 2 * np.pi + 0.05, 300)
    eight = 500 + 100 * np.column_stack([np.sin(angle), np.sin(angle) * np.cos(angle)])
    with pytest.raises(UserError, match="crosses itself") as refusal:
        outline_from_strokes([eight])
    places = np.array(refusal.value.places)
    assert len(places) >= 1
    assert np.abs(places - 500).max() < 5


def test_a_small_loop_is_only_clumsiness() -> None:
    line = _arc(0.0, 1.0)[:-1]
    angle = np.linspace(0, 2 * np.pi, 12)
    loop = line[80] + 1.5 * np.column_stack([np.cos(angle) - 1, np.sin(angle)])
    drawn = outline_from_strokes([np.vstack([line[:81], loop, line[81:]])])
    assert o.iou(drawn, outline_from_rings([line])) > 0.99


@pytest.mark.parametrize(
    "strokes",
    [
        [],
        [np.zeros((0, 2))],
        [np.array([[3.0, 4.0]])],
        [np.tile([3.0, 4.0], (9, 1))],
        [np.array([[0.0, 0.0], [1.0, 1.0]])],
        [np.column_stack([np.arange(50.0), 2 * np.arange(50.0)])],
        [np.array([[0.0, 0.0], [np.nan, 1.0], [1.0, 1.0]])],
        [np.array([[0.0, 0.0], [np.inf, 1.0], [1.0, 1.0]])],
        [o.circle(0, 0, 10), o.circle(8, 0, 10)],
    ],
    ids=["none", "empty", "point", "dot", "line", "collinear", "nan", "inf", "crossing rings"],
)
def test_what_cannot_be_a_shape_is_refused_kindly(strokes) -> None:
    with pytest.raises(UserError) as refusal:
        outline_from_strokes(strokes)
    assert refusal.value.message.endswith(".")


def test_random_scribble_never_raises_anything_else() -> None:
    random = np.random.default_rng(3)
    for _ in range(60):
        count = int(random.integers(1, 80))
        scribble = random.normal(size=(count, 2)).cumsum(axis=0)
        try:
            drawn = outline_from_strokes([scribble])
        except UserError:
            continue
        assert drawn.polygon().is_valid


def test_tremor_is_filtered_without_shrinking_or_rounding() -> None:
    random = np.random.default_rng(5)
    square = o.dense(np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), 0.003)
    calm = filtered(square + random.normal(0.0, 0.002, square.shape))
    assert noise_of(calm) < 0.25 * 0.002
    exact, drawn = outline_from_rings([square]), outline_from_rings([calm])
    assert drawn.area == pytest.approx(1.0, abs=4e-3)
    corner = np.hypot(
        *(calm[:, None] - np.array([[0, 0], [1, 0], [1, 1], [0, 1]])).transpose(2, 0, 1)
    )
    assert corner.min(axis=0).max() < 0.01
    assert o.iou(drawn, exact) > 0.99
    assert filtered(square) is square


@pytest.mark.parametrize("name", ["heart", "key", "spider"])
def test_pen_like_ink(name: str) -> None:
    path = o.COMMITTED / f"{name}.ink.json"
    strokes, *_ = o.ink(path)
    drawn = o.in_outline_units(outline_from_strokes(strokes), path)
    exact = o.outline(name)
    assert (drawn.components, drawn.genus) == (exact.components, exact.genus)
    assert o.iou(drawn, exact) > 0.965
