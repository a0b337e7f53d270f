"""Many splines at once: SciPy's, one by one, is the oracle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from bozzetto_car.styling.cubic_splines import not_a_knot_splines


def runs(seed: int, count: int = 40) -> list[tuple[np.ndarray, np.ndarray]]:
    """Splines through two to thirty places at uneven steps."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        size = int(rng.choice([2, 3, 4, 5, int(rng.integers(6, 30))]))
        at = rng.uniform(-50.0, 50.0) + np.cumsum(np.exp(rng.normal(0.0, 1.5, size)))
        made.append((at, rng.uniform(0.0, 1.0, (size, 2))))
    return made


@pytest.mark.parametrize("seed", range(5))
def test_each_is_the_spline_that_it_is_alone(seed: int) -> None:
    given = runs(seed)
    for (at, places), pieces in zip(given, not_a_knot_splines(given), strict=True):
        wanted = CubicSpline(at, places)
        share = np.linspace(0.0, 1.0, 7)[:, None, None]
        steps = share * np.diff(at)[:, None]
        third, second, first, zeroth = pieces
        found = ((third * steps + second) * steps + first) * steps + zeroth
        expected = wanted(at[:-1] + steps[..., 0])
        assert np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("seed", range(3))
def test_neighbours_have_no_say(seed: int) -> None:
    given = runs(seed)
    alone = [not_a_knot_splines([own])[0] for own in given]
    for one, other in zip(alone, not_a_knot_splines(given[::-1])[::-1], strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-11 * np.abs(one).max())


@pytest.mark.parametrize("seed", range(3))
def test_a_cubic_is_repeated(seed: int) -> None:
    rng = np.random.default_rng(seed)
    powers = rng.normal(size=(4, 2))
    at = np.cumsum(rng.uniform(0.2, 2.0, 9))
    places = sum(one * at[:, None] ** power for power, one in enumerate(powers))
    (pieces,) = not_a_knot_splines([(at, places)])
    np.testing.assert_allclose(pieces[0], np.tile(powers[3], (8, 1)), rtol=0.0, atol=1e-8)


def test_no_places_give_no_splines() -> None:
    assert not_a_knot_splines([]) == []
