"""Work that is stopped when nobody waits for it any more."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from bozzetto.errors import Cancelled, UserError
from bozzetto.plugin.job import Job
from bozzetto.plugin.overrides import overrides
from bozzetto.testing.deep_equal import same
from bozzetto.testing.machine_speed import slowness
from bozzetto.testing.subject import Subject, ensure

if TYPE_CHECKING:
    from bozzetto.testing.headless_shell import Shell

LOOKS: Final = (1, 2, 5)
"""Looks at the job after which the work is stopped."""

LONGEST_UNSEEN: Final = 1.0
"""Processor time that work may take between two looks at its job on a usual machine, s."""

TRIES: Final = 3
"""How often work that took too long between two looks is watched: other programs on the machine
make it seem longer, never shorter."""


class Watch:
    """Whether work looks at its job often enough.

    Attributes
    ----------
    longest : float
        Processor time of this thread between two looks, the beginning or the end, s.
    """

    def __init__(self) -> None:
        self.longest = 0.0
        self._last = time.thread_time()

    def look(self) -> bool:
        """Note a look; the work is not cancelled."""
        now = time.thread_time()
        self.longest = max(self.longest, now - self._last)
        self._last = now
        return False


def stop_at(look: int, name: str, work: Callable[[Job], Any]) -> None:
    """Do work that is cancelled at its n-th look at the job, and check that it ends there.

    Parameters
    ----------
    look : int
        At which look it is cancelled, counted from 1.
    name : str
        Of the work, for messages.
    work : callable
        Gets the job.

    Raises
    ------
    Broken
        If it went on.
    """
    looks = 0

    def cancelled() -> bool:
        nonlocal looks
        looks += 1
        return looks >= look

    try:
        work(Job(cancelled=cancelled))
    except Cancelled:
        return
    ensure(looks < look, f"{name} went on although job.checkpoint raised Cancelled")


def check_stopping(subject: Subject) -> None:
    """Check that reports, drawings being read and advice can be stopped, and are whole later.

    What takes long looks at its job meanwhile.
    """
    with subject.drawn() as shell:
        modeler = shell.registry.modeler(subject.modeler)
        for name, ask in _questions(shell):
            if not overrides(modeler, name):
                continue
            try:
                for look in LOOKS:
                    stop_at(look, name, ask)
                again = ask(Job())
                whole, unseen = _watched(subject, name)
                for _ in range(TRIES - 1):
                    if unseen >= LONGEST_UNSEEN:
                        unseen = min(unseen, _watched(subject, name)[1])
            except UserError:
                continue  # what may be refused, and how, is for other articles
            ensure(
                unseen < LONGEST_UNSEEN,
                f"{name} works for {unseen:.1f} s without a look at its job; call "
                "job.checkpoint in its loops",
            )
            ensure(same(again, whole), f"{name} that was cancelled is another one when asked again")


def _watched(subject: Subject, name: str) -> tuple[Any, float]:
    """Return an answer to a question that nobody asked before, and its longest time unseen.

    The time is that of a usual machine, s.
    """
    with subject.drawn() as shell:
        ask = dict(_questions(shell))[name]
        watch = Watch()
        whole = ask(Job(cancelled=watch.look))
        watch.look()
    return whole, watch.longest / slowness()


def _questions(shell: Shell) -> tuple[tuple[str, Callable[[Job], Any]], ...]:
    """Return what is asked with a job besides a solve, by the names of the contract."""
    bench, model, camera = shell.workbench, shell.model, shell.camera
    result = shell.solve()
    guarded = bench.guarded(model)

    def read(job: Job) -> Any:
        drawing = bench.readings.drawing_of([model])
        return guarded.read_drawing(drawing, shell.context(), job)

    return (
        ("report", lambda job: guarded.report(model.state, result, job)),
        ("read_drawing", read),
        ("view_advice", lambda job: guarded.view_advice(model.state, camera, job)),
    )
