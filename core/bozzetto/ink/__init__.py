"""Ink: strokes as they were drawn, and the plane-curve tools that every modeler shares."""

from __future__ import annotations

from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import Stroke, Strokes

__all__ = ["Drawing", "Stroke", "Strokes"]
