from __future__ import annotations

import threading

import pytest

from bozzetto.document.storage.state_codec import state_digest
from bozzetto.errors import Cancelled, UserError
from bozzetto.plugin.guard import watchdog
from bozzetto.plugin.guard.guard import Guard, PluginFault
from bozzetto.plugin.guard.watchdog import Watchdog, interrupt
from bozzetto.testing import Pen


@pytest.fixture(autouse=True)
def short_grace(monkeypatch):
    monkeypatch.setattr(watchdog, "GRACE", 0.3)


def forever():
    while True:
        pass


def stubborn():
    while True:
        try:
            while True:
                pass
        except Exception:
            pass


def test_answers_and_errors_come_through():
    dog = Watchdog(Guard(), 20.0)
    assert dog.call("a.b", "solve", lambda x: x + 1, 2) == 3
    for problem in (UserError("no"), Cancelled()):

        def fail(problem=problem):
            raise problem

        with pytest.raises(type(problem)):
            dog.call("a.b", "solve", fail)
    with pytest.raises(PluginFault, match="ZeroDivisionError"):
        dog.call("a.b", "solve", lambda: 1 / 0)


@pytest.mark.parametrize("loop", [forever, stubborn])
def test_a_loop_in_python_is_ended(loop):
    guard, threads = Guard(), []

    def work():
        threads.append(threading.current_thread())
        loop()

    with pytest.raises(PluginFault, match=r"did not answer within 0\.1 s") as caught:
        Watchdog(guard, 0.1).call("a.b", "solve", work)
    threads[0].join(20)
    assert not threads[0].is_alive()
    assert loop.__name__ in caught.value.details
    assert guard.faults("a.b") == 1


def test_a_thread_that_waits_in_c_is_abandoned_and_said_so():
    release = threading.Event()
    try:
        with pytest.raises(PluginFault, match="could not be stopped"):
            Watchdog(Guard(), 0.1).call("a.b", "solve", release.wait, 60)
    finally:
        release.set()


def test_a_hung_modeler_leaves_the_document_as_it_was(workshop, faulty):
    workshop.draw(Pen().circle())
    digest, document = state_digest(workshop.state), workshop.document

    def hang(state, job):
        object.__setattr__(state, "size", 9.0)
        forever()

    faulty.misdeeds["solve"] = hang
    dog = Watchdog(workshop.registry.guard, 0.1)
    for _ in range(3):
        with pytest.raises(PluginFault, match="did not answer"):
            dog.call("faulty.modeler", "solve", faulty.solve, workshop.state, None)
    assert workshop.document is document
    assert state_digest(workshop.state) == digest
    assert workshop.registry.guard.is_off("faulty.plugin")


def test_interrupting_what_has_ended_does_nothing():
    thread = threading.Thread(target=lambda: None)
    assert not interrupt(thread)
    thread.start()
    thread.join()
    assert not interrupt(thread)
