"""The two ways in which something can go wrong: the person's, or ours."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["Cancelled", "DocumentError", "FormatError", "Unfinished", "UserError"]


class UserError(Exception):
    """A mistake that a person can mend; the message says what to do next.

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
