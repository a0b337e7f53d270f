"""Questions that are remembered one by one, and answered all at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from bozzetto.plugin import Remembered

Asked = TypeVar("Asked")
Answer = TypeVar("Answer")


def each(
    one: Remembered[[Asked], Answer],
    every: Callable[[list[Asked]], list[Answer]],
    asked: Sequence[Asked],
) -> list[Answer]:
    """Ask each question; those that are not remembered are answered all at once.

    Every step takes arrays, and a seam or a fillet has some hundred faces: of many, most of the
    time would go into the calls. The answer to one question must not depend on the others.

    Parameters
    ----------
    one : remembered function
        Of one question.
    every : callable
        The same of several.
    asked : sequence
        The questions.
    """
    found = [one.known(question) for question in asked]
    fresh = [question for question, answer in zip(asked, found, strict=True) if answer is None]
    made = iter(every(fresh) if fresh else [])
    answers = []
    for question, answer in zip(asked, found, strict=True):
        if answer is None:
            answer = next(made)
            one.put(answer, question)
        answers.append(answer)
    return answers
