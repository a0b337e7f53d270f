"""Shapes in space: meshes, curves, placements, and what downstream programs want of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.arrays import frozen as frozen
    from bozzetto.geometry.curve_flattening import FLATNESS as FLATNESS
    from bozzetto.geometry.curve_flattening import flattened as flattened
    from bozzetto.geometry.mesh import Mesh as Mesh
    from bozzetto.geometry.mesh_places import MeshPlaces as MeshPlaces
    from bozzetto.geometry.mesh_places import closest_on_mesh as closest_on_mesh
    from bozzetto.geometry.mesh_places import face_normals as face_normals
    from bozzetto.geometry.mesh_places import mesh_points as mesh_points
    from bozzetto.geometry.patches.patchwork import Patchwork as Patchwork
    from bozzetto.geometry.placement import Placement as Placement
    from bozzetto.geometry.rig import Rig as Rig
    from bozzetto.geometry.rig import Skin as Skin
    from bozzetto.geometry.shapes import Color as Color
    from bozzetto.geometry.shapes import Curve as Curve
    from bozzetto.geometry.shapes import Shapes as Shapes
    from bozzetto.geometry.shapes import Skeleton as Skeleton
    from bozzetto.geometry.shapes import Solid as Solid
    from bozzetto.geometry.shapes import Surface as Surface
    from bozzetto.geometry.spline import DEGREE as DEGREE
    from bozzetto.geometry.spline import Spline as Spline
    from bozzetto.geometry.spline import derived_points as derived_points
    from bozzetto.geometry.spline import uniform_knots as uniform_knots
    from bozzetto.geometry.texture import Texture as Texture
    from bozzetto.geometry.triangulation import Triangulation as Triangulation
    from bozzetto.geometry.triangulation import ring_links as ring_links
    from bozzetto.geometry.triangulation import triangulate as triangulate
    from bozzetto.geometry.wrap.shrink_wrap import SHRINK_WRAP_LEVELS as SHRINK_WRAP_LEVELS
    from bozzetto.geometry.wrap.shrink_wrap import curve_distances as curve_distances
    from bozzetto.geometry.wrap.shrink_wrap import shrink_wrap as shrink_wrap
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.arrays": "frozen",
            "bozzetto.geometry.curve_flattening": "FLATNESS flattened",
            "bozzetto.geometry.mesh": "Mesh",
            "bozzetto.geometry.mesh_places": "MeshPlaces closest_on_mesh face_normals mesh_points",
            "bozzetto.geometry.patches.patchwork": "Patchwork",
            "bozzetto.geometry.placement": "Placement",
            "bozzetto.geometry.rig": "Rig Skin",
            "bozzetto.geometry.shapes": "Color Curve Shapes Skeleton Solid Surface",
            "bozzetto.geometry.spline": "DEGREE Spline derived_points uniform_knots",
            "bozzetto.geometry.texture": "Texture",
            "bozzetto.geometry.triangulation": "Triangulation ring_links triangulate",
            "bozzetto.geometry.wrap.shrink_wrap": "SHRINK_WRAP_LEVELS curve_distances shrink_wrap",
        },
    )
