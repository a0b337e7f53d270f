"""The display list, picking, and pictures without a screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture as Picture
    from bozzetto.scene.display_list import Handle as Handle
    from bozzetto.scene.display_list import Image as Image
    from bozzetto.scene.display_list import Item as Item
    from bozzetto.scene.display_list import Label as Label
    from bozzetto.scene.display_list import Layer as Layer
    from bozzetto.scene.display_list import Lines as Lines
    from bozzetto.scene.display_list import Paint as Paint
    from bozzetto.scene.display_list import Points as Points
    from bozzetto.scene.display_list import Scene as Scene
    from bozzetto.scene.display_list import Shaded as Shaded
    from bozzetto.scene.palette import DARK as DARK
    from bozzetto.scene.palette import LIGHT as LIGHT
    from bozzetto.scene.palette import Palette as Palette
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.images.stored_picture": "Picture",
            "bozzetto.scene.display_list": "Handle Image Item Label Layer Lines Paint "
            "Points Scene Shaded",
            "bozzetto.scene.palette": "DARK LIGHT Palette",
        },
    )
