"""The clear text of STEP files (ISO 10303-21): instances, numbers and strings."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

EPOCH: Final = "1980-01-01T00:00:00"
"""Time stamp of every file, so that equal shapes give equal files."""

PLAIN: Final = re.compile(r"[^\x20-\x7e]+")
"""Characters that the clear text cannot hold as they are."""

ENDING: Final = re.compile("'(?= *[,)])")
"""Apostrophes at which OpenCASCADE believes a string to end, even where they are doubled."""

APOSTROPHE: Final = "\\X2\\0027\\X0\\"
"""Escape sequence of an apostrophe."""


class Part21:
    """An exchange file in the making."""

    def __init__(self) -> None:
        self._lines: list[str] = []

    def add(self, record: str) -> str:
        """Add an instance; what comes back refers to it, like ``#7``."""
        self._lines.append(f"#{len(self._lines) + 1}={record};\n")
        return f"#{len(self._lines)}"

    def encoded(self, schema: str, title: str) -> bytes:
        """Return the whole file.

        Parameters
        ----------
        schema : str
            The application protocol's schema with its object identifier.
        title : str
            Name of the file in its header.
        """
        program = string("Bozzetto")
        return (
            "ISO-10303-21;\nHEADER;\n"
            f"FILE_DESCRIPTION(({string(title)}),'2;1');\n"
            f"FILE_NAME({string(title)},'{EPOCH}',(''),(''),{program},{program},'');\n"
            f"FILE_SCHEMA(({string(schema)}));\nENDSEC;\nDATA;\n"
            + "".join(self._lines)
            + "ENDSEC;\nEND-ISO-10303-21;\n"
        ).encode("ascii")


def real(value: float) -> str:
    """Write a number with all its digits (17 where it takes so many), and the dot that reals need.

    Parameters
    ----------
    value : float
        Finite.
    """
    digits, sign, power = repr(float(value) + 0.0).partition("e")  # -0.0 becomes 0.0
    return (digits.removesuffix("0") if digits.endswith(".0") else digits) + (
        ("" if "." in digits else ".") + f"E{int(power)}" if sign else ""
    )


def string(text: str) -> str:
    """Write a string literal; characters beyond ASCII by their code points (6.4.3.3)."""
    text = ENDING.sub(lambda _: APOSTROPHE, text.replace("\\", "\\\\")).replace("'", "''")
    return f"'{PLAIN.sub(_code_points, text)}'"


def _code_points(match: re.Match[str]) -> str:
    """Write a run of characters, those of the first plane in 16 bits, others in 32."""
    pieces = []
    for run in re.findall("[\x00-\uffff]+|[^\x00-\uffff]+", match[0]):
        wide = run[0] > "\uffff"
        encoded = run.encode("utf-32-be" if wide else "utf-16-be", "replace")
        pieces.append(f"\\X{4 if wide else 2}\\{encoded.hex().upper()}\\X0\\")
    return "".join(pieces)


def many(values: Iterable[str]) -> str:
    """Write a list."""
    return f"({','.join(values)})"
