"""Surfaces of implicit solids: closed, exact, nothing lost between the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import Cancelled
from bozzetto_silhouette.implicit.implicit_solid import Sample
from bozzetto_silhouette.inflation.manifold_check import as_manifold
from bozzetto_silhouette.solids.polygonize import Wanted, extract, extracted

Points = NDArray[np.float64]


@dataclass
class Capsules:
    """The union of capsules (n, 7): two ends and a radius; it counts what it is asked."""

    rows: Points
    asked: int = 0

    @property
    def bounds(self) -> Points:
        ends = self.rows[:, :6].reshape(-1, 2, 3)
        radius = self.rows[:, 6, None]
        return np.stack([(ends.min(1) - radius).min(0), (ends.max(1) + radius).max(0)])

    def sample(self, points: Points) -> Sample:
        a, b, radius = self.rows[:, :3], self.rows[:, 3:6], self.rows[:, 6]
        span = b - a
        offset = points[:, None] - a
        along = (offset * span).sum(2) / np.maximum((span**2).sum(1), 1e-12)
        away = offset - np.clip(along, 0, 1)[..., None] * span
        gap = np.linalg.norm(away, axis=2)
        best = (radius - gap).argmax(1)
        row = np.arange(len(points))
        length = np.maximum(gap[row, best], 1e-12)[:, None]
        return Sample((radius - gap)[row, best], -away[row, best] / length)

    def value(self, points: Points) -> Points:
        self.asked += len(points)
        return self.sample(points).value


@dataclass
class Torus:
    """About the z axis, radii 1 and 0.3."""

    @property
    def bounds(self) -> Points:
        return np.array([[-1.3, -1.3, -0.3], [1.3, 1.3, 0.3]])

    def sample(self, points: Points) -> Sample:
        around = np.maximum(np.hypot(points[:, 0], points[:, 1]), 1e-12)
        gap = np.maximum(np.hypot(around - 1.0, points[:, 2]), 1e-12)
        slope = (around - 1.0) / gap / around
        gradient = np.column_stack([-slope[:, None] * points[:, :2], -points[:, 2] / gap])
        return Sample(0.3 - gap, gradient)

    def value(self, points: Points) -> Points:
        return self.sample(points).value


def ball(x: float, y: float, z: float, radius: float) -> list[float]:
    return [x, y, z, x, y, z, radius]


@pytest.mark.parametrize("middle", [0.0, 1e5])
def test_a_ball_to_seven_digits(middle: float) -> None:
    solid = Capsules(np.array([ball(middle, middle, middle, 1.0)]))
    found = extract(solid, solid.bounds, 0.05)
    ray = found.vertices - middle
    assert np.linalg.norm(ray, axis=1) == pytest.approx(np.ones(len(ray)), abs=1e-7)
    assert (found.normals * ray).sum(axis=1) == pytest.approx(np.ones(len(ray)), abs=1e-6)
    assert as_manifold(ray, found.faces).volume() == pytest.approx(4 / 3 * np.pi, rel=3e-3)


def test_a_torus_keeps_its_hole() -> None:
    solid = Torus()
    found = extract(solid, solid.bounds, 0.04)
    whole = as_manifold(found.vertices, found.faces)
    assert whole.genus() == 1
    assert whole.volume() == pytest.approx(2 * np.pi**2 * 0.3**2, rel=5e-3)
    assert whole.surface_area() == pytest.approx(4 * np.pi**2 * 0.3, rel=5e-3)


def test_a_hair_between_the_blocks_is_not_lost() -> None:
    rng = np.random.default_rng(5)
    for _ in range(6):
        a, b = rng.uniform(-1, 1, (2, 3))
        solid = Capsules(np.array([[*a, *b, 0.03]]))
        found = extract(solid, np.array([[-1.2] * 3, [1.2] * 3]), 0.024)
        whole = as_manifold(found.vertices, found.faces)
        assert len(whole.decompose()) == 1
        wanted = np.pi * 0.03**2 * np.linalg.norm(b - a) + 4 / 3 * np.pi * 0.03**3
        assert whole.volume() == pytest.approx(wanted, rel=0.35)


def test_what_sticks_out_of_the_box_is_cut_and_closed() -> None:
    solid = Capsules(np.array([[-5.0, 0, 0, 5, 0, 0, 0.5]]))
    found = extract(solid, np.array([[-1.0, -0.5, -0.5], [1, 0.5, 0.5]]), 0.05)
    whole = as_manifold(found.vertices, found.faces)
    assert whole.status().name == "NoError"
    assert 1.9 < found.vertices[:, 0].max() - found.vertices[:, 0].min() < 4.0
    assert whole.volume() > 0.0


def test_nothing_inside_is_no_mesh() -> None:
    solid = Capsules(np.array([ball(9.0, 9, 9, 1.0)]))
    assert not len(extract(solid, np.array([[-1.0] * 3, [1.0] * 3]), 0.1).faces)


def test_only_a_band_is_evaluated() -> None:
    solid = Capsules(np.array([ball(0.0, 0, 0, 1.0), [0, 0, 0, 2, 1, 0, 0.1]]))
    found = extract(solid, solid.bounds, 3.0 / 128)
    full = np.prod(np.ptp(solid.bounds, axis=0) / (3.0 / 128))
    assert solid.asked < 0.25 * full
    assert as_manifold(found.vertices, found.faces).genus() == 0


def test_a_function_that_knows_no_distance_still_gives_a_closed_mesh() -> None:
    @dataclass
    class Wild:
        bounds: Points

        def value(self, points: Points) -> Points:
            return self.sample(points).value

        def sample(self, points: Points) -> Sample:
            p = 9.0 * points
            value = np.sin(p).prod(axis=1) * np.exp(3.0 * np.sin(p.sum(axis=1)))
            return Sample(value, np.zeros_like(points))

    found = extract(Wild(np.array([[-1.0] * 3, [1.0] * 3])), np.array([[-1.0] * 3, [1] * 3]), 0.07)
    whole = as_manifold(found.vertices, found.faces)
    assert whole.status().name == "NoError"
    assert whole.volume() > 0.0
    assert np.linalg.norm(found.normals, axis=1) == pytest.approx(np.ones(len(found.normals)))


def test_work_can_be_stopped() -> None:
    def stop(fraction: float, step: str) -> None:
        raise Cancelled

    solid = Torus()
    with pytest.raises(Cancelled):
        extract(solid, solid.bounds, 0.05, stop)


def test_several_are_extracted_as_each_by_itself() -> None:
    empty = np.array([[5.0] * 3, [6.0] * 3])
    solids = [Torus(), Capsules(np.array([ball(0.0, 0.0, 0.0, 1.0)])), Torus()]
    wanted = [
        Wanted(solid, solid.bounds, step)
        for solid, step in zip(solids, (0.05, 0.08, 0.07), strict=True)
    ]
    wanted.insert(1, Wanted(Torus(), empty, 0.1))
    for found, some in zip(extracted(wanted), wanted, strict=True):
        alone = extract(*some)
        assert found.vertices == pytest.approx(alone.vertices, abs=1e-12)
        assert np.array_equal(found.faces, alone.faces)
        assert found.normals == pytest.approx(alone.normals, abs=1e-9)


def test_what_is_far_from_the_surface_is_not_asked_for() -> None:
    solid = Capsules(np.array([ball(0.0, 0.0, 0.0, 1.0)]))
    found = extract(solid, solid.bounds, 0.04)
    # 3.0 for each vertex, coarse blocks included; 5.1 when nodes far off were asked for, too.
    assert solid.asked < 4.0 * len(found.vertices)
