"""Shapes in space: meshes, curves, placements, and what downstream programs want of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.arrays import frozen as frozen
    from bozzetto.geometry.mesh import Mesh as Mesh
    from bozzetto.geometry.patches.patchwork import Patchwork as Patchwork
    from bozzetto.geometry.placement import Placement as Placement
    from bozzetto.geometry.rig import Rig as Rig
    from bozzetto.geometry.rig import Skin as Skin
    from bozzetto.geometry.shapes import Curve as Curve
    from bozzetto.geometry.shapes import Shapes as Shapes
    from bozzetto.geometry.shapes import Skeleton as Skeleton
    from bozzetto.geometry.shapes import Solid as Solid
    from bozzetto.geometry.shapes import Surface as Surface
    from bozzetto.geometry.texture import Texture as Texture
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.arrays": "frozen",
            "bozzetto.geometry.mesh": "Mesh",
            "bozzetto.geometry.patches.patchwork": "Patchwork",
            "bozzetto.geometry.placement": "Placement",
            "bozzetto.geometry.rig": "Rig Skin",
            "bozzetto.geometry.shapes": "Curve Shapes Skeleton Solid Surface",
            "bozzetto.geometry.texture": "Texture",
        },
    )
