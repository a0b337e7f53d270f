"""The look: a palette pair of our own, and one style sheet made from its tones.

The platform's colour scheme is only asked, never set: `QStyleHints.setColorScheme` has no
effect on several platforms, so both themes bring all their colours.
"""

from __future__ import annotations

import logging
import os
from enum import Enum
from functools import lru_cache
from pathlib import Path
from string import Template

from msgspec.structs import asdict
from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import (
    QColor,
    QFont,
    QFontInfo,
    QFontMetrics,
    QGuiApplication,
    QPainter,
    QPalette,
)
from PySide6.QtWidgets import QApplication, QLabel

from bozzetto.scene.palette import DARK, LIGHT, Color, Palette
from bozzetto.temporary_files import temporary_path
from bozzetto_app.paths import cache_folder
from bozzetto_app.style.colors import Tones, tones_of
from bozzetto_app.style.icons import FOLDER

__all__ = [
    "FRAME",
    "Theme",
    "apply_theme",
    "current_palette",
    "fill",
    "palette_for",
    "qcolor",
    "set_tone",
    "small_font",
    "strong_font",
    "style_sheet",
    "tones",
]

log = logging.getLogger(__name__)

SMALL = 0.86
"""Size of the second, smaller type beside the system's own."""

FRAME = (8, 48)
"""What a window's frame and title take of a screen, pixels."""

STYLE = Path(__file__).parent / "theme.qss"

_shown: Palette = LIGHT


class Theme(Enum):
    """Choice of a theme in the preferences."""

    SYSTEM = "system"
    LIGHT = "light"
    DARK = "dark"


def palette_for(theme: Theme) -> Palette:
    """Return the palette of a theme; the system's choice counts if the person made none."""
    if theme is Theme.SYSTEM:
        dark = QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark
        return DARK if dark else LIGHT
    return DARK if theme is Theme.DARK else LIGHT


def current_palette() -> Palette:
    """Return the palette that was applied last."""
    return _shown


def tones() -> Tones:
    """Return the tones of the current palette, for widgets that paint themselves."""
    return _mixed_once(_shown)


@lru_cache(maxsize=8)
def _mixed_once(palette: Palette) -> Tones:
    return tones_of(palette)


def qcolor(color: Color, opacity: float = 1.0) -> QColor:
    """Return a Qt colour; opacity 0 … 1."""
    made = QColor(*color)
    made.setAlphaF(opacity)
    return made


def fill(painter: QPainter, place: QRect | QRectF, color: Color) -> None:
    """Fill a rectangle with a colour.

    The painter's own `fillRect` makes PySide import the 170 presets of `QGradient`, 4 ms of every
    start.
    """
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(qcolor(color))
    painter.drawRect(place)


def set_tone(label: QLabel, tone: str) -> None:
    """Show a label in a tone of the style sheet: "", "quiet" or "warning".

    The style is asked for only where the tone differs: PySide makes forty enums for its class, 20
    ms of every start.
    """
    if tone != (label.property("tone") or ""):
        label.setProperty("tone", tone)
        style = label.style()
        style.unpolish(label)
        style.polish(label)


def _body_font() -> QFont:
    font = QFont(QApplication.font())
    font.setFeature(QFont.Tag("tnum"), 1)
    return font


def small_font(font: QFont) -> QFont:
    """Return the smaller of the two sizes of a font."""
    smaller = QFont(font)
    smaller.setPixelSize(_small_pixels(font))
    return smaller


def strong_font(font: QFont) -> QFont:
    """Return a font with more weight, for headings and for what is chosen."""
    stronger = QFont(font)
    stronger.setWeight(QFont.Weight.DemiBold)
    return stronger


def text_height(least: int) -> int:
    """Return the height that a line of text takes, px: this much, more where letters are large."""
    return max(least, QFontMetrics(QApplication.font()).height() + 8)


def _small_pixels(font: QFont) -> int:
    return max(10, round(QFontInfo(font).pixelSize() * SMALL))


def apply_theme(app: QApplication, palette: Palette) -> None:
    """Dress the whole program in a palette; may be called again at any time."""
    global _shown
    _shown = palette
    app.setFont(_body_font())
    app.setPalette(_qt_palette(_mixed_once(palette)))
    app.setStyleSheet(style_sheet(palette))


def _qt_palette(tones: Tones) -> QPalette:
    made = QPalette()
    role = QPalette.ColorRole
    for where, color in (
        (role.Window, tones.panel),
        (role.WindowText, tones.text),
        (role.Base, tones.field),
        (role.AlternateBase, tones.panel),
        (role.Text, tones.text),
        (role.PlaceholderText, tones.quiet),
        (role.Button, tones.panel),
        (role.ButtonText, tones.text),
        (role.BrightText, tones.accent_text),
        (role.ToolTipBase, tones.raised),
        (role.ToolTipText, tones.text),
        (role.Highlight, tones.accent_fill),
        (role.HighlightedText, tones.on_accent),
        (role.Accent, tones.accent_fill),
        (role.Link, tones.second),
        (role.LinkVisited, tones.second),
        (role.Light, tones.raised),
        (role.Midlight, tones.hover),
        (role.Mid, tones.hairline),
        (role.Dark, tones.edge),
        (role.Shadow, tones.edge),
    ):
        made.setColor(where, qcolor(color))
    for where in (role.WindowText, role.Text, role.ButtonText, role.PlaceholderText):
        made.setColor(QPalette.ColorGroup.Disabled, where, qcolor(tones.disabled))
    return made


def style_sheet(palette: Palette) -> str:
    """Return the style sheet of a palette."""
    mixed = _mixed_once(palette)
    colors = {
        name: "#{:02x}{:02x}{:02x}".format(*value)
        for name, value in asdict(mixed).items()
        if name != "name"
    }
    return Template(STYLE.read_text("utf-8")).substitute(
        colors,
        small=_small_pixels(QApplication.font()),
        icons=_tinted_files(mixed).as_posix(),
    )


def _tinted_files(tones: Tones) -> Path:
    """Return a folder with the few icons that a style sheet can only take from files.

    They are kept between two starts; a disk that is full costs the icons, not the start.
    """
    color = "#{:02x}{:02x}{:02x}".format(*tones.text)
    folder = cache_folder() / f"icons-{color[1:]}"
    for name in ("check", "chevron-right", "chevron-down", "cross", "panels"):
        content = (FOLDER / f"{name}.svg").read_bytes().replace(b"currentColor", color.encode())
        place = folder / f"{name}.svg"
        try:
            if not place.is_file() or place.read_bytes() != content:
                folder.mkdir(parents=True, exist_ok=True)
                beside = temporary_path(place)
                beside.write_bytes(content)
                os.replace(beside, place)  # one that a crash damages is made again
        except OSError:
            log.warning("the icon %s could not be kept", place, exc_info=True)
    return folder
