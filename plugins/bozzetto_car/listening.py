"""Whether anybody still waits, asked between the steps of a solve.

Bodies are remembered by what they are made of, and functions between a question and its steps take
no job: an answer does not depend on who waits for it. So the job is that of the thread.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

from bozzetto.plugin import Job

_UNDER_WAY: Final[ContextVar[tuple[Job, float, str] | None]] = ContextVar("job", default=None)


@contextmanager
def listening(job: Job, fraction: float, step: str) -> Iterator[None]:
    """Let the steps of what is worked out within look at a job; see `Job.checkpoint`.

    Raises
    ------
    Cancelled
        If the answer is no longer wanted, here or at one of the steps.
    """
    job.checkpoint(fraction, step)
    before = _UNDER_WAY.set((job, fraction, step))
    try:
        yield
    finally:
        _UNDER_WAY.reset(before)


def look() -> None:
    """Look at the job of this thread, if there is one; call it between steps, and in loops.

    Raises
    ------
    Cancelled
        If the answer is no longer wanted. Let it pass.
    """
    under_way = _UNDER_WAY.get()
    if under_way is not None:
        job, fraction, step = under_way
        job.checkpoint(fraction, step)
