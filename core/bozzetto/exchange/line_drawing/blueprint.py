"""A blueprint: front, side, top and three-quarter view on one sheet, with dimensions.

The views lie as in third angle projection (ISO 5456-2): what is seen from above lies above,
what is seen from the right lies to the right. Scales are those of ISO 5455, the sheet is an A3
lying down (ISO 5457).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.handover import MM_PER, Unit
from bozzetto.exchange.line_drawing.hidden_lines import DrawnLine
from bozzetto.exchange.line_drawing.page import (
    Page,
    PageLine,
    PageText,
    bounds_of,
    moved,
    net_to_draw,
    page_lines,
    parallel_lines,
)
from bozzetto.geometry.shapes import Shapes

SHEET: Final = (420.0, 297.0)
"""A3, mm."""

BORDER: Final = (20.0, 10.0)
"""Of the frame: at the left, where sheets are bound, and elsewhere, mm."""

TITLE: Final = (180.0, 27.0)
"""Of the title block, mm."""

GAP: Final = 24.0
"""Between views, mm: dimensions lie there."""

SCALES: Final = tuple(
    sorted((m * 10.0**e for m in (1.0, 2.0, 5.0) for e in range(-9, 9)), reverse=True)
)
"""Of the ISO: 1, 2 and 5 by powers of ten."""

LETTERS: Final = 3.5
"""Height of letters, mm (ISO 3098)."""

TITLE_LETTERS: Final = 7.0

LETTER_WIDTH: Final = 0.65
"""Of a digit, as a share of its height, with what is free beside it."""

CLEAR: Final = 1.0
"""Between a number and the lines around it, mm."""

FLAT: Final = 1e-6
"""Share of the size below which an extent is none, and has no dimension."""

ARROW: Final = (3.0, 0.5)
"""Length and half width of an arrowhead, mm."""

STAND_OFF: Final = 10.0
"""Of a dimension from what it measures, mm."""

OVERHANG: Final = 2.0
"""By which extension lines pass it, mm."""

VIEWS: Final[dict[str, Array]] = {
    "front": np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]),
    "right": np.array([[0.0, 1, 0], [0, 0, 1], [-1, 0, 0]]),
    "top": np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, -1]]),
}
"""Rows: to the right, up, and away from the eye."""


def _oblique() -> Array:
    away = np.array([-0.55, 0.75, -0.42])
    away /= np.linalg.norm(away)
    right = np.cross(away, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    return np.stack((right, np.cross(right, away), away))


def blueprint_page(shapes: Shapes, title: str, unit: Unit = "mm", *, hidden: bool) -> Page:
    """Return a sheet with four views of shapes and their overall dimensions.

    Parameters
    ----------
    shapes : Shapes
        mm.
    title : str
        In the title block.
    unit : {"mm", "cm", "m", "in"}
        Of the dimensions.
    hidden : bool
        Whether lines that are hidden are drawn, too, dashed.

    Raises
    ------
    UserError
        If there is nothing to draw.
    """
    net = net_to_draw(shapes)
    views = {name: parallel_lines(net, axes) for name, axes in VIEWS.items()}
    oblique = parallel_lines(net, _oblique())
    used = np.unique(np.concatenate((net.faces.ravel(), net.wires.ravel())))
    low, high = net.points[used].min(axis=0), net.points[used].max(axis=0)
    size = np.maximum(high - low, 1e-9)
    width, depth, tall = size.tolist()
    left, rim = BORDER
    room = np.array(SHEET) - (left + rim, 2 * rim) - 2 * GAP
    room[1] -= TITLE[1] - GAP / 4
    scale = next(
        (s for s in SCALES
         if s * (width + depth) + GAP <= room[0] and s * (tall + depth) + GAP <= room[1]),
        SCALES[-1],
    )  # fmt: skip
    # Columns: front and top, then side and three-quarter; rows: top, then front.
    used_up = scale * np.array((width + depth, tall + depth)) + GAP
    x, y = np.array((left, rim)) + GAP + (room - used_up) * (0.3, 0.5)
    corners = {
        "top": (x, y),
        "front": (x, y + scale * depth + GAP),
        "right": (x + scale * width + GAP, y + scale * depth + GAP),
    }
    lines: list[PageLine] = []
    for name, drawn in views.items():
        axes = VIEWS[name]
        first = np.minimum(axes @ low, axes @ high), np.maximum(axes @ low, axes @ high)
        corner = np.array((first[0][0], -first[1][1]))
        lines += _placed(drawn, scale, np.array(corners[name]) - scale * corner, hidden=hidden)
    texts: list[PageText] = []
    (fx, fy), (sx, sy) = corners["front"], corners["right"]
    bottom = fy + scale * tall
    lines += _small_view(oblique, (x, y), (sx, sy), (sx + scale * depth, bottom), scale)
    for begin, end, value, upright, after in (
        ((fx, bottom), (fx + scale * width, bottom), width, False, False),
        ((fx, fy), (fx, bottom), tall, True, False),
        ((sx, bottom), (sx + scale * depth, bottom), depth, False, True),
    ):
        if value <= FLAT * float(size.max()):
            continue
        words = _said(value, unit)
        drawn_dimension, text = _dimension(begin, end, words, upright=upright, after=after)
        lines += drawn_dimension
        texts.append(text)
    lines += _frame()
    texts += _title(title, scale, unit)
    return Page((0.0, 0.0), *SHEET, "mm", tuple(lines), tuple(texts))


def _placed(lines: list[DrawnLine], scale: float, offset: Array, *, hidden: bool) -> list[PageLine]:
    return [moved(line, scale, offset) for line in page_lines(lines, hidden=hidden)]


def _small_view(
    lines: list[DrawnLine],
    begin: tuple[float, float],
    side: tuple[float, float],
    end: tuple[float, float],
    scale: float,
) -> list[PageLine]:
    """Return the three-quarter view where the sheet has most room for it, smaller if need be.

    Parameters
    ----------
    lines : list of DrawnLine
        Of the view, mm.
    begin, side, end : (x, y)
        Upper left corners of the top view and of the side view, and the lower right one of that.
    scale : float
        Of the other views.
    """
    low, high = bounds_of(lines)
    left, top = BORDER[0] + GAP / 2, BORDER[1] + GAP / 2
    right, bottom = SHEET[0] - BORDER[1] - GAP / 2, SHEET[1] - BORDER[1] - GAP / 2
    title_left, title_top = right + GAP / 2 - TITLE[0], bottom + GAP / 2 - TITLE[1]
    rooms = [
        ((side[0], top), (right, side[1] - GAP / 2)),
        ((end[0] + GAP, top), (right, title_top - GAP / 2)),
        ((left, top), (right, begin[1] - GAP / 2)),
        ((left, end[1] + GAP), (title_left - GAP / 2, bottom)),
    ]
    fitting = [
        min(scale, float((np.subtract(*room[::-1]) / np.maximum(high - low, 1e-9)).min()))
        for room in rooms
    ]
    best = int(np.argmax(fitting))
    offset = np.mean(rooms[best], axis=0) - fitting[best] * (low + high) / 2
    return _placed(lines, fitting[best], offset, hidden=False)


def _said(value: float, unit: Unit) -> str:
    """Return a length in a unit: four digits or all before the point, never a power of ten."""
    length = value / MM_PER[unit]
    words = f"{length:.{max(0, 3 - int(np.floor(np.log10(length))))}f}"
    return words.rstrip("0").rstrip(".") if "." in words else words


def _dimension(
    begin: tuple[float, float],
    end: tuple[float, float],
    words: str,
    *,
    upright: bool,
    after: bool,
) -> tuple[list[PageLine], PageText]:
    """Return extension lines, a line with two arrowheads, and its number (ISO 129-1).

    A number that does not fit between the extension lines stands beside them, on the longer line:
    beyond the end if it is to be `after`, else before the beginning.
    """
    a, b = np.array(begin), np.array(end)
    away = np.array((-1.0, 0.0) if upright else (0.0, 1.0))
    first, second = a + away * STAND_OFF, b + away * STAND_OFF
    rows = [np.stack((p + away, q + away * OVERHANG)) for p, q in ((a, first), (b, second))]
    length = float(np.linalg.norm(b - a))
    along = np.array((0.0, 1.0) if upright else (1.0, 0.0))
    wide = LETTER_WIDTH * LETTERS * len(words)
    inward = 1.0 if length > 4 * ARROW[0] else -1.0
    beyond = 0.0 if inward > 0 else 2.0 * ARROW[0]
    ends = [first - along * beyond, second + along * beyond]
    middle = 0.5 * (first + second)
    if wide + 2 * CLEAR > length:
        beyond = max(beyond, CLEAR)
        middle, way = (second, along) if after else (first, -along)
        middle = middle + way * (beyond + 0.5 * wide)
        ends[int(after)] = middle + way * 0.5 * wide
    rows.append(np.stack(ends))
    for tip, way in ((first, along), (second, -along)):
        back = tip + inward * way * ARROW[0]
        side = np.array((-way[1], way[0])) * ARROW[1]
        rows.append(np.stack((back + side, tip, back - side, back + side)))
    x, y = (middle + CLEAR * (away if upright else -away)).tolist()
    place = PageText(words, (x, y), LETTERS, upwards=upright)
    return [PageLine(row, "dimensions") for row in rows], place


def _frame() -> list[PageLine]:
    left, rim = BORDER
    right, bottom = SHEET[0] - rim, SHEET[1] - rim
    x, y = right - TITLE[0], bottom - TITLE[1]
    half = y + TITLE[1] / 2

    def box(x0: float, y0: float, x1: float, y1: float) -> Array:
        return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]])

    rows = [
        box(left, rim, right, bottom),
        box(x, y, right, bottom),
        np.array([[x, half], [right, half]]),
        *(np.array([[x + k * TITLE[0] / 3, half], [x + k * TITLE[0] / 3, bottom]]) for k in (1, 2)),
    ]
    return [PageLine(row, "frame") for row in rows]


def _title(title: str, scale: float, unit: Unit) -> list[PageText]:
    x = SHEET[0] - BORDER[1] - TITLE[0] + 3.0
    y = SHEET[1] - BORDER[1] - TITLE[1]
    ratio = f"{scale:.0f} : 1" if scale >= 1 else f"1 : {1 / scale:.0f}"
    low = y + TITLE[1] - 4.5
    cells = (f"Scale {ratio}", f"Dimensions in {unit}", "Third angle projection")
    return [
        PageText(title[:40], (x, y + TITLE[1] / 2 - 3.5), TITLE_LETTERS, centered=False),
        *(
            PageText(words, (x + k * TITLE[0] / 3, low), LETTERS, centered=False)
            for k, words in enumerate(cells)
        ),
    ]
