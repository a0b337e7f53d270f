"""Errors of damaged files: one place where what readers raise becomes a sentence."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from bozzetto.errors import FormatError

DAMAGE: Final = (
    ArithmeticError,  # among them OverflowError
    UnicodeError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
)
"""Exceptions of readers, and of the libraries below them, on contents that make no sense."""

TOO_LARGE: Final = (
    "It needs more memory than a file may take. Split it or simplify it in the program that "
    "made it."
)
TOO_DEEP: Final = "It is nested too deeply. Simplify it in the program that made it."
DAMAGED: Final = "It is damaged, or not what its name says. Save it again where it was made."


@contextmanager
def as_format_errors(error: type[FormatError] = FormatError) -> Iterator[None]:
    """Turn what only a file's content can have caused into a sentence.

    Parameters
    ----------
    error : type of FormatError
        What is raised instead; the cause stays attached.

    Raises
    ------
    FormatError
        For a lack of memory, bottomless nesting and the exceptions in `DAMAGE`. Everything
        else passes: it is a defect of ours.
    """
    try:
        yield
    except MemoryError as problem:
        raise error(TOO_LARGE) from problem
    except RecursionError as problem:
        raise error(TOO_DEEP) from problem
    except DAMAGE as problem:
        raise error(DAMAGED) from problem
