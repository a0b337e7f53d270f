"""Icons: one family of SVG drawings on a 20 px grid, tinted by the theme.

The drawings are strokes of 1.5 px in ``currentColor``; they are put in the colour wanted
and rendered at the very size of the screen's pixels, so they are crisp at any scale.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QByteArray, QRectF, QSize, Qt
from PySide6.QtGui import QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from bozzetto_app.style.colors import tones_of

if TYPE_CHECKING:
    from bozzetto.scene.palette import Color, Palette

__all__ = ["FOLDER", "GRID", "icon", "icon_from_file", "icon_names", "paint_icon"]

FOLDER = Path(__file__).parents[1] / "icons"

GRID = 20
"""Side of an icon, logical pixels."""

SCALES = (1.0, 1.25, 1.5, 2.0, 3.0)
"""Screen scales for which a `QIcon` holds an exact picture; others are scaled from these."""

LARGEST_FILE = 64 * 1024
"""Longest SVG accepted from a plugin, bytes; a 20 px drawing needs a thousandth of it."""


def icon_names() -> tuple[str, ...]:
    """Names of all icons of the family."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.svg")))


@lru_cache(maxsize=512)
def _renderer(path: Path, color: Color) -> QSvgRenderer | None:
    """Return the drawing in one colour; None if the file cannot be read as SVG."""
    try:
        if path.stat().st_size > LARGEST_FILE:
            return None
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    tinted = text.replace("currentColor", "#{:02x}{:02x}{:02x}".format(*color))
    renderer = QSvgRenderer(QByteArray(tinted.encode()))
    return renderer if renderer.isValid() else None


def paint_icon(painter: QPainter, source: str | Path, place: QRectF, color: Color) -> bool:
    """Paint an icon of the family (by name) or a plugin's (by path).

    Returns
    -------
    bool
        False where there is no such drawing; the caller then shows a letter.
    """
    path = source if isinstance(source, Path) else FOLDER / f"{source}.svg"
    renderer = _renderer(path, color)
    if renderer is None:
        return False
    renderer.render(painter, place)
    return True


def _picture(path: Path, color: Color, side: int) -> QPixmap | None:
    picture = QPixmap(QSize(side, side))
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    done = paint_icon(painter, path, QRectF(0, 0, side, side), color)
    painter.end()
    return picture if done else None


@lru_cache(maxsize=512)
def icon_from_file(path: Path, palette: Palette) -> QIcon:
    """Return an icon in the text colour of a theme; a null icon if the file is no SVG."""
    tones = tones_of(palette)
    made = QIcon()
    for mode, color in (
        (QIcon.Mode.Normal, tones.text),
        (QIcon.Mode.Disabled, tones.disabled),
    ):
        for scale in SCALES:
            picture = _picture(path, color, round(GRID * scale))
            if picture is not None:
                made.addPixmap(picture, mode)
    return made


def icon(name: str, palette: Palette) -> QIcon:
    """Return an icon of the family in the text colour of a theme.

    Raises
    ------
    KeyError
        If the family has no icon of that name.
    """
    path = FOLDER / f"{name}.svg"
    if not path.exists():
        raise KeyError(f"no icon {name!r}")
    return icon_from_file(path, palette)
