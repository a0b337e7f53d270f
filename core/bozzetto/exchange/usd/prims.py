"""The text of USD: prims with their properties, names and numbers.

The syntax is that of the text file format of OpenUSD (``.usda``, "usda 1.0"): arrays in brackets,
tuples in parentheses, matrices by rows that multiply from the right.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

PLACES: Final = "%.9g"
"""Single precision with all its digits."""

DIRECTIONS: Final = "%.6g"

FULL: Final = "%.15g"
"""Double precision, without the noise of its last digit."""


@dataclass
class Prim:
    """A thing of a scene: its type, its name among those beside it, and what is in it.

    Parameters
    ----------
    type : str
        Such as "Mesh".
    name : str
        An identifier; see `Names`.
    title : str
        The name for people; said where it is another one.
    schemas : tuple of str
        Those that are applied, besides that of its type.
    """

    type: str
    name: str
    title: str = ""
    schemas: tuple[str, ...] = ()
    lines: list[str] = field(default_factory=list)
    children: list[Prim] = field(default_factory=list)

    def put(self, declared: str, value: str) -> None:
        """Add a property, such as ``uniform token orientation``, with its value as text."""
        self.lines.append(f"{declared} = {value}")

    def text(self, indent: str = "") -> str:
        """Return the prim and all that is in it as text."""
        head = f'{indent}def {self.type} "{self.name}"'
        said = []
        if self.schemas:
            said.append(f"prepend apiSchemas = {tokens(self.schemas)}")
        if self.title and self.title != self.name:
            said.append(f"displayName = {quoted(self.title)}")
        if said:
            head += " (\n" + "".join(f"{indent}    {line}\n" for line in said) + f"{indent})"
        inner = "".join(f"{indent}    {line}\n" for line in self.lines)
        inner += "".join(child.text(indent + "    ") for child in self.children)
        return f"{head}\n{indent}{{\n{inner}{indent}}}\n"


class Names:
    """Identifiers of things that are beside one another: no two of them are the same.

    They are letters without accents, digits and underscores, as programs before OpenUSD 24.03
    demand it.
    """

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def new(self, name: str, otherwise: str = "part") -> str:
        """Return a new identifier that is as near to a name as it can be."""
        plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
        plain = re.sub(r"[^A-Za-z0-9_]+", "_", plain.strip())
        if not plain.strip("_"):
            plain = otherwise
        if plain[0].isdigit():
            plain = f"_{plain}"
        found, number = plain, 1
        while found in self._taken:
            number += 1
            found = f"{plain}_{number}"
        self._taken.add(found)
        return found


def quoted(text: str) -> str:
    """Return a string or a token as USD writes it."""
    plain = "".join(letter if letter.isprintable() else " " for letter in text)
    return '"' + plain.replace("\\", "\\\\").replace('"', '\\"') + '"'


def tokens(words: Sequence[str]) -> str:
    """Return an array of tokens."""
    return "[" + ", ".join(map(quoted, words)) + "]"


def numbers(values: NDArray[Any], form: str = "%d") -> str:
    """Return an array of numbers, (n,)."""
    return "[" + ", ".join([form] * len(values)) % tuple(values.tolist()) + "]"


def tuples(rows: NDArray[Any], form: str) -> str:
    """Return an array of tuples, (n, k)."""
    one = "(" + ", ".join([form] * rows.shape[1]) + ")"
    return "[" + ", ".join([one] * len(rows)) % tuple(rows.ravel().tolist()) + "]"


def matrices(columns: NDArray[np.float64]) -> str:
    """Return an array of matrices, (n, 4, 4), which multiply columns from the left."""
    line = "(" + ", ".join([FULL] * 4) + ")"
    one = "(" + ", ".join([line] * 4) + ")"
    rows = columns.transpose(0, 2, 1) + 0.0
    return "[" + ", ".join([one] * len(rows)) % tuple(rows.ravel().tolist()) + "]"


def samples(times: NDArray[np.float64], values: Sequence[str]) -> str:
    """Return values at times, in frames."""
    rows = ", ".join(f"{FULL % time}: {value}" for time, value in zip(times, values, strict=True))
    return f"{{{rows}}}"
