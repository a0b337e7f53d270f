"""Nothing is lost while a drawing is brought back: faults at every call, and all orders."""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import shutil

import pytest

from bozzetto.document.model import Document, Model
from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.document.waiting_ink import WaitingStroke, strokes_of
from bozzetto.errors import UserError
from bozzetto.ink.stroke import Strokes
from bozzetto_app.session.drawing_record import BroughtBack, DrawingRecord, Snapshot, State
from tests.disk_faults import fail_at, full_after, watch
from tests.document_kit import FakeRegistry, Ink, stroke

STROKES = [stroke(number) for number in range(10)]


def drawn(*numbers, pending=()):
    """A drawing of numbered strokes: some applied, some waiting."""
    state = Ink(Strokes([stroke(number) for number in numbers]))
    document = Document((Model("m", "Ink", "test.ink", state),))
    return Snapshot("Drawing", None, None, waiting_too(document, *pending))


def waiting_too(document, *numbers):
    more = (WaitingStroke(stroke(number)) for number in numbers)
    return document.with_waiting((*document.waiting, *more))


def crashed(folder, *numbers, pending=()):
    record = DrawingRecord(RecoveryStore(folder))
    record.write(drawn())
    record.write(drawn(*numbers, pending=pending))
    record.set_aside()  # offered again, as after a crash


def kept(folder):
    """What is offered: for each drawing, the numbers of its strokes."""
    store = RecoveryStore(folder)
    found = []
    for session in store.crashed_sessions():
        back = store.recover(session, FakeRegistry())
        ink = [*back.document.models[0].state.strokes, *strokes_of(back.document.waiting)]
        found.append(tuple(n for n, one in enumerate(STROKES) if one in ink))
        store.keep(session)
    return sorted(found)


def bring_back(store, session):
    """Bring a drawing back; its record, and how it is."""
    back = store.recover(session, FakeRegistry())
    record = DrawingRecord(store, BroughtBack(session, back.is_whole))
    return record, Snapshot("Drawing", None, None, back.document)


@pytest.fixture
def fast(monkeypatch):
    """No waiting for the real disk: what is tested is the order of the calls."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def bring_back_and_draw(folder, states):
    """What a window does: look, bring back, write, go on drawing."""
    store = RecoveryStore(folder)
    store.tidy()
    for session in store.crashed_sessions():
        record, now = bring_back(store, session)
        states.append(record)
        record.write(now)
        record.write(now._replace(document=waiting_too(now.document, 9)))


ORDERS = [*itertools.permutations(range(5))]
SLOW = pytest.mark.slow
EVERY_CALL = [pytest.param(n, 1, marks=SLOW) for n in (errno.EIO, errno.EDQUOT, errno.EACCES)]


@pytest.mark.parametrize(("number", "step"), [(errno.EIO, 5), *EVERY_CALL])
def test_a_fault_at_any_call_of_a_recovery_loses_nothing(tmp_path, fast, number, step):
    whole = tmp_path / "whole"
    crashed(whole, 1, 2, pending=[3])
    failures = 0
    for k in itertools.count(1, step):
        folder = tmp_path / str(k)
        shutil.copytree(whole, folder)
        records: list[DrawingRecord] = []
        with watch(folder, fail_at(k, number)) as calls:
            try:
                bring_back_and_draw(folder, records)
            except UserError:
                failures += 1
        for record in records:
            record.set_aside()
        offered = kept(folder)
        assert any({1, 2, 3} <= set(strokes) for strokes in offered), (k, calls.names)
        shutil.rmtree(folder)
        if len(calls.names) < k:
            break
    assert k > 40
    assert failures > 10 / step


def test_a_quota_anywhere_in_a_recovery_loses_nothing(tmp_path, fast):
    whole = tmp_path / "whole"
    crashed(whole, 1, 2, pending=[3])
    for size in range(0, 6000, 397):
        folder = tmp_path / str(size)
        shutil.copytree(whole, folder)
        records: list[DrawingRecord] = []
        with watch(folder, full_after(size)), contextlib.suppress(UserError):
            bring_back_and_draw(folder, records)
        for record in records:
            record.set_aside()
        assert any({1, 2, 3} <= set(strokes) for strokes in kept(folder)), size
        shutil.rmtree(folder)


def test_a_fault_at_any_call_while_giving_up_tells_nobody_a_half(tmp_path, fast):
    k = 0
    while True:
        k += 1
        folder = tmp_path / str(k)
        record = DrawingRecord(RecoveryStore(folder))
        record.write(drawn())
        record.write(drawn(1, 2))
        with watch(folder, fail_at(k)) as calls:
            record.give_up()
        assert record.state is State.LEFT
        left = tmp_path / f"left {k}"  # as another process finds it: nobody holds its lock files
        shutil.copytree(folder, left)
        assert kept(left) in ([], [(1, 2)]), calls.names
        if len(calls.names) < k:
            break
    assert k > 5


@pytest.mark.parametrize(
    "order",
    [order if n % 40 == 17 else pytest.param(order, marks=SLOW) for n, order in enumerate(ORDERS)],
)
def test_five_crashed_drawings_opened_in_every_order_and_twice(tmp_path, fast, order):
    for number in range(5):
        crashed(tmp_path, number)
    store = RecoveryStore(tmp_path)
    sessions = {}
    for session in store.crashed_sessions():
        record, now = bring_back(store, session)
        ink = now.document.models[0].state.strokes
        sessions[next(n for n in range(5) if stroke(n) in ink)] = session
        record.set_aside()
    left = set(range(5))
    for number in order:
        record, now = bring_back(store, sessions[number])
        with pytest.raises(UserError, match="already"):
            store.recover(sessions[number], FakeRegistry())
        record.write(now)
        with pytest.raises(UserError, match="already"):
            store.recover(sessions[number], FakeRegistry())
        assert kept(tmp_path) == sorted((n,) for n in left - {number})
        before = {session.id for session in store.crashed_sessions()}
        record.set_aside()  # replaced by the next one, without an answer
        assert kept(tmp_path) == sorted((n,) for n in left)
        if number % 2:
            (found,) = [s for s in store.crashed_sessions() if s.id not in before]
            again, _ = bring_back(store, found)
            again.give_up()
            left.discard(number)
        assert kept(tmp_path) == sorted((n,) for n in left)
