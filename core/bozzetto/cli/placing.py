"""``--place``: objects and underlays of a document put somewhere else before it is handed over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.errors import UserError

if TYPE_CHECKING:
    import argparse

    from bozzetto.document.model import Document, Underlay

FORM = (
    "--place takes NAME=X,Y,Z or NAME=X,Y,Z,TURN, in mm and degrees about the vertical; of an "
    "underlay NAME=X,Y,Z,TURN,WIDTH as well, the place of its middle, its turn and its width"
)


def add_place(parser: argparse.ArgumentParser) -> None:
    """Let a command take places of objects."""
    parser.add_argument(
        "--place",
        action="append",
        default=[],
        metavar="NAME=X,Y,Z[,TURN[,WIDTH]]",
        help="put an object or an underlay somewhere else, mm, and turn it, degrees: an object "
        "about the vertical, an underlay in its plane about its middle, WIDTH mm wide",
    )


def placed(document: Document, places: Sequence[str]) -> Document:
    """Return a document whose objects and underlays lie where ``--place`` says.

    As in the window's forms.

    Raises
    ------
    UserError
        If one is not of the form, or names nothing that is there, or a locked object, or a place
        where an underlay cannot be.
    """
    from bozzetto.document import edit

    for told in places:
        name, sign, text = told.rpartition("=")
        try:
            numbers = [float(word) for word in text.split(",")]
        except ValueError:
            numbers = []
        found = [model for model in document if model.name == name]
        pictures = [one for one in document.underlays if one.name == name]
        lengths = (3, 4, 5) if pictures and not found else (3, 4)
        if not sign or len(numbers) not in lengths or not all(map(math.isfinite, numbers)):
            raise UserError(f"{FORM}, not {told!r}.")
        if not found and not pictures:
            there = [*document, *document.underlays]
            names = ", ".join(f"“{one.name}”" for one in there) or "no object"
            raise UserError(f"There is no object called “{name}”; the document has {names}.")
        for picture in pictures:
            document = edit.change_underlay(document, _laid(picture, numbers)).document
        for model in found:
            x, y, z = numbers[:3]
            place = replace(model.placement, offset=(x, y, z))
            if len(numbers) == 4:
                place = place.headed(numbers[3])
            document, _ = edit.place_model(document, model.id, place)
    return document


def _laid(picture: Underlay, numbers: Sequence[float]) -> Underlay:
    """Return an underlay with its middle, turn and width as told; what is not told stays."""
    from bozzetto.document import underlay_place

    place = underlay_place.place_of(picture)
    x, y, z, *more = numbers
    turn, width = (*more, *(place.turn, place.width)[len(more) :])
    return underlay_place.placed(picture, underlay_place.UnderlayPlace((x, y, z), width, turn))
