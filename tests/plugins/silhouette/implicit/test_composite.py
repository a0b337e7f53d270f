"""Trees of solids as functions of space: long ones are cheap."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto_silhouette.implicit.composite import Composite, localized
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed, Sample, sample_each
from bozzetto_silhouette.inflation.heightfield import Relief
from tests.plugins.silhouette import bodies as b

Points = NDArray[np.float64]


@dataclass
class Ball:
    """A ball of radius 1 that counts how often it is asked."""

    middle: tuple[float, float, float]
    asked: list[int] = field(default_factory=list)

    @property
    def bounds(self) -> Points:
        return np.array(self.middle) + np.array([[-1.0] * 3, [1.0] * 3])

    def value(self, points: Points) -> Points:
        return self.sample(points).value

    def sample(self, points: Points) -> Sample:
        self.asked.append(len(points))
        away = points - self.middle
        length = np.linalg.norm(away, axis=1)
        return Sample(1.0 - length, -away / np.maximum(length, 1e-300)[:, None], 1.0)


def chain(count: int) -> tuple[Implicit, list[Ball]]:
    """Balls in a row, each blended with all before it."""
    balls = [Ball((1.5 * k, 0.0, 0.0)) for k in range(count)]
    whole: Implicit = balls[0]
    for ball in balls[1:]:
        whole = Composite(whole, ball, "add", 0.5, 0.5)
    return whole, balls


def around(count: int) -> Points:
    random = np.random.default_rng(5)
    return random.uniform([-2.0, -2.0, -2.0], [1.5 * count + 1.0, 2.0, 2.0], (2000, 3))


def test_a_long_chain_asks_every_link_at_most_twice() -> None:
    whole, balls = chain(40)
    whole.sample(around(40))
    assert max(len(ball.asked) for ball in balls) <= 2


def test_the_order_of_a_union_does_not_matter() -> None:
    one, other = Ball((0.0, 0.0, 0.0)), Ball((1.5, 0.0, 0.0))
    there, back = Composite(one, other, "add", 0.5, 0.5), Composite(other, one, "add", 0.5, 0.5)
    near = np.abs(there.value(around(2))) < 0.5
    assert there.value(around(2))[near] == pytest.approx(back.value(around(2))[near])


def test_in_its_box_what_is_localized_is_the_same() -> None:
    whole, balls = chain(40)
    box = np.array([[28.0, -1.5, -1.5], [31.0, 1.5, 1.5]])
    part = localized(whole, box, 1.0)
    points = np.random.default_rng(6).uniform(*box, (2000, 3))
    value = whole.value(points)
    near = np.abs(value) < 0.9
    assert part.value(points)[near] == pytest.approx(value[near], abs=1e-12)
    for ball in balls:
        ball.asked.clear()
    part.value(points)
    assert sum(len(ball.asked) > 0 for ball in balls) < 10


def test_many_are_sampled_as_each_by_itself() -> None:
    random = np.random.default_rng(7)
    relief, other = b.ball(0.0, 30.0, 24).implicit, b.capsule(20.0, 12.0, 24).implicit
    assert isinstance(relief, Relief)
    flat = Relief(replace(relief.solid, back=0.3 * relief.solid.back))
    placed = [Placed(relief, b.turn("x", 40.0, (5.0, 0.0, 2.0))), Placed(other, b.turn("y", 70.0))]
    solids: list[Implicit] = [
        relief,
        placed[0],
        Composite(placed[0], placed[1], "add", 0.5, 6.0),
        Composite(relief, placed[1], "carve", 0.5, 6.0),
        Composite(other, placed[0], "merge", 0.5, 6.0),
        Composite(Composite(relief, other, "add", 0.3, 4.0), placed[1], "add", 0.5, 6.0),
        flat,
        placed[1],
        Composite(flat, other, "intersect", 0.5, 6.0),
        relief,
    ]
    counts = random.integers(0, 300, len(solids))
    ends = np.cumsum([0, *counts])
    points = random.uniform(-80.0, 80.0, (ends[-1], 3))
    found = sample_each(solids, points, ends)
    for solid, low, high in zip(solids, ends[:-1], ends[1:], strict=True):
        alone = solid.sample(points[low:high])
        for column, own in zip(found, alone, strict=True):
            assert np.asarray(column)[low:high] == pytest.approx(own, rel=1e-9, abs=1e-9)
