"""What survives a crash, and that nothing goes without an answer."""

from __future__ import annotations

import json
import os
import random
import time
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.document.model import Document, Model, OpaqueState
from bozzetto.document.recovery import recovery_session
from bozzetto.document.recovery.file_lock import Locked
from bozzetto.document.recovery.journal import read_records
from bozzetto.document.recovery.journal_records import ChangeWriter, Replay
from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.document.storage.bozz_file import encode_document, open_document, write_document
from bozzetto.document.storage.bozz_reader import parse_document
from bozzetto.errors import DocumentError, UserError
from bozzetto.ink.stroke import Strokes
from tests.dead_process import crash
from tests.document_kit import (
    CAMERA,
    SIDE,
    FakeRegistry,
    Ink,
    full_stroke,
    mesh,
    rich_document,
    same_document,
    stroke,
    underlay,
    waiting_ink,
)


def random_edit(document: Document, rng: random.Random) -> Document:
    """Any change that a document can undergo."""
    choice = rng.randrange(10)
    if choice == 9:
        left = tuple(one for one in document.waiting if rng.random() < 0.7)
        return document.with_waiting((*left, *waiting_ink(rng.randrange(99))[: rng.randrange(4)]))
    if choice == 0 or not len(document):
        model = Model(
            f"n{rng.random()}"[:12],
            "New",
            "test.ink",
            Ink(Strokes([full_stroke(rng.randrange(99))])),
        )
        return edit.add_model(document, model, at=rng.randrange(len(document) + 1)).document
    model = rng.choice(list(document))
    if choice == 1:
        return edit.show_model(document, model.id, not model.visible).document
    if choice == 2:
        return edit.move_model(document, model.id, rng.randrange(len(document))).document
    if choice == 3:
        return edit.duplicate_model(document, model.id).document
    if choice == 4:
        return edit.add_view(
            document, f"View {rng.randrange(3)}", rng.choice([SIDE, CAMERA])
        ).document
    if choice == 5 and document.underlays:
        picture = replace(document.underlays[0], opacity=rng.random())
        return edit.change_underlay(document, picture).document
    if choice == 6:
        return replace(document, camera=rng.choice([SIDE, CAMERA, None]))
    if model.locked or isinstance(model.state, OpaqueState):
        return edit.lock_model(document, model.id, False).document
    if choice == 7 and len(document) > 2:
        return edit.delete_models(document, [model.id]).document
    grown = model.state.strokes.extended([stroke(rng.randrange(99), 3)])
    changes = {"strokes": grown}
    if hasattr(model.state, "mesh"):
        changes["mesh"] = rng.choice([model.state.mesh, mesh(rng.randrange(99)), None])
    return edit.change_state(document, model.id, replace(model.state, **changes), "Draw").document


@pytest.mark.parametrize("seed", range(12))
def test_base_and_records_give_every_snapshot_again(seed):
    rng = random.Random(seed)
    document = rich_document() if seed % 3 else Document()
    snapshots = [document]
    writer = ChangeWriter(document)
    replay = Replay(parse_document(encode_document(document)))
    for moment in range(40):
        back = rng.random() < 0.2  # an undo
        document = rng.choice(snapshots) if back else random_edit(document, rng)
        snapshots.append(document)
        pending = [stroke(n, 4) for n in range(rng.randrange(3))]
        record = writer.record(document, pending, float(moment))
        if record is not None:
            replay.feed(record)
            assert replay.time == moment
        again, _ = open_document(replay.stored, FakeRegistry())
        assert same_document(document, again)
        assert list(replay.pending) == pending


def test_a_record_costs_its_stroke_and_little_more():
    many = Strokes([stroke(n, 200) for n in range(300)])
    document = Document((Model("m", "Ink", "test.ink", Ink(many)),))
    writer = ChangeWriter(document)
    drawn = stroke(1000, 200)
    state = Ink(many.extended([drawn]))
    changed = edit.change_state(document, "m", state, "Draw").document
    record = writer.record(changed, (), 0.0)
    assert len(record) < 200 * 2 * 4 + 2500
    assert writer.record(changed, (), 1.0) is None
    undone = writer.record(document, (), 2.0)
    assert len(undone) < 2500


def test_a_record_that_does_not_follow_is_refused_and_changes_nothing():
    document = rich_document()
    writer = ChangeWriter(document)
    grown = edit.add_model(
        document, Model("n", "N", "test.ink", Ink(Strokes([stroke(3)])))
    ).document
    first = writer.record(grown, (), 0.0)
    second = writer.record(edit.duplicate_model(grown, "n").document, (stroke(5),), 1.0)
    replay = Replay(parse_document(encode_document(Document())))
    before = replay.stored
    for record in (first, second, b"", b"nonsense"):
        with pytest.raises(DocumentError):
            replay.feed(record)
    assert replay.stored is before


def test_a_crashed_session_comes_back(tmp_path):
    store = RecoveryStore(tmp_path)
    document = rich_document()
    session = store.begin("Vase", "/home/ada/vase.bozz", document)
    changed = edit.rename_model(document, "m1", "Belly").document
    session.record(changed)
    session.record(changed, [stroke(7)])
    crash(session)

    after = RecoveryStore(tmp_path)
    (found,) = after.crashed_sessions()
    assert found.name == "Vase"
    assert str(found.path) == "/home/ada/vase.bozz"
    assert found.began <= found.complete_to
    recovered = after.recover(found, FakeRegistry())
    assert same_document(recovered.document, changed)
    assert list(recovered.pending) == [stroke(7)]
    assert recovered.complete_to == found.complete_to


def test_living_sessions_are_not_offered_and_closed_ones_are_gone(tmp_path):
    store = RecoveryStore(tmp_path)
    session = store.begin("A", None, Document())
    assert RecoveryStore(tmp_path).crashed_sessions() == []
    session.close()
    assert os.listdir(tmp_path) == []
    assert RecoveryStore(tmp_path / "none").crashed_sessions() == []


def test_a_record_that_comes_after_the_close_does_nothing(tmp_path):
    session = RecoveryStore(tmp_path).begin("A", tmp_path / "caf\udce9.bozz", Document())
    session.close()
    session.record(rich_document())
    session.saved(rich_document(), "A", tmp_path / "a.bozz")
    assert os.listdir(tmp_path) == []


def test_nothing_is_deleted_without_an_answer(tmp_path):
    session = RecoveryStore(tmp_path).begin("A", None, rich_document())
    crash(session)
    for _ in range(3):
        store = RecoveryStore(tmp_path)
        (found,) = store.crashed_sessions()
        store.recover(found, FakeRegistry())
        assert store.crashed_sessions() == []  # it is claimed …
        with pytest.raises(Locked):
            RecoveryStore(tmp_path).recover(found, FakeRegistry())
        with pytest.raises(UserError, match="already"):
            store.recover(found, FakeRegistry())
        store.keep(found)  # … until the person says: later
    (found,) = store.crashed_sessions()
    store.discard(found)
    assert os.listdir(tmp_path) == []
    with pytest.raises(UserError, match="already"):
        store.recover(found, FakeRegistry())


def test_discarding_needs_no_recovering(tmp_path):
    crash(RecoveryStore(tmp_path).begin("A", None, Document()))
    store = RecoveryStore(tmp_path)
    store.discard(store.crashed_sessions()[0])
    assert os.listdir(tmp_path) == []


def test_a_save_starts_afresh(tmp_path):
    session = RecoveryStore(tmp_path).begin("New drawing", None, Document())
    document = rich_document()
    session.record(document)
    session.saved(document, "Vase", tmp_path / "vase.bozz")
    assert {path.name for path in session.folder.iterdir()} == {
        "lock",
        "session.json",
        "base-2.bozz",
        "journal-2.bin",
    }
    changed = document.without_model("m3")
    session.record(changed)
    crash(session)
    store = RecoveryStore(tmp_path)
    (found,) = store.crashed_sessions()
    assert (found.name, found.path) == ("Vase", tmp_path / "vase.bozz")
    assert same_document(store.recover(found, FakeRegistry()).document, changed)


@pytest.fixture
def after_save(tmp_path):
    """A session whose document was saved, the document and its file; the store is elsewhere."""
    document, path = rich_document(), tmp_path / "vase.bozz"
    session = RecoveryStore(tmp_path / "recovery").begin("New drawing", None, Document())
    session.record(document)
    written = write_document(document, path, backups=0)
    session.saved(document, "Vase", path, written.stamp)
    return session, document, path


def test_what_is_in_its_file_is_not_offered_and_goes(tmp_path, after_save):
    session, document, path = after_save
    session.record(document)
    crash(session)
    store = RecoveryStore(tmp_path / "recovery")
    assert store.crashed_sessions() == []
    store.tidy()
    assert os.listdir(tmp_path / "recovery") == []
    assert path.exists()


def _changed_file(session, document, path):
    path.write_bytes(path.read_bytes() + b"more")


def _touched_file(session, document, path):
    os.utime(path, ns=(0, 0))


def _deleted_file(session, document, path):
    path.unlink()


def _drawn_on(session, document, path):
    session.record(document.without_model("m3"))


def _ink_waits(session, document, path):
    session.record(document, [stroke(1, 4)])


def _drawn_on_until_a_new_base(session, document, path):
    (journal,) = session.folder.glob("journal-*")
    journal.unlink()  # what is recorded then begins with a new base
    session.record(document.without_model("m3"))


def _damaged_journal(session, document, path):
    session.record(document.without_model("m3"))
    (journal,) = session.folder.glob("journal-*")
    content = bytearray(journal.read_bytes())
    content[-1] ^= 0xFF
    journal.write_bytes(content)


@pytest.mark.parametrize(
    "then",
    [
        _changed_file,
        _touched_file,
        _deleted_file,
        _drawn_on,
        _ink_waits,
        _drawn_on_until_a_new_base,
        _damaged_journal,
    ],
)
def test_what_may_not_be_in_its_file_is_offered_and_stays(tmp_path, after_save, then):
    then(*after_save)
    crash(after_save[0])
    store = RecoveryStore(tmp_path / "recovery")
    store.tidy()
    assert [found.name for found in store.crashed_sessions()] == ["Vase"]


def test_a_document_that_is_open_stays_though_it_is_saved(tmp_path, after_save):
    RecoveryStore(tmp_path / "recovery").tidy()
    assert after_save[0].folder.is_dir()
    after_save[0].close()


def test_a_long_journal_makes_room_for_a_new_base(tmp_path, monkeypatch):
    monkeypatch.setattr(recovery_session, "REBASE_BYTES", 20_000)
    session = RecoveryStore(tmp_path).begin("A", None, Document())
    document = Document()
    for n in range(60):
        document = edit.add_model(
            document, Model(f"m{n}", "M", "test.ink", Ink(Strokes([stroke(n, 100)])))
        ).document
        session.record(document)
    (base,) = session.folder.glob("base-*.bozz")
    assert base.name != "base-1.bozz"
    crash(session)
    store = RecoveryStore(tmp_path)
    again = store.recover(store.crashed_sessions()[0], FakeRegistry())
    assert same_document(again.document, document)


def test_a_full_disk_is_said_and_the_next_record_starts_over(tmp_path, monkeypatch):
    session = RecoveryStore(tmp_path).begin("A", None, Document())
    first = rich_document()

    def full(self, content):
        raise UserError("no room")

    with monkeypatch.context() as patch:
        patch.setattr(recovery_session.JournalWriter, "append", full)
        with pytest.raises(UserError):
            session.record(first)
    second = first.without_model("m3")
    session.record(second)
    crash(session)
    store = RecoveryStore(tmp_path)
    again = store.recover(store.crashed_sessions()[0], FakeRegistry())
    assert same_document(again.document, second)


def test_a_session_that_cannot_begin_leaves_nothing(tmp_path, monkeypatch):
    def full(*_, **__):
        raise UserError("no room")

    monkeypatch.setattr(recovery_session, "write_document", full)
    with pytest.raises(UserError):
        RecoveryStore(tmp_path).begin("A", None, Document())
    assert os.listdir(tmp_path) == []


def session_with_records(tmp_path):
    document = rich_document()
    session = RecoveryStore(tmp_path).begin("A", None, document)
    snapshots = [document]
    for n in range(5):
        state = replace(document.model("m3").state, thickness=float(n))
        document = edit.change_state(document, "m3", state, "Slide").document
        session.record(document)
        snapshots.append(document)
    crash(session)
    return session.folder, snapshots


def test_wherever_the_journal_is_cut_an_earlier_snapshot_comes_back(tmp_path):
    folder, snapshots = session_with_records(tmp_path)
    path = folder / "journal-1.bin"
    content = path.read_bytes()
    for cut in np.linspace(0, len(content), 40).astype(int):
        path.write_bytes(content[:cut])
        whole = len(list(read_records(path)))
        store = RecoveryStore(tmp_path)
        (found,) = store.crashed_sessions()
        again = store.recover(found, FakeRegistry())
        assert same_document(again.document, snapshots[whole])
        store.keep(found)


def test_a_base_without_its_journal_comes_back(tmp_path):
    folder, snapshots = session_with_records(tmp_path)
    (folder / "journal-1.bin").unlink()
    store = RecoveryStore(tmp_path)
    again = store.recover(store.crashed_sessions()[0], FakeRegistry())
    assert same_document(again.document, snapshots[0])


def test_a_crash_between_two_bases_leaves_the_older_one(tmp_path):
    folder, snapshots = session_with_records(tmp_path)
    (folder / "base-2.bozz").write_bytes(b"half a file")
    store = RecoveryStore(tmp_path)
    again = store.recover(store.crashed_sessions()[0], FakeRegistry())
    assert same_document(again.document, snapshots[-1])
    assert "later state" in again.warnings[0]


def test_damaged_data_stay_where_they_are(tmp_path):
    folder, _ = session_with_records(tmp_path)
    (folder / "base-1.bozz").write_bytes(b"dust")
    store = RecoveryStore(tmp_path)
    with pytest.raises(DocumentError, match="stay in"):
        store.recover(store.crashed_sessions()[0], FakeRegistry())
    assert (folder / "journal-1.bin").exists()
    assert len(store.crashed_sessions()) == 1


@pytest.mark.parametrize("content", [b"", b"dust", b"\xff", b"{}", None])
def test_damaged_facts_hide_no_drawing(tmp_path, content):
    folder, snapshots = session_with_records(tmp_path)
    (folder / "session.json").unlink()
    if content is not None:
        (folder / "session.json").write_bytes(content)
    store = RecoveryStore(tmp_path)
    (found,) = store.crashed_sessions()
    assert (found.name, found.path) == ("Untitled", None)
    assert same_document(store.recover(found, FakeRegistry()).document, snapshots[-1])


def test_a_session_of_another_machine_is_offered_with_its_name(tmp_path):
    folder, snapshots = session_with_records(tmp_path)
    lock = folder / "lock"
    lock.write_text(json.dumps(json.loads(lock.read_text()) | {"machine": "0", "host": "attic"}))
    store = RecoveryStore(tmp_path)
    (found,) = store.crashed_sessions()
    assert found.host == "attic"
    assert same_document(store.recover(found, FakeRegistry()).document, snapshots[-1])
    assert store.crashed_sessions() == []


@pytest.mark.skipif(os.name == "nt", reason="any bytes are a name")
def test_a_path_that_is_not_text_comes_back_as_it_was(tmp_path):
    path = tmp_path / "caf\udce9.bozz"
    crash(RecoveryStore(tmp_path).begin("caf\udce9", path, Document()))
    (found,) = RecoveryStore(tmp_path).crashed_sessions()
    assert found.path == path
    assert found.name == "caf?"


def test_a_damaged_journal_is_told_and_a_torn_one_is_not(tmp_path):
    folder, _ = session_with_records(tmp_path)
    path = folder / "journal-1.bin"
    whole = path.read_bytes()
    for content, is_whole in (
        (whole[:-3], True),
        (whole + bytes(100), True),
        (whole[:-9] + b"!" + whole[-8:], False),
        (b"?" + whole[1:], False),
    ):
        path.write_bytes(content)
        store = RecoveryStore(tmp_path)
        (found,) = store.crashed_sessions()
        recovered = store.recover(found, FakeRegistry())
        assert recovered.is_whole is is_whole
        assert any("Later changes" in said for said in recovered.warnings) is not is_whole
        store.keep(found)


def test_a_clock_that_goes_backwards_loses_nothing(tmp_path, monkeypatch):
    clock = iter(range(10**9, 0, -(10**6)))
    monkeypatch.setattr(time, "time", lambda: float(next(clock)))
    monkeypatch.setattr(recovery_session, "REBASE_BYTES", 20_000)
    document = rich_document()
    session = RecoveryStore(tmp_path).begin("A", None, document)
    for n in range(40):
        added = Model(f"n{n}", "M", "test.ink", Ink(Strokes([stroke(n, 100)])))
        document = edit.add_model(document, added).document
        session.record(document)
    crash(session)
    store = RecoveryStore(tmp_path)
    store.tidy()
    (found,) = store.crashed_sessions()
    assert same_document(store.recover(found, FakeRegistry()).document, document)


def test_what_was_half_deleted_or_never_filled_is_tidied_and_nothing_else(tmp_path):
    folder, _ = session_with_records(tmp_path)
    half = tmp_path / f".discarded-{folder.name}"
    half.mkdir()
    (half / "base-1.bozz").write_bytes(b"")
    empty, young = tmp_path / "19990101-000000-0", tmp_path / "19990101-000000-1"
    living = RecoveryStore(tmp_path).begin("B", None, Document())
    for made in (empty, young):
        made.mkdir()
        (made / "session.json").write_bytes(b"{}")
    os.utime(empty, (1, 1))
    os.utime(living.folder, (1, 1))
    RecoveryStore(tmp_path).tidy()
    assert set(os.listdir(tmp_path)) == {folder.name, young.name, living.folder.name}
    living.close()


def test_a_session_that_is_set_aside_is_offered_again(tmp_path):
    document = rich_document().without_model("m3")
    store = RecoveryStore(tmp_path)
    session = store.begin("A", None, rich_document())
    session.record(document)
    session.set_aside()
    session.close()  # from a thread that has not heard of it
    (found,) = store.crashed_sessions()
    assert same_document(store.recover(found, FakeRegistry()).document, document)


def test_pictures_under_the_sheet_are_written_once(tmp_path):
    document = Document(underlays=(underlay(),))
    writer = ChangeWriter(document)
    fainter = edit.change_underlay(document, replace(document.underlays[0], opacity=0.1)).document
    assert b"arrays/0.u1" not in writer.record(fainter, (), 0.0)
    more = edit.add_underlay(fainter, replace(underlay("Other"), id="other")).document
    assert b"arrays/0.u1" in writer.record(more, (), 1.0)
