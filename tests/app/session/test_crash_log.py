"""What a crash of native code leaves behind: which plugin was at work is read from it."""

import os
import subprocess
import sys
import time

import pytest

from bozzetto_app.session.crash_log import files_at_crash

CRASH = """
import ctypes, faulthandler, pathlib, sys, threading

sys.path.insert(0, sys.argv[2])
log = open(sys.argv[1], "a")
faulthandler.enable(log)
threading.Thread(target=threading.Event().wait, daemon=True).start()
import {module}
{module}.crash()
"""


@pytest.fixture
def log(tmp_path):
    return tmp_path / "crash.log"


def crash_in(tmp_path, log, module):
    """Crash a process in a function of a module; return the module's file."""
    file = tmp_path / module / "__init__.py"
    file.parent.mkdir(exist_ok=True)
    file.write_text("import ctypes\n\n\ndef crash():\n    ctypes.string_at(0)\n")
    program = CRASH.format(module=module)
    ended = subprocess.run([sys.executable, "-c", program, str(log), str(tmp_path)], check=False)
    assert ended.returncode != 0
    return str(file)


def test_the_files_of_the_thread_that_crashed_are_told(tmp_path, log):
    file = crash_in(tmp_path, log, "one_of_ours")
    files = files_at_crash(log, 0.0)
    assert files.index(file) < files.index("<string>")
    assert not any("threading" in each for each in files)  # those of the thread that waited


def test_the_last_crash_counts(tmp_path, log):
    first = crash_in(tmp_path, log, "one_of_ours")
    second = crash_in(tmp_path, log, "another")
    assert second in files_at_crash(log, 0.0)
    assert first not in files_at_crash(log, 0.0)


def test_a_crash_of_long_ago_is_of_no_interest(tmp_path, log):
    crash_in(tmp_path, log, "one_of_ours")
    now = time.time()
    assert files_at_crash(log, now - 60.0)
    os.utime(log, (now - 3600.0, now - 3600.0))
    assert files_at_crash(log, now - 60.0) == ()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe\x00" * 100,
        b"Fatal Python error: Aborted\n",
        b"Fatal Python error: Aborted\n\nCurrent thread 0x1 (most recent call first):\n",
        b'Windows fatal exception: code 0x8001010d\n\nCurrent thread 0x1:\n  File "a.py", line 1\n',
    ],
)
def test_nothing_is_told_of_what_tells_nothing(log, content):
    log.write_bytes(content)
    assert files_at_crash(log, 0.0) == ()


def test_a_log_that_is_not_there_tells_nothing(log):
    assert files_at_crash(log, 0.0) == ()
