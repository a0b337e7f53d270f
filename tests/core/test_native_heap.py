"""The C library's heap: what was freed goes back, and only that."""

from __future__ import annotations

import subprocess
import sys

import pytest

from bozzetto.native_heap import give_back

SCATTERED = """
import numpy as np
import os
from bozzetto.native_heap import give_back

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

blocks = [np.ones(10_000) for _ in range(4_000)]  # 80 kB each: in the heap, not mapped
kept = blocks[::40]
del blocks
full = resident()
give_back()
print(full, resident(), sum(int(block.sum()) for block in kept))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="glibc is meant")
def test_freed_blocks_between_kept_ones_go_back_to_the_system():
    if not give_back():
        pytest.skip("another C library than glibc")
    said = subprocess.run(
        [sys.executable, "-c", SCATTERED], check=True, capture_output=True, text=True
    ).stdout
    full, rest, total = map(int, said.split())
    assert full - rest > 250e6
    assert total == 100 * 10_000


THREADS = """
import os, threading
import numpy as np
from bozzetto.native_heap import bound_heap, give_back

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

assert bound_heap()
np.ones(3_900_000)  # 31 MB, freed: what the C library keeps for later grows with it
before, together, end = resident(), threading.Barrier(9), threading.Event()

def work():
    together.wait()
    blocks = [np.ones(25_000) for _ in range(200)]  # 40 MB in pieces of 200 kB
    together.wait()
    del blocks
    together.wait()
    end.wait()

for _ in range(8):
    threading.Thread(target=work).start()
for _ in range(3):
    together.wait()
give_back()
print(resident() - before)
end.set()
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="glibc is meant")
def test_threads_that_are_done_keep_little_of_the_heap():
    if not give_back():
        pytest.skip("another C library than glibc")
    said = subprocess.run(
        [sys.executable, "-c", THREADS], check=True, capture_output=True, text=True
    ).stdout
    assert int(said) < 40e6  # 80 million and more of the 320 as the C library is by itself
