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

from bozzetto.arrays import frozen
from bozzetto.atomic_files import (
    Disk,
    FileChanged,
    Over,
    atomic_write,
    backup_path,
    explain,
    read_bytes,
    read_stamped,
)
from bozzetto.errors import UserError
from bozzetto.temporary_files import remove_leftovers, temporary_path

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

    def create(self, path: Path, mode: int) -> Any:
        self.tick("create")
        return _FaultyFile(super().create(path, mode), self)

    def stamp(self, file: Any) -> Any:
        self.tick("stamp")
        return super().stamp(getattr(file, "file", file))

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


for _name in ("resolve", "facts", "dress", "same", "copy", "replace", "remove", "sync_folder"):
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
        "from bozzetto.atomic_files import atomic_write\n"
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


# -- what another program did meanwhile ----------------------------------------------------------


def write(content: bytes) -> Any:
    return lambda file: file.write(content)


def test_only_the_content_that_is_known_is_written_over(tmp_path):
    path = tmp_path / "a"
    first = atomic_write(path, write(OLD), over=Over.NOTHING).stamp
    second = atomic_write(path, write(NEW), over=first).stamp
    with pytest.raises(FileChanged, match="another program") as raised:
        atomic_write(path, write(OLD), over=first, backups=2)
    assert raised.value.found.is_content_of(second)
    assert raised.value.expected is first
    with pytest.raises(FileChanged, match="already"):
        atomic_write(path, write(OLD), over=Over.NOTHING)
    assert path.read_bytes() == NEW
    assert os.listdir(tmp_path) == ["a"]
    atomic_write(path, write(OLD))
    assert path.read_bytes() == OLD


def test_a_change_of_the_content_counts_and_a_change_of_its_time_does_not(tmp_path):
    path = tmp_path / "a"
    stamp = atomic_write(path, write(OLD)).stamp
    os.utime(path, (1, 1))
    path.rename(tmp_path / "b")
    (tmp_path / "b").rename(path)
    copied = tmp_path / "c"
    copied.write_bytes(OLD)
    copied.replace(path)  # as a program does that synchronises folders
    stamp = atomic_write(path, write(NEW), over=stamp).stamp
    assert read_stamped(path, 1 << 20) == (NEW, stamp)
    path.write_bytes(NEW[:-1] + b"!")
    with pytest.raises(FileChanged):
        atomic_write(path, write(OLD), over=stamp)


def test_a_file_that_is_gone_is_written_again(tmp_path):
    path = tmp_path / "a"
    stamp = atomic_write(path, write(OLD)).stamp
    path.unlink()
    atomic_write(path, write(NEW), over=stamp)
    assert path.read_bytes() == NEW


def test_a_file_that_became_a_folder_is_explained(tmp_path):
    path = tmp_path / "a"
    stamp = atomic_write(path, write(OLD)).stamp
    path.unlink()
    path.mkdir()
    with pytest.raises(UserError, match="is a folder"):
        atomic_write(path, write(NEW), over=stamp)
    assert os.listdir(tmp_path) == ["a"]


def test_what_changes_while_it_is_being_written_is_noticed(tmp_path):
    path = tmp_path / "a"
    stamp = atomic_write(path, write(OLD)).stamp

    def interrupted(file: Any) -> None:
        file.write(NEW)
        path.write_bytes(b"theirs")

    with pytest.raises(FileChanged):
        atomic_write(path, interrupted, over=stamp)
    assert path.read_bytes() == b"theirs"


# -- what else belongs to a file -------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(os, "setxattr"), reason="the system has no attributes")
def test_attributes_stay(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)
    try:
        os.setxattr(path, "user.bozzetto.test", b"seven")
    except OSError:
        pytest.skip("the disk has no attributes")
    atomic_write(path, write_new)
    assert os.getxattr(path, "user.bozzetto.test") == b"seven"


@pytest.mark.skipif(os.name == "nt" or os.geteuid() != 0, reason="only root gives files away")
def test_owner_and_group_stay(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)
    os.chown(path, 1234, 2345)
    path.chmod(0o4664)
    atomic_write(path, write_new)
    facts = path.stat()
    assert (facts.st_uid, facts.st_gid, facts.st_mode & 0o7777) == (1234, 2345, 0o4664)


def test_what_nobody_may_read_is_not_shown_while_it_is_written(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)
    path.chmod(0o600)

    def looked_at(file: Any) -> None:
        assert os.fstat(file.fileno()).st_mode & 0o077 == 0
        file.write(NEW)

    atomic_write(path, looked_at)


@pytest.mark.skipif(os.name == "nt", reason="links")
def test_other_names_of_a_file_are_counted_and_backups_are_none(tmp_path):
    path = tmp_path / "a"
    assert atomic_write(path, write(OLD), backups=2).other_names == 0
    os.link(path, tmp_path / "other")
    assert atomic_write(path, write(NEW), backups=2).other_names == 1
    assert (tmp_path / "other").read_bytes() == OLD
    os.unlink(backup_path(path, 1))
    os.link(path, backup_path(path, 1))  # the last save did not come to its end
    assert atomic_write(path, write(OLD), backups=2).other_names == 0


@pytest.mark.skipif(os.name == "nt", reason="any bytes are a name")
def test_a_name_that_is_not_text_stays_as_it_is(tmp_path):
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.bozz"))
    try:
        path.write_bytes(OLD)
    except OSError:
        pytest.skip("the disk wants text")
    _, stamp = read_stamped(path, 1 << 20)
    atomic_write(path, write_new, over=stamp, backups=1)
    assert sorted(os.listdir(os.fsencode(tmp_path))) == [b"caf\xe9.bozz", b"caf\xe9.bozz~1"]


# -- what a killed process left ------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")
def test_temporary_files_of_the_dead_go_and_those_of_the_living_stay(tmp_path):
    def left(folder: Path) -> None:
        child = os.fork()
        if child == 0:
            atomic_write(folder / "a", lambda file: os._exit(0))
        os.waitpid(child, 0)

    left(tmp_path)
    (dead,) = leftovers(tmp_path)
    living = temporary_path(tmp_path / "a")
    living.write_bytes(b"being written")
    elsewhere = tmp_path / dead.replace(dead.split("-")[1], "0123abcd")
    elsewhere.write_bytes(b"of another machine")
    (tmp_path / ".bozzetto-notes").write_bytes(b"a person's")
    assert remove_leftovers([tmp_path, tmp_path, tmp_path / "none"]) == 1
    assert sorted(leftovers(tmp_path)) == sorted([living.name, elsewhere.name, ".bozzetto-notes"])
