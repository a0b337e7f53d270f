"""Reading of whole files, with errors in plain words."""

from __future__ import annotations

import os
import stat
from typing import BinaryIO

from bozzetto.atomic_files import open_at_once
from bozzetto.errors import FormatError, UserError, words_of


def file_size(path: str | os.PathLike[str], limit: int) -> int:
    """Return the size of a file that can be read, bytes; raises as `read_bytes`, reads nothing."""
    with _opened(os.fspath(path)) as file:
        return _checked_size(os.fstat(file.fileno()).st_size, os.fspath(path), limit)


def read_bytes(path: str | os.PathLike[str], limit: int) -> bytes:
    """Read a whole file of at most `limit` bytes.

    Raises
    ------
    UserError
        If there is no such file, it may not be read, or it is no file but a device or a pipe.
    FormatError
        If it is empty or too large.
    """
    name = os.fspath(path)
    with _opened(name) as file:
        size = _checked_size(os.fstat(file.fileno()).st_size, name, limit)
        data = _read(file, size, name)  # what it was when it was opened: it may grow meanwhile
    _checked_size(len(data), name, limit)  # it may have been cut, too
    return data


def read_start(path: str | os.PathLike[str], most: int) -> bytes:
    """Read a file's first bytes, all where there are no more than `most`.

    Raises
    ------
    UserError
        As `read_bytes`; an empty file is no error.
    """
    name = os.fspath(path)
    with _opened(name) as file:
        return _read(file, most, name)


def _read(file: BinaryIO, count: int, name: str) -> bytes:
    try:
        return file.read(count)
    except OSError as error:
        raise UserError(f"“{name}” cannot be read: {error.strerror}.") from error


def _checked_size(size: int, name: str, limit: int) -> int:
    if size > limit:
        raise FormatError(f"“{name}” is larger than the {limit >> 20} MB that can be read.")
    if not size:
        raise FormatError(f"“{name}” is empty.")
    return size


def _opened(name: str) -> BinaryIO:
    """Open a file for reading; a pipe or a device is not waited for."""
    try:
        file = open(name, "rb", opener=open_at_once)
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
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise UserError(f"“{name}” is not a file that can be read. Choose another.")
    return file
