"""Ink: strokes as they were drawn, and the plane-curve tools that every modeler shares."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing as Drawing
    from bozzetto.ink.stroke import Stroke as Stroke
    from bozzetto.ink.stroke import Strokes as Strokes
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.ink.drawing": "Drawing",
            "bozzetto.ink.stroke": "Stroke Strokes",
        },
    )
