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

from bozzetto.document.lock import FileLock, Locked, document_lock_path, holder
from bozzetto.errors import UserError


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


def test_only_one_of_many_gets_a_stale_lock(tmp_path):
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
    if not os.path.exists(f"/proc/{os.getpid()}/stat"):
        pytest.skip("the system does not say when a process was born")
    place = tmp_path / "lock"
    FileLock.acquire(place, "it")
    mine = holder(place)
    assert not mine.is_gone
    earlier = msgspec.structs.replace(mine, born="another-start-of-the-machine/7")
    assert earlier.is_gone
    assert not msgspec.structs.replace(mine, born="").is_gone
    place.write_bytes(msgspec.json.encode(earlier))
    with FileLock.acquire(place, "it"):
        assert holder(place).born == mine.born
