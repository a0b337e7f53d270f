"""A drawing is read once; what came of it is read from disk to the last digit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.plugins.polyhedron.figures_confidence import ASKED, bins_of, error_of, of_edges
from tests.plugins.polyhedron.kept_outcomes import Outcome, kept, read_from, written


def made(seed: int) -> Outcome | None:
    """Return any outcome; every fifth drawing has none."""
    rng = np.random.default_rng(seed)
    if seed % 5 == 4:
        return None
    return Outcome("loose", rng.normal(), rng.normal(size=26), rng.random() < 0.5, rng.normal())


def test_a_drawing_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BOZZETTO_OUTCOMES", str(tmp_path))
    asked: list[int] = []

    def reading(seed: int) -> Outcome | None:
        asked.append(seed)
        return made(seed)

    first = kept("solids", range(10), reading)
    again = kept("solids", range(5, 15), reading)
    assert asked == list(range(15))
    assert list(first) == [seed for seed in range(10) if seed % 5 != 4]
    for seed, each in again.items():
        assert written(each) == written(made(seed))


def test_without_a_folder_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("BOZZETTO_OUTCOMES", raising=False)
    monkeypatch.chdir(tmp_path)
    assert len(kept("solids", range(5), made)) == 4
    assert not list(tmp_path.iterdir())


def test_an_outcome_comes_back_as_it_was() -> None:
    one = made(3)
    assert one is not None
    other = read_from(written(one))
    assert other is not None
    assert written(other) == written(one)
    assert np.array_equal(other.traits, one.traits)
    assert read_from(written(None)) is None


@pytest.mark.parametrize("count", [1, 20, 200, 2000])
def test_bins_that_show_nothing_are_put_together_and_none_is_lost(count: int) -> None:
    told = np.random.default_rng(count).uniform(0.02, 0.995, count)
    bins = bins_of(told)
    assert (np.sum(bins, axis=0) == 1).all()
    assert (np.sum(of_edges(told), axis=0) == 1).all()
    assert len(bins) == 1 or max(error_of(told[here]) for here in bins) <= ASKED
    limits = [(told[here].min(), told[here].max()) for here in bins]
    assert limits == sorted(limits)
