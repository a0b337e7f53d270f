"""Cross products of rows are those of NumPy, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.arrays import cross_product


@pytest.mark.parametrize(
    "shapes", [((3,), (3,)), ((7, 3), (7, 3)), ((2, 5, 3), (3,)), ((0, 3), (3,))]
)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_cross_products_are_those_of_numpy(shapes: tuple, dtype: type) -> None:
    random = np.random.default_rng(4)
    one, other = (random.normal(size=shape).astype(dtype) for shape in shapes)
    made = cross_product(one, other)
    assert made.dtype == dtype
    assert np.array_equal(made, np.cross(one, other))


def test_what_is_not_finite_stays_so() -> None:
    one = np.array([(1.0, np.inf, 0.0), (np.nan, 1.0, 2.0)])
    with np.errstate(invalid="ignore"):
        assert np.array_equal(
            cross_product(one, one[::-1]), np.cross(one, one[::-1]), equal_nan=True
        )
