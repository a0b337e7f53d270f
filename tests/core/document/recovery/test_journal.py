"""Records: whole ones come back, nothing else does."""

from __future__ import annotations

import os
import struct
import threading
import time
import zlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.document.recovery import journal
from bozzetto.document.recovery.journal import JournalWriter, read_records
from bozzetto.errors import UserError

RECORDS = [b"one", b"\0" * 100, b"three" * 50]


def written(path, records=RECORDS) -> bytes:
    writer = JournalWriter(path)
    for record in records:
        writer.append(record)
    writer.close()
    return path.read_bytes()


def test_records_come_back_in_order(tmp_path):
    written(tmp_path / "j")
    assert list(read_records(tmp_path / "j")) == RECORDS


def test_a_record_can_be_read_as_soon_as_it_is_appended(tmp_path):
    writer = JournalWriter(tmp_path / "j")
    for count in range(1, 4):
        writer.append(b"x" * count)
        assert len(list(read_records(tmp_path / "j"))) == count
    writer.close()


def test_the_layout_is_length_checksum_content(tmp_path):
    content = written(tmp_path / "j", [b"abc"])
    assert content[8:] == struct.pack("<II", 3, zlib.crc32(b"abc")) + b"abc"


def test_wherever_it_is_cut_the_whole_records_before_come_back(tmp_path):
    content = written(tmp_path / "j")
    ends = [8]
    for record in RECORDS:
        ends.append(ends[-1] + 8 + len(record))
    for cut in range(len(content)):
        (tmp_path / "c").write_bytes(content[:cut])
        whole = sum(end <= cut for end in ends[1:])
        assert list(read_records(tmp_path / "c")) == RECORDS[:whole]


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damage_hides_what_comes_after_it_and_invents_nothing(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("journal") / "j"
    content = bytearray(written(path))
    place = data.draw(st.integers(0, len(content) - 1))
    content[place] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    found = list(read_records(path))
    assert found == RECORDS[: len(found)]
    assert len(found) < 3


def test_zeros_behind_the_end_are_no_records(tmp_path):
    written(tmp_path / "j")
    with open(tmp_path / "j", "ab") as file:
        file.write(bytes(4096))
    assert list(read_records(tmp_path / "j")) == RECORDS


def test_a_journal_never_writes_over_another(tmp_path):
    written(tmp_path / "j")
    with pytest.raises(UserError):
        JournalWriter(tmp_path / "j")
    assert list(read_records(tmp_path / "j")) == RECORDS


class FullDisk:
    """A file that fails once, when it has taken the bytes that are left."""

    def __init__(self, file) -> None:
        self.file, self.left = file, -1

    def __getattr__(self, name):
        return getattr(self.file, name)

    def write(self, content) -> int:
        if self.left == 3:
            self.left = 0
            return self.file.write(content[:3])
        if self.left == 0:
            self.left = -1
            raise OSError(28, "No space left on device")
        return self.file.write(content)


def test_half_a_record_is_taken_back_when_the_disk_is_full(tmp_path, monkeypatch):
    files = []

    def opened(*asked, **more):
        files.append(FullDisk(open(*asked, **more)))
        return files[-1]

    with monkeypatch.context() as patch:
        patch.setattr(journal, "open", opened, raising=False)
        writer = JournalWriter(tmp_path / "j")
    writer.append(b"before")
    files[0].left = 3
    with pytest.raises(UserError, match="room"):
        writer.append(b"lost" * 100)
    writer.append(b"after")
    writer.close()
    assert list(read_records(tmp_path / "j")) == [b"before", b"after"]


def test_what_was_appended_is_brought_to_the_disk_by_itself(tmp_path, monkeypatch):
    synced = threading.Event()
    monkeypatch.setattr(journal, "SYNC_SECONDS", 0.01)
    fsync = os.fsync
    monkeypatch.setattr(os, "fsync", lambda handle: (fsync(handle), synced.set()))
    writer = JournalWriter(tmp_path / "j")
    writer.append(b"x")
    assert synced.wait(10)
    writer.close()


def test_a_disk_that_fails_behind_our_back_is_said_with_the_next_record(tmp_path, monkeypatch):
    failed = threading.Event()

    def fsync(handle) -> None:
        failed.set()
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(journal, "SYNC_SECONDS", 0.01)
    monkeypatch.setattr(os, "fsync", fsync)
    writer = JournalWriter(tmp_path / "j")
    assert failed.wait(10)
    until = time.monotonic() + 10.0
    said = ""
    while not said and time.monotonic() < until:
        try:
            writer.append(b"x")
        except UserError as problem:
            said = problem.message
    assert "another disk" in said
    writer.close()
