"""Answers of pure functions that take long, remembered by the host."""

from __future__ import annotations

import inspect
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import partial, update_wrapper
from typing import Any, Final, Generic, ParamSpec, TypeVar

from bozzetto.plugin.memory_budget import MOST_BYTES, Entry, MemoryBudget
from bozzetto.plugin.memory_size import size_of

Answer = TypeVar("Answer")
Asked = ParamSpec("Asked")

GLANCE: Final = 0.05
"""Seconds after which who waits for another thread's answer wakes up for a moment: a thread that
sleeps cannot be interrupted."""

MEASURED_AGAIN: Final = frozenset({1, 8, 64})
"""Uses at which an answer is measured again: it takes up to a millisecond."""

BY_PLACE: Final = (
    inspect.Parameter.POSITIONAL_ONLY,
    inspect.Parameter.POSITIONAL_OR_KEYWORD,
)

ALL: Final = MemoryBudget(MOST_BYTES)
"""The budget that all caches of the process share."""


def forget_all() -> None:
    """Forget all answers of all functions; what is asked again is worked out again."""
    ALL.forget_all()


def remembered(
    *, limit: int, key: Callable[..., Hashable] | None = None
) -> Callable[[Callable[Asked, Answer]], Remembered[Asked, Answer]]:
    """Let the host remember the last answers of a pure function of a module.

    Parameters
    ----------
    limit : int
        How many answers are kept at most. All functions share one budget of bytes besides, and
        everything is forgotten when documents close.
    key : callable, optional
        Called with the arguments, all of them; returns what the answer depends on, hashable.
        Without it that is the arguments themselves. Give it where arguments are large, cannot be
        hashed, or do not matter, such as a `Job.checkpoint`.

    Examples
    --------
    >>> @remembered(limit=64)
    ... def solid_of(outline: Outline, resolution: int) -> Mesh: ...

    Notes
    -----
    May be called from any thread; who asks what another thread works on waits for its answer. The
    function must not ask itself what it is to answer. What it raises is not remembered.
    """
    return partial(Remembered, limit=limit, key=key)


class Remembered(Generic[Asked, Answer]):
    """A function of which the last answers are remembered; see `remembered`."""

    __wrapped__: Callable[Asked, Answer]

    def __init__(
        self,
        function: Callable[Asked, Answer],
        *,
        limit: int,
        key: Callable[..., Hashable] | None,
    ) -> None:
        update_wrapper(self, function)
        self._key = key
        self._memory: Memory[Answer] = Memory(limit)
        self._signature = inspect.signature(function)
        kinds = [parameter.kind for parameter in self._signature.parameters.values()]
        by_place = all(kind in BY_PLACE for kind in kinds)
        self._count = len(kinds) if by_place else -1

    def __call__(self, *args: Asked.args, **kwargs: Asked.kwargs) -> Answer:
        """Return the remembered answer, or ask the function and remember what it says."""
        question = self._question(args, kwargs)
        return self._memory.recall(question, partial(self.__wrapped__, *args, **kwargs))

    def known(self, *args: Asked.args, **kwargs: Asked.kwargs) -> Answer | None:
        """Return the remembered answer, if there is one."""
        return self._memory.known(self._question(args, kwargs))

    def put(self, answer: Answer, *args: Asked.args, **kwargs: Asked.kwargs) -> None:
        """Remember an answer that was found elsewhere."""
        self._memory.put(self._question(args, kwargs), answer)

    def _question(self, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Hashable:
        """Return what is asked: the same, in whatever way the arguments are written."""
        if kwargs or len(args) != self._count:
            bound = self._signature.bind(*args, **kwargs)
            bound.apply_defaults()
            if self._key is not None:
                return self._key(*bound.args, **bound.kwargs)
            return tuple(bound.arguments.values())
        return args if self._key is None else self._key(*args)


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
        entry = _Remembered(self._remove, question, answer)
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

    __slots__ = ("_remove", "answer", "question", "uses")

    def __init__(
        self,
        remove: Callable[[_Remembered[Answer]], None],
        question: Hashable,
        answer: Answer,
    ) -> None:
        super().__init__(size_of(question, answer))
        self._remove = remove
        self.question = question
        self.answer = answer
        self.uses = 0

    def forget(self) -> None:
        self._remove(self)
