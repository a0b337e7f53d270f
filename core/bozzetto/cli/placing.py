"""``--place``: objects of a document put somewhere else before they are handed over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.errors import UserError

if TYPE_CHECKING:
    import argparse

    from bozzetto.document.model import Document

FORM = "--place takes NAME=X,Y,Z or NAME=X,Y,Z,TURN, in mm and degrees about the vertical"


def add_place(parser: argparse.ArgumentParser) -> None:
    """Let a command take places of objects."""
    parser.add_argument(
        "--place",
        action="append",
        default=[],
        metavar="NAME=X,Y,Z[,TURN]",
        help="put an object somewhere else, mm, and turn it about the vertical, degrees",
    )


def placed(document: Document, places: Sequence[str]) -> Document:
    """Return a document whose objects stand where ``--place`` says; as in the window's form.

    Raises
    ------
    UserError
        If one is not of the form, or names no object, or a locked one.
    """
    from bozzetto.document import edit

    for told in places:
        name, sign, text = told.rpartition("=")
        try:
            numbers = [float(word) for word in text.split(",")]
        except ValueError:
            numbers = []
        if not sign or len(numbers) not in (3, 4) or not all(map(math.isfinite, numbers)):
            raise UserError(f"{FORM}, not {told!r}.")
        found = [model for model in document if model.name == name]
        if not found:
            names = ", ".join(f"“{model.name}”" for model in document) or "no object"
            raise UserError(f"There is no object called “{name}”; the document has {names}.")
        for model in found:
            x, y, z = numbers[:3]
            place = replace(model.placement, offset=(x, y, z))
            if len(numbers) == 4:
                place = place.headed(numbers[3])
            document, _ = edit.place_model(document, model.id, place)
    return document
