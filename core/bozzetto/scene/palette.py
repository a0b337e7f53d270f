"""The colours of the two themes, by the role they play on the sheet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

from bozzetto.scene.contrast import Color, readable

__all__ = ["DARK", "LIGHT", "ROLES", "Color", "Palette", "Role"]

Role = Literal[
    "paper", "panel", "ink", "ghost", "accent", "second", "clay", "faint", "grid", "warning"
]
ROLES: tuple[str, ...] = get_args(Role)


@dataclass(frozen=True)
class Palette:
    """One colour (r, g, b; 0 … 255) for every role.

    ``paper`` is the sheet, ``panel`` the docks, ``ink`` fresh strokes and text, ``ghost``
    processed strokes, ``accent`` the one vermilion, ``second`` the slate blue of what is
    symmetric or mirrored, ``clay`` the matte of shapes, ``faint`` boxes and planes,
    ``grid`` the ground, ``warning`` places that need a look.
    """

    name: str
    paper: Color
    panel: Color
    ink: Color
    ghost: Color
    accent: Color
    second: Color
    clay: Color
    faint: Color
    grid: Color
    warning: Color

    def color(self, paint: str | Color) -> Color:
        """Resolve a role's name, or pass a colour through."""
        if isinstance(paint, str):
            resolved: Color = getattr(self, paint)
            return resolved
        return paint

    def letters(self, paint: str | Color) -> Color:
        """Resolve the colour of a text on the sheet, moved towards the ink until it is legible."""
        return _letters(self.color(paint), self.ink, self.paper)


@lru_cache(maxsize=64)  # asked for every text of every frame
def _letters(color: Color, ink: Color, paper: Color) -> Color:
    return readable(color, ink, paper)


LIGHT = Palette(
    name="light",
    paper=(0xF6, 0xF4, 0xEF),
    panel=(0xEC, 0xE9, 0xE2),
    ink=(0x22, 0x21, 0x1F),
    ghost=(0x8C, 0x88, 0x80),
    accent=(0xD4, 0x50, 0x2F),
    second=(0x4A, 0x68, 0x8F),
    clay=(0xD9, 0xD0, 0xC3),
    faint=(0xB9, 0xB4, 0xAA),
    grid=(0xDE, 0xDA, 0xD1),
    warning=(0xB8, 0x74, 0x00),
)
"""The colours of the light theme."""

DARK = Palette(
    name="dark",
    paper=(0x1F, 0x21, 0x24),
    panel=(0x2A, 0x2D, 0x31),
    ink=(0xEE, 0xEC, 0xE6),
    ghost=(0x85, 0x88, 0x8C),
    accent=(0xF0, 0x80, 0x5C),
    second=(0x8F, 0xAE, 0xD6),
    clay=(0xB4, 0xAC, 0xA2),
    faint=(0x55, 0x59, 0x5F),
    grid=(0x30, 0x33, 0x38),
    warning=(0xE2, 0xB0, 0x4A),
)
"""The colours of the dark theme."""
