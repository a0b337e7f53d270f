"""Whatever is done in whatever order, no stroke goes without an answer.

The keeper runs on a pretended session whose disk and whose loads take their turn only when
the test says so: crashes, loads, questions, saves and failures come in any order.
"""

from __future__ import annotations

import contextlib
import errno
import os
import queue
import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import ClassVar
from unittest import mock

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Document, Model
from bozzetto.document.recovery import recovery, recovery_session
from bozzetto.document.recovery.file_lock import FileLock
from bozzetto.document.recovery.journal import JournalWriter
from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.document.waiting_ink import WaitingStroke, strokes_of
from bozzetto.errors import UserError
from bozzetto.ink.stroke import Strokes
from bozzetto.plugin.job import Job
from bozzetto_app.session import autosave as keeping
from bozzetto_app.session.autosave import Keeper
from bozzetto_app.session.document_locks import Claim
from bozzetto_app.session.document_model import DocumentModel
from bozzetto_app.session.drawing_record import DrawingRecord
from bozzetto_app.session.notices import Notices
from bozzetto_app.workers.main_thread import install
from tests.disk_faults import watch
from tests.document_kit import FakeRegistry, Ink, stroke
from tests.sizes import sized

INK = [stroke(number, 2) for number in range(200)]
NUMBER = {id(one): number for number, one in enumerate(INK)}


def document_of(strokes):
    return Document((Model("m", "Ink", "test.ink", Ink(Strokes(strokes))),))


def numbers(document):
    """Which strokes a drawing has."""
    found = set()
    for one in [*(s for m in document for s in m.state.strokes), *strokes_of(document.waiting)]:
        found.add(NUMBER[id(one)] if id(one) in NUMBER else INK.index(one))
    return found


class Thread:
    """A thread that does nothing by itself, but to give back what nobody wants."""

    def __init__(self, target=None, name="", args=(), **_):
        self.given_back = partial(target, *args) if name == "bozzetto-unlock" else None

    def start(self):
        if self.given_back is not None:
            self.given_back()

    def join(self, _=None):
        pass


class Loads:
    """A channel whose requests are done when the test says so."""

    def __init__(self, *_, **__):
        self.waiting = []

    def submit(self, request):
        self.waiting.append(request)

    def turn(self):
        request = self.waiting.pop(0)
        try:
            inputs = () if request.inputs is None else (request.inputs(),)
            answer = request.work(Job(), *inputs)
        except UserError as problem:
            request.failed(problem)
        else:
            request.done(answer)

    def stop(self, has_begun):
        """The person stops it, before it has begun or while it is worked on."""
        request = self.waiting.pop(0)
        request.stopped()
        if has_begun:
            with contextlib.suppress(UserError):
                request.dropped(request.work(Job(), request.inputs()))


class FakeFiles(QObject):
    """Files without a disk; their questions wait for an answer of the test's."""

    saved = Signal(object)
    given_up = Signal()
    lock = stamp = None

    def __init__(self, drawing):
        super().__init__(drawing)
        self.drawing = drawing
        self.question = None
        self.saving = None
        self.loads = Loads()
        self.read = self.loads.submit

    def claim(self, path, held):
        return Claim(None)

    def leave(self, claim):
        pass

    def show(self, claim, document, path, *, saved=True, pending=(), stamp=None):
        assert not pending, "only journals of earlier versions have ink beside the document"
        self.drawing.show(document, path, saved=saved)

    def when_safe(self, then, refused=None):
        if not self.drawing.is_modified:
            then()
        elif self.question is not None or self.saving is not None:
            (refused or (lambda: None))()
        else:
            self.question = then, refused or (lambda: None)


class FakeSession(QObject):
    """A session with a real document, and nobody to talk to."""

    def __init__(self):
        super().__init__()
        self.registry = FakeRegistry()
        self.drawing = DocumentModel(self)
        self.files = FakeFiles(self.drawing)
        self.notices = mock.Mock(spec=Notices)

    def draw(self, one, waits):
        document = self.drawing.document
        if waits:
            self.drawing.set_waiting("Draw", (*document.waiting, WaitingStroke(one)))
            return
        strokes = [s for m in document for s in m.state.strokes]
        self.drawing.commit("Draw", document_of([*strokes, *strokes_of(document.waiting), one]))


class Record(DrawingRecord):
    """A record that tells what it has written, and whether it could not."""

    def __init__(self, orders, *asked):
        super().__init__(*asked)
        self.orders = orders

    def write(self, now):
        self.orders.unwritten.add(self)
        super().write(now)
        self.orders.unwritten.remove(self)
        self.orders.on_disk |= frozenset(numbers(now.document))


class Lock(FileLock):
    """A lock that a dead process gives back."""

    taken: ClassVar[list] = []

    def __init__(self, *asked):
        super().__init__(*asked)
        self.taken.append(self)


class Journal(JournalWriter):
    """A journal that a dead process closes."""

    open: ClassVar[list] = []

    def __init__(self, *asked):
        super().__init__(*asked)
        self.open.append(self)


class Orders(RuleBasedStateMachine):
    """All strokes that reached the disk are found until they are saved or given up."""

    def __init__(self):
        super().__init__()
        self.folder = Path(tempfile.mkdtemp(prefix="bozzetto-orders-"))
        self.patches = [
            mock.patch.object(os, "fsync", return_value=None),
            mock.patch.object(keeping.threading, "Thread", Thread),
            mock.patch.object(keeping, "Channel", Loads),
            mock.patch.object(keeping, "DrawingRecord", partial(Record, self)),
            mock.patch.object(recovery, "FileLock", Lock),
            mock.patch.object(recovery_session, "JournalWriter", Journal),
        ]
        for patch in self.patches:
            patch.start()
        self.drawn = self.on_disk = self.answered = self.in_files = self.excused = frozenset()
        self.next = 0
        self.start()

    def start(self):
        self.session = FakeSession()
        self.tasks: queue.Queue = queue.Queue()
        self.keeper = Keeper(self.session, self.folder, self.tasks)
        self.unwritten = set()

    def sheet(self):
        return frozenset(numbers(self.session.drawing.document))

    # -- the disk --

    def turn(self):
        task = self.tasks.get_nowait()
        try:
            if task is not None:
                task()
        except UserError:
            pass
        finally:
            self.tasks.task_done()

    def drain(self):
        while not self.tasks.empty():
            self.turn()

    @precondition(lambda self: not self.tasks.empty())
    @rule()
    def disk_has_a_turn(self):
        self.turn()

    @precondition(lambda self: not self.tasks.empty())
    @rule(number=st.sampled_from([errno.EIO, errno.ENOSPC]), after=st.integers(0, 30))
    def disk_fails(self, number, after):
        left = [after]

        def before(name, size):
            left[0] -= 1
            if left[0] < 0 and name not in ("close", "unlink", "rmdir"):
                raise OSError(number, os.strerror(number))

        with watch(self.folder, before):
            self.turn()

    # -- the person --

    @precondition(lambda self: self.next < len(INK))
    @rule(waits=st.booleans())
    def draw(self, waits):
        self.drawn |= {self.next}
        self.session.draw(INK[self.next], waits)
        self.next += 1

    @rule()
    def new(self):
        self.session.files.when_safe(lambda: self.session.drawing.show(Document(), None))

    @rule()
    def replaced_without_a_question(self):
        self.session.drawing.show(Document(), None)

    @rule(which=st.integers(0, 5))
    def open_crashed(self, which):
        offered = RecoveryStore(self.folder).crashed_sessions()
        if offered:
            self.keeper.recover(offered[which % len(offered)])

    @precondition(lambda self: self.session.files.loads.waiting)
    @rule()
    def load_ends(self):
        self.session.files.loads.turn()

    @precondition(lambda self: self.session.files.loads.waiting)
    @rule(has_begun=st.booleans())
    def load_is_stopped(self, has_begun):
        self.session.files.loads.stop(has_begun)

    @precondition(lambda self: self.session.files.question is not None)
    @rule(answer=st.sampled_from(["cancel", "give up", "save"]))
    def answer(self, answer):
        (then, refused), self.session.files.question = self.session.files.question, None
        if answer == "give up":
            self.answered |= self.sheet()
            self.session.files.given_up.emit()
            then()
        elif answer == "cancel":
            refused()
        else:
            self.begin_save(lambda: self.session.files.when_safe(then, refused), refused)

    @precondition(
        lambda self: self.session.files.saving is None and self.session.files.question is None
    )
    @rule()
    def save(self):
        self.begin_save(lambda: None, lambda: None)

    def begin_save(self, then, failed):
        self.session.files.saving = (
            self.session.drawing.history,
            self.session.drawing.document,
            then,
            failed,
        )

    @precondition(lambda self: self.session.files.saving is not None)
    @rule(works=st.booleans())
    def save_ends(self, works):
        (history, snapshot, then, failed), self.session.files.saving = (
            self.session.files.saving,
            None,
        )
        if not works:
            failed()
            return
        self.in_files |= frozenset(numbers(snapshot))
        if self.session.drawing.history is history:
            self.session.drawing.saved_as(Path("/drawings/a.bozz"), snapshot)
            self.session.files.saved.emit(self.session.drawing.path)
        then()

    # -- the end --

    @rule(at_once=st.booleans())
    def crash(self, at_once):
        if not at_once:
            self.drain()
        self.excused |= self.drawn - self.on_disk
        self.release_everything()
        self.start()

    def release_everything(self):
        """The system gives back what a dead process held; its lock files stay."""
        while Journal.open:
            Journal.open.pop().close()
        while Lock.taken:
            lock = Lock.taken.pop()
            content = lock.path.read_bytes() if lock.is_held else None
            lock.release()
            if content is not None:
                lock.path.write_bytes(content)

    @rule()
    def close(self):
        self.keeper.close()
        self.drain()
        self.excused |= self.drawn - self.on_disk
        self.release_everything()
        self.start()

    @invariant()
    def nothing_is_lost(self):
        """Look as a new process would, with the disk as it is at this moment."""
        expected = self.on_disk - self.answered - self.in_files - self.excused
        with tempfile.TemporaryDirectory(prefix="bozzetto-orders-") as place:
            copy = Path(place, "copy")
            if self.folder.exists():
                shutil.copytree(self.folder, copy)
            for lock in copy.glob("*/lock"):
                lock.unlink()
            store = RecoveryStore(copy)
            found = set()
            for session in store.crashed_sessions():
                back = store.recover(session, FakeRegistry())
                found |= numbers(back.document)
        assert expected <= found, (expected - found, sorted(os.listdir(self.folder)))

    def teardown(self):
        self.drain()
        self.keeper.close()
        self.drain()
        if not self.unwritten:
            self.on_disk |= self.drawn - self.excused
            self.nothing_is_lost()
        self.release_everything()
        for patch in reversed(self.patches):
            patch.stop()
        shutil.rmtree(self.folder, ignore_errors=True)


@pytest.fixture(autouse=True)
def _window_thread(qapp):
    install()


def test_a_stroke_that_is_written_before_the_save_of_an_earlier_one_is_kept():
    orders = Orders()
    orders.draw(waits=False)
    orders.save()
    orders.save_ends(works=True)
    orders.draw(waits=False)
    orders.close()  # only now does the disk take its turns
    orders.nothing_is_lost()
    orders.teardown()


def explore(examples):
    """Try orders of thirty steps; the same ones every time."""
    run_state_machine_as_test(
        Orders,
        settings=settings(
            max_examples=examples,
            stateful_step_count=30,
            deadline=None,
            derandomize=True,
            database=None,
            suppress_health_check=list(HealthCheck),
        ),
    )


def test_some_orders_lose_nothing():
    explore(6)


@pytest.mark.slow
def test_many_orders_lose_nothing():
    explore(sized(40, 200))
