"""SIGKILL at random moments: of a save, and of drawing.

``python -m tests.kill_documents saves --count 1000`` and ``… drawing --count 1000`` run the
long versions; the default test suite runs short ones. A child works and acknowledges each
thing done through a pipe; it is killed; what it left must be whole, and must hold all that
was acknowledged. (This shows the death of a process, not a power cut.)
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from bozzetto.document.edit import change_state
from bozzetto.document.file import read_document, write_document
from bozzetto.document.model import Document, Model
from bozzetto.document.recovery import RecoveryStore
from bozzetto.errors import UserError
from bozzetto.ink.stroke import Strokes
from tests.document_kit import FakeRegistry, Ink, stroke

SHORTEST, LONGEST = 0.002, 0.030
"""Life of a child after it has begun its work, seconds."""


def killed(work: Callable[[Callable[[], None]], None], rng: random.Random) -> int:
    """Let a child work and kill it; how many things it acknowledged."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            work(lambda: os.write(writing, b"x") and None)
        finally:
            os._exit(1)
    os.close(writing)
    first = os.read(reading, 1)  # it is at work now
    time.sleep(rng.uniform(SHORTEST, LONGEST))
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if not first or not os.WIFSIGNALED(status):
        raise RuntimeError("the child died by itself")
    done = 1
    while more := os.read(reading, 65536):
        done += len(more)
    os.close(reading)
    return done


def saves(count: int, seed: int = 0) -> dict[str, int]:
    """Kill a child that saves without end; nothing may be lost, nor an acknowledged save."""
    rng = random.Random(seed)
    ink = Ink(Strokes([stroke(n, 1000) for n in range(60)]))
    lost = stale = interrupted = generations = 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.bozz")

        def document(generation: int) -> Document:
            return Document((Model("m", f"{generation}", "test.ink", ink),))

        start = 0
        write_document(document(start), path)
        for _ in range(count):

            def work(acknowledge: Callable[[], None], first: int = start) -> None:
                acknowledge()  # the last one's save
                generation = first
                while True:
                    generation += 1
                    write_document(document(generation), path)
                    acknowledge()

            saved = start + killed(work, rng) - 1
            try:
                found, _ = read_document(path, FakeRegistry())
                generation = int(found.models[0].name)
                lost += found.models[0].state != ink
                stale += not saved <= generation <= saved + 1
                for number in (1, 2, 3):
                    backup = path.with_name(f"{path.name}~{number}")
                    lost += backup.exists() and _is_broken(backup)
                generations += generation - start
                start = generation
            except UserError:
                lost += 1
            for left in Path(folder).glob(".bozzetto-*"):
                left.unlink()
                interrupted += 1
    return {
        "kills": count,
        "lost": lost,
        "stale": stale,
        "in the middle of a save": interrupted,
        "saves": generations,
    }


def _is_broken(path: Path) -> bool:
    try:
        read_document(path, FakeRegistry())
    except UserError:
        return True
    return False


def drawing(count: int, seed: int = 0) -> dict[str, int]:
    """Kill a child that draws without end; at most the stroke under way may be lost."""
    rng = random.Random(seed)
    ink = [stroke(n, 200) for n in range(300)]
    lost = wrong = strokes = 0
    for _ in range(count):
        folder = Path(tempfile.mkdtemp())

        def work(acknowledge: Callable[[], None], folder: Path = folder) -> None:
            document = Document((Model("m", "Ink", "test.ink", Ink()),))
            session = RecoveryStore(folder).begin("Drawing", None, document)
            for number, drawn in enumerate(ink):
                # Every third stroke waits as pending ink before it is applied.
                if number % 3 == 0:
                    session.record(document, [drawn])
                    acknowledge()
                state = Ink(document.models[0].state.strokes.extended([drawn]))
                document = change_state(document, "m", state, "Draw").document
                session.record(document)
                if number % 3:
                    acknowledge()
            time.sleep(60)

        acknowledged = killed(work, rng)
        store = RecoveryStore(folder)
        (session,) = store.crashed_sessions()
        recovered = store.recover(session, FakeRegistry())
        found = [*recovered.document.models[0].state.strokes, *recovered.pending]
        lost += max(0, acknowledged - len(found))
        wrong += found != ink[: len(found)] or len(found) > acknowledged + 1
        strokes += acknowledged
        shutil.rmtree(folder)
    return {"kills": count, "lost": lost, "wrong": wrong, "strokes": strokes}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["saves", "drawing"])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    run = saves if options.what == "saves" else drawing
    tally = run(options.count, options.seed)
    print(", ".join(f"{number} {name}" for name, number in tally.items()))
    sys.exit(any(tally.get(name, 0) for name in ("lost", "stale", "wrong")))


if __name__ == "__main__":
    main()
