"""Reading a file in a process of its own, which can be ended.

Files come from strangers, and what reading them takes cannot be known before. So it is done
where it may take no more than its `Budget`, where the window does not wait for a lock of the
interpreter, and where it can be stopped at any moment. One process is kept for a while after it
has answered, for starting it takes longer than reading a small file.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.awake_time import awake_time
from bozzetto.document.storage.zip_container import all_finite
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import Budget
from bozzetto.exchange.read_process.answers import Answer, unpack_answer
from bozzetto.typed_data import decode_msgpack

POLL_SECONDS: Final = 0.05
"""Interval at which it is asked whether the answer is still wanted."""

TOO_MUCH: Final = (
    "It takes more than {what} to be read. Simplify it or split it in the program that made "
    "it. If you know who made it, “bozzetto build --trust-file” reads it without this limit."
)

Checkpoint = Callable[[], None]


class ReaderFault(RuntimeError):
    """A defect of ours in the process that reads, with its traceback."""


class _Ended(Exception):
    """The process ended instead of answering.

    Attributes
    ----------
    accepted : bool
        Whether it had got the request.
    """

    def __init__(self, accepted: bool) -> None:
        super().__init__("the reading process ended")
        self.accepted = accepted


class _Process:
    """A reading process and the pipes to it."""

    def __init__(self) -> None:
        code = (
            f"import sys; sys.path[:] = {sys.path!r}; "
            "from bozzetto.exchange.read_process.child import main; main()"
        )
        # One thread of BLAS: a pool of them takes memory and time, and does nothing here.
        env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        try:
            self._popen = subprocess.Popen(
                [sys.executable, "-c", code],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=env,
            )
        except OSError as problem:
            raise UserError(
                f"No process can be started to read the file ({problem.strerror}). Close "
                "other programs and try again."
            ) from problem
        self.owner = os.getpid()

    def end(self) -> int:
        """End it, and say how it ended."""
        self._popen.kill()
        code = self._popen.wait()
        for pipe in (self._popen.stdin, self._popen.stdout):
            with contextlib.suppress(OSError):  # what was not yet sent is of no use now
                if pipe is not None:
                    pipe.close()
        return code

    def ended_by(self) -> int:
        """Return the exit code with which it ended by itself."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(1.0)
        return self.end()

    def ask(self, kind: str, path: bytes, budget: Budget) -> tuple[Any, list[NDArray[Any]]]:
        """Send a request and wait for the reply.

        Raises
        ------
        _Ended
        """
        # Here, and not on top: the child's module imports the readers.
        from bozzetto.exchange.read_process.child import ACCEPTED, LENGTH, Reply, Request

        text = msgspec.msgpack.encode(Request(kind, path, budget.seconds, budget.megabytes))
        try:
            assert self._popen.stdin is not None
            self._popen.stdin.write(LENGTH.pack(len(text)) + text)
            self._popen.stdin.flush()
        except OSError:
            raise _Ended(accepted=False) from None
        if bytes(self._bytes(1, accepted=False)) != ACCEPTED:
            raise _Ended(accepted=False)
        (length,) = LENGTH.unpack(self._bytes(LENGTH.size))
        reply: Reply = decode_msgpack(self._bytes(length), Reply)
        arrays = [self._array(np.dtype(dtype), shape) for dtype, shape in reply.arrays]
        return reply, arrays

    def _array(self, dtype: np.dtype[Any], shape: tuple[int, ...]) -> NDArray[Any]:
        count = int(np.prod(shape, dtype=np.int64))
        array = np.frombuffer(self._bytes(count * dtype.itemsize), dtype).reshape(shape)
        if not all_finite(array):
            raise FormatError("It holds numbers that are not finite.")
        return array

    def _bytes(self, count: int, *, accepted: bool = True) -> memoryview:
        assert self._popen.stdout is not None
        content = np.empty(count, np.uint8).data
        done = 0
        while done < count:
            got = self._popen.stdout.readinto(content[done:])  # type: ignore[attr-defined]
            if not got:
                raise _Ended(accepted)
            done += got
        return content.toreadonly()


_idle: list[_Process] = []
"""At most one process that has answered and waits for the next request."""

_lock = threading.Lock()


@atexit.register
def end_idle() -> None:
    """End the process that waits for the next request; the next reading starts another."""
    while _idle:
        _idle.pop().end()


def _taken() -> _Process | None:
    """Return the waiting process, if there is one of this process; a fork's does not count."""
    with _lock:
        process = _idle.pop() if _idle else None
    return process if process is not None and process.owner == os.getpid() else None


def _put_back(process: _Process) -> None:
    with _lock:
        if not _idle:
            _idle.append(process)
            return
    process.end()


def read_in_child(
    kind: str,
    path: str | os.PathLike[str],
    budget: Budget,
    checkpoint: Checkpoint | None = None,
) -> Answer:
    """Read a file in a process of its own.

    Parameters
    ----------
    kind : {"mesh", "drawing", "image", "picture"}
        As `import_file.read_here` knows them.
    path : path
        The file.
    budget : Budget
        Processor time and memory that the reading may take.
    checkpoint : callable, optional
        Called now and then while waiting; whatever it raises ends the reading and passes.

    Raises
    ------
    UserError, FormatError
        What the reader says; or that it took more than its budget.
    ReaderFault
        If the reader raised something else: a defect.
    """
    where = os.fsencode(os.path.abspath(path))
    process = _taken()
    if process is not None:
        try:
            return _conversation(process, kind, where, budget, checkpoint)
        except _Ended as ended:
            if ended.accepted:  # not: it had gone home before the request came
                raise _refusal(process, budget) from None
            process.end()
    process = _Process()
    try:
        return _conversation(process, kind, where, budget, checkpoint)
    except _Ended:
        raise _refusal(process, budget) from None


def _refusal(process: _Process, budget: Budget) -> FormatError:
    """Return the reason why a process ended that had a file to read."""
    import signal

    code = process.ended_by()
    if code == -int(getattr(signal, "SIGXCPU", 0)) != 0:
        return FormatError(TOO_MUCH.format(what=f"{budget.seconds} seconds"))
    return FormatError(TOO_MUCH.format(what=f"{budget.megabytes} MB of memory"))


def _conversation(
    process: _Process,
    kind: str,
    path: bytes,
    budget: Budget,
    checkpoint: Checkpoint | None,
) -> Answer:
    """Ask, and look up now and then while waiting; the process ends unless all went well."""
    answers: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def ask() -> None:
        try:
            answers.put(process.ask(kind, path, budget))
        except BaseException as problem:
            answers.put(problem)

    asking = threading.Thread(target=ask, name="bozzetto-reading", daemon=True)
    finished = False
    until = awake_time() + budget.wall_seconds
    asking.start()
    try:
        answer: Any = None
        while answer is None:
            try:
                answer = answers.get(timeout=POLL_SECONDS)
            except queue.Empty:
                if checkpoint is not None:
                    checkpoint()
                if awake_time() > until:
                    raise FormatError(
                        TOO_MUCH.format(what=f"{budget.wall_seconds} seconds")
                    ) from None
        if isinstance(answer, _Ended):
            finished = True  # the caller looks at how
            raise answer
        if isinstance(answer, BaseException):
            raise answer
        reply, arrays = answer
        finished = not reply.last
        if finished:
            _put_back(process)
    finally:
        if not finished:
            process.end()
    if reply.fault:
        raise ReaderFault(reply.fault)
    if reply.refused:
        raise (FormatError if reply.is_format else UserError)(reply.refused)
    return unpack_answer(reply.record, arrays)
