"""Nothing that was lifted is lost: whatever is done, undo reaches every stroke."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.app.waiting_life import ACTS, MOODS, life_in
from tests.sizes import sized

moods = st.tuples(st.just("mood"), st.sampled_from(MOODS))
draws = st.tuples(st.just("draw"), st.sampled_from(["closed", "open"]), st.booleans())
others = st.tuples(st.sampled_from(ACTS), st.integers(0, 5))
lives = st.lists(st.one_of(moods, draws, draws, others), max_size=25)

QUIET = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]


@pytest.fixture
def life(tmp_path, _tidy):
    with life_in(tmp_path) as made:
        yield made


@settings(max_examples=20, deadline=None, suppress_health_check=QUIET, derandomize=True)
@given(lives)
def test_undo_reaches_every_stroke_that_was_lifted(life, acts):
    life.live(acts)


@pytest.mark.slow
@settings(max_examples=sized(60, 400), deadline=None, suppress_health_check=QUIET)
@given(lives)
def test_undo_reaches_every_stroke_in_many_lives(life, acts):
    life.live(acts)
