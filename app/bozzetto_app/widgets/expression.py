"""Sums in number fields: ``120/2+5`` is read by a parser of our own, exactly."""

from __future__ import annotations

import re
from fractions import Fraction

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr

__all__ = ["compute"]

LONGEST = 120
"""Longest sum accepted, characters: keeps exact fractions small."""

DEEPEST = 20
"""Deepest nesting of brackets and signs."""

_TOKEN = re.compile(r"\s*(?:(\d+(?:[.,]\d*)?|[.,]\d+)|([-+*/()]))")
_SAME = str.maketrans({"×": "*", "·": "*", "÷": "/", ":": "/", "−": "-", "–": "-"})


def compute(text: str) -> Fraction:
    """Return the value of a sum of decimal numbers with ``+ - * / ( )``.

    A comma may stand for the decimal point; the signs × · ÷ : − are understood.

    Raises
    ------
    UserError
        If the text is not such a sum, or divides by zero; the message says where.
    """
    if len(text) > LONGEST:
        raise UserError(tr("Arithmetic", "That sum is too long to be read."))
    reader = _Reader(_tokens(text.translate(_SAME)))
    value = reader.sum(0)
    if reader.here is not None:
        raise _unexpected(reader.here)
    return value


def _unexpected(token: str | None) -> UserError:
    if token is None:
        return UserError(tr("Arithmetic", "The sum ends too early; a number is missing."))
    return UserError(tr("Arithmetic", "“{token}” is not expected here.", token=token))


def _tokens(text: str) -> list[str]:
    found, place = [], 0
    text = text.rstrip()
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise _unexpected(text[place:].strip()[:1])
        found.append(match[1] or match[2])
        place = match.end()
    return found


class _Reader:
    """Recursive descent: a sum is made of products, a product of signed numbers."""

    def __init__(self, tokens: list[str]) -> None:
        self._tokens = tokens
        self._place = 0

    @property
    def here(self) -> str | None:
        return self._tokens[self._place] if self._place < len(self._tokens) else None

    def _next(self) -> str | None:
        token = self.here
        self._place += 1
        return token

    def sum(self, depth: int) -> Fraction:
        value = self._product(depth)
        while self.here in ("+", "-"):
            value += self._product(depth) if self._next() == "+" else -self._product(depth)
        return value

    def _product(self, depth: int) -> Fraction:
        value = self._number(depth)
        while self.here in ("*", "/"):
            times = self._next() == "*"
            factor = self._number(depth)
            if times:
                value *= factor
            elif factor == 0:
                raise UserError(tr("Arithmetic", "The sum divides by zero."))
            else:
                value /= factor
        return value

    def _number(self, depth: int) -> Fraction:
        if depth > DEEPEST:
            raise UserError(tr("Arithmetic", "The sum has too many brackets."))
        token = self._next()
        if token in ("+", "-"):
            value = self._number(depth + 1)
            return -value if token == "-" else value
        if token == "(":
            value = self.sum(depth + 1)
            if self._next() != ")":
                raise UserError(tr("Arithmetic", "A bracket is not closed."))
            return value
        if token is None or not (token[0].isdigit() or token[0] in ".,"):
            raise _unexpected(token)
        return Fraction(token.replace(",", "."))
