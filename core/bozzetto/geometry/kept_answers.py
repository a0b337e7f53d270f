"""Answers that follow from a frozen value alone, kept with it for as long as it lives.

Shapes that are changed step by step share most of their surfaces and edges from one step to the
next. What was found of these is not worked out again, and goes when they go.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Any, Final, TypeVar

Answer = TypeVar("Answer")

MOST: Final = 12
"""Answers that are kept with one value; those that were used least recently go first."""

_LOCK: Final = Lock()


def kept(value: object, question: Hashable, answer: Callable[[], Answer]) -> Answer:
    """Return the answer to a question on a frozen value, worked out once.

    Parameters
    ----------
    value : object
        An instance of a frozen dataclass without slots.
    question : hashable
        All that the answer depends on besides.
    answer : callable
        Works it out; what it returns must not be changed by anybody.
    """
    with _LOCK:
        known: OrderedDict[Hashable, Any] = vars(value).setdefault("_kept", OrderedDict())
        if question in known:
            known.move_to_end(question)
            return known[question]  # type: ignore[no-any-return]
    made = answer()
    with _LOCK:
        known[question] = made
        while len(known) > MOST:
            known.popitem(last=False)
    return made
