"""Work beside the window: threads that answer by signal, newest request first.

A channel carries one kind of work ("preview", "solve", "apply"). At most one request of a
channel runs; while it runs only the newest waiting request is kept (or all of them, in
order, where a channel says so). An answer is delivered on the window's thread, and only if
its request was not overtaken. A request that overruns its time limit is left behind with its
thread, unless its channel is patient: then it is reported as slow, and goes on until it
answers or a person stops it. Work that does not listen when it is cancelled is left behind as
well, and interrupted if it shows no sign of life even then: the window never waits.
"""

from __future__ import annotations

import atexit
import itertools
import logging
import math
import threading
import weakref
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.awake_time import awake_time
from bozzetto.errors import Cancelled
from bozzetto.plugin.guard.guard import Overrun
from bozzetto.plugin.guard.watchdog import interrupt, stack_of
from bozzetto.plugin.job import Job
from bozzetto_app.workers.main_thread import (
    call_on_main_thread,
    install,
    release_on_main_thread,
)

__all__ = ["LATE_AFTER", "Channel", "Hung", "Request"]

log = logging.getLogger(__name__)

PROGRESS_INTERVAL = 0.05
"""Seconds between two progress messages to the window."""

GRACE = 1.0
"""Seconds that abandoned work gets to notice it, before its thread is left behind."""

PATIENCE = 60.0
"""Seconds until work that was left behind is interrupted, where it has no time limit."""

LATE_AFTER = 60.0
"""Seconds without progress after which work is late: a patient channel tells that it is slow, and
what a plugin is asked besides counts as hung. On a crowded machine a hint comes after a solve."""

IDLE = 1.0
"""Seconds that a thread waits for more work before it ends."""

_tickets = itertools.count(1)


class Hung(TimeoutError):
    """Work did not answer in time.

    Attributes
    ----------
    limit : float
        Seconds.
    thread : Thread
        Where it went on when this was noticed.
    is_again : bool
        Whether the same work was told as slow before.
    stack : str
        What it was doing there.
    """

    def __init__(self, limit: float, thread: threading.Thread, *, is_again: bool = False) -> None:
        super().__init__(f"no answer within {limit:g} s")
        self.limit = limit
        self.thread = thread
        self.is_again = is_again
        self.stack = stack_of(thread)


@dataclass(eq=False)
class Request:
    """One piece of work and what becomes of it.

    Parameters
    ----------
    work : callable
        Called with a `Job` in the worker.
    done, failed : callable
        Called on the window's thread with the answer, or with the exception.
    quality : {"preview", "final"}
    inputs : callable, optional
        Called on the window's thread when the turn of the request has come; `work` gets its
        answer as a second argument. So work in a queue starts from the newest state, and
        reads nothing that belongs to the window's thread.
    dropped : callable
        Called with an answer that nobody takes: the request was abandoned, or its channel is
        gone. What the answer holds, such as a lock, is given back here; from any thread.
    stopped : callable
        Called on the window's thread when it is cancelled or withdrawn before there is an answer.
    is_kept : bool
        Whether what it is about is in the history without an answer, as ink that waits is: then
        undoing it is not for the queue.
    """

    work: Callable[..., Any]
    done: Callable[[Any], None]
    failed: Callable[[BaseException], None]
    quality: str = "final"
    inputs: Callable[[], Any] | None = None
    dropped: Callable[[Any], None] = lambda answer: None
    stopped: Callable[[], None] = lambda: None
    is_kept: bool = False
    ticket: int = field(default_factory=lambda: next(_tickets))
    seen_alive: float = 0.0
    abandoned_at: float | None = None
    is_told_slow: bool = False
    told_at: float = -math.inf
    thread: threading.Thread | None = None

    @property
    def abandoned(self) -> bool:
        """Whether nobody wants the answer any more."""
        return self.abandoned_at is not None

    def abandon(self) -> None:
        """Say that nobody wants the answer any more."""
        if self.abandoned_at is None:
            self.abandoned_at = awake_time()


class _Worker:
    """A thread that does one request after another, and ends when it has been idle for long.

    Starting a thread means waiting for it, and a busy worker of another channel may hold
    the interpreter meanwhile: too expensive for each value of a slider.
    """

    def __init__(self, name: str) -> None:
        self._waiting: SimpleQueue[list[Callable[[], None]] | None] = SimpleQueue()
        self._is_idle = False
        self._lock = threading.Lock()
        self._is_open = True
        self.thread = threading.Thread(target=self._run, name=name, daemon=True)
        self.thread.start()
        _workers.add(self)

    @property
    def is_idle(self) -> bool:
        """Whether it waits for work."""
        return self._is_idle

    def take(self, work: Callable[[], None]) -> bool:
        """Do this next; False where the thread has ended meanwhile."""
        with self._lock:
            if self._is_open:
                self._waiting.put([work])
            return self._is_open

    def retire(self) -> None:
        """Take nothing more, and end when what is being done has ended."""
        with self._lock:
            self._is_open = False
            self._waiting.put(None)

    def _run(self) -> None:
        while True:
            self._is_idle = True
            try:
                task = self._waiting.get(timeout=IDLE)
            except Empty:
                with self._lock:
                    if not self._waiting.empty():
                        continue
                    self._is_open = False
                return
            if task is None:
                return
            self._is_idle = False
            task[0]()
            release_on_main_thread(task)
            del task  # what it holds must not live on in an idle thread


_workers: weakref.WeakSet[_Worker] = weakref.WeakSet()


@atexit.register
def _end_idle_workers() -> None:
    """Let no thread wait for work while the interpreter is taken apart."""
    for worker in tuple(_workers):
        idle = worker.is_idle
        worker.retire()
        if idle:
            worker.thread.join(IDLE)


class Channel(QObject):
    """A queue of requests with one worker thread at a time.

    Parameters
    ----------
    name : str
        For thread names and the log.
    keep_all : bool
        Run every request in order; otherwise only the newest waiting one survives.
    time_limit : float, optional
        Seconds without progress after which a running request counts as hung: it fails
        with `Hung` and its thread is left behind.
    is_patient : bool
        Tell that it is slow instead, and wait; after `LATE_AFTER` where no limit is given.

    Signals
    -------
    progressed : float, str; busy_changed : bool
    slow : Hung
        What runs has overrun the time limit of a patient channel, once or once more.
    caught_up
        What was told as slow has ended, or is waited for no more.
    """

    progressed = Signal(float, str)
    busy_changed = Signal(bool)
    slow = Signal(object)
    caught_up = Signal()

    def __init__(
        self,
        name: str,
        *,
        keep_all: bool = False,
        time_limit: float | None = None,
        is_patient: bool = False,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.name = name
        self.keep_all = keep_all
        self.time_limit = LATE_AFTER if is_patient and time_limit is None else time_limit
        self.is_patient = is_patient
        self._waiting: deque[Request] = deque()
        self._running: Request | None = None
        self._worker: _Worker | None = None
        self._last_progress = 0.0
        self._left_behind: list[Request] = []
        install()
        self._watch = QTimer(self)
        self._watch.setInterval(50)
        self._watch.timeout.connect(self._look_at_the_clock)

    @property
    def busy(self) -> bool:
        """Whether a request is running or waiting."""
        return self._running is not None or bool(self._waiting)

    @property
    def running(self) -> Request | None:
        """The request being worked on."""
        return self._running

    def submit(self, request: Request) -> Request:
        """Queue a request; on a newest-only channel it replaces the waiting one."""
        if not self.keep_all:
            self._waiting.clear()
        self._waiting.append(request)
        self._start_next()
        return request

    def cancel(self, *, only_kept: bool = False) -> None:
        """Drop what waits and abandon what runs; its answer will not be delivered.

        Parameters
        ----------
        only_kept : bool
            Leave all requests that are not kept elsewhere; see `Request.is_kept`.
        """
        stopped = [one for one in self._waiting if one.is_kept or not only_kept]
        for request in stopped:
            self._waiting.remove(request)
        running = self._running
        if running is not None and not running.abandoned and (running.is_kept or not only_kept):
            running.abandon()
            stopped.append(running)
        for request in stopped:
            request.stopped()

    def withdraw_newest(self) -> bool:
        """Drop only what was asked for last, and say whether it was dropped.

        Returns
        -------
        bool
            False where nothing is without an answer, or the newest is kept; see `Request.is_kept`.
        """
        running = self._running
        newest = self._waiting[-1] if self._waiting else running
        if newest is None or newest.abandoned or newest.is_kept:
            return False
        if newest is running:
            newest.abandon()
        else:
            self._waiting.pop()
        newest.stopped()
        return True

    def _start_next(self) -> None:
        if self._running is not None or not self._waiting:
            return
        request = self._waiting.popleft()
        self._running = request
        request.seen_alive = awake_time()
        self._watch.start()
        self.busy_changed.emit(True)
        self._hand_over(request)

    def _hand_over(self, request: Request) -> None:
        """Hand the request to the worker, or to a new one if there is none."""
        arguments = () if request.inputs is None else (request.inputs(),)

        def work() -> None:
            self._work(request, arguments)

        if self._worker is not None:
            request.thread = self._worker.thread
            if self._worker.take(work):
                return
        self._worker = _Worker(f"bozzetto-{self.name}")
        request.thread = self._worker.thread
        self._worker.take(work)

    def _work(self, request: Request, arguments: tuple[Any, ...]) -> None:
        def progress(fraction: float, step: str) -> None:
            request.seen_alive = now = awake_time()
            if now - self._last_progress > PROGRESS_INTERVAL and request is self._running:
                self._last_progress = now
                call_on_main_thread(self, self.progressed.emit, float(fraction), str(step))

        job = Job(
            quality="preview" if request.quality == "preview" else "final",
            progress=progress,
            cancelled=lambda: request.abandoned,
        )
        answer: Any = None
        error: BaseException | None = None
        try:
            try:
                answer = request.work(job, *arguments)
            except BaseException as problem:
                error = problem
            drop = partial(_drop, request, answer, error)
            call_on_main_thread(self, self._deliver, request, answer, error, otherwise=drop)
        except Overrun:
            log.debug("%s answered just when it was abandoned", self.name)

    def _deliver(self, request: Request, answer: Any, error: BaseException | None) -> None:
        if request is not self._running:
            _drop(request, answer, error)
            return
        self._finish()
        if request.abandoned:
            _drop(request, answer, error)
        elif not isinstance(error, Cancelled):
            if error is None:
                request.done(answer)
            else:
                request.failed(error)
        self._start_next()
        if not self.busy:
            self.busy_changed.emit(False)

    def _look_at_the_clock(self) -> None:
        now = awake_time()
        self._interrupt_the_hung(now)
        request = self._running
        if request is None:
            if not self._left_behind:
                self._watch.stop()
            return
        late = self.time_limit is not None and now - request.seen_alive > self.time_limit
        deaf = request.abandoned_at is not None and now - request.abandoned_at > GRACE
        if late and self.is_patient and not deaf:
            self._tell_slow(request, now)
            return
        if not (deaf or late):
            return
        left = "%s did not stop or answer in time; its thread is left behind, at\n%s"
        log.warning(left, self.name, stack_of(request.thread))
        wanted = not request.abandoned
        request.abandon()
        self._finish()
        self._left_behind.append(request)
        if self._worker is not None:
            self._worker.retire()
            self._worker = None
        if wanted and self.time_limit is not None and request.thread is not None:
            # Told before it is interrupted, while it can still be seen where it hangs.
            request.failed(Hung(self.time_limit, request.thread))
        self._interrupt_the_hung(now)
        self._start_next()
        if not self.busy:
            self.busy_changed.emit(False)

    def _tell_slow(self, request: Request, now: float) -> None:
        """Say that work goes on for long, once in a time limit; whoever waits may stop it."""
        assert self.time_limit is not None
        assert request.thread is not None
        if request.abandoned or now - request.told_at <= self.time_limit:
            return
        is_again, request.is_told_slow, request.told_at = request.is_told_slow, True, now
        self.slow.emit(Hung(self.time_limit, request.thread, is_again=is_again))

    def _interrupt_the_hung(self, now: float) -> None:
        """Stop work that was left behind, once it has shown no sign of life for long.

        Not at once: it may be in the middle of an import, which must not be torn.
        """
        for request in tuple(self._left_behind):
            limit = PATIENCE if self.time_limit is None else self.time_limit
            assert request.thread is not None
            if not request.thread.is_alive():
                self._left_behind.remove(request)
            elif now - request.seen_alive > limit:
                self._left_behind.remove(request)
                interrupt(request.thread)

    def _finish(self) -> None:
        ended, self._running = self._running, None
        if ended is not None and ended.is_told_slow:
            self.caught_up.emit()


def _drop(request: Request, answer: Any, error: BaseException | None) -> None:
    """Let go of an answer that nobody takes."""
    if error is None:
        request.dropped(answer)
