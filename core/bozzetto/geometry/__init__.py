"""Shapes in space: meshes, curves, placements, and what downstream programs want of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.arrays import frozen as frozen
    from bozzetto.geometry.brep.brep import Brep as Brep
    from bozzetto.geometry.brep.brep import Face as Face
    from bozzetto.geometry.brep.brep import GapError as GapError
    from bozzetto.geometry.brep.brep import ParameterCurve as ParameterCurve
    from bozzetto.geometry.brep.brep import Trim as Trim
    from bozzetto.geometry.brep.planes import plane_face as plane_face
    from bozzetto.geometry.brep.revolution import cylinder as cylinder
    from bozzetto.geometry.brep.revolution import surface_of_revolution as surface_of_revolution
    from bozzetto.geometry.brep.ruled import ruled_surface as ruled_surface
    from bozzetto.geometry.brep.sewing import sewn as sewn
    from bozzetto.geometry.brep.surface import BSplineSurface as BSplineSurface
    from bozzetto.geometry.brep.tessellation import brep_mesh as brep_mesh
    from bozzetto.geometry.brep.tessellation import counted_mesh as counted_mesh
    from bozzetto.geometry.brep.tessellation import shaded_brep as shaded_brep
    from bozzetto.geometry.brep.tessellation import shaded_faces as shaded_faces
    from bozzetto.geometry.corner_normals import CornerNormals as CornerNormals
    from bozzetto.geometry.curve import Color as Color
    from bozzetto.geometry.curve import Curve as Curve
    from bozzetto.geometry.curve_flattening import FLATNESS as FLATNESS
    from bozzetto.geometry.curve_flattening import flattened as flattened
    from bozzetto.geometry.look import Finish as Finish
    from bozzetto.geometry.look import Look as Look
    from bozzetto.geometry.mesh import Mesh as Mesh
    from bozzetto.geometry.mesh_places import MeshPlaces as MeshPlaces
    from bozzetto.geometry.mesh_places import closest_on_mesh as closest_on_mesh
    from bozzetto.geometry.mesh_places import face_normals as face_normals
    from bozzetto.geometry.mesh_places import mesh_points as mesh_points
    from bozzetto.geometry.meshed_shapes import meshed as meshed
    from bozzetto.geometry.patches.patchwork import Patchwork as Patchwork
    from bozzetto.geometry.placement import Placement as Placement
    from bozzetto.geometry.rig import Clip as Clip
    from bozzetto.geometry.rig import Rig as Rig
    from bozzetto.geometry.rig import Skin as Skin
    from bozzetto.geometry.shapes import FaceGroup as FaceGroup
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
            "bozzetto.geometry.brep.brep": "Brep Face GapError ParameterCurve Trim",
            "bozzetto.geometry.brep.planes": "plane_face",
            "bozzetto.geometry.brep.revolution": "cylinder surface_of_revolution",
            "bozzetto.geometry.brep.ruled": "ruled_surface",
            "bozzetto.geometry.brep.sewing": "sewn",
            "bozzetto.geometry.brep.surface": "BSplineSurface",
            "bozzetto.geometry.brep.tessellation": (
                "brep_mesh counted_mesh shaded_brep shaded_faces"
            ),
            "bozzetto.geometry.corner_normals": "CornerNormals",
            "bozzetto.geometry.curve": "Color Curve",
            "bozzetto.geometry.curve_flattening": "FLATNESS flattened",
            "bozzetto.geometry.look": "Finish Look",
            "bozzetto.geometry.mesh": "Mesh",
            "bozzetto.geometry.mesh_places": "MeshPlaces closest_on_mesh face_normals mesh_points",
            "bozzetto.geometry.patches.patchwork": "Patchwork",
            "bozzetto.geometry.meshed_shapes": "meshed",
            "bozzetto.geometry.placement": "Placement",
            "bozzetto.geometry.rig": "Clip Rig Skin",
            "bozzetto.geometry.shapes": "FaceGroup Shapes Skeleton Solid Surface",
            "bozzetto.geometry.spline": "DEGREE Spline derived_points uniform_knots",
            "bozzetto.geometry.texture": "Texture",
            "bozzetto.geometry.triangulation": "Triangulation ring_links triangulate",
            "bozzetto.geometry.wrap.shrink_wrap": "SHRINK_WRAP_LEVELS curve_distances shrink_wrap",
        },
    )
