"""The C library's heap: what was freed is given back to the system.

The C library keeps freed memory for later. Solves allocate and free hundreds of megabytes in
arrays of all sizes and in several threads, each with a part of the heap of its own: after an
hour more than half of the process is such free memory, and its share keeps growing.
"""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

__all__ = ["give_back", "resident_bytes"]


def give_back() -> bool:
    """Give the free pages of the heap back to the system; False where that is not known to work.

    Notes
    -----
    Takes about 0.1 ms per megabyte given back; other threads go on meanwhile unless they
    allocate in the same part of the heap.
    """
    if not sys.platform.startswith("linux"):
        return False
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except AttributeError:
        return False  # another C library than glibc
    trim.argtypes = [ctypes.c_size_t]
    trim(0)
    return True


def resident_bytes() -> int:
    """What the process takes of the machine's memory now; 0 if the system does not tell."""
    try:
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    except (OSError, IndexError):
        return 0
    return int(pages) * os.sysconf("SC_PAGE_SIZE")
