"""Channels: order, overtaking, cancelling and hanging, seen from the window's thread."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
from shiboken6 import delete

from bozzetto.errors import Cancelled
from bozzetto_app.session.notices import Notices
from bozzetto_app.workers.channel import Channel, Hung, Request
from bozzetto_app.workers.main_thread import call_on_main_thread


class Heard:
    """Collects what a channel answers."""

    def __init__(self):
        self.answers = []
        self.problems = []

    def request(self, work, quality="final"):
        return Request(work, self.answers.append, self.problems.append, quality)


@pytest.fixture
def heard():
    return Heard()


def test_answers_come_on_the_windows_thread(qtbot, heard):
    channel = Channel("test")
    threads = []
    channel.submit(
        Request(
            lambda job: threads.append(threading.get_ident()),
            lambda answer: threads.append(threading.get_ident()),
            heard.problems.append,
        )
    )
    qtbot.waitUntil(lambda: len(threads) == 2)
    assert threads[0] != threading.get_ident() == threads[1]


def test_newest_only_drops_what_waits_and_keeps_what_runs(qtbot, heard):
    channel, gate = Channel("test"), threading.Event()
    channel.submit(heard.request(lambda job: gate.wait(5) and "first"))
    for name in ("second", "third", "fourth"):
        channel.submit(heard.request(lambda job, name=name: name))
    gate.set()
    qtbot.waitUntil(lambda: not channel.busy)
    assert heard.answers == ["first", "fourth"]


def test_keep_all_answers_everything_in_order(qtbot, heard):
    channel = Channel("test", keep_all=True)
    for number in range(20):
        channel.submit(heard.request(lambda job, number=number: number))
    qtbot.waitUntil(lambda: not channel.busy)
    assert heard.answers == list(range(20))


def test_the_next_request_starts_after_the_answer_was_taken(qtbot):
    channel, state = Channel("test", keep_all=True), {"value": 0}
    for _ in range(10):
        channel.submit(
            Request(
                lambda job: state["value"] + 1,
                lambda answer: state.update(value=answer),
                lambda problem: None,
            )
        )
    qtbot.waitUntil(lambda: not channel.busy)
    assert state["value"] == 10


def test_a_cancelled_run_answers_nothing(qtbot, heard):
    channel, started = Channel("test"), threading.Event()

    def work(job):
        started.set()
        while True:
            job.checkpoint(0.5, "going round")
            time.sleep(0.002)

    channel.submit(heard.request(work))
    assert started.wait(5)
    channel.cancel()
    qtbot.waitUntil(lambda: not channel.busy)
    assert heard.answers == []
    assert heard.problems == []


def test_an_exception_reaches_failed_unless_it_is_a_cancellation(qtbot, heard):
    channel = Channel("test", keep_all=True)

    def broken(job):
        raise ZeroDivisionError

    def cancelled(job):
        raise Cancelled

    channel.submit(heard.request(broken))
    channel.submit(heard.request(cancelled))
    qtbot.waitUntil(lambda: not channel.busy)
    assert [type(problem) for problem in heard.problems] == [ZeroDivisionError]


def test_a_hung_request_is_left_behind_and_the_next_one_runs(qtbot, heard):
    channel, gate = Channel("test", keep_all=True, time_limit=0.2), threading.Event()
    channel.submit(heard.request(lambda job: gate.wait(30)))
    channel.submit(heard.request(lambda job: "alive"))
    qtbot.waitUntil(lambda: heard.answers == ["alive"], timeout=5000)
    assert [type(problem) for problem in heard.problems] == [Hung]
    gate.set()
    qtbot.wait(50)
    assert heard.answers == ["alive"]


def test_cancelling_a_request_that_does_not_listen_frees_the_channel(qtbot, heard):
    channel, gate = Channel("test"), threading.Event()
    channel.submit(heard.request(lambda job: gate.wait(30)))
    channel.cancel()
    channel.submit(heard.request(lambda job: "alive"))
    qtbot.waitUntil(lambda: heard.answers == ["alive"], timeout=5000)
    gate.set()


@pytest.mark.parametrize("how", ["cancelled", "left behind", "channel deleted"])
def test_an_answer_that_nobody_takes_is_handed_back(qtbot, heard, how, monkeypatch):
    """It may hold a lock, for instance."""
    monkeypatch.setattr("bozzetto_app.workers.channel.GRACE", 0.1)
    channel = Channel("test")
    begun, gate, back = threading.Event(), threading.Event(), []

    def work(job):
        begun.set()
        gate.wait(30)
        return "held"

    channel.submit(replace(heard.request(work), dropped=back.append))
    assert begun.wait(5)
    if how == "channel deleted":
        delete(channel)
    else:
        channel.cancel()
    if how == "left behind":
        qtbot.waitUntil(lambda: not channel.busy)
    gate.set()
    qtbot.waitUntil(lambda: back == ["held"])
    assert heard.answers == []


def test_an_answer_that_was_taken_or_failed_is_not_handed_back(qtbot, heard):
    channel, back = Channel("test", keep_all=True), []
    channel.submit(replace(heard.request(lambda job: "taken"), dropped=back.append))
    channel.submit(replace(heard.request(lambda job: 1 / 0), dropped=back.append))
    qtbot.waitUntil(lambda: not channel.busy)
    assert (heard.answers, back) == (["taken"], [])


def test_progress_of_the_running_request_is_heard(qtbot, heard):
    channel, seen = Channel("test"), []
    channel.progressed.connect(lambda fraction, step: seen.append((fraction, step)))
    channel.submit(heard.request(lambda job: job.checkpoint(0.25, "a quarter")))
    qtbot.waitUntil(lambda: not channel.busy)
    assert seen == [(0.25, "a quarter")]


def test_a_patient_channel_tells_that_work_is_slow_and_waits_for_it(qtbot, heard):
    channel = Channel("test", time_limit=0.2, is_patient=True)
    gate, told = threading.Event(), []
    channel.slow.connect(told.append)
    ends: list[bool] = []
    channel.caught_up.connect(lambda: ends.append(channel.busy))
    channel.submit(heard.request(lambda job: gate.wait(20) and "late, but here"))
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    assert [type(problem) for problem in told] == [Hung]
    assert channel.busy
    assert not ends
    gate.set()
    qtbot.waitUntil(lambda: not channel.busy, timeout=10_000)
    assert ends == [False]
    assert heard.answers == ["late, but here"]
    assert heard.problems == []
    assert [problem.is_again for problem in told] == [False] + [True] * (len(told) - 1)


def test_slow_work_is_named_once_it_has_come_to_a_plugin(qtbot, heard):
    calls: dict[threading.Thread, tuple[str, str]] = {}
    guard = SimpleNamespace(
        caught_in=calls.get,
        suspect=lambda *_: SimpleNamespace(plugin="maria.lathe", details="a stack"),
    )
    notices, channel = Notices(guard), Channel("test", time_limit=0.1, is_patient=True)
    notices.watch(channel)
    told, workers, gate = [], [], threading.Event()
    notices.noticed.connect(told.append)
    channel.slow.connect(lambda problem: workers.append(problem.thread))
    channel.submit(heard.request(lambda job: gate.wait(20)))
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    qtbot.wait(400)
    assert [notice.plugin for notice in told] == [""]
    calls[workers[0]] = ("maria.lathe", "tools")
    qtbot.waitUntil(lambda: len(told) == 2, timeout=10_000)
    qtbot.wait(400)
    assert [notice.plugin for notice in told] == ["", "maria.lathe"]
    assert "tools" in told[1].text
    gate.set()
    qtbot.waitUntil(lambda: not channel.busy, timeout=10_000)


def test_slow_work_that_does_not_listen_can_be_stopped(qtbot, heard, monkeypatch):
    monkeypatch.setattr("bozzetto_app.workers.channel.GRACE", 0.1)
    channel = Channel("test", time_limit=0.2, is_patient=True)
    gate, told = threading.Event(), []
    channel.slow.connect(told.append)
    channel.submit(heard.request(lambda job: gate.wait(20)))
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    with qtbot.waitSignal(channel.caught_up, timeout=10_000):
        channel.cancel()
    qtbot.waitUntil(lambda: not channel.busy, timeout=10_000)
    with qtbot.assertNotEmitted(channel.caught_up):
        channel.submit(heard.request(lambda job: "the next"))
        qtbot.waitUntil(lambda: heard.answers == ["the next"], timeout=10_000)
    gate.set()


def test_a_thread_does_one_request_after_another_and_ends_when_idle(qtbot, heard, monkeypatch):
    monkeypatch.setattr("bozzetto_app.workers.channel.IDLE", 0.1)
    channel = Channel("test", keep_all=True)
    for _ in range(5):
        channel.submit(heard.request(lambda job: threading.current_thread()))
    qtbot.waitUntil(lambda: len(heard.answers) == 5, timeout=10_000)
    assert len(set(heard.answers)) == 1
    qtbot.waitUntil(lambda: not heard.answers[0].is_alive(), timeout=10_000)
    channel.submit(heard.request(lambda job: "again"))
    qtbot.waitUntil(lambda: heard.answers[-1] == "again", timeout=10_000)


def test_work_in_a_queue_gets_what_the_window_has_when_its_turn_comes(qtbot, heard):
    channel = Channel("test", keep_all=True)
    state, threads = [0], []

    def inputs():
        threads.append(threading.get_ident())
        return state[0]

    def answered(answer):
        heard.answers.append(answer)
        state[0] += 10

    for _ in range(3):
        channel.submit(
            Request(lambda job, found: found + 1, answered, heard.problems.append, inputs=inputs)
        )
    qtbot.waitUntil(lambda: len(heard.answers) == 3)
    assert heard.answers == [1, 11, 21]
    assert set(threads) == {threading.get_ident()}


def test_what_work_held_ends_on_the_windows_thread(qtbot, heard, monkeypatch):
    """Qt objects that a worker lets go of last would be destroyed there."""
    ended = []

    class Held:
        def __del__(self):
            ended.append(threading.get_ident())

    def slowly(*arguments, **options):
        call_on_main_thread(*arguments, **options)
        time.sleep(0.2)  # the window has long forgotten the answer when the worker goes on

    monkeypatch.setattr("bozzetto_app.workers.channel.call_on_main_thread", slowly)
    channel = Channel("test")
    for _ in range(2):
        held = Held()
        channel.submit(heard.request(lambda job, held=held: type(held).__name__))
        del held
        qtbot.waitUntil(lambda: not channel.busy)
    qtbot.waitUntil(lambda: len(ended) == 2)
    assert ended == [threading.get_ident()] * 2
    assert heard.answers == ["Held", "Held"]


def test_work_during_which_the_machine_slept_is_not_late(qtbot, monkeypatch):
    channel, ahead = Channel("test", time_limit=3.0), [0.0]
    real = time.monotonic
    monkeypatch.setattr("bozzetto.awake_time.time.monotonic", lambda: real() + ahead[0])
    answers, problems = [], []

    def work(job):
        ahead[0] += 3600.0
        time.sleep(0.3)  # the window looks at the clock meanwhile
        return "answer"

    channel.submit(Request(work, answers.append, problems.append))
    qtbot.waitUntil(lambda: bool(answers or problems), timeout=20_000)
    assert (answers, problems) == (["answer"], [])
