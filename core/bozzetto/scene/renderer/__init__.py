"""The software renderer: a numpy z-buffer, for pictures without a screen."""

from __future__ import annotations

from bozzetto.scene.renderer.renderer import MOST_PIXELS, render
from bozzetto.scene.renderer.shading import SHADINGS, Shading

__all__ = ["MOST_PIXELS", "SHADINGS", "Shading", "render"]
