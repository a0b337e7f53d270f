"""Documents open at a cost that grows with their size, whatever list of a state has grown."""

import pytest

from bozzetto.testing.machine_speed import slowness
from tests.reliability.grown_documents import grown_lists, opening_time

SIZES = (100_000, 200_000, 400_000)
"""JSON values of the state."""

LARGEST = 1_400_000
"""Nearly all that a state may hold."""

FREE = 0.3
"""Seconds below which growth is not looked at."""

GROWTH = 3.2
"""What twice the size may cost; twice is linear, and four times is not."""

BUDGET = 10.0
"""Seconds of the processor for a file."""

MODELERS = [
    f"bozzetto.{name}"
    for name in ("car", "mesh", "polyhedron", "product", "silhouette", "symmetry")
]


@pytest.mark.long
def test_every_bundled_modeler_has_such_lists():
    assert {one.modeler for one in grown_lists()} == set(MODELERS)


@pytest.mark.long
@pytest.mark.parametrize("modeler", MODELERS)
def test_the_cost_of_a_state_grows_no_faster_than_the_state(modeler):
    for one in grown_lists():
        if one.modeler != modeler:
            continue
        small, middle, large = (opening_time(one.grown(size)) for size in SIZES)
        assert middle < GROWTH * max(small, FREE), one.name
        assert large < GROWTH * max(middle, FREE), one.name


@pytest.mark.slow
@pytest.mark.parametrize("modeler", MODELERS)
def test_a_state_as_large_as_it_may_be_is_open_within_the_budget(modeler):
    for one in grown_lists():
        if one.modeler == modeler:
            assert opening_time(one.grown(LARGEST)) < BUDGET * slowness(), one.name
