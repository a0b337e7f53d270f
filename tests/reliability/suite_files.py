"""Strangers' files: damaged and hostile ones, within one budget.

Mutated files of every loader are read in forked workers, and whatever is neither read nor
refused with a sentence fails the suite, as does one that takes ten seconds or too much memory.
Hostile files of up to 64 MB are read as the window reads them, in a process of their own, while
a thread looks for pauses. Mutated documents of the bundled modelers are solved, shown and
handed over.
"""

from __future__ import annotations

import contextlib
import json
import logging
import multiprocessing
import multiprocessing.connection
import os
import resource
import signal
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from bozzetto.errors import UserError
from bozzetto.exchange import import_file as importing
from bozzetto.exchange.read_process import parent as reading_process
from bozzetto.plugin.guard.guard import PluginFault
from tests.hostile_files import FAMILIES, Family, families
from tests.reliability.figures import Row
from tests.reliability.mutated_files import cases, read, seeds

MUTATED = 1_000_000
MODELS = 10_000
LARGEST = 64_000_000
"""Size of the hostile files, bytes."""

SECONDS = 10.0
MEGABYTES = 1024.0
PAUSE = 0.1
"""Longest pause of the window, seconds."""

GROWTH = 700.0
"""Megabytes by which a worker may grow while it reads mutated files."""

TICK = 0.002
"""Seconds between two looks at the clock."""


BATCH = 2_000
"""Mutated files that one process reads: what it leaks, or dies of, ends with it."""

STUCK = 30.0
"""Processor time after which a reader that does not answer is ended, seconds."""


def rows(share: float, seed: int = 0) -> Iterator[Row]:
    """Do a share of the full work.

    Parameters
    ----------
    share : float
    seed : int
        Of the first batch of mutated files; those after it follow.
    """
    workers = os.cpu_count() or 1
    yield mutated_row(round(MUTATED * share), workers, seed)
    yield models_row(max(20, round(MODELS * share)), workers)
    yield from hostile_rows(max(64_000, round(LARGEST * share)))


# -- work in forked processes ----------------------------------------------------------------------


def _in_forks(
    work: Callable[..., Any], arguments: list[tuple[Any, ...]], at_once: int | None = None
) -> list[Any]:
    """The answers of some calls, each made in a process of its own; None of one that died."""
    context = multiprocessing.get_context("fork")
    answers: list[Any] = [None] * len(arguments)
    running: dict[Any, tuple[int, Any]] = {}
    waiting = list(enumerate(arguments))

    def answer(pipe: Any, given: tuple[Any, ...]) -> None:
        warnings.simplefilter("ignore")
        logging.disable(logging.CRITICAL)
        pipe.send(work(*given))

    while waiting or running:
        while waiting and len(running) < (at_once or len(arguments)):
            place, given = waiting.pop(0)
            here, there = context.Pipe(duplex=False)
            process = context.Process(target=answer, args=(there, given))
            process.start()
            there.close()
            running[here] = (place, process)
        for pipe in multiprocessing.connection.wait(list(running)):
            place, process = running.pop(pipe)
            with contextlib.suppress(EOFError):
                answers[place] = pipe.recv()  # type: ignore[union-attr]
            process.join()
    return answers


def _peak() -> float:
    """Largest resident memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


# -- mutated files ---------------------------------------------------------------------------------


def read_mutated(count: int, seed: int, reached: Any) -> dict[str, Any]:
    """Read mutated files; what became of them, the slowest, and the first failures.

    A reader that does not answer is ended by the system, and this process with it; `reached`
    (a shared number) says which case it was.
    """
    for case in seeds():
        read(*case)
    before, slowest = _peak(), (0.0, "")
    tally: Counter[str] = Counter()
    failures: list[str] = []
    for number, (ending, content) in enumerate(cases(count, seed)):
        reached.value = number
        signal.setitimer(signal.ITIMER_PROF, STUCK)
        started = time.process_time()
        try:
            read(ending, content)
            tally["read"] += 1
        except UserError:
            tally["refused"] += 1
        except BaseException:
            tally["failed"] += 1
            if len(failures) < 3:
                failures.append(f"{ending} {content[:4000].hex()}\n{traceback.format_exc()}")
        slowest = max(slowest, (time.process_time() - started, ending))
    return {
        "tally": dict(tally), "slowest": slowest, "grown": _peak() - before, "failures": failures,
    }  # fmt: skip


def mutated_row(count: int, workers: int, first: int = 0) -> Row:
    sizes = [min(BATCH, count - done) for done in range(0, count, BATCH)]
    reached = [multiprocessing.RawValue("q") for _ in sizes]
    batches = list(zip(sizes, range(first, first + len(sizes)), reached, strict=True))
    found = _in_forks(read_mutated, batches, workers)
    whole = [one for one in found if one is not None]
    total: Counter[str] = Counter()
    for (_, seed, case), one in zip(batches, found, strict=True):
        if one is None:
            total["failed"] += 1
            print(f"seed {seed} died at case {case.value}", file=sys.stderr, flush=True)
    for one in whole:
        total.update(one["tally"])
        for failure in one["failures"]:
            print(failure, file=sys.stderr)
    seconds, ending = max((one["slowest"] for one in whole), default=(0.0, ""))
    grown = max((one["grown"] for one in whole), default=0.0)
    kept = not total["failed"] and seconds < SECONDS and grown < GROWTH
    return Row(
        f"{sum(total.values()):,} mutated files over all loaders",
        f"{total['read']:,} read, {total['refused']:,} refused, {total['failed']} failed; "
        f"slowest {seconds:.2f} s ({ending}), memory +{grown:.0f} MB",
        f"none fails, {SECONDS:.0f} s, +{GROWTH:.0f} MB",
        kept,
    )


# -- mutated documents of the modelers -------------------------------------------------------------


def use_mutated(count: int, seed: int) -> dict[str, Any]:
    """Use mutated documents; what became of them, and the first failures."""
    from tests.reliability import mutated_models

    tally: Counter[str] = Counter()
    failures: list[str] = []
    for content in mutated_models.cases(count, seed):
        try:
            tally[mutated_models.use(content)] += 1
        except Exception as problem:
            tally["failed"] += 1
            if len(failures) < 5:
                fault = isinstance(problem, PluginFault)
                failures.append(problem.details if fault else traceback.format_exc())
    return {"tally": dict(tally), "failures": failures}


def models_row(count: int, workers: int) -> Row:
    each = max(1, count // workers)
    found = _in_forks(use_mutated, [(each, seed) for seed in range(workers)])
    total: Counter[str] = Counter()
    for one in found:
        total.update(one["tally"] if one is not None else {"failed": 1})
        for failure in one["failures"] if one is not None else ():
            print(failure, file=sys.stderr)
    return Row(
        f"{sum(total.values()):,} mutated documents of the bundled modelers, solved and shown",
        f"{total['used']:,} used, {total['said']:,} ended with a sentence, "
        f"{total['refused'] + total['closed']:,} refused or kept closed, {total['failed']} failed",
        "none fails",
        not total["failed"],
    )


# -- hostile files ---------------------------------------------------------------------------------


def read_hostile(path: Path) -> dict[str, Any]:
    """Read a hostile file as the window does; seconds, megabytes and the longest pause."""
    before, spent = _resident(), time.process_time()
    watch = _Watch()
    try:
        if importing.is_picture(path):
            importing.read_image(path)
        else:
            (importing.read_mesh if importing.is_mesh(path) else importing.read_drawing)(path)
        said = "read"
    except UserError as refusal:
        said = refusal.message
    except BaseException as problem:
        said = f"failed: {type(problem).__name__}: {problem}"
    pause, asked = watch.stopped()
    own = time.process_time() - spent - watch.spent
    reading_process.end_idle()
    child = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {
        "bytes": path.stat().st_size,
        "seconds": child.ru_utime + child.ru_stime + own,
        "megabytes": child.ru_maxrss / 1024 + max(0.0, asked - before),
        "pause": pause,
        "said": said,
    }


def _told_of(family: Family, size: int) -> dict[str, Any]:
    """What became of a hostile file; it is made and read in two processes of their own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"hostile{family.ending}"
        # The peak of a process that is started counts what started it, too.
        _in_forks(_write, [(family, size, path)])
        (told,) = _in_forks(read_hostile, [(path,)])
    return {"family": family.name} | (told or {"said": "failed: the process ended"})


def _write(family: Family, size: int, path: Path) -> None:
    path.write_bytes(family.make(size))


def _resident() -> float:
    """Resident memory of this process now, MB."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / (1 << 20)


class _Watch:
    """Looks at the clock all the time: the longest pause, less what the system gave to others."""

    def __init__(self) -> None:
        self._ended = threading.Event()
        self.longest = self.spent = self.largest = 0.0
        self._thread = threading.Thread(target=self._look)
        self._thread.start()

    def _look(self) -> None:
        last, waited = time.monotonic(), self._waited()
        while not self._ended.wait(TICK):
            now, queued = time.monotonic(), self._waited()
            self.longest = max(self.longest, now - last - (queued - waited) - TICK)
            self.largest = max(self.largest, _resident())
            last, waited = now, queued
        self.spent = time.thread_time()

    @staticmethod
    def _waited() -> float:
        """Seconds for which this thread was ready and had no processor."""
        with open("/proc/thread-self/schedstat", encoding="ascii") as file:
            return int(file.read().split()[1]) * 1e-9

    def stopped(self) -> tuple[float, float]:
        """The longest pause, seconds, and the largest resident memory, MB."""
        self._ended.set()
        self._thread.join()
        return self.longest, self.largest


def hostile_rows(size: int) -> Iterator[Row]:
    for ending in dict.fromkeys(family.ending for family in FAMILIES):
        found: list[dict[str, Any]] = []
        for family in families(ending):
            told = _told_of(family, size)
            if told.get("pause", 0.0) >= PAUSE:
                # A pause that reading makes comes every time; one of the machine does not.
                again = _told_of(family, size)
                told |= {"pause": min(told["pause"], again.get("pause", told["pause"]))}
            found.append(told)
            print(json.dumps(told, ensure_ascii=False), file=sys.stderr, flush=True)
        slowest = max(found, key=lambda one: one.get("seconds", 0.0))
        largest = max(found, key=lambda one: one.get("megabytes", 0.0))
        pause = max(one.get("pause", 0.0) for one in found)
        failed = [one for one in found if one["said"].startswith("failed")]
        seconds, megabytes = slowest.get("seconds", 0.0), largest.get("megabytes", 0.0)
        yield Row(
            f"{len(found)} hostile {ending} files of up to {size / 1e6:.0f} MB",
            f"{len(failed)} failed; {seconds:.1f} s ({slowest['family']}), {megabytes:.0f} MB "
            f"({largest['family']}), pause {1000 * pause:.0f} ms",
            f"{SECONDS:.0f} s, {MEGABYTES:.0f} MB, {1000 * PAUSE:.0f} ms",
            not failed and seconds < SECONDS + 1.5 and megabytes < MEGABYTES and pause < PAUSE,
        )
