"""The pictures that a drawing's file names: they lie beside it, or in folders below."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Final

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import at_most
from bozzetto.images.stored_picture import Picture

MOST_PICTURES: Final = 64
"""Pictures of one drawing: nobody sketches one thing from more sides."""


def pictures_named_in(
    facts: Mapping[str, Any], folder: Path, read: Callable[[Path], Picture]
) -> dict[str, Picture]:
    """Read the pictures that a drawing's facts name.

    Parameters
    ----------
    facts : mapping
        ``"image": {"file": "a.png"}``, at the top and in each entry of ``"views"``; what is
        of another form is for the modeler to judge.
    folder : Path
        Where the drawing's file lies.
    read : callable
        Reads one of them.

    Returns
    -------
    dict of str to Picture
        By the names as they stand in the facts.

    Raises
    ------
    UserError
        If one is missing; names it.
    FormatError
        If a name leads out of the folder, a file is no picture, or there are too many.
    """
    names = dict.fromkeys(_names(facts))
    at_most(len(names), MOST_PICTURES, "pictures")
    return {name: read(_place(name, folder)) for name in names}


def _names(facts: Mapping[str, Any]) -> Iterator[str]:
    views = facts.get("views")
    for holder in (facts, *(views if isinstance(views, list) else ())):
        image = holder.get("image") if isinstance(holder, Mapping) else None
        if isinstance(image, Mapping) and "file" in image:
            if not isinstance(image["file"], str):
                raise FormatError("image: “file” is the name of a picture.")
            yield image["file"]


def _place(name: str, folder: Path) -> Path:
    inner = PurePosixPath(name)
    leads_out = inner.is_absolute() or ".." in inner.parts or "\\" in name or ":" in name
    if leads_out or not inner.name or not name.isprintable():
        raise FormatError(
            f"image: “{name[:80]}” is not in the folder of this file. Put the picture beside it, "
            "and write its name only."
        )
    path = folder / inner
    try:
        if not path.resolve().is_relative_to(folder.resolve()):
            raise FormatError(f"image: “{name}” is a link out of the folder. Put a copy there.")
        if not path.is_file():
            raise UserError(f"The picture “{name}” is not there. Put it beside the file.")
    except OSError as problem:
        raise UserError(f"The picture “{name}” cannot be read: {problem.strerror}.") from problem
    return path
