"""The pictures and drawings that a drawing's file names: they lie beside it, or below."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Final

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import at_most
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.steps import AddStep

MOST_PICTURES: Final = 64
"""Pictures of one drawing: nobody sketches one thing from more sides."""

MOST_DRAWINGS: Final = 64
"""Drawings of one drawing: logos and signs."""


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
    return {name: read(place_beside(name, folder)) for name in names}


def drawings_named_in(
    drawing: Drawing, folder: Path, read: Callable[[Path], Drawing]
) -> dict[str, Drawing]:
    """Read the drawings that another one names, in steps that add them and in its facts.

    Parameters
    ----------
    drawing : Drawing
        In its facts ``"drawing": {"file": "a.svg"}`` at any depth counts.
    folder, read
        As in `pictures_named_in`. What such a drawing names in turn is not read.

    Returns
    -------
    dict of str to Drawing
        By the names as they stand in the file.

    Raises
    ------
    UserError, FormatError
        As in `pictures_named_in`.
    """
    added = [step.add for step in drawing.steps if isinstance(step, AddStep)]
    names = dict.fromkeys((*added, *_drawing_names(drawing.facts)))
    at_most(len(names), MOST_DRAWINGS, "drawings")
    return {name: read(place_beside(name, folder, "drawing")) for name in names}


def _drawing_names(facts: Mapping[str, Any]) -> Iterator[str]:
    waiting: list[Any] = [facts]
    while waiting:
        value = waiting.pop()
        if isinstance(value, Mapping):
            named = value.get("drawing")
            if isinstance(named, Mapping) and isinstance(named.get("file"), str):
                yield named["file"]
            waiting.extend(reversed(list(value.values())))
        elif isinstance(value, list):
            waiting.extend(one for one in reversed(value) if isinstance(one, Mapping | list))


def _names(facts: Mapping[str, Any]) -> Iterator[str]:
    views = facts.get("views")
    for holder in (facts, *(views if isinstance(views, list) else ())):
        image = holder.get("image") if isinstance(holder, Mapping) else None
        if isinstance(image, Mapping) and "file" in image:
            if not isinstance(image["file"], str):
                raise FormatError("image: “file” is the name of a picture.")
            yield image["file"]


def place_beside(name: str, folder: Path, kind: str = "picture") -> Path:
    """Return where a file lies that another one names: beside it, or below.

    Parameters
    ----------
    name : str
        As it stands there, with slashes.
    folder : Path
        Where the file lies that names it.
    kind : str
        For messages.

    Raises
    ------
    UserError
        If it is missing.
    FormatError
        If the name leads out of the folder.
    """
    inner = PurePosixPath(name)
    leads_out = inner.is_absolute() or ".." in inner.parts or "\\" in name or ":" in name
    if leads_out or not inner.name or not name.isprintable():
        raise FormatError(
            f"{kind}: “{name[:80]}” is not in the folder of this file. Put the {kind} beside it, "
            "and write its name only."
        )
    path = folder / inner
    try:
        if not path.resolve().is_relative_to(folder.resolve()):
            raise FormatError(f"{kind}: “{name}” is a link out of the folder. Put a copy there.")
        if not path.is_file():
            raise UserError(f"The {kind} “{name}” is not there. Put it beside the file.")
    except OSError as problem:
        raise UserError(f"The {kind} “{name}” cannot be read: {problem.strerror}.") from problem
    return path
