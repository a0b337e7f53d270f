"""Entries of packages that strangers made."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.limits import at_most


@contextmanager
def unpacking() -> Iterator[None]:
    """Turn what the library raises at packages that are locked or packed oddly into a sentence."""
    try:
        yield
    except (RuntimeError, ValueError, OSError) as error:  # locked, or packed in an unknown way
        raise FormatError(f"It cannot be unpacked: {words_of(error)}. Save it again.") from error


def unpacked(zipped: zipfile.ZipFile, name: str, most: int, what: str) -> bytes:
    """Return the content of an entry, if it has no more than so many bytes.

    Parameters
    ----------
    zipped : ZipFile
        The package.
    name : str
        Of the entry.
    most : int
        Bytes, unpacked.
    what : str
        Of what, for the message.

    Raises
    ------
    FormatError
    """
    at_most(zipped.getinfo(name).file_size, most, f"bytes in {what}")
    with unpacking():
        return zipped.read(name)
