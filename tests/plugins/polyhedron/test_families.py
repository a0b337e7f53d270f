"""Five families of drawings in equal shares, and what is said of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.plugins.polyhedron.figures_confidence import said
from tests.plugins.polyhedron.figures_families import FAMILIES, family_of, outcome
from tests.plugins.polyhedron.fit_confidence import BINS
from tests.plugins.polyhedron.test_confidence import FEWEST, off

DRAWINGS = range(90_000, 90_200)


def test_a_drawing_is_the_same_each_time_and_families_have_equal_shares() -> None:
    seeds = range(90_000, 90_005)
    assert {family_of(seed) for seed in seeds} == set(FAMILIES)
    for seed in seeds:
        one, other = outcome(seed), outcome(seed)
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            assert (one.evidence, one.lead, one.right) == (other.evidence, other.lead, other.right)
            assert np.array_equal(one.traits, other.traits)


@pytest.mark.slow
def test_what_is_said_of_five_families_is_how_often_it_is_right() -> None:
    every = [each for seed in DRAWINGS if (each := outcome(seed)) is not None]
    assert len(every) > 150
    for low, high in pairwise(BINS):
        found = [each for each in every if low <= said(each) < high]
        if len(found) >= FEWEST:
            assert off(found) < 0.0, (low, high, len(found))
