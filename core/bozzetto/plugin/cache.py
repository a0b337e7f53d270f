"""Caches for pure functions that take long."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Final, Generic, TypeVar

from bozzetto.plugin.memory_budget import MOST_BYTES, Entry, MemoryBudget
from bozzetto.plugin.memory_size import size_of

Answer = TypeVar("Answer")

GLANCE: Final = 0.05
"""Seconds after which who waits for another thread's answer wakes up for a moment: a thread that
sleeps cannot be interrupted."""

MEASURED_AGAIN: Final = frozenset({1, 8, 64})
"""Uses at which an answer is measured again: it takes up to a millisecond."""

ALL: Final = MemoryBudget(MOST_BYTES)
"""The budget that all caches of the process share."""


def forget_all() -> None:
    """Forget all answers of all memories; what is asked again is worked out again."""
    ALL.forget_all()


class Memory(Generic[Answer]):
    """The last answers by their question; usable from any thread.

    All memories of a process share one budget of bytes. Where it is exceeded, the answers that
    were used least recently go first, whichever memory they are in.

    Parameters
    ----------
    limit : int
        How many are kept at most.
    budget : MemoryBudget, optional
        Instead of the common one.
    """

    def __init__(self, limit: int, budget: MemoryBudget = ALL) -> None:
        self._limit = limit
        self._budget = budget
        self._answers: OrderedDict[Hashable, _Remembered[Answer]] = OrderedDict()
        self._under_way: dict[Hashable, _Work] = {}
        self._lock = threading.Lock()

    def recall(self, question: Hashable, work: Callable[[], Answer]) -> Answer:
        """Return the remembered answer, or compute and remember it.

        Who asks while another thread works on the same question waits for its answer: to work
        on it twice at a time would take both twice as long.

        Raises
        ------
        RuntimeError
            If `work` asks the question that it is to answer: it would wait for itself.
        """
        while True:
            with self._lock:
                known = self._answers.get(question)
                if known is not None:
                    self._answers.move_to_end(question)
                    break
                other = self._under_way.get(question)
                if other is None:
                    mine = self._under_way[question] = _Work()
                    break
            if other.thread == threading.get_ident():
                raise RuntimeError(f"the answer to {question!r:.200} asks for itself")
            other.done.wait(GLANCE)
        if known is not None:
            self._used(known)
            return known.answer
        try:
            answer = work()
            self.put(question, answer)
            return answer
        finally:
            with self._lock:
                del self._under_way[question]
            mine.done.set()

    def known(self, question: Hashable) -> Answer | None:
        """Return the remembered answer, if there is one."""
        with self._lock:
            known = self._answers.get(question)
        return None if known is None else known.answer

    def put(self, question: Hashable, answer: Answer) -> None:
        """Remember an answer that was found elsewhere."""
        entry = _Remembered(self, question, answer)
        gone: list[_Remembered[Answer]] = []
        with self._lock:
            if question in self._answers:
                gone.append(self._answers.pop(question))
            self._answers[question] = entry
            while len(self._answers) > self._limit:
                gone.append(self._answers.popitem(last=False)[1])
        self._budget.drop(gone)
        self._budget.keep(entry)

    def _remove(self, entry: _Remembered[Answer]) -> None:
        """Forget an answer that the budget has no room for."""
        with self._lock:
            if self._answers.get(entry.question) is entry:
                del self._answers[entry.question]

    def _used(self, entry: _Remembered[Answer]) -> None:
        """Tell that an answer was used, and measure it again now and then.

        Answers grow: many work out their properties when they are first asked for, which is
        mostly at one of the first uses.
        """
        self._budget.use(entry)
        entry.uses += 1
        if entry.uses in MEASURED_AGAIN:
            self._budget.resize(entry, size_of(entry.question, entry.answer))


class _Work:
    """An answer that is being worked out, and by which thread."""

    def __init__(self) -> None:
        self.thread = threading.get_ident()
        self.done = threading.Event()


class _Remembered(Entry, Generic[Answer]):
    """An answer with its question."""

    __slots__ = ("_memory", "answer", "question", "uses")

    def __init__(self, memory: Memory[Answer], question: Hashable, answer: Answer) -> None:
        super().__init__(size_of(question, answer))
        self._memory = memory
        self.question = question
        self.answer = answer
        self.uses = 0

    def forget(self) -> None:
        self._memory._remove(self)
