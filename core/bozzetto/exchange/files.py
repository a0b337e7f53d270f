"""Bytes from files, with the errors told in plain words."""

from __future__ import annotations

import os

from bozzetto.errors import FormatError, UserError, words_of

__all__ = ["read_bytes"]


def read_bytes(path: str | os.PathLike[str], limit: int) -> bytes:
    """Read a whole file of at most `limit` bytes.

    Raises
    ------
    UserError
        If there is no such file, or it may not be read.
    FormatError
        If it is empty or too large.
    """
    name = os.fspath(path)
    try:
        with open(name, "rb") as file:
            data = file.read(limit + 1)
    except FileNotFoundError:
        raise UserError(f"There is no file “{name}”. Check its name and folder.") from None
    except IsADirectoryError:
        raise UserError(f"“{name}” is a folder. Choose a file inside it.") from None
    except PermissionError:
        if os.path.isdir(name):  # Windows says it this way
            raise UserError(f"“{name}” is a folder. Choose a file inside it.") from None
        raise UserError(f"“{name}” may not be read. Check its permissions.") from None
    except (OSError, ValueError) as error:
        raise UserError(f"“{name}” cannot be read: {words_of(error)}.") from error
    if len(data) > limit:
        raise FormatError(f"“{name}” is larger than the {limit >> 20} MB that can be read.")
    if not data:
        raise FormatError(f"“{name}” is empty.")
    return data
