"""Killed at any moment: while saving, while drawing, while recovering.

A child works and acknowledges each thing done through a pipe; it is killed (SIGKILL) at a
random moment; what it left must be whole, and must hold all that was acknowledged. This
shows the death of a process, not a power cut.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from bozzetto.document.edit import change_state
from bozzetto.document.model import Document, Model
from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.errors import UserError
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.temporary_files import remove_leftovers
from bozzetto_app.session.drawing_record import BroughtBack, DrawingRecord, Snapshot
from tests.document_kit import FakeRegistry, Ink, stroke
from tests.reliability.figures import Row

COUNT = 1000
"""Kills of each kind in the full suite."""

SHORTEST, LONGEST = 0.002, 0.030
"""Life of a child after it has begun its work, seconds."""

RECOVERING = 0.120
"""The same at most, where it brings a drawing back, seconds."""


def killed(
    work: Callable[[Callable[[], None]], None], rng: random.Random, longest: float = LONGEST
) -> int:
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
    time.sleep(rng.uniform(SHORTEST, longest))
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
            interrupted += remove_leftovers([Path(folder)])
            lost += any(Path(folder).glob(".bozzetto-*"))
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


def recovering(count: int, seed: int = 0) -> dict[str, int]:
    """Kill a child that brings a drawing back without end, and draws a stroke each time.

    Between old and new recovery data there must always be some that hold everything.
    """
    rng = random.Random(seed)
    lost = wrong = twice = strokes = brought_back = 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        start = Snapshot("Drawing", None, None, _with_strokes(0))
        first = DrawingRecord(RecoveryStore(folder))
        first.write(start)
        first.set_aside()
        for _ in range(count):

            def work(acknowledge: Callable[[], None], strokes: int = strokes) -> None:
                acknowledge()  # what is there already
                while True:
                    store = RecoveryStore(folder)
                    store.tidy()
                    found = _most(store)
                    number, back = found
                    record = DrawingRecord(store, back)
                    drawn = _with_strokes(number + 1)
                    record.write(Snapshot("Drawing", None, None, drawn))
                    acknowledge()
                    record.set_aside()

            acknowledged = strokes + killed(work, rng, RECOVERING) - 1
            store = RecoveryStore(folder)
            store.tidy()
            offered = store.crashed_sessions()
            twice += len(offered) > 1
            if not offered:
                return {"kills": count, "lost": strokes, "wrong": wrong}
            kept = []
            for session in offered:
                recovered = store.recover(session, FakeRegistry())
                kept.append(len(recovered.document.models[0].state.strokes))
                wrong += not recovered.is_whole
                wrong += recovered.document.models[0].state != _state(kept[-1])
                store.keep(session)
            lost += max(0, acknowledged - max(kept))
            wrong += max(kept) > acknowledged + 1
            brought_back += max(kept) - strokes
            strokes = max(kept)
            best = kept.index(strokes)
            for place_of, session in enumerate(offered):  # as a person does with a double
                if place_of != best:
                    store.discard(session)
            if strokes > 200:
                record = DrawingRecord(store)
                record.write(start)
                record.set_aside()
                store.discard(offered[best])
                strokes = 0
    return {
        "kills": count,
        "lost": lost,
        "wrong": wrong,
        "recoveries": brought_back,
        "between old and new data": twice,
    }


_INK: list[Stroke] = []


def _state(count: int) -> Ink:
    while len(_INK) < count:
        _INK.append(stroke(len(_INK), 200))
    return Ink(Strokes(_INK[:count]))


def _with_strokes(count: int) -> Document:
    return Document((Model("m", "Ink", "test.ink", _state(count)),))


def _most(store: RecoveryStore) -> tuple[int, BroughtBack]:
    """Bring the drawing back; of two, the one with more in it."""
    found = []
    for session in store.crashed_sessions():
        recovered = store.recover(session, FakeRegistry())
        count = len(recovered.document.models[0].state.strokes)
        found.append((count, BroughtBack(session, recovered.is_whole)))
        store.keep(session)
    count, back = max(found, key=lambda one: one[0])
    store.recover(back.session, FakeRegistry())
    return count, back


def rows(share: float) -> Iterator[Row]:
    """Do a share of the kills; one row for each kind."""
    count = max(1, round(COUNT * share))
    for what, run, bad in (
        ("while saving", saves, ("lost", "stale")),
        ("while drawing", drawing, ("lost", "wrong")),
        ("while recovering", recovering, ("lost", "wrong")),
    ):
        tally = run(count)
        said = ", ".join(f"{number} {name}" for name, number in tally.items() if name != "kills")
        kept = not any(tally[name] for name in bad)
        yield Row(f"{count:,} kills {what}", said, f"0 {bad[0]}, 0 {bad[1]}", kept)
