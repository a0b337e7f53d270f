"""What is kept and not computed again is what computing it again would give."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph.draft import Draft, draft_of
from bozzetto_polyhedron.graph.likelihood import Fits
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.steps import steps
from bozzetto_polyhedron.graph.surroundings import MOST_NEAR, Surroundings
from bozzetto_polyhedron.reconstruction.lengths import dots, lengths_of
from tests.plugins.polyhedron.cad_parts import part
from tests.plugins.polyhedron.untidy_parts import untidy


@pytest.fixture(scope="module")
def draft() -> Draft:
    found = searched(untidy(part("clevis", 310), 310)[0]).draft
    assert found is not None
    return found


def test_the_price_of_a_step_is_how_the_cost_of_all_lines_together_grows(draft: Draft) -> None:
    every = [each for each in steps(draft) if np.isfinite(draft.price(each))]
    assert len(every) > 100
    for change in every[:: len(every) // 50]:
        made = draft.copied()
        made.apply(change)
        anew = draft_of(draft.fits, made.lines.values())
        cost = anew.cost + draft.fits.tick_cost(made.dropped)
        assert abs(made.cost - draft.cost - draft.price(change)) < 1e-6
        assert abs(made.cost - cost) < 1e-6
        assert made.costs.keys() == anew.costs.keys()
        assert all(abs(made.costs[k] - anew.costs[k]) < 1e-6 for k in made.costs)


def test_segments_in_any_order_are_one_line(draft: Draft) -> None:
    fits = draft.fits
    several = [each.line.members for each in draft.lines.values() if len(each.line.members) > 1]
    assert several
    for members in several:
        assert fits.line(members[::-1]) is fits.line(members)
        assert fits.line(members) == Fits(fits.segments, fits.spread, fits.few).line(members)


def test_steps_are_the_same_the_second_time(draft: Draft) -> None:
    first = [(each.removed, each.added, each.dropped) for each in steps(draft)]
    assert first == [(each.removed, each.added, each.dropped) for each in steps(draft)]


def test_corners_near_a_place_are_the_nearest_whatever_was_asked_before(draft: Draft) -> None:
    rng = np.random.default_rng(3)
    around = Surroundings(draft)
    places = [around.place[k] for k in around.corners] + [tuple(rng.random(2)) for _ in range(20)]
    for place in places:
        away = {k: float(np.hypot(*np.subtract(around.place[k], place))) for k in around.corners}
        for most, reach in ((1, 0.08), (MOST_NEAR, 0.3), (2, 0.02), (4, 0.08)):
            expected = [k for k in sorted(away, key=lambda k: away[k])[:most] if away[k] < reach]
            assert around.near(place, most, reach) == expected


@pytest.mark.parametrize("shape", [(3,), (5, 3), (4, 7, 3), (0, 3)])
def test_products_and_lengths_are_those_of_numpy(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(4)
    first, second = rng.normal(size=(2, *shape))
    assert np.array_equal(dots(first, second), (first * second).sum(-1))
    assert np.array_equal(lengths_of(first), np.linalg.norm(first, axis=-1, keepdims=True))
