"""Bicubic patches that share their edges: places on them, rays, creases, curvature, triangles."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.geometry.patches.closest_points import foot_points as foot_points
    from bozzetto.geometry.patches.coons import coons_nets as coons_nets
    from bozzetto.geometry.patches.coons import sides_of as sides_of
    from bozzetto.geometry.patches.crease import SMOOTH as SMOOTH
    from bozzetto.geometry.patches.crease import crease_angles as crease_angles
    from bozzetto.geometry.patches.crease import joint_rows as joint_rows
    from bozzetto.geometry.patches.crease import locked as locked
    from bozzetto.geometry.patches.curvature import Curvatures as Curvatures
    from bozzetto.geometry.patches.curvature import grid_curvatures as grid_curvatures
    from bozzetto.geometry.patches.patch import Places as Places
    from bozzetto.geometry.patches.patch import bernstein as bernstein
    from bozzetto.geometry.patches.patch import extent as extent
    from bozzetto.geometry.patches.patch import grid as grid
    from bozzetto.geometry.patches.patch import normals_at as normals_at
    from bozzetto.geometry.patches.patch import points_at as points_at
    from bozzetto.geometry.patches.patchwork import Patchwork as Patchwork
    from bozzetto.geometry.patches.ray_intersections import ray_hits as ray_hits
    from bozzetto.geometry.patches.tessellation import shaded as shaded
    from bozzetto.geometry.patches.tessellation import shaded_parameters as shaded_parameters
    from bozzetto.geometry.patches.tessellation import tessellated as tessellated
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.geometry.patches.closest_points": "foot_points",
            "bozzetto.geometry.patches.coons": "coons_nets sides_of",
            "bozzetto.geometry.patches.crease": "SMOOTH crease_angles joint_rows locked",
            "bozzetto.geometry.patches.curvature": "Curvatures grid_curvatures",
            "bozzetto.geometry.patches.patch": "Places bernstein extent grid normals_at points_at",
            "bozzetto.geometry.patches.patchwork": "Patchwork",
            "bozzetto.geometry.patches.ray_intersections": "ray_hits",
            "bozzetto.geometry.patches.tessellation": "shaded shaded_parameters tessellated",
        },
    )
