"""The display list, picking, ink on surfaces, and pictures without a screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture as Picture
    from bozzetto.scene.display_list import Handle as Handle
    from bozzetto.scene.display_list import Hidden as Hidden
    from bozzetto.scene.display_list import Image as Image
    from bozzetto.scene.display_list import Item as Item
    from bozzetto.scene.display_list import Label as Label
    from bozzetto.scene.display_list import Layer as Layer
    from bozzetto.scene.display_list import Lines as Lines
    from bozzetto.scene.display_list import Paint as Paint
    from bozzetto.scene.display_list import Points as Points
    from bozzetto.scene.display_list import Scene as Scene
    from bozzetto.scene.display_list import Shaded as Shaded
    from bozzetto.scene.ink_projection import InkBreak as InkBreak
    from bozzetto.scene.ink_projection import InkRun as InkRun
    from bozzetto.scene.ink_projection import ProjectedInk as ProjectedInk
    from bozzetto.scene.ink_projection import project_stroke as project_stroke
    from bozzetto.scene.palette import DARK as DARK
    from bozzetto.scene.palette import LIGHT as LIGHT
    from bozzetto.scene.palette import Palette as Palette
    from bozzetto.scene.part_display import SHOWN_FINISHES as SHOWN_FINISHES
    from bozzetto.scene.part_display import in_look as in_look
    from bozzetto.scene.part_display import shaded_part as shaded_part
    from bozzetto.scene.picking import Hits as Hits
    from bozzetto.scene.picking import SceneSurface as SceneSurface
    from bozzetto.scene.picking import cast_rays as cast_rays
    from bozzetto.scene.renderer.renderer import render as render
    from bozzetto.scene.renderer.zbuffer import DepthBuffer as DepthBuffer
    from bozzetto.scene.renderer.zbuffer import blank_buffer as blank_buffer
    from bozzetto.scene.renderer.zbuffer import rasterize as rasterize
    from bozzetto.scene.surface_places import FollowedPlaces as FollowedPlaces
    from bozzetto.scene.surface_places import SurfacePlaces as SurfacePlaces
    from bozzetto.scene.surface_places import follow as follow
    from bozzetto.scene.surface_places import located as located
    from bozzetto.scene.surface_places import surface_mesh as surface_mesh
    from bozzetto.scene.surface_places import topology_of as topology_of
    from bozzetto.scene.surface_runs import depth_breaks as depth_breaks
    from bozzetto.scene.surface_runs import unbroken_runs as unbroken_runs
    from bozzetto.scene.wall_thickness import Walls as Walls
    from bozzetto.scene.wall_thickness import walls_of as walls_of
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.images.stored_picture": "Picture",
            "bozzetto.scene.display_list": "Handle Hidden Image Item Label Layer Lines Paint "
            "Points Scene Shaded",
            "bozzetto.scene.ink_projection": "InkBreak InkRun ProjectedInk project_stroke",
            "bozzetto.scene.palette": "DARK LIGHT Palette",
            "bozzetto.scene.picking": "Hits SceneSurface cast_rays",
            "bozzetto.scene.renderer.renderer": "render",
            "bozzetto.scene.renderer.zbuffer": "DepthBuffer blank_buffer rasterize",
            "bozzetto.scene.part_display": "SHOWN_FINISHES in_look shaded_part",
            "bozzetto.scene.surface_places": "FollowedPlaces SurfacePlaces follow located "
            "surface_mesh topology_of",
            "bozzetto.scene.surface_runs": "depth_breaks unbroken_runs",
            "bozzetto.scene.wall_thickness": "Walls walls_of",
        },
    )
