"""Short texts beside points, in Pillow's bundled font."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Label
    from bozzetto.scene.palette import Palette
    from bozzetto.scene.renderer.lines_and_points import Canvas

OFFSET = (6.0, -6.0)
"""Offset from the point to the text's lower left corner, px right and down."""

HALO = 2
"""Width of the rim in paper colour that keeps a text legible on anything, px."""

LONGEST = 200
"""Characters drawn at most."""

TALLEST = 400.0
"""Largest size of a text, px."""


def draw_label(canvas: Canvas, item: Label, palette: Palette) -> None:
    """Draw a text beside its point; nothing if the point is behind the eye."""
    seen = canvas.sight.seen([item.point])
    if seen[0, 2] < canvas.sight.near or not item.text.strip():
        return
    x, y, _ = canvas.sight.placed(seen)[0]
    size = float(np.clip(item.size * canvas.scale, 4.0, TALLEST))
    reach = TALLEST * LONGEST
    if not (-reach < x < canvas.sight.width + reach and -reach < y < canvas.sight.height + reach):
        return
    halo = max(1, round(HALO * canvas.scale))
    rim, letters = (_mask(item.text[:LONGEST], size, width) for width in (halo, 0))
    x = beginning(x, letters[0].shape[1], canvas.sight.width, OFFSET[0] * canvas.scale)
    y += OFFSET[1] * canvas.scale
    for (mask, left, top), color in ((rim, palette.paper), (letters, palette.letters(item.color))):
        _cover(canvas, mask, round(x) + left, round(y) + top, np.array(color, float))


def beginning(x: float, wide: float, sheet: float, offset: float) -> float:
    """Return where a text begins: right of its point, or left of it where only there is room.

    Where there is room on neither side, it ends where the sheet does, and goes beyond on the right
    only what is wider than the sheet.

    Parameters
    ----------
    x : float
        Place of the point, px.
    wide, sheet : float
        Width of the text, and of the sheet, px.
    offset : float
        Distance from the point, px.
    """
    left, right = x - offset - wide, x + offset
    if right + wide <= sheet or not 0.0 <= x <= sheet:
        return right
    return left if left >= 0.0 else min(right, max(0.0, sheet - wide))


def _mask(text: str, size: float, rim: int) -> tuple[NDArray[np.float32], int, int]:
    """Return the coverage of a text, and its left and top edges relative to its anchor."""
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.load_default(size)
    measure = ImageDraw.Draw(Image.new("L", (1, 1)))
    box = measure.multiline_textbbox((0, 0), text, font=font, anchor="ld", stroke_width=rim)
    left, top = int(np.floor(box[0])), int(np.floor(box[1]))
    shape = (int(np.ceil(box[2])) - left + 1, int(np.ceil(box[3])) - top + 1)
    image = Image.new("L", shape)
    ImageDraw.Draw(image).multiline_text(
        (-left, -top), text, fill=255, font=font, anchor="ld", stroke_width=rim
    )
    return np.asarray(image, np.float32) / np.float32(255), left, top


def _cover(
    canvas: Canvas, mask: NDArray[np.float32], left: int, top: int, color: NDArray[np.float64]
) -> None:
    row, column = np.nonzero(mask > 0)
    share = mask[row, column]
    row, column = row + top, column + left
    width, height = canvas.sight.width, canvas.sight.height
    keep = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    canvas.cover(row[keep] * width + column[keep], share[keep], color, 1.0)
