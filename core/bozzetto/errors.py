"""The two ways in which something can go wrong: the person's, or ours."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

__all__ = [
    "Cancelled",
    "DocumentError",
    "FormatError",
    "Unfinished",
    "UserError",
    "message_of",
    "words_of",
]

OBJECT: Final = re.compile(
    r"<(?:[^<>]|<[^<>]*>)*?\bat 0x[0-9a-fA-F]+(?:[^<>]|<[^<>]*>)*>|\b0x[0-9a-fA-F]{6,}\b"
)
"""An object as Python shows it, with its address: it means nothing to a person."""

LONGEST: Final = 300
"""Characters of another library's message that are passed on."""


class UserError(Exception):
    """A mistake that a person can correct; the message says what to do next.

    Parameters
    ----------
    message : str
        One sentence or two: what happened and what to do instead.
    places : sequence of (x, y), optional
        Where it happened, in canvas pixels of the stroke concerned; the shell
        lights these places on the sheet.
    """

    def __init__(self, message: str, *, places: Sequence[tuple[float, float]] = ()) -> None:
        super().__init__(message)
        self.message = message
        self.places = tuple((float(x), float(y)) for x, y in places)


class FormatError(UserError):
    """A file that is not what it claims to be: refused, and never half-read."""


class DocumentError(FormatError):
    """A ``.bozz`` file that cannot be trusted or understood."""


class Unfinished(Exception):
    """A gesture that is good so far and needs more strokes.

    The host keeps the strokes as pending ink and shows the hint.

    Parameters
    ----------
    hint : str
        What to do next, in plain words.
    """

    def __init__(self, hint: str) -> None:
        super().__init__(hint)
        self.hint = hint


class Cancelled(Exception):
    """Raised by `Job.checkpoint` when nobody wants the answer any more."""


def words_of(problem: BaseException) -> str:
    """Return the message of an exception for the middle of a sentence, on one line.

    Whatever another library raised goes through here on its way into a message. The addresses
    of objects go, and so does the full stop; who says nothing is told by the kind of fault.
    """
    if isinstance(problem, MemoryError):
        return "there is not enough memory"
    if isinstance(problem, RecursionError):
        return "it is nested too deeply"
    if isinstance(problem, OSError) and problem.strerror:
        return problem.strerror
    return message_of(problem) or f"an error of the kind {type(problem).__name__}"


def message_of(problem: BaseException) -> str:
    """Return the message of an exception, or "", for a person who is told its kind, too."""
    try:
        said = str(problem)
    except Exception:  # its own __str__ may be a plugin's, and fail
        said = ""
    said = " ".join(OBJECT.sub("the data", said).split())
    if len(said) > LONGEST:
        said = f"{said[: LONGEST - 1]}…"
    return said.rstrip(".")
