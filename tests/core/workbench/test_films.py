"""Films of recordings: which times they have, and what is shown at them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.model import Document, Model
from bozzetto.errors import UserError
from bozzetto.plugin.guard.answer_validation import sound_times
from bozzetto.plugin.guard.checked_values import Unsound
from bozzetto.workbench.films import MOST_FRAMES, pace_of, recorded_times, recordings, replayed


class Bench:
    """A workbench whose models have recorded the times that are their states."""

    def is_usable(self, model):
        return True

    def recorded(self, model):
        return model.state

    def replayed(self, model, seconds):
        return replace(model, state=seconds)


def drawn(**times):
    return Document(tuple(Model(key, key, "a.b", value) for key, value in times.items()))


def test_objects_begin_together_and_one_that_is_over_stands_still():
    document = drawn(long=(5.0, 6.0, 8.0), short=(0.5, 1.0), still=(), once=(3.0,))
    known = recordings(Bench(), document)
    assert set(known) == {"long", "short"}
    times = recorded_times(known)
    assert times == [0.0, 0.5, 1.0, 3.0]
    rows = [[model.state for model in one] for one in replayed(Bench(), document, known, times)]
    assert [row[0] for row in rows] == [5.0, 5.5, 6.0, 8.0]
    assert [row[1] for row in rows] == [0.5, 1.0, 1.0, 1.0]
    assert all(row[2:] == [(), (3.0,)] for row in rows)


def test_what_is_hidden_is_in_no_film():
    document = drawn(a=(0.0, 1.0))
    hidden = Document(tuple(replace(model, visible=False) for model in document))
    assert recordings(Bench(), hidden) == {}


@pytest.mark.parametrize("rate", [7.0, 25.0, 30.0, 60.0])
@pytest.mark.parametrize("last", [0.01, 0.1, 1.0, 2.8, 3.217])
def test_frames_at_a_rate_are_even_and_end_with_the_recording(rate, last):
    times = np.array(recorded_times({"a": (2.0, 2.0 + last)}, rate))
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(last)
    assert np.diff(times)[:-1] == pytest.approx(1.0 / rate)
    assert 0.0 < np.diff(times)[-1] <= 1.0 / rate + 1e-9


@pytest.mark.parametrize("rate", [None, 60.0])
def test_long_recordings_have_as_many_frames_as_a_film_may_have(rate):
    known = {"a": np.linspace(0.0, 900.0, 5 * MOST_FRAMES)}
    times = recorded_times(known, rate)
    assert len(times) == MOST_FRAMES
    assert (times[0], times[-1]) == (0.0, 900.0)
    assert np.diff(times) == pytest.approx(900.0 / (MOST_FRAMES - 1))


@pytest.mark.parametrize("last", [0.3, 1.0, 200.0])
def test_pictures_of_a_recording_last_as_long_as_it_did(last):
    times = recorded_times({"a": (0.0, last)}, 25.0)
    assert (len(times) - 1) / pace_of(times, 25.0) == pytest.approx(last, abs=1 / 25)


def test_times_that_are_next_to_one_another_are_one_frame():
    assert recorded_times({"a": (0.0, 1.0), "b": (0.0, 1.0 + 1e-6, 2.0)}) == [0.0, 1.0, 2.0]


def test_no_recording_and_no_rate_are_refused():
    with pytest.raises(UserError, match="Nothing was recorded"):
        recorded_times({})
    for rate in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(UserError, match="above 0"):
            recorded_times({"a": (0.0, 1.0)}, rate)


@pytest.mark.parametrize(
    "times", [None, "ab", 3, (0.0, 0.0), (1.0, 0.5), (0.0, float("nan")), (0.0, float("inf"))]
)
def test_times_that_do_not_grow_are_a_fault_of_the_plugin(times):
    with pytest.raises(Unsound):
        sound_times(times)


def test_times_of_any_row_are_taken():
    assert sound_times(np.array([0.0, 0.5])) == sound_times([0, 0.5]) == (0.0, 0.5)
