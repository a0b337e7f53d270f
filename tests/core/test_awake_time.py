"""Time limits go by a clock that stands still while the process does."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time

import pytest

from bozzetto import awake_time as module
from bozzetto.awake_time import awake_time, wait_awake
from bozzetto.plugin.guard.guard import Guard, PluginFault
from bozzetto.plugin.guard.watchdog import Watchdog


class _Clock:
    """The system's clock, which can be put on."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ahead = 0.0
        real = time.monotonic
        monkeypatch.setattr(module.time, "monotonic", lambda: real() + self.ahead)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Clock:
    return _Clock(monkeypatch)


def test_it_goes_as_the_system_does_while_somebody_looks():
    begun, seen = time.monotonic(), awake_time()
    while time.monotonic() < begun + 0.3:
        time.sleep(0.02)
        awake_time()
    assert awake_time() - seen == pytest.approx(time.monotonic() - begun, abs=0.02)


@pytest.mark.parametrize("ahead", [3600.0, 86400.0])
def test_an_hour_in_which_nothing_ran_counts_for_little(clock, ahead):
    before = awake_time()
    clock.ahead += ahead
    assert 0.0 <= awake_time() - before <= 1.0


def test_it_never_goes_back(clock):
    before = awake_time()
    clock.ahead -= 100.0
    assert awake_time() >= before
    time.sleep(0.05)
    assert awake_time() - before >= 0.04


def test_a_wait_ends_by_the_event_and_by_the_time():
    event = threading.Event()
    begun = time.monotonic()
    assert not wait_awake(event, 0.3)
    assert time.monotonic() - begun >= 0.29
    threading.Timer(0.1, event.set).start()
    assert wait_awake(event, 60.0)
    assert wait_awake(event, 0.0)


def test_a_call_during_which_the_machine_slept_is_not_late(clock):
    def sleeps() -> str:
        time.sleep(0.3)
        clock.ahead += 3600.0
        time.sleep(0.3)
        return "answer"

    assert Watchdog(Guard(), 2.5).call("a.modeler", "build", sleeps) == "answer"


def test_a_call_that_hangs_after_the_machine_slept_is_late():
    def hangs() -> None:
        while True:
            time.sleep(0.01)

    with pytest.raises(PluginFault, match="did not answer"):
        Watchdog(Guard(), 0.5).call("a.modeler", "build", hangs)


STOPPED = """
import time
from bozzetto.plugin.guard.guard import Guard
from bozzetto.plugin.guard.watchdog import Watchdog

def build():
    print("building", flush=True)
    for _ in range(100):
        time.sleep(0.01)
    return "answer"

print(Watchdog(Guard(), 2.5).call("a.modeler", "build", build), flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="processes cannot be stopped there")
def test_a_process_that_was_stopped_blames_nobody():
    child = subprocess.Popen(
        [sys.executable, "-c", STOPPED], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == "building\n"
        child.send_signal(signal.SIGSTOP)
        time.sleep(3.0)  # longer than the limit
        child.send_signal(signal.SIGCONT)
        told, problem = child.communicate(timeout=60.0)
    finally:
        child.kill()
    assert told == "answer\n", problem
