"""A memory for pure functions whose answers are dear."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

__all__ = ["Memory"]

Answer = TypeVar("Answer")


class Memory(Generic[Answer]):
    """The last `limit` answers by their question; usable from any thread."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._answers: OrderedDict[Hashable, Answer] = OrderedDict()
        self._lock = threading.Lock()

    def recall(self, question: Hashable, work: Callable[[], Answer]) -> Answer:
        """The remembered answer, or the one that `work` gives now."""
        with self._lock:
            if question in self._answers:
                self._answers.move_to_end(question)
                return self._answers[question]
        answer = work()
        self.put(question, answer)
        return answer

    def known(self, question: Hashable) -> Answer | None:
        """The remembered answer, if there is one."""
        with self._lock:
            return self._answers.get(question)

    def put(self, question: Hashable, answer: Answer) -> None:
        """Remember an answer that was found elsewhere."""
        with self._lock:
            self._answers[question] = answer
            self._answers.move_to_end(question)
            while len(self._answers) > self._limit:
                self._answers.popitem(last=False)
