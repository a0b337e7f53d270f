"""Windows along a closed ring: how far each sample is from a marked one, and how weights fade."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_silhouette.ink.ring_fits import faded_in


@pytest.mark.parametrize("seed", range(8))
def test_weights_fade_with_the_way_round_the_ring_to_the_nearest_sample_outside(seed):
    dice = np.random.default_rng(seed)
    for _ in range(40):
        count, width = int(dice.integers(1, 80)), int(dice.integers(1, 12))
        inside = dice.random(count) < dice.random()
        weight = faded_in(inside, width)
        outside = np.flatnonzero(~inside).tolist()
        for place in range(count):
            ways = [
                min(abs(place - other), count - abs(place - other)) for other in outside
            ] or [count]  # fmt: skip
            share = min(max((min(ways) - 1) / width, 0.0), 1.0)
            assert weight[place] == pytest.approx(share**2 * (3.0 - 2.0 * share), abs=1e-15)


def test_a_ring_moved_on_by_some_samples_has_its_weights_moved_on():
    inside = np.random.default_rng(80).random(500) < 0.97
    weight = faded_in(inside, 7)
    for by in (1, 77, 499):
        assert (faded_in(np.roll(inside, by), 7) == np.roll(weight, by)).all()
