"""At a terminal a call into a plugin that takes long is told, once."""

from __future__ import annotations

import threading
import time

import pytest

from bozzetto.cli.slow_calls import tell_slow_calls
from bozzetto.plugin.guard.guard import Guard

LATE = 0.3
"""Seconds, in place of a minute."""


@pytest.fixture
def told():
    return []


def run(told, *calls, late_after=LATE):
    """Make calls in a thread of their own, watched; return when nobody watches any more."""
    watchers = []

    def work():
        guard = Guard()
        watchers.append(tell_slow_calls(guard, told.append, late_after=late_after, every=0.02))
        for what, seconds in calls:
            guard.call("author.thing", what, lambda seconds: time.sleep(seconds), seconds)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    watchers[0].join(5.0)
    assert not watchers[0].is_alive()


def test_a_long_call_is_told_once_and_by_name(told):
    run(told, ("solve", 4.0 * LATE))
    (words,) = told
    assert words.startswith("still working: author.thing (solve), for")
    assert words.endswith("Ctrl+C stops it.")


def test_many_short_calls_are_not_told(told):
    run(told, *(("solve", 0.01) for _ in range(150)), late_after=1.0)
    assert told == []


def test_each_long_call_is_told(told):
    run(told, ("solve", 3.0 * LATE), ("shapes", 3.0 * LATE))
    assert [words.split(",")[0] for words in told] == [
        "still working: author.thing (solve)",
        "still working: author.thing (shapes)",
    ]
