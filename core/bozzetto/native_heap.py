"""The C library's heap: what was freed is given back to the system.

The C library keeps freed memory for later. Solves allocate and free hundreds of megabytes in
arrays of all sizes and in several threads, each with a part of the heap of its own: after a
thousand random actions two thirds of it were such free memory, and the share kept growing.
"""

from __future__ import annotations

import ctypes
import sys
from typing import Any, Final

PARTS: Final = 2
"""Parts that the heap is divided into: one for the window's thread, one for all others. Their
number is else eight for each core, and a part's free end is never given back by a trim."""

FREE_END: Final = 16 << 20
"""Bytes of a part's free end that may be kept for later; else up to 64 MB."""

MAPPED: Final = 32 << 20
"""Bytes from which on an allocation has pages of its own: as the C library chooses by itself after
a while, but not once the free end is bounded."""

M_TRIM_THRESHOLD: Final = -1
M_MMAP_THRESHOLD: Final = -3
M_ARENA_MAX: Final = -8
"""Numbers of `mallopt`'s parameters, from malloc.h."""


def bound_heap() -> bool:
    """Bound the freed memory that the heap keeps; False where that is not known to work.

    Called once, before the first thread is started.
    """
    library = _glibc()
    if library is None:
        return False
    values = ((M_ARENA_MAX, PARTS), (M_TRIM_THRESHOLD, FREE_END), (M_MMAP_THRESHOLD, MAPPED))
    return all([library.mallopt(name, value) for name, value in values])


def give_back() -> bool:
    """Give the free pages of the heap back to the system; False where that is not known to work.

    Notes
    -----
    Takes about 0.1 ms per megabyte given back; other threads go on meanwhile unless they
    allocate in the same part of the heap.
    """
    library = _glibc()
    if library is None:
        return False
    library.malloc_trim(ctypes.c_size_t(0))
    return True


def _glibc() -> Any | None:
    """Return the C library, if it is the one that knows these calls."""
    if not sys.platform.startswith("linux"):
        return None
    library = ctypes.CDLL(None)
    return library if hasattr(library, "malloc_trim") and hasattr(library, "mallopt") else None
