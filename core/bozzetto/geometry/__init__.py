"""Shapes in space: meshes, curves, placements, and what downstream programs want of them."""

from __future__ import annotations

from bozzetto.arrays import frozen
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Rig, Skin
from bozzetto.geometry.shapes import Curve, Shapes, Skeleton, Solid, Surface
from bozzetto.geometry.texture import Texture

__all__ = [
    "Curve",
    "Mesh",
    "Patchwork",
    "Placement",
    "Rig",
    "Shapes",
    "Skeleton",
    "Skin",
    "Solid",
    "Surface",
    "Texture",
    "frozen",
]
