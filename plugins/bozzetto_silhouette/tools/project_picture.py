"""Project picture: the underlay is laid on the shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Tap, override
from bozzetto_silhouette.model.state import Picture, SilhouetteState
from bozzetto_silhouette.tools.erasing_tool import ColouringTool

MOST_PIXELS = 2048
"""Longest side of the picture that is kept: beyond, files grow and nothing more shows."""


class ProjectPicture(ColouringTool):
    """The underlay colours the shape, front and back; without an underlay it comes off."""

    id = "picture"
    title = "Project picture"
    icon = "icons/picture.svg"
    hint = "Tap to lay the underlay on the shape; tap without an underlay to take it off."
    gesture = "tap"

    @override
    def tap(self, state: SilhouetteState, tap: Tap, context: Context) -> SilhouetteState:
        """Keep the underlay as the shape's picture.

        Raises
        ------
        UserError
            If there is no underlay and no picture to take off, or the underlay is a line.
        """
        image = context.underlay
        if image is None:
            if state.picture is None:
                raise UserError("There is no underlay to project. Drop a picture on the sheet.")
            return replace(state, picture=None)
        if not np.linalg.norm(np.cross(image.across, image.down)) > 0.0:
            raise UserError("This underlay has no area. Drop the picture on the sheet again.")
        pixels = _within(image.pixels, MOST_PIXELS)
        return replace(state, picture=Picture(pixels, image.corner, image.across, image.down))


def _within(pixels: NDArray[np.uint8], most: int) -> NDArray[np.uint8]:
    """Shrink a picture until no side is longer than `most`."""
    height, width = pixels.shape[:2]
    if max(height, width) <= most:
        return pixels
    from PIL import Image

    share = most / max(height, width)
    size = (max(1, round(width * share)), max(1, round(height * share)))
    smaller = Image.fromarray(np.ascontiguousarray(pixels)).resize(size, Image.Resampling.BOX)
    return np.asarray(smaller, np.uint8)
