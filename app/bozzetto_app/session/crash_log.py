"""The tracebacks that crashes of native code leave: where the last one happened."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

__all__ = ["files_at_crash"]

FATAL: Final = re.compile(
    rb"^(?:Fatal Python error:|Windows fatal exception: (?:access violation|stack overflow))", re.M
)
"""How a traceback begins after which the process ended; on Windows others are logged, too."""

FRAME: Final = re.compile(r'^  File "(.*)", line ')

MOST_BYTES: Final = 1_000_000
"""How much of the end of the file is read: a traceback has a hundred frames a thread at most."""

CLOCK_SLACK: Final = 2.0
"""Seconds by which a file's time may lie before the clock: file systems round it."""


def files_at_crash(log: Path, since: float) -> tuple[str, ...]:
    """Return the source files in which the thread was that crashed last, the innermost first.

    Parameters
    ----------
    log : Path
        Written by `faulthandler`, each crash behind the ones before.
    since : float
        Seconds since 1970; a crash before it is of no interest.

    Returns
    -------
    tuple of str
        Empty where there was none, or nobody knows in which thread.
    """
    try:
        if log.stat().st_mtime < since - CLOCK_SLACK:
            return ()
        with log.open("rb") as file:
            file.seek(max(0, log.stat().st_size - MOST_BYTES))
            content = file.read(MOST_BYTES)
    except OSError:
        return ()
    begins = [found.start() for found in FATAL.finditer(content)]
    if not begins:
        return ()
    lines = iter(content[begins[-1] :].decode("utf-8", "replace").splitlines())
    for line in lines:
        if line.startswith("Current thread"):
            break
    files = []
    for line in lines:
        frame = FRAME.match(line)
        if frame is None:
            break
        files.append(frame[1])
    return tuple(files)
