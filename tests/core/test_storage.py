"""Atomic replacement: whatever fails, and whenever, a whole file is there afterwards."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry.arrays import frozen
from bozzetto.storage import Disk, atomic_write, backup_path, explain, read_bytes

OLD, NEW = b"old" * 1000, b"new" * 2000


class FaultyDisk(Disk):
    """Fails at the k-th call; a failing write leaves half of its bytes behind."""

    def __init__(self, k: int, number: int = errno.EIO, links: bool = True) -> None:
        self.k, self.number, self.links = k, number, links
        self.calls: list[str] = []

    def tick(self, name: str) -> None:
        self.calls.append(name)
        if len(self.calls) == self.k:
            raise OSError(self.number, os.strerror(self.number))

    def create(self, path: Path) -> Any:
        self.tick("create")
        return _FaultyFile(super().create(path), self)

    def sync(self, file: Any) -> None:
        self.tick("sync")
        super().sync(file.file)

    def link(self, path: Path, name: Path) -> None:
        self.tick("link")
        if not self.links:
            raise OSError(errno.EPERM, "no links here")
        super().link(path, name)


class _FaultyFile:
    def __init__(self, file: Any, disk: FaultyDisk) -> None:
        self.file, self.disk = file, disk

    def write(self, content: bytes) -> int:
        try:
            self.disk.tick("write")
        except OSError:
            self.file.write(content[: len(content) // 2])
            self.file.flush()
            raise
        return int(self.file.write(content))

    def __enter__(self) -> _FaultyFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()
        self.disk.tick("close")


def _counted(name: str) -> Any:
    def call(self: FaultyDisk, *arguments: Any) -> Any:
        self.tick(name)
        return getattr(Disk, name)(self, *arguments)

    return call


for _name in ("resolve", "mode", "set_mode", "same", "copy", "replace", "remove", "sync_folder"):
    setattr(FaultyDisk, _name, _counted(_name))


def write_new(file: Any) -> None:
    for start in range(0, len(NEW), 1000):
        file.write(NEW[start : start + 1000])


def leftovers(folder: Path) -> list[str]:
    return [name for name in os.listdir(folder) if name.startswith(".bozzetto-")]


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("number", [errno.EIO, errno.ENOSPC, errno.EACCES, errno.EROFS])
def test_a_fault_at_any_call_leaves_a_whole_file(tmp_path, number, links):
    k = 0
    failures = 0
    while True:
        k += 1
        folder = tmp_path / str(k)
        folder.mkdir()
        path = folder / "a.bozz"
        for content in (b"oldest", b"older", OLD):
            atomic_write(path, lambda file, c=content: file.write(c), backups=2)
        disk = FaultyDisk(k, number, links)
        try:
            atomic_write(path, write_new, backups=2, disk=disk)
        except UserError:
            failures += 1
            done = disk.calls[-1] == "sync_folder"
            assert path.read_bytes() == (NEW if done else OLD), disk.calls
        else:
            assert path.read_bytes() == NEW, disk.calls
        kept = {backup_path(path, n).read_bytes() for n in (1, 2) if backup_path(path, n).exists()}
        assert kept <= {b"oldest", b"older", OLD}
        if "remove" not in disk.calls or disk.calls[-1] != "remove":
            assert leftovers(folder) == []
        if len(disk.calls) < k:
            break
    assert failures >= 8
    assert k > 15


def test_a_fault_of_a_first_save_leaves_nothing(tmp_path):
    for k in range(1, 30):
        path = tmp_path / str(k)
        disk = FaultyDisk(k)
        try:
            atomic_write(path, write_new, backups=2, disk=disk)
        except UserError:
            assert not path.exists() or disk.calls[-1] == "sync_folder"
            if path.exists():
                path.unlink()
        else:
            assert path.read_bytes() == NEW
            path.unlink()
    assert os.listdir(tmp_path) == []


def test_the_order_of_calls_is_the_one_that_survives_a_power_cut(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)
    disk = FaultyDisk(0)
    atomic_write(path, write_new, backups=1, disk=disk)
    order = [disk.calls.index(name) for name in ("create", "write", "sync", "close")]
    order += [
        disk.calls.index("link"),
        disk.calls.index("replace"),
        disk.calls.index("sync_folder"),
    ]
    assert order == sorted(order)
    assert len(disk.calls) - 1 - disk.calls[::-1].index("write") < disk.calls.index("sync")


def test_backups_are_numbered_from_the_newest(tmp_path):
    path = tmp_path / "a.bozz"
    for number in range(6):
        atomic_write(path, lambda file, n=number: file.write(b"%d" % n), backups=3)
    assert sorted(os.listdir(tmp_path)) == ["a.bozz", "a.bozz~1", "a.bozz~2", "a.bozz~3"]
    assert [backup_path(path, n).read_bytes() for n in (1, 2, 3)] == [b"4", b"3", b"2"]


def test_saves_that_fail_again_and_again_do_not_push_the_backups_out(tmp_path):
    path = tmp_path / "a"
    for content in (b"1", b"2", b"3"):
        atomic_write(path, lambda file, c=content: file.write(c), backups=2)

    class Stubborn(Disk):
        def replace(self, source: Path, name: Path) -> None:
            if name == path:
                raise PermissionError(errno.EACCES, "open in another program")
            super().replace(source, name)

    for _ in range(4):
        with pytest.raises(UserError):
            atomic_write(path, write_new, backups=2, disk=Stubborn())
    assert path.read_bytes() == b"3"
    assert backup_path(path, 2).read_bytes() == b"2"


def test_an_exception_of_the_writer_passes_and_leaves_the_file(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)

    def write(file: Any) -> None:
        file.write(b"half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        atomic_write(path, write)
    assert path.read_bytes() == OLD
    assert leftovers(tmp_path) == []


def test_a_link_stays_a_link_and_permissions_stay(tmp_path):
    real = tmp_path / "real"
    real.write_bytes(OLD)
    real.chmod(0o640)
    link = tmp_path / "link"
    link.symlink_to(real)
    atomic_write(link, write_new, backups=1)
    assert link.is_symlink()
    assert real.read_bytes() == NEW
    assert real.stat().st_mode & 0o777 == 0o640
    assert backup_path(real, 1).read_bytes() == OLD


def test_a_file_that_somebody_made_read_only_is_not_replaced(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)
    path.chmod(0o444)
    with pytest.raises(UserError, match="may not be written"):
        atomic_write(path, write_new)
    assert path.read_bytes() == OLD


def test_folders_and_long_names_are_explained(tmp_path):
    with pytest.raises(UserError, match="folder"):
        atomic_write(tmp_path / "none" / "a", write_new)
    with pytest.raises(UserError, match="folder"):
        atomic_write(tmp_path, write_new)
    with pytest.raises(UserError, match="shorter"):
        atomic_write(tmp_path / ("x" * 300), write_new)
    atomic_write(tmp_path / ("x" * 250), write_new)
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(UserError, match="folder"):
        atomic_write(tmp_path / "file" / "a", write_new)


def test_every_explanation_says_what_to_do():
    for number in errno.errorcode:
        text = explain(OSError(number, os.strerror(number)), "name")
        assert "name" in text
        assert any(word in text for word in ("Save", "Choose", "Free"))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of file sizes are POSIX")
def test_a_disk_that_really_runs_full_leaves_the_old_file(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)
    script = (
        "import resource, signal, sys\n"
        "from bozzetto.errors import UserError\n"
        "from bozzetto.storage import atomic_write\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n"
        "try:\n"
        "    atomic_write(sys.argv[1], lambda f: f.write(bytes(100_000)), backups=2)\n"
        "except UserError as error:\n"
        "    print(error.message)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True
    )
    assert "no room" in run.stdout
    assert path.read_bytes() == OLD
    assert leftovers(tmp_path) == []


def test_a_file_is_read_whole_and_cannot_be_written_to(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(NEW)
    content = read_bytes(path, len(NEW))
    assert content == NEW
    assert content.readonly
    with pytest.raises(UserError, match="too long"):
        read_bytes(path, len(NEW) - 1)


def test_meshes_over_a_files_content_are_not_copied(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(bytes(36))
    values = np.frombuffer(read_bytes(path, 36), np.float32).reshape(3, 3)
    assert np.shares_memory(frozen(values, np.float32, 3), values)
    with pytest.raises(ValueError, match="WRITEABLE"):
        values.flags.writeable = True
