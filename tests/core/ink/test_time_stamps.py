"""Time stamps of ticking clocks, invented and real."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.ink.time_stamps import regular_times, speeds

REAL = Path(__file__).parents[4] / "shared/data/ink/libmypaint/painting30sec.dat"


@given(st.lists(st.integers(0, 40), min_size=2, max_size=200))
@settings(max_examples=200, deadline=None)
def test_laws(ticks):
    stamps = np.sort(np.asarray(ticks)) * 0.008
    times = regular_times(stamps)
    assert (np.diff(times) > 0).all()
    if stamps[-1] > stamps[0]:
        assert times[0] == stamps[0]
        assert times[-1] == stamps[-1]
        alone = np.isin(stamps, [s for s in np.unique(stamps) if (stamps == s).sum() == 1])
        assert (times[alone] == stamps[alone]).all()
        # nobody is moved beyond the neighbouring ticks
        unique = np.unique(stamps)
        at = np.searchsorted(unique, stamps)
        assert (times >= unique[np.maximum(at - 1, 0)] - 1e-12).all()
        assert (times <= unique[np.minimum(at + 1, len(unique) - 1)] + 1e-12).all()


def test_good_stamps_are_left_alone():
    stamps = np.cumsum(np.random.default_rng(5).random(100) + 1e-6)
    assert (regular_times(stamps) == stamps).all()


def test_a_clock_that_jumps_back_is_held():
    assert (np.diff(regular_times([0, 0.1, 0.05, 0.2])) > 0).all()


def test_a_steady_pen_on_a_ticking_clock_has_a_steady_speed():
    true = np.arange(400) / 240.0
    ticking = np.floor(true / 0.016) * 0.016
    points = np.column_stack((120 * true, 160 * true))
    inner = speeds(points, ticking)[8:-8]
    assert np.abs(inner - 200).max() < 60
    assert abs(np.median(inner) - 200) < 10
    assert np.isfinite(speeds(points, np.zeros(400))).all()
    assert speeds(points[:1], [0.0]).tolist() == [0.0]


@pytest.mark.skipif(not REAL.exists(), reason="the real ink is not here")
def test_thirty_seconds_of_a_real_tablet():
    t, x, y, _ = np.loadtxt(REAL).T
    times = regular_times(np.floor(t / 0.016) * 0.016)
    assert (np.diff(times) > 0).all()
    assert np.abs(times - t).max() < 0.032
    coarse = speeds(np.column_stack((x, y)), np.floor(t / 0.016) * 0.016)
    fine = speeds(np.column_stack((x, y)), t)
    assert np.corrcoef(coarse, fine)[0, 1] > 0.9
