"""The software renderer: a numpy z-buffer, for pictures without a screen."""

from __future__ import annotations

from bozzetto.scene.software.frame import MOST_PIXELS, render
from bozzetto.scene.software.shading import SHADINGS, Shading

__all__ = ["MOST_PIXELS", "SHADINGS", "Shading", "render"]
