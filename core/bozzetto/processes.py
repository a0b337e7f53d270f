"""Processes and their machine: identity, birth, and whether one still runs."""

from __future__ import annotations

import os
import sys
from functools import lru_cache
from pathlib import Path
from typing import Final

MACHINE_FILES: Final = ("/etc/machine-id", "/var/lib/dbus/machine-id")
RANDOM_NODE: Final = 1 << 40
"""Set in `uuid.getnode` where the system told no network address and a number was drawn."""


@lru_cache(maxsize=1)
def machine_id() -> str:
    """Return a name of this machine that stays when its host name changes."""
    for place in MACHINE_FILES:
        try:
            content = Path(place).read_text().strip()
        except (OSError, ValueError):
            continue
        if content:
            return content
    import uuid

    node = uuid.getnode()
    return host_name() if node & RANDOM_NODE else f"{node:012x}"


def host_name() -> str:
    """Return the name of this machine in its network."""
    from socket import gethostname  # a module that the first paint of a window does not need

    return gethostname()


def birth(pid: int) -> str:
    """Return when a process was born, by the machine's start and the time since; "" if unknown."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        # The name before the last bracket may hold blanks; the start is the 22nd field.
        ticks = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    except (OSError, IndexError, ValueError):
        return ""
    return f"{boot}/{ticks}"


def is_running(pid: int) -> bool:
    """Whether this machine has a process of that number."""
    if sys.platform == "win32":
        import ctypes

        query_limited_information, still_active = 0x1000, 259
        process = ctypes.windll.kernel32.OpenProcess(query_limited_information, False, pid)
        code = ctypes.c_ulong()
        known = ctypes.windll.kernel32.GetExitCodeProcess(process, ctypes.byref(code))
        ctypes.windll.kernel32.CloseHandle(process)
        return bool(known) and code.value == still_active
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
