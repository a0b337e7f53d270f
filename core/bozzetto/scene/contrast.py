"""How well colours can be told apart, and the legible form of one."""

from __future__ import annotations

from functools import lru_cache

Color = tuple[int, int, int]

LEGIBLE = 4.5
"""Smallest contrast of text against its ground (WCAG 2.2, success criterion 1.4.3, AA)."""

MIXING_STEPS = 40
"""How finely `readable` searches between a colour and the ink."""


@lru_cache(maxsize=256)
def luminance(color: Color) -> float:
    """Relative luminance of an sRGB colour, 0 … 1 (WCAG 2.2, "relative luminance")."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (value / 255.0 for value in color)
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: Color, other: Color) -> float:
    """Contrast ratio of two colours, 1 … 21 (WCAG 2.2, "contrast ratio")."""
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def mixed(one: Color, other: Color, share: float) -> Color:
    """Return a share (0 … 1) of `one` over `other`."""
    red, green, blue = (
        round(share * a + (1.0 - share) * b) for a, b in zip(one, other, strict=True)
    )
    return red, green, blue


def readable(color: Color, ink: Color, *grounds: Color) -> Color:
    """`color`, moved towards the ink just until it is legible on every ground."""
    for step in range(MIXING_STEPS):
        candidate = mixed(ink, color, step / MIXING_STEPS)
        if all(contrast(candidate, ground) >= LEGIBLE for ground in grounds):
            return candidate
    return ink
