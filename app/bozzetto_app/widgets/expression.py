"""Sums in number fields: ``120/2+5`` and ``1/2 in`` are read by a parser of our own, exactly."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import Final

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr

__all__ = ["compute"]

LONGEST = 120
"""Longest sum accepted, characters: keeps exact fractions small."""

DEEPEST = 20
"""Deepest nesting of brackets and signs."""

_INCH: Final = Fraction("25.4")
_RADIAN: Final = Fraction(180.0 / math.pi)

UNITS: Final[tuple[dict[str, Fraction], ...]] = (
    {
        "µm": Fraction(1, 1000), "μm": Fraction(1, 1000), "um": Fraction(1, 1000),
        "mm": Fraction(1), "cm": Fraction(10), "dm": Fraction(100), "m": Fraction(1000),
        "in": _INCH, "inch": _INCH, "″": _INCH, '"': _INCH, "”": _INCH,
        "ft": 12 * _INCH, "feet": 12 * _INCH, "′": 12 * _INCH, "'": 12 * _INCH, "’": 12 * _INCH,
        "yd": 36 * _INCH, "mil": _INCH / 1000, "thou": _INCH / 1000,
    },
    {"°": Fraction(1), "deg": Fraction(1), "rad": _RADIAN},
    {"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60)},
)  # fmt: skip
"""Units that may be typed for one another; each row in its first common measure."""

_NUMBER: Final = (
    r"\d{1,3}(?:[ \u00a0\u2009\u202f'’]\d{3})+(?:[.,]\d*)?(?!\d)"  # parted by spaces or apostrophes
    r"|\d+(?:[.,]\d+)*[.,]?|[.,]\d+"
)
_TOKEN = re.compile(rf"\s*(?:({_NUMBER})|([-+*/()])|([^\W\d_]+|[°″\"”′'’]))")
_SAME = str.maketrans(
    {"×": "*", "·": "*", "÷": "/", ":": "/", "−": "-", "–": "-", "٫": ".", "٬": ","}
    # What is typed on a Japanese or Chinese keyboard is as wide as their letters.
    | {chr(wide): chr(wide - 0xFEE0) for wide in range(0xFF01, 0xFF5F)}
    | {"\u3000": " "}
)
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(,\d{3})+|[1-9]\d{0,2}(\.\d{3}){2,}")


def compute(text: str, unit: str = "", *, comma_parts: bool = False) -> Fraction:
    """Return the value of a sum of numbers with ``+ - * / ( )``, which may have units.

    A comma may stand for the decimal point; the signs × · ÷ : − and wide digits are understood.

    Parameters
    ----------
    text : str
        What was typed.
    unit : str
        Of the answer and of what has none. A unit belongs to the product before it, so that
        ``1/2 in`` is half an inch.
    comma_parts : bool
        Whether ``4,261`` is four thousand here. What is plain from the signs themselves
        (``4,261.5``, ``4.261,5``, ``4 261``) is read in any case.

    Raises
    ------
    UserError
        If the text is not such a sum, or divides by zero; the message says where.
    """
    if len(text) > LONGEST:
        raise UserError(tr("Arithmetic", "That sum is too long to be read."))
    reader = _Reader(_tokens(text.translate(_SAME)), unit, comma_parts=comma_parts)
    value = reader.sum(0)
    if reader.here is not None:
        raise _unexpected(reader.here)
    return value


def _decimal(numeral: str, *, comma_parts: bool) -> Fraction:
    """Return the value of a numeral; its last sign is the decimal one unless it parts thousands."""
    plain = re.sub(r"[ \u00a0\u2009\u202f'’]", "", numeral)
    first = _THOUSANDS.fullmatch(plain)
    if first and (comma_parts or plain.count(",") != 1):
        return Fraction(re.sub("[.,]", "", plain))
    whole, sign, digits = plain.rpartition(max(".,", key=plain.rfind))
    other = "," if sign == "." else "."
    if other in whole and re.fullmatch(rf"[1-9]\d{{0,2}}(\{other}\d{{3}})+", whole):
        whole = whole.replace(other, "")
    if not sign:
        return Fraction(plain)
    if not (whole + digits).isdecimal():
        raise _unexpected(numeral)
    return Fraction(f"{whole or 0}.{digits or 0}")


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
        found.append(match[1] or match[2] or match[3])
        place = match.end()
    return found


class _Reader:
    """Recursive descent: a sum is made of products, a product of signed numbers."""

    def __init__(self, tokens: list[str], unit: str, *, comma_parts: bool) -> None:
        self._tokens = tokens
        self._place = 0
        self._unit = unit
        self._comma_parts = comma_parts

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
        measure = self._measure()
        while self.here in ("*", "/"):
            times = self._next() == "*"
            factor = self._number(depth)
            if times:
                value *= factor
            elif factor == 0:
                raise UserError(tr("Arithmetic", "The sum divides by zero."))
            else:
                value /= factor
            another = self._measure()
            if measure is not None and another is not None:
                raise UserError(
                    tr("Arithmetic", "Only one number of a product or quotient can have a unit.")
                )
            measure = another if measure is None else measure
        return value if measure is None else value * measure

    def _measure(self) -> Fraction | None:
        """Take a unit, if there is one here, and return how many of the answer's unit it is."""
        name = self.here
        if name is None or name[0].isdecimal() or name[0] in ".,+-*/()":
            return None
        self._next()
        if name == self._unit:
            return Fraction(1)
        row = next((row for row in UNITS if self._unit in row), {})
        if name not in row:
            raise UserError(tr("Arithmetic", "“{token}” is no unit of this number.", token=name))
        return row[name] / row[self._unit]

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
        if token is None or not (token[0].isdecimal() or token[0] in ".,"):
            raise _unexpected(token)
        return _decimal(token, comma_parts=self._comma_parts)
