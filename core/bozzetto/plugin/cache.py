"""A memory for pure functions whose answers are dear."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Final, Generic, TypeVar

__all__ = ["Memory"]

Answer = TypeVar("Answer")

GLANCE: Final = 0.05
"""Seconds after which who waits for another thread's answer wakes up for a moment: a thread that
sleeps cannot be interrupted."""


class Memory(Generic[Answer]):
    """The last answers by their question; usable from any thread.

    Parameters
    ----------
    limit : int
        How many are kept at most.
    weight : callable, optional
        What an answer takes, bytes.
    most : int
        What all of them may take together.
    """

    def __init__(
        self, limit: int, weight: Callable[[Answer], int] | None = None, most: int = 0
    ) -> None:
        self._limit = limit
        self._weight = weight or (lambda answer: 0)
        self._most = most
        self._held = 0
        self._answers: OrderedDict[Hashable, Answer] = OrderedDict()
        self._under_way: dict[Hashable, threading.Event] = {}
        self._lock = threading.Lock()

    def recall(self, question: Hashable, work: Callable[[], Answer]) -> Answer:
        """The remembered answer, or the one that `work` gives now.

        Who asks while another thread works on the same question waits for its answer: to work
        on it twice at a time would take both twice as long.
        """
        while True:
            with self._lock:
                if question in self._answers:
                    self._answers.move_to_end(question)
                    return self._answers[question]
                other = self._under_way.get(question)
                if other is None:
                    mine = self._under_way[question] = threading.Event()
                    break
            other.wait(GLANCE)
        try:
            answer = work()
            self.put(question, answer)
            return answer
        finally:
            with self._lock:
                del self._under_way[question]
            mine.set()

    def known(self, question: Hashable) -> Answer | None:
        """The remembered answer, if there is one."""
        with self._lock:
            return self._answers.get(question)

    def put(self, question: Hashable, answer: Answer) -> None:
        """Remember an answer that was found elsewhere."""
        with self._lock:
            if question in self._answers:
                self._held -= self._weight(self._answers.pop(question))
            self._answers[question] = answer
            self._held += self._weight(answer)
            while len(self._answers) > self._limit or self._held > self._most:
                _, forgotten = self._answers.popitem(last=False)
                self._held -= self._weight(forgotten)
