from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.view.camera import Camera
from bozzetto_app.canvas.input.stroke_samples import Clock, PressureCurve, RawSample, SampleColumns


def test_device_times_count_while_they_advance():
    clock = Clock()
    # all received at one moment: the queue was late, the pen was not
    assert [clock(1000 + 4 * i, 7.0) for i in range(4)] == pytest.approx([0, 0.004, 0.008, 0.012])


@pytest.mark.parametrize("stamp", [0, 1000])
def test_our_clock_stands_in_for_missing_and_repeating_times(stamp):
    clock = Clock()
    times = [clock(stamp, 7.0 + 0.01 * i) for i in range(4)]
    assert times == pytest.approx([0, 0.01, 0.02, 0.03])


@given(st.lists(st.tuples(st.integers(0, 5000), st.floats(0, 100)), min_size=1, max_size=50))
def test_time_never_runs_backwards(events):
    clock = Clock()
    times = [clock(stamp, received) for stamp, received in events]
    assert times[0] == 0
    assert (np.diff(times) >= 0).all()


@given(st.floats(0.25, 4), st.floats(0, 1), st.floats(0, 1))
def test_a_pressure_curve_keeps_order_and_ends(gamma, a, b):
    curve = PressureCurve(gamma)
    assert curve(0.0) == 0.0
    assert curve(1.0) == 1.0
    assert (curve(a) <= curve(b)) == (a <= b) or curve(a) == curve(b)


@pytest.mark.parametrize("value", ["soft", None, "", [], "nan?"])
def test_a_setting_that_is_no_number_is_a_straight_curve(value):
    assert PressureCurve.from_setting(value).gamma == 1.0


def test_a_light_hand_draws_bold_with_a_soft_curve():
    assert PressureCurve.from_setting("0.5")(0.25) == pytest.approx(0.5)


def test_columns_grow_past_their_first_room():
    columns = SampleColumns(PressureCurve(), has_pressure=True)
    for i in range(5000):
        columns.append(RawSample(i, 2 * i, 0.5, 1000 + i, 1, 2, 3, 0.001 * i))
    stroke = columns.stroke(Camera(), "pen")
    np.testing.assert_array_equal(stroke.x, np.arange(5000))
    np.testing.assert_array_equal(stroke.y, 2 * np.arange(5000))
    np.testing.assert_allclose(stroke.t, 0.001 * np.arange(5000), atol=1e-6)


@given(st.lists(st.booleans(), min_size=2, max_size=60), st.integers(1, 16))
def test_slow_frames_do_not_stretch_the_times_of_a_coarse_device(late, grain):
    """Samples 2 ms apart, a device that counts in steps of `grain`, queues that are looked at
    150 ms late now and then."""
    clock, looked = Clock(), 0.0
    for k, waits in enumerate(late):
        drawn = 0.002 * k
        looked = max(looked, drawn + (0.15 if waits else 0.0))
        stamp = 1000 + round(1000 * drawn) // grain * grain
        assert clock(stamp, looked) == pytest.approx(drawn, abs=0.001 * grain + 0.017)


def test_a_device_time_that_comes_late_replaces_our_own_clock():
    clock = Clock()
    stamps = [0, 0, 1000, 1000, 1010, 1020]
    times = [clock(stamp, 7.0 + 0.01 * k) for k, stamp in enumerate(stamps)]
    assert times == pytest.approx([0, 0.01, 0.02, 0.03, 0.03, 0.04])
