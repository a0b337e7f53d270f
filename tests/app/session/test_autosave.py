"""Nothing that was drawn is lost: the journal, a killed process, and the next start."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QMessageBox, QPushButton
from shiboken6 import delete

from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.document.waiting_ink import WaitingStroke
from bozzetto.errors import UserError
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.host.switched_off import switched_off
from bozzetto_app.dialogs.recovery import RecoveryDialog
from bozzetto_app.paths import crash_log
from bozzetto_app.session.autosave import Keeper
from bozzetto_app.session.drawing_record import DrawingRecord
from bozzetto_app.workers.channel import Channel
from tests.app import drawing_child
from tests.app.tablet import circle, draw, stroke_of
from tests.app.troublemaker import MODELER, PLUGIN
from tests.dead_process import left_behind

ROOT = Path(__file__).parents[3]
DEFAULT_KILLS, MANY_KILLS = 2, 30

MACHINE = 1.0
"""Seconds that a machine which others use as well may need more, for the thread that writes."""


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "recovery"


@pytest.fixture
def keep(make_session, boxes, folder, settle):
    """A session that draws boxes and is kept; and its keeper."""
    keepers = []

    def make():
        session = make_session(MODELER, extra=[boxes.package])
        keeper = Keeper(session, folder)
        keepers.append(keeper)
        return session, keeper

    yield make
    for keeper in keepers:
        keeper.close()
        keeper.wait()


@pytest.fixture
def crash(folder):
    """A function that lets the process of a keeper die: what it kept stays, held by nobody."""

    def die(keeper):
        with left_behind(folder) as left:
            keeper.close()
            keeper.wait()
        assert left

    return die


def kept_strokes(folder, registry=None):
    """How many strokes each crashed session has, applied and waiting."""
    store = RecoveryStore(folder)
    found = []
    for crashed in store.crashed_sessions():
        back = store.recover(crashed, registry or Registry())
        applied = sum(strokes_of(model.state) for model in back.document)
        found.append(applied + len(back.document.waiting))
        store.keep(crashed)
    return found


def strokes_of(state):
    if hasattr(state, "parts"):
        return sum(len(part.strokes) for part in state.parts)
    return len(state.strokes)


# -- the journal -----------------------------------------------------------------------------------


def test_every_stroke_is_kept_applied_or_waiting(keep, folder, settle, crash):
    session, keeper = keep()
    assert not list(folder.glob("*"))  # nothing was drawn: nothing is kept
    draw(session, settle, keeper)
    draw(session, settle, keeper, share=0.5)
    crash(keeper)
    assert kept_strokes(folder, session.registry) == [2]


def test_a_stroke_that_was_taken_back_is_not_kept(keep, folder, settle, crash):
    session, keeper = keep()
    draw(session, settle, keeper)
    draw(session, settle, keeper, share=0.5)
    session.gestures.drop_last()
    settle(session, keeper)
    crash(keeper)
    assert kept_strokes(folder, session.registry) == [1]


def test_at_no_moment_is_a_stroke_in_neither_place(keep, settle, monkeypatch):
    session, keeper = keep()
    shown, written = [], []

    def strokes_in(document):
        return sum(strokes_of(model.state) for model in document) + len(document.waiting)

    def look():
        shown.append(strokes_in(session.drawing.document))

    monkeypatch.setattr(
        DrawingRecord, "write", lambda record, now: written.append(strokes_in(now.document))
    )
    session.drawing.waiting_changed.connect(look)
    session.drawing.changed.connect(look)
    for radius in range(40, 100, 10):
        draw(session, settle, keeper, radius=radius)
    for totals in (shown, written):
        assert totals == sorted(totals)
        assert totals[-1] == 6


def test_a_drag_is_kept_while_it_goes_on(keep, crash, folder, settle, qtbot):
    """Nothing rests, so there is no other time to write it down."""
    session, keeper = keep()
    draw(session, settle, keeper)
    sizes = iter(range(20, 100_000))
    (journal,) = folder.glob("*/journal-*")
    before = journal.stat().st_size

    def kept():
        session.objects.set_parameter("size", 1e-3 * next(sizes) + 20.0, dragging=True)
        return journal.stat().st_size - before

    qtbot.waitUntil(lambda: kept() > 0)
    assert session.drawing.is_dragging
    qtbot.waitUntil(lambda: not keeper.busy)
    crash(keeper)
    store = RecoveryStore(folder)
    (crashed,) = store.crashed_sessions()
    (model,) = store.recover(crashed, session.registry).document
    assert model.state.size > 20.0


def test_a_live_session_is_not_offered_to_others(keep, folder, settle):
    one, first = keep()
    two, second = keep()
    draw(one, settle, first)
    draw(two, settle, second)
    assert len(list(folder.glob("*/"))) == 2
    assert RecoveryStore(folder).crashed_sessions() == []


def test_what_the_person_gives_up_leaves_nothing_behind(keep, folder, settle):
    session, keeper = keep()
    draw(session, settle, keeper)
    session.files.given_up.emit()
    session.files.new()
    settle(session, keeper)
    assert list(folder.glob("*")) == []
    draw(session, settle, keeper)
    session.files.given_up.emit()
    keeper.close()
    keeper.wait()
    assert list(folder.glob("*")) == []


def test_what_leaves_the_sheet_without_an_answer_is_offered_again(keep, folder, settle):
    session, keeper = keep()
    draw(session, settle, keeper)
    session.files.given_up.emit()
    draw(session, settle, keeper, radius=50)  # the answer was not about this stroke
    session.files.new()
    draw(session, settle, keeper)
    keeper.close()
    keeper.wait()
    assert sorted(kept_strokes(folder, session.registry)) == [1, 2]
    assert any("is kept" in notice.text for notice in session.heard)


def test_a_window_that_ends_in_any_way_lets_go_of_its_drawing(keep, folder, settle):
    session, keeper = keep()
    draw(session, settle, keeper)
    delete(keeper)  # as its window does when it is deleted without being closed
    keeper.wait()
    assert kept_strokes(folder, session.registry) == [1]


def test_a_drawing_that_comes_back_when_its_window_is_gone_is_offered_again(
    keep, crash, folder, settle, qtbot, monkeypatch
):
    session, keeper = keep()
    draw(session, settle, keeper)
    crash(keeper)
    (crashed,) = RecoveryStore(folder).crashed_sessions()
    other, second = keep()
    begun, gate, recover = threading.Event(), threading.Event(), RecoveryStore.recover

    def slow(store, *arguments):
        answer = recover(store, *arguments)
        begun.set()
        gate.wait(10)
        return answer

    with monkeypatch.context() as patch:
        patch.setattr(RecoveryStore, "recover", slow)
        second.recover(crashed)
        assert begun.wait(10)
        assert RecoveryStore(folder).crashed_sessions() == []
        delete(other.files)
        gate.set()
        qtbot.waitUntil(lambda: RecoveryStore(folder).crashed_sessions() == [crashed])


def test_what_could_not_be_written_when_it_left_is_written_later(
    keep, folder, settle, monkeypatch, crash
):
    session, keeper = keep()

    def full(*_):
        raise UserError("The disk is full. Make room.")

    with monkeypatch.context() as patch:
        patch.setattr(RecoveryStore, "begin", full)
        draw(session, settle, keeper)
        session.files.new()
        settle(session, keeper)
        assert not list(folder.glob("*/*"))
    draw(session, settle, keeper)
    crash(keeper)
    assert kept_strokes(folder, session.registry) == [1, 1]


def test_what_is_drawn_while_a_save_is_under_way_is_kept_too(keep, folder, settle, tmp_path, crash):
    session, keeper = keep()
    draw(session, settle, keeper)
    session.files.save(tmp_path / "a.bozz")
    draw(session, settle, keeper, radius=50)
    draw(session, settle, keeper, share=0.5)
    crash(keeper)
    (crashed,) = RecoveryStore(folder).crashed_sessions()
    assert crashed.name == "a"
    assert crashed.path == tmp_path / "a.bozz"
    assert kept_strokes(folder, session.registry) == [3]


def test_recovering_shows_the_drawing_unsaved_and_forgets_the_old_data_only_then(
    keep, crash, folder, settle
):
    session, keeper = keep()
    draw(session, settle, keeper)
    draw(session, settle, keeper, share=0.5)
    crash(keeper)
    later, other = keep()
    found = []
    other.find_crashed(found.extend)
    settle(later, other)
    other.recover(found[0])
    settle(later, other)
    assert [strokes_of(model.state) for model in later.drawing.document] == [1]
    assert len(later.drawing.pending) == 1
    assert later.drawing.is_modified
    assert RecoveryStore(folder).crashed_sessions() == []
    crash(other)
    assert kept_strokes(folder, later.registry) == [2]


@pytest.fixture
def offered(make_window, keep, boxes, folder, settle, qtbot, crash):
    """A window that offers so many crashed drawings of one stroke each; and its dialog."""

    def make(count):
        for _ in range(count):
            session, keeper = keep()
            draw(session, settle, keeper)
            crash(keeper)
        window = make_window(MODELER, extra=[boxes.package], recovery=folder)
        window.offer_recovery()
        qtbot.waitUntil(lambda: window.findChild(RecoveryDialog) is not None, timeout=10_000)
        return window, window.findChild(RecoveryDialog)

    return make


def test_the_plugin_in_which_the_program_crashed_can_be_switched_off_before(
    offered, boxes, settle, qtbot
):
    folder = Registry(extra=[boxes.package]).info(MODELER).icon.parent
    crash_log().write_text(
        "Fatal Python error: Segmentation fault\n\n"
        'Current thread 0x1 (most recent call first):\n  File "/elsewhere/native.py", line 4 in f\n'
        f'  File "{folder / "modeler.py"}", line 3 in solve\n'
    )
    window, dialog = offered(1)
    dialog.findChild(QPushButton, "switch-off-suspect").click()
    assert PLUGIN in switched_off()
    solved = boxes.calls["solve"]
    buttons(dialog, "Open")[0].click()
    qtbot.waitUntil(lambda: len(window.session.drawing.document) == 1, timeout=10_000)
    settle(window.session, window.keeper)
    assert boxes.calls["solve"] == solved  # it cannot crash again


def buttons(dialog, words):
    return [b for b in dialog.findChildren(QPushButton) if b.text().replace("&", "") == words]


def question(window, qtbot, name="unsaved"):
    qtbot.waitUntil(lambda: window.findChild(QMessageBox, name) is not None, timeout=10_000)
    return window.findChild(QMessageBox, name)


def press(box, words):
    next(b for b in box.buttons() if b.text().replace("&", "") == words).click()


def test_two_drawings_opened_in_one_breath_are_both_kept(offered, folder, settle, qtbot, crash):
    window, dialog = offered(2)
    first, second = buttons(dialog, "Open")
    first.click()
    second.click()
    box = question(window, qtbot)
    assert len(window.session.drawing.document) == 1
    box.reject()
    settle(window.session, window.keeper)
    assert (first.text(), second.text()) == ("Opened", "Open")
    assert second.isEnabled()
    crash(window.keeper)
    assert kept_strokes(folder, window.session.registry) == [1, 1]


def test_a_slow_recovery_is_told_waited_for_and_can_be_stopped(
    offered, folder, settle, qtbot, monkeypatch
):
    window, dialog = offered(1)
    said, gate, recover = [], threading.Event(), RecoveryStore.recover
    window.session.notices.noticed.connect(said.append)
    window.session.findChild(Channel, "file").time_limit = 0.05

    def slow(store, crashed, states, progress):
        while not gate.wait(0.3):
            progress()
        return recover(store, crashed, states, progress)

    monkeypatch.setattr(RecoveryStore, "recover", slow)
    (button,) = buttons(dialog, "Open")
    button.click()
    assert not button.isEnabled()
    qtbot.waitUntil(lambda: any(notice.kind == "slow" for notice in said))
    assert window.session.files.busy, "it goes on"
    window.session.cancel_work()
    assert button.isEnabled()
    assert button.text() == "Open"
    settle(window.session, window.keeper)
    gate.set()
    button.click()
    qtbot.waitUntil(lambda: bool(len(window.session.drawing.document)))
    assert not [notice for notice in said if notice.kind == "error"]


def test_strokes_drawn_while_a_recovery_loads_are_asked_about(
    offered, folder, settle, qtbot, crash
):
    window, dialog = offered(1)
    buttons(dialog, "Open")[0].click()
    stroke = stroke_of(circle(share=0.5), window.session.view.camera)
    window.session.drawing.set_waiting("Stroke", (WaitingStroke(stroke),))
    question(window, qtbot).reject()
    settle(window.session, window.keeper)
    assert window.session.drawing.pending == (stroke,)
    crash(window.keeper)
    assert kept_strokes(folder, window.session.registry) == [1, 1]


def test_who_closes_the_window_over_the_question_is_offered_both_again(
    offered, folder, settle, qtbot
):
    """Nothing answers for the drawing that was on its way: it does not stay claimed."""
    window, dialog = offered(1)
    buttons(dialog, "Open")[0].click()
    stroke = stroke_of(circle(share=0.5), window.session.view.camera)
    window.session.drawing.set_waiting("Stroke", (WaitingStroke(stroke),))
    question(window, qtbot)
    assert RecoveryStore(folder).crashed_sessions() == []
    window.close_without_asking()
    window.keeper.wait()
    assert kept_strokes(folder, window.session.registry) == [1, 1]


def test_what_is_given_up_for_another_drawing_goes_and_that_comes(
    offered, folder, settle, qtbot, crash
):
    window, dialog = offered(2)
    for button in buttons(dialog, "Open"):
        button.click()
    press(question(window, qtbot), "Don’t save")
    settle(window.session, window.keeper)
    assert window.findChild(RecoveryDialog) is None
    crash(window.keeper)
    assert kept_strokes(folder, window.session.registry) == [1]


def test_a_stroke_drawn_while_the_answer_saves_is_asked_about_again(
    offered, folder, settle, qtbot, tmp_path
):
    window, dialog = offered(1)
    session = window.session
    draw(session, settle, window.keeper)
    session.files.save(tmp_path / "mine.bozz")
    draw(session, settle, window.keeper, radius=50)
    buttons(dialog, "Open")[0].click()
    box = question(window, qtbot)
    before = session.files.save

    def save_and_draw(*arguments, **more):
        before(*arguments, **more)
        stroke = stroke_of(circle(share=0.5), session.view.camera)
        session.drawing.set_waiting("Stroke", (WaitingStroke(stroke),))

    session.files.save = save_and_draw
    press(box, "Save")
    session.files.save = before
    qtbot.waitUntil(lambda: not session.files.saving, timeout=10_000)
    qtbot.waitUntil(lambda: window.findChild(QMessageBox, "unsaved") not in (None, box))
    window.findChild(QMessageBox, "unsaved").reject()
    settle(session, window.keeper)
    assert session.drawing.title == "mine"
    assert len(session.drawing.pending) == 1
    assert len(RecoveryStore(folder).crashed_sessions()) == 1


def test_a_crashed_drawing_is_discarded_only_by_who_is_sure(offered, folder, qtbot):
    window, dialog = offered(2)
    away = buttons(dialog, "Discard…")[0]

    def click(answer):
        QTimer.singleShot(0, lambda: press(dialog.findChildren(QMessageBox, "discard")[-1], answer))
        away.click()

    click("Keep")
    assert len(RecoveryStore(folder).crashed_sessions()) == 2
    click("Discard")
    qtbot.waitUntil(lambda: len(RecoveryStore(folder).crashed_sessions()) == 1)
    qtbot.waitUntil(lambda: len(buttons(dialog, "Discarded")) == 1)
    assert len(buttons(dialog, "Open")) == 1
    assert not window.session.drawing.is_modified


def test_a_damaged_drawing_can_be_tried_again_and_is_not_deleted(offered, folder, settle):
    window, dialog = offered(1)
    for base in folder.glob("*/base-*"):
        base.write_bytes(b"dust")
    (button,) = buttons(dialog, "Open")
    for _ in range(2):
        button.click()
        settle(window.session, window.keeper)
        assert button.isEnabled()
    assert len(RecoveryStore(folder).crashed_sessions()) == 1


def test_what_was_not_brought_back_whole_stays_until_it_is_discarded(offered, folder, settle):
    window, dialog = offered(1)
    (journal,) = folder.glob("*/journal-*")
    content = bytearray(journal.read_bytes())
    content[-20] ^= 255
    journal.write_bytes(content)
    buttons(dialog, "Open")[0].click()
    settle(window.session, window.keeper)
    assert journal.exists()
    assert len(RecoveryStore(folder).crashed_sessions()) == 1
    assert any("Not all" in notice.text for notice in window.session.heard)


def test_keeping_a_crash_for_later_deletes_nothing(
    make_window, keep, boxes, folder, settle, qtbot, crash
):
    session, keeper = keep()
    draw(session, settle, keeper)
    crash(keeper)
    window = make_window(MODELER, extra=[boxes.package], recovery=folder)
    window.offer_recovery()
    qtbot.waitUntil(lambda: window.findChild(RecoveryDialog) is not None, timeout=10_000)
    window.findChild(RecoveryDialog).keep.click()
    draw(window.session, settle, window.keeper)
    window.session.files.given_up.emit()
    window.keeper.close()
    window.keeper.wait()
    assert kept_strokes(folder, session.registry) == [1]


def test_a_full_disk_is_told_and_drawing_goes_on(keep, crash, folder, settle, monkeypatch):
    session, keeper = keep()

    def full(*_):
        raise UserError("The disk is full. Make room.")

    monkeypatch.setattr(RecoveryStore, "begin", full)
    draw(session, settle, keeper)
    draw(session, settle, keeper)
    assert "The disk is full. Make room." in [notice.text for notice in session.heard]
    assert strokes_of(session.drawing.document.models[0].state) == 2
    monkeypatch.undo()
    draw(session, settle, keeper)
    crash(keeper)
    assert kept_strokes(folder, session.registry) == [3]


# -- a process that is killed ---------------------------------------------------------------------


class Child:
    """A window in a process of its own that draws until it is killed."""

    def __init__(self, folder, *what):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.app.drawing_child", str(folder), *what],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        )
        assert self.process.stdout.readline() == "began\n"

    def kill_after(self, seconds):
        """Kill it; how many strokes it had said to be on the sheet by then."""
        said = self.said_until_killed_after(seconds)
        return int(said[-1]) if said else 0

    def said_until_killed_after(self, seconds):
        time.sleep(seconds)
        self.process.send_signal(signal.SIGKILL)
        return self.process.communicate()[0].splitlines()


def killed_once(folder, seconds):
    drawn = Child(folder).kill_after(seconds)
    found = kept_strokes(folder)
    kept = found[0] if found else 0
    assert len(found) <= 1
    assert drawn - 1 <= kept <= drawn + 1, f"{drawn} strokes drawn, {kept} kept"
    return drawn


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_a_killed_window_loses_at_most_the_stroke_under_the_pen(tmp_path):
    seeds = random.Random(1)
    drawn: list[int] = []
    # A busy machine draws more slowly, and is given longer.
    while len(drawn) < 4 * DEFAULT_KILLS and (len(drawn) < DEFAULT_KILLS or max(drawn) < 2):
        longer = 1 + len(drawn) // DEFAULT_KILLS
        drawn.append(killed_once(tmp_path / str(len(drawn)), longer * seeds.uniform(0.7, 1.2)))
    assert max(drawn) >= 2


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_a_window_killed_in_a_drag_loses_the_last_second_of_it(tmp_path):
    said = Child(tmp_path, "drag").said_until_killed_after(4.0)
    times = {int(count): float(moment) for count, moment in map(str.split, said)}
    store = RecoveryStore(tmp_path)
    (crashed,) = store.crashed_sessions()
    (model,) = store.recover(crashed, Registry()).document
    (part,) = model.state.parts
    kept = round((getattr(part, drawing_child.VALUE) - 0.5) / drawing_child.STEP)
    lost = max(times.values()) - times[kept]
    assert lost <= 1.0 + MACHINE, f"{lost:.2f} s of {len(times)} values"


@pytest.mark.kill
def test_many_killed_windows_lose_at_most_one_stroke_each(tmp_path):
    seeds = random.Random(2)
    drawn = [killed_once(tmp_path / str(k), seeds.uniform(0.0, 2.5)) for k in range(MANY_KILLS)]
    assert sum(drawn) > 5 * MANY_KILLS / 2


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_after_a_kill_the_next_window_offers_the_drawing_and_a_living_one_is_left_alone(
    make_window, folder, settle, qtbot
):
    living, dead = Child(folder), Child(folder)
    assert dead.process.stdout.readline() == "1\n"  # a busy machine takes its time for a stroke
    drawn = max(dead.kill_after(0.8), 1)
    try:
        window = make_window(recovery=folder)
        window.offer_recovery()
        qtbot.waitUntil(lambda: window.findChild(RecoveryDialog) is not None, timeout=10_000)
        opens = [
            button
            for button in window.findChild(RecoveryDialog).findChildren(QPushButton)
            if button.text() == "Open"
        ]
        assert len(opens) == 1
        opens[0].click()
        settle(window.session, window.keeper)
        QApplication.processEvents()
        strokes = sum(strokes_of(model.state) for model in window.session.drawing.document)
        assert strokes + len(window.session.drawing.pending) >= drawn - 1
        assert window.session.drawing.is_modified
        assert window.isWindowModified()
    finally:
        living.kill_after(0)
