"""The display list, picking, and pictures without a screen."""

from __future__ import annotations

from bozzetto.images.stored_picture import Picture
from bozzetto.scene.display_list import (
    Handle,
    Image,
    Item,
    Label,
    Layer,
    Lines,
    Paint,
    Points,
    Scene,
    Shaded,
)
from bozzetto.scene.palette import DARK, LIGHT, Palette

__all__ = [
    "DARK",
    "LIGHT",
    "Handle",
    "Image",
    "Item",
    "Label",
    "Layer",
    "Lines",
    "Paint",
    "Palette",
    "Picture",
    "Points",
    "Scene",
    "Shaded",
]
