"""A drawing: what an ink file holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from bozzetto.ink.steps import Step
from bozzetto.ink.stroke import Strokes
from bozzetto.view.camera import Camera

__all__ = ["Drawing"]


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
    extra : dict
        What the file said beyond the strokes (``"box"``, ``"plane"``, ``"marks"`` …),
        for the modelers that know it; already checked to be plain JSON values.
    steps : tuple of Step
        How the strokes were used, where the file says so; they name strokes that there are.
    """

    strokes: Strokes
    camera: Camera
    name: str = "drawing"
    extra: dict[str, Any] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
