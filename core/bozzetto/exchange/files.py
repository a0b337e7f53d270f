"""Bytes from files and bytes to files, with the errors told in plain words."""

from __future__ import annotations

import contextlib
import os
import secrets
from pathlib import Path

from bozzetto.errors import FormatError, UserError

__all__ = ["read_bytes", "write_bytes"]


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
        raise UserError(f"“{name}” cannot be read: {error}") from error
    if len(data) > limit:
        raise FormatError(f"“{name}” is larger than the {limit >> 20} MB that can be read.")
    if not data:
        raise FormatError(f"“{name}” is empty.")
    return data


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a whole file, or leave what was there.

    The bytes go to a new file in the same folder, which takes the old one's place when
    they have reached the disk. A symbolic link stays one.

    Raises
    ------
    UserError
        If the folder does not exist or may not be written to, or the disk is full.
    """
    target = Path(os.path.realpath(path))
    beside = target.with_name(f".{target.name[:100]}.{secrets.token_hex(6)}.part")
    try:
        if target.is_dir():
            raise UserError(f"“{target}” is a folder. Add a file name.")
        try:
            with open(beside, "xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.replace(beside, target)
        except BaseException:
            with contextlib.suppress(OSError):
                beside.unlink()
            raise
        _sync_folder(target.parent)
    except FileNotFoundError:
        raise UserError(
            f"There is no folder “{target.parent}”. Create it or choose another."
        ) from None
    except PermissionError:
        raise UserError(
            f"“{target.parent}” may not be written to. Choose another folder."
        ) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise UserError(
            f"“{target}” could not be written ({reason}). What was there before is untouched; "
            "free some space or choose another place."
        ) from error


def _sync_folder(folder: Path) -> None:
    """Make the new name last through a power cut, where the system knows how."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
