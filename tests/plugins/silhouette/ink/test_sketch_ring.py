"""Outlines sketched in many strokes that lie over and across one another."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes


def meant(angle: Array) -> Array:
    """A bean, 300 px long."""
    radius = 110.0 * (1.0 + 0.25 * np.cos(angle) + 0.15 * np.cos(2.0 * angle + 0.7))
    return np.column_stack([400.0 + radius * np.cos(angle), 300.0 + radius * np.sin(angle)])


def sketched(seed: int, off: float = 2.0) -> list[Array]:
    """Seven strokes around the bean that overlap, each somewhat beside it and turned."""
    rng = np.random.default_rng(seed)
    strokes = []
    for k in range(7):
        begin = 2.0 * np.pi * k / 7.0 - rng.uniform(0.15, 0.3)
        end = 2.0 * np.pi * (k + 1) / 7.0 + rng.uniform(0.15, 0.3)
        line = meant(np.linspace(begin, end, 60))
        middle, turn = line.mean(axis=0), rng.normal(0.0, 0.01)
        across = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        line = (line - middle) @ across.T + middle + rng.normal(0.0, off, 2)
        strokes.append(line[::-1] if rng.random() < 0.5 else line)
    return [strokes[k] for k in rng.permutation(7)]


def overlap(one: shapely.Polygon, other: shapely.Polygon) -> float:
    return float(one.intersection(other).area / one.union(other).area)


def region(strokes: list[Array]) -> shapely.Polygon:
    (ring,) = rings_from_strokes(strokes)
    return shapely.Polygon(ring)


@pytest.mark.parametrize("seed", range(100, 106))
def test_strokes_across_one_another_are_one_outline_between_them(seed: int) -> None:
    bean = shapely.Polygon(meant(np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)))
    found = region(sketched(seed))
    assert overlap(found, bean) > 0.96
    assert abs(found.area / bean.area - 1.0) < 0.03, "neither the outer border nor the inner one"


def test_what_is_drawn_twice_around_is_one_outline() -> None:
    angle = np.linspace(0.0, 4.1 * np.pi, 500)
    twice = meant(angle) + np.column_stack([2.0 * np.sin(0.7 * angle), 2.0 * np.cos(0.9 * angle)])
    bean = shapely.Polygon(meant(np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)))
    assert overlap(region([twice]), bean) > 0.96


def test_neither_order_nor_size_nor_place_tells() -> None:
    strokes = sketched(7)
    first = region(strokes)
    assert overlap(first, region([s[::-1] for s in strokes[::-1]])) > 0.99
    moved = region([40.0 * s - 5000.0 for s in strokes])
    assert moved.area == pytest.approx(1600.0 * first.area, rel=1e-6)


def circle(x: float, y: float, radius: float) -> Array:
    angle = np.linspace(0.0, 2.0 * np.pi, 120)
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])


@pytest.mark.parametrize(
    "strokes",
    [
        [circle(300.0, 300.0, 100.0), circle(420.0, 300.0, 100.0)],
        [np.column_stack([np.sin(t := np.linspace(0, 2 * np.pi, 200)), np.sin(2.0 * t)])],
        [*sketched(3), np.array([[250.0, 300.0], [600.0, 300.0]])],
    ],
    ids=["two circles", "an eight", "a line across"],
)
def test_what_encloses_more_than_one_place_is_refused(strokes: list[Array]) -> None:
    with pytest.raises(UserError) as refused:
        rings_from_strokes(strokes)
    places = np.array(refused.value.places)
    ink = np.concatenate(strokes)
    assert len(places)
    assert ((places >= ink.min(axis=0)) & (places <= ink.max(axis=0))).all()
