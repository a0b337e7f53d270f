"""The watchdog: a call into a plugin that does not answer is interrupted.

What it can do, and what it cannot
----------------------------------
A call runs in a thread of its own. After its time limit an exception is planted in that
thread (``PyThreadState_SetAsyncExc``); Python raises it between two bytecodes, so a loop
written in Python ends, and its traceback shows where it hung. Three things stay out of
reach: code in C (one long numpy or scipy call) goes on until it returns to Python; code
that swallows ``BaseException`` in a loop survives; a thread that waits for a lock never
notices. Such a thread is abandoned: it is a daemon, nobody waits for it and its answer is
dropped, but it keeps a core busy until the program ends.
"""

from __future__ import annotations

import ctypes
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from bozzetto.awake_time import awake_time, wait_awake
from bozzetto.plugin.guard.argument_snapshot import ArgumentSnapshot
from bozzetto.plugin.guard.guard import Guard, Overrun, PluginFault

GRACE = 1.0
"""Seconds that an interrupted call has to end."""

REPEAT = 0.1
"""Seconds between two interruptions of a call that does not end."""

Answer = TypeVar("Answer")


def interrupt(thread: threading.Thread) -> bool:
    """Raise `Overrun` in another thread, at its next bytecode.

    Returns
    -------
    bool
        Whether the thread was still running Python code to raise it in.
    """
    if thread.ident is None or not thread.is_alive():
        return False
    planted = ctypes.pythonapi.PyThreadState_SetAsyncExc(
        ctypes.c_ulong(thread.ident), ctypes.py_object(Overrun)
    )
    return bool(planted == 1)


def stack_of(thread: threading.Thread | None) -> str:
    """Return what a thread is doing, as in a traceback; "" if it has ended."""
    # Python has no other way to look at a thread from outside of it.
    frame = sys._current_frames().get((thread and thread.ident) or 0)  # noqa: SLF001
    return "".join(traceback.format_stack(frame)) if frame is not None else ""


class _Call(Generic[Answer]):
    """One call in its own thread, with what became of it."""

    def __init__(self, work: Callable[[], Answer]) -> None:
        self.answer: list[Answer] = []
        self.problem: BaseException | None = None
        self.ended = threading.Event()
        self._work = work
        self.thread = threading.Thread(target=self._run, name="bozzetto-guarded", daemon=True)
        self.thread.start()

    def _run(self) -> None:
        try:
            try:
                self.answer.append(self._work())
            except BaseException as problem:
                self.problem = problem
            self.ended.set()
        except Overrun as late:
            # Planted in the last moment, between the answer and the end.
            self.problem = self.problem or late
            self.ended.set()


class Watchdog:
    """Runs calls of a guard within a time limit.

    Parameters
    ----------
    guard : Guard
    limit : float
        Seconds.
    """

    def __init__(self, guard: Guard, limit: float) -> None:
        self.guard = guard
        self.limit = limit

    def call(
        self, modeler_id: str, what: str, function: Callable[..., Answer], *arguments: Any
    ) -> Answer:
        """Call a plugin's function as `Guard.call` does, but wait no longer than the limit.

        Raises
        ------
        UserError, Unfinished, Cancelled, PluginFault
            As `Guard.call`; and `PluginFault` if there was no answer in time.
        """
        before = ArgumentSnapshot(arguments)
        call = _Call(lambda: self.guard.call(modeler_id, what, function, *arguments))
        if not wait_awake(call.ended, self.limit):
            until = awake_time() + GRACE
            while not call.ended.is_set() and awake_time() < until:
                interrupt(call.thread)
                call.ended.wait(REPEAT)
            before.restore()
            told = call.problem.details if isinstance(call.problem, PluginFault) else ""
            left = "" if call.ended.is_set() else "; its thread could not be stopped"
            raise self.guard.blame(
                modeler_id, f"{what} did not answer within {self.limit:g} s{left}", told
            )
        if call.problem is not None:
            raise call.problem
        return call.answer[0]
