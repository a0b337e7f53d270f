"""Charts in a square: places asked of whole numbers, against asking cell by cell and polygons."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry.atlas.chart_bitmaps import Square, bitmap_of, coarser, drawn
from bozzetto.geometry.atlas.chart_compaction import GROWN, compacted
from bozzetto.geometry.atlas.chart_packing import Outline, packed


def blob(random, most=9):
    """Some cells that hang together, with holes now and then."""
    high, wide = random.integers(1, most, 2)
    cells = random.random((high, wide)) < 0.7
    cells[0, random.integers(wide)] = cells[-1, random.integers(wide)] = True
    cells[random.integers(high), 0] = cells[random.integers(high), -1] = True
    return cells


def free_spots(taken, cells, side):
    high, wide = cells.shape
    return [
        (row, column)
        for row in range(side - high + 1)
        for column in range(side - wide + 1)
        if not (taken[row : row + high, column : column + wide] & cells).any()
    ]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("lowest", [True, False])
def test_the_best_free_place_is_the_one_that_trying_all_finds(seed, lowest):
    random = np.random.default_rng(910_000 + seed)
    size, side = 24, int(random.integers(12, 25))
    square, taken = Square(size), np.zeros((size, size), bool)
    for _ in range(30):
        cells = blob(random)
        high, wide = cells.shape
        spots = free_spots(taken, cells, side)
        found = square.spot(bitmap_of(cells, size), side, lowest=lowest)
        if not spots:
            assert found is None
            continue
        reach = lambda spot: 0 if lowest else max(spot[0] + high, spot[1] + wide)  # noqa: B023, E731
        assert found == min(spots, key=lambda spot: (reach(spot), spot))
        row, column = found
        square.put(bitmap_of(cells, size), row, column)
        taken[row : row + high, column : column + wide] |= cells
        if random.random() < 0.2:
            square.put(bitmap_of(cells, size), row, column, taken=False)
            taken[row : row + high, column : column + wide][cells] = False


@pytest.mark.parametrize("around", [0, 1, 2])
def test_a_drawn_chart_takes_every_cell_that_it_touches_and_those_beside(around):
    import shapely

    random = np.random.default_rng(910_100 + around)
    for _ in range(20):
        angles = np.sort(random.uniform(0.0, 2 * np.pi, 9))
        reach = random.uniform(2.0, 9.0, 9)
        ring = np.stack([np.cos(angles), np.sin(angles)], 1) * reach[:, None] + random.uniform(
            -5, 5
        )
        cells, low = drawn([ring], around)
        shape = shapely.Polygon(ring).buffer(0)
        for row, column in np.argwhere(~np.pad(cells, 1)):
            x, y = low + np.array([column, row]) - 1.0
            away = shape.distance(shapely.box(x, y, x + 1.0, y + 1.0))
            assert away > around - 0.3  # by dots of a quarter of a cell


def test_a_coarse_cell_is_taken_if_any_of_its_cells_is():
    cells = np.zeros((5, 7), bool)
    cells[4, 6] = cells[0, 2] = True
    assert coarser(cells, 3).tolist() == [[True, False, False], [False, False, True]]


def stars(random, count):
    """Charts of all sizes: stars, some long."""
    found = []
    for _ in range(count):
        corners = int(random.integers(3, 14))
        angles = np.sort(random.uniform(0.0, 2 * np.pi, corners))
        ring = np.stack([np.cos(angles), np.sin(angles)], 1)
        ring *= random.uniform(0.3, 1.0, (corners, 1)) * random.lognormal(0.0, 0.8)
        ring[:, 0] *= random.choice([1.0, 1.0, 5.0])
        found.append(ring)
    return found


@pytest.mark.parametrize("count", [1, 2, 7, 30, 200])
def test_charts_of_any_shape_lie_apart_in_the_square_as_they_are(count):
    import shapely

    random = np.random.default_rng(910_200 + count)
    shapes = []
    while len(shapes) < count:
        shapes += [s for s in map(shapely.Polygon, stars(random, count)) if s.is_valid]
    shapes = shapes[:count]
    outlines = [Outline([np.array(s.exterior.coords[:-1])], s.area) for s in shapes]
    found = packed(outlines, 256)
    alike_but_for_growth(found.turn)
    placed = [
        shapely.Polygon(one.rings[0] @ turn + offset)
        for one, turn, offset in zip(outlines, found.turn, found.offset, strict=True)
    ]
    tree = shapely.STRtree(placed)
    one, other = tree.query(placed, "dwithin", 0.98 * found.side / 256)
    assert (one == other).all()
    low, high = shapely.total_bounds(placed).reshape(2, 2)
    assert low.min() >= -1e-9 * found.side
    assert high.max() <= (1.0 + 1e-9) * found.side


def alike_but_for_growth(turn):
    """No chart is mirrored, bent or smaller than another one by more than is said."""
    large, little = np.linalg.svd(turn, compute_uv=False).T
    np.testing.assert_allclose(large, little, rtol=1e-9)
    assert (np.linalg.det(turn) > 0.0).all()
    assert large.min() == pytest.approx(1.0)
    assert large.max() <= (1.0 + GROWN) * (1.0 + 1e-9)


def test_the_same_charts_lie_in_the_same_places_in_any_unit():
    random = np.random.default_rng(910_300)
    rings = stars(random, 12)
    one, two = (packed([Outline([r * s], s * s) for r in rings], 256) for s in (1.0, 250.0))
    np.testing.assert_array_equal(one.turn, two.turn)
    np.testing.assert_allclose(two.offset, 250.0 * one.offset, atol=1e-6)


def test_charts_pushed_together_keep_their_distance_and_shape_in_a_smaller_square():
    import shapely

    gap = 1 / 256
    ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.4, 0.4], [0.4, 1.0], [0.0, 1.0]])
    outlines = [[ring], [ring * 0.5 + 0.46], [ring @ [[0.0, 1.0], [-1.0, 0.0]] + [2.1, 0.0]]]
    turn, offset, side = compacted(outlines, gap, lambda done: None)
    assert side < 0.96 * 2.1
    alike_but_for_growth(turn)
    moved = [
        shapely.Polygon(rings[0] @ t + o)
        for rings, t, o in zip(outlines, turn, offset, strict=True)
    ]
    for k, one in enumerate(moved):
        assert all(one.distance(other) >= gap * side for other in moved[:k])
    low, high = shapely.total_bounds(moved).reshape(2, 2)
    assert low.min() >= -1e-9
    assert high.max() <= side * (1.0 + 1e-9)
