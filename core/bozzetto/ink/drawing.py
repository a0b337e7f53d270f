"""A drawing: what an ink file holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from bozzetto.ink.stroke import Strokes
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture
    from bozzetto.ink.steps import Step


MODELER_FACT: Final = "modeler"
"""The fact that names the modeler for which a file was drawn: its id, or the last part of it."""


@dataclass(frozen=True)
class Drawing:
    """Strokes on a canvas, as read from an ink file or a vector drawing.

    Parameters
    ----------
    strokes : Strokes
        Every stroke carries its own camera; usually all share `camera`.
    camera : Camera
        The camera of the sheet; its viewport is the canvas in pixels.
    name : str
        Where it came from, without folder or ending; becomes the model's name.
    facts : dict
        What the file said beyond the strokes (``"box"``, ``"plane"``, ``"marks"`` …),
        for the modelers that know it; already checked to be plain JSON values.
    steps : tuple of Step
        How the strokes were used, where the file says so; they name strokes that there are.
    pictures : mapping of str to Picture
        The pictures that `facts` names, by the names of their files as they stand there.
    drawings : mapping of str to Drawing
        The drawings that `facts` and `steps` name, by the names of their files as they stand there.
    left_out : tuple of str
        What the file holds besides and was not read, a sentence each that says what to do.
    """

    strokes: Strokes
    camera: Camera
    name: str = "drawing"
    facts: dict[str, Any] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    drawings: Mapping[str, Drawing] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
