"""The process that reads files for another: it may be ended at any moment.

It takes requests from its standard input and answers on its standard output, one after the
other, until nobody asks any more. Every reading has a `Budget`; where the system can hold it,
the process that overdraws it is ended by the system.
"""

from __future__ import annotations

import os
import signal
import struct
import sys
import threading
import traceback
from typing import Any, BinaryIO, Final

import msgspec

from bozzetto.damaged_files import as_format_errors
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.import_file import read_here
from bozzetto.exchange.read_process.answers import pack_answer
from bozzetto.typed_data import decode_msgpack

LENGTH: Final = struct.Struct("<Q")
"""Length of the message that follows, bytes."""

ACCEPTED: Final = b"+"
"""Byte sent as soon as a request has arrived: from then on, silence is a failure."""

IDLE_SECONDS: Final = 20.0
"""Time without a request after which the process ends by itself."""

RESTART_BYTES: Final = 256 << 20
"""Resident memory above which the process ends after its answer: the next one begins small."""


class Request(msgspec.Struct):
    """One file to be read.

    Attributes
    ----------
    kind : str
        As `import_file.read_here` knows them.
    path : bytes
        As the system spells it, from the root.
    seconds, megabytes : int
        Limits of the `Budget`.
    """

    kind: str
    path: bytes
    seconds: int
    megabytes: int


class Reply(msgspec.Struct):
    """Outcome of a request.

    Attributes
    ----------
    record : bytes
        Record of the answer; the arrays follow the reply.
    arrays : list of (str, tuple of int)
        Element type and shape of each.
    refused, fault : str
        The sentence that says why there is none; or, for a defect, its traceback.
    is_format : bool
        Whether the refusal is about the content.
    last : bool
        The process ends now.
    """

    record: bytes = b""
    arrays: list[tuple[str, tuple[int, ...]]] = []
    refused: str = ""
    fault: str = ""
    is_format: bool = False
    last: bool = False


def main() -> None:
    """Answer requests until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asks is interrupted, and ends this
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    requests = os.fdopen(os.dup(0), "rb")
    while True:
        idle = threading.Timer(IDLE_SECONDS, os._exit, (0,))
        idle.daemon = True
        idle.start()
        head = requests.read(LENGTH.size)
        idle.cancel()
        if len(head) < LENGTH.size:
            return
        answers.write(ACCEPTED)
        answers.flush()
        text = requests.read(LENGTH.unpack(head)[0])
        last = _answer(decode_msgpack(text, Request), answers)
        answers.flush()
        if last:
            return


def _answer(request: Request, answers: BinaryIO) -> bool:
    arrays: list[Any] = []
    try:
        _hold_to(request)
        with as_format_errors():
            record, arrays = pack_answer(read_here(request.kind, os.fsdecode(request.path)))
        facts = [(array.dtype.str, array.shape) for array in arrays]
        reply = Reply(record, facts)
    except UserError as refusal:
        reply = Reply(refused=refusal.message, is_format=isinstance(refusal, FormatError))
    except Exception:
        reply = Reply(fault=traceback.format_exc())
    reply.last = _resident_bytes() > RESTART_BYTES
    text = msgspec.msgpack.encode(reply)
    answers.write(LENGTH.pack(len(text)) + text)
    for array in arrays:
        if array.size:
            answers.write(memoryview(array).cast("B"))
    return reply.last


def _hold_to(request: Request) -> None:
    """Let the system end this process where it goes beyond the request's budget."""
    try:
        import resource
    except ImportError:  # Windows: who asked watches the clock
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    spent = int(used.ru_utime + used.ru_stime) + 1
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (spent + request.seconds, most))
    if sys.platform == "linux":  # macOS has this limit and does not hold it
        with open("/proc/self/statm", encoding="ascii") as file:
            begun = int(file.read().split()[0]) * resource.getpagesize()
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (begun + (request.megabytes << 20), most))


def _resident_bytes() -> int:
    try:
        import resource
    except ImportError:
        return RESTART_BYTES + 1  # not known: the next one begins small in any case
    if sys.platform == "linux":  # its ru_maxrss counts in what the process that started us took
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * resource.getpagesize()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak << 10
