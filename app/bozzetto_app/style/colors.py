"""The colours of widgets, mixed from the few roles of the sheet's palette."""

from __future__ import annotations

from functools import lru_cache

import msgspec

from bozzetto.scene.contrast import luminance, mixed, readable
from bozzetto.scene.palette import Color, Palette

__all__ = ["Tones", "tones_of"]


class Tones(msgspec.Struct, frozen=True):
    """Colours of widgets.

    ``panel`` the docks, ``field`` what can be typed into, ``raised`` menus and pop-ups;
    ``text`` and ``quiet`` (second in rank) are legible on all three. ``hairline`` parts
    things, ``edge`` outlines what can be touched, ``hover`` and ``press`` lie under the
    pointer, ``chosen`` under what is selected. ``accent`` marks; ``accent_text`` is its
    legible form, ``on_accent`` is written on ``accent_fill``. ``second`` is the slate blue,
    ``warning`` and ``good`` accompany a mark and a word, never stand alone.
    """

    name: str
    panel: Color
    field: Color
    raised: Color
    text: Color
    quiet: Color
    disabled: Color
    hairline: Color
    edge: Color
    hover: Color
    press: Color
    chosen: Color
    accent: Color
    accent_text: Color
    accent_fill: Color
    on_accent: Color
    second: Color
    warning: Color
    good: Color


@lru_cache(maxsize=8)  # every icon asks, and the search for legible tones takes a millisecond
def tones_of(palette: Palette) -> Tones:
    """Mix the widgets' colours from a palette."""
    ink, panel, paper = palette.ink, palette.panel, palette.paper
    light = luminance(paper) > luminance(ink)
    raised = mixed((255, 255, 255), paper, 0.5) if light else mixed(ink, panel, 0.06)
    chosen = mixed(palette.accent, panel, 0.16)
    grounds = (panel, paper, raised, chosen)
    black: Color = (0, 0, 0)
    on_accent = paper
    accent_fill = readable(palette.accent, black if light else (255, 255, 255), on_accent)
    return Tones(
        name=palette.name,
        panel=panel,
        field=paper,
        raised=raised,
        text=ink,
        quiet=readable(mixed(ink, panel, 0.5), ink, *grounds),
        disabled=mixed(ink, panel, 0.36),
        hairline=mixed(ink, panel, 0.12),
        edge=mixed(ink, panel, 0.24),
        hover=mixed(ink, panel, 0.06),
        press=mixed(ink, panel, 0.12),
        chosen=chosen,
        accent=palette.accent,
        accent_text=readable(palette.accent, ink, *grounds),
        accent_fill=accent_fill,
        on_accent=on_accent,
        second=readable(palette.second, ink, *grounds),
        warning=readable(palette.warning, ink, *grounds),
        good=readable(palette.second, ink, *grounds),
    )
