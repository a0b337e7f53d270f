"""The lock file: one holder, named; a dead one does not keep others out."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import threading

import msgspec
import pytest

from bozzetto.document.recovery import file_lock as lock
from bozzetto.document.recovery.file_lock import (
    FileLock,
    Locked,
    abandoned_holder,
    document_lock_path,
    holder,
)
from bozzetto.errors import UserError
from bozzetto.file_locks import Taken, take
from bozzetto.processes import machine_id


def dead_pid() -> int:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def foreign_lock(path, **changes) -> None:
    facts = {
        "user": "ada",
        "host": socket.gethostname(),
        "pid": dead_pid(),
        "since": 1.0,
        "token": "0",
    }
    path.write_text(json.dumps(facts | changes))


def test_the_lock_lies_beside_the_document_and_follows_links(tmp_path):
    (tmp_path / "a.bozz").write_bytes(b"")
    (tmp_path / "link.bozz").symlink_to(tmp_path / "a.bozz")
    assert document_lock_path(tmp_path / "a.bozz").name == ".~lock.a.bozz#"
    assert document_lock_path(tmp_path / "link.bozz") == document_lock_path(tmp_path / "a.bozz")


def test_the_second_is_told_who_was_first(tmp_path):
    path = tmp_path / "lock"
    with FileLock.acquire(path, "a.bozz"):
        assert holder(path).pid == os.getpid()
        with pytest.raises(Locked, match=r"a\.bozz") as found:
            FileLock.acquire(path, "a.bozz")
        assert found.value.holder == holder(path)
    assert os.listdir(tmp_path) == []
    FileLock.acquire(path, "a.bozz").release()


def test_the_lock_of_a_dead_process_is_taken_over(tmp_path):
    path = tmp_path / "lock"
    foreign_lock(path)
    lock = FileLock.acquire(path, "a")
    assert holder(path).pid == os.getpid()
    lock.release()
    assert os.listdir(tmp_path) == []


def test_the_lock_of_another_host_is_only_taken_on_purpose(tmp_path):
    path = tmp_path / "lock"
    foreign_lock(path, host="elsewhere")
    with pytest.raises(Locked, match="ada on elsewhere"):
        FileLock.acquire(path, "a")
    FileLock.acquire(path, "a", force=True)
    assert holder(path).pid == os.getpid()


def test_who_lost_the_lock_does_not_take_it_away_from_its_new_holder(tmp_path):
    path = tmp_path / "lock"
    first = FileLock.acquire(path, "a")
    second = FileLock.acquire(path, "a", force=True)
    first.release()
    assert holder(path) is not None
    second.release()
    assert holder(path) is None


@pytest.mark.parametrize("content", [b"", b"{", b'{"pid": 1}', b"\xff\xfe"])
def test_a_lock_file_without_sense_is_replaced_once_it_is_old(tmp_path, content):
    path = tmp_path / "lock"
    path.write_bytes(content)
    os.utime(path, (1, 1))
    FileLock.acquire(path, "a").release()


def test_only_one_of_many_gets_a_stale_lock(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "WAIT_SECONDS", 0.05)
    path = tmp_path / "lock"
    for _ in range(20):
        foreign_lock(path)
        got: list[FileLock] = []
        lost: list[Locked] = []
        start = threading.Barrier(8)

        def attempt(start=start, got=got, lost=lost) -> None:
            start.wait()
            try:
                got.append(FileLock.acquire(path, "a"))
            except Locked as error:
                lost.append(error)

        threads = [threading.Thread(target=attempt) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert (len(got), len(lost)) == (1, 7)
        got[0].release()
        assert os.listdir(tmp_path) == []


def test_a_folder_that_is_not_there_is_explained(tmp_path):
    with pytest.raises(UserError, match="folder"):
        FileLock.acquire(tmp_path / "none" / "lock", "a")


def test_a_number_that_another_process_has_now_is_gone(tmp_path):
    place = tmp_path / "lock"
    with FileLock.acquire(place, "it"):
        mine = holder(place)
    assert not mine.is_gone
    earlier = msgspec.structs.replace(mine, born="another-start-of-the-machine/7")
    if mine.born:
        assert earlier.is_gone
    assert not msgspec.structs.replace(mine, born="").is_gone
    for left in (earlier, mine):  # a living process has the number, and yet nobody holds it
        place.write_bytes(msgspec.json.encode(left))
        with FileLock.acquire(place, "it"):
            assert holder(place).token not in (mine.token, earlier.token)


def test_another_host_name_locks_nobody_out(tmp_path, monkeypatch):
    place = tmp_path / "lock"
    code = (
        "import os, sys; from bozzetto.document.recovery.file_lock import FileLock; "
        "FileLock.acquire(sys.argv[1], 'a'); os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", code, str(place)], check=True)
    monkeypatch.setattr(socket, "gethostname", lambda: "renamed")
    assert abandoned_holder(place).pid != os.getpid()
    with FileLock.acquire(place, "a"):
        assert holder(place).host == "renamed"


def test_a_living_process_holds_it_under_any_host_name(tmp_path, monkeypatch):
    with FileLock.acquire(tmp_path / "lock", "a"):
        monkeypatch.setattr(socket, "gethostname", lambda: "renamed")
        assert abandoned_holder(tmp_path / "lock") is None
        with pytest.raises(Locked):
            FileLock.acquire(tmp_path / "lock", "a")


def test_who_left_it_on_another_machine_is_named(tmp_path):
    place = tmp_path / "lock"
    foreign_lock(place, host="elsewhere", machine="0" * 32)
    assert abandoned_holder(place).host == "elsewhere"
    place.unlink()
    assert abandoned_holder(place).host == ""


@pytest.mark.parametrize("left", [b"", b"{", b"\0" * 9000])
def test_without_locks_of_the_system_the_process_is_looked_for(tmp_path, monkeypatch, left):
    monkeypatch.setattr(lock, "take", lambda handle: Taken.UNKNOWN)
    place = tmp_path / "lock"
    foreign_lock(place, machine=machine_id())
    assert abandoned_holder(place) is not None
    with FileLock.acquire(place, "a"):
        assert abandoned_holder(place) is None
        with pytest.raises(Locked):
            FileLock.acquire(place, "a")
    place.write_bytes(left)
    assert abandoned_holder(place) is None  # perhaps it is just being written
    os.utime(place, (1, 1))
    FileLock.acquire(place, "a").release()


def test_a_lock_that_was_taken_over_is_known_to_be_lost(tmp_path):
    place = tmp_path / "lock"
    first = FileLock.acquire(place, "a")
    assert first.is_held
    second = FileLock.acquire(place, "a", force=True)
    assert (first.is_held, second.is_held) == (False, True)
    first.release()
    first.release()
    assert second.is_held
    second.release()
    assert not second.is_held


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")
def test_a_child_that_lives_on_does_not_keep_it(tmp_path):
    mine = FileLock.acquire(tmp_path / "lock", "a")
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.read(reading, 1)
        os._exit(0)
    try:
        mine.release()
        FileLock.acquire(tmp_path / "lock", "a").release()
    finally:
        os.write(writing, b"x")
        os.waitpid(child, 0)
        os.close(reading)
        os.close(writing)


@pytest.mark.skipif(os.name == "nt", reason="links")
def test_what_cannot_be_a_lock_file_is_said_and_not_waited_for_without_end(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "FRESH_SECONDS", 0.1)
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    (tmp_path / "folder").mkdir()
    for name in ("link", "folder"):
        with pytest.raises(UserError):
            FileLock.acquire(tmp_path / name, "a")


def test_looking_at_locks_keeps_nobody_from_taking_one(tmp_path):
    place = tmp_path / "lock"
    end = threading.Event()

    def look() -> None:
        while not end.is_set():
            abandoned_holder(place)

    looking = [threading.Thread(target=look) for _ in range(3)]
    for thread in looking:
        thread.start()
    try:
        for _ in range(100):
            FileLock.acquire(place, "a").release()
    finally:
        end.set()
        for thread in looking:
            thread.join()


def test_who_only_looks_at_an_abandoned_lock_is_waited_for(tmp_path):
    place = tmp_path / "lock"
    place.touch()
    handle = os.open(place, os.O_RDWR)
    assert take(handle) is Taken.YES
    looking = threading.Timer(2.0 * lock.WAIT_SECONDS, os.close, (handle,))
    looking.start()
    FileLock.acquire(place, "a").release()
    looking.join()
