"""The software renderer: a numpy z-buffer, for pictures without a screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.scene.renderer.renderer import MOST_PIXELS as MOST_PIXELS
    from bozzetto.scene.renderer.renderer import render as render
    from bozzetto.scene.renderer.shading import SHADINGS as SHADINGS
    from bozzetto.scene.renderer.shading import Shading as Shading
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.scene.renderer.renderer": "MOST_PIXELS render",
            "bozzetto.scene.renderer.shading": "SHADINGS Shading",
        },
    )
