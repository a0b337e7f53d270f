"""Context of a gesture: the world around, as far as a tool may ask."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from bozzetto.geometry.shapes import Curve, Shapes
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing
from bozzetto.plugin.lazy_curves import LazyCurves
from bozzetto.scene.display_list import Image, Layer, Scene, Shaded
from bozzetto.scene.ink_projection import ProjectedInk, project_stroke
from bozzetto.scene.picking import Hits, cast_rays
from bozzetto.view.camera import Camera, Rays
from bozzetto.view.rotations import triple

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.host.listing import TemplateFile


@dataclass(frozen=True)
class PenSettings:
    """Settings of the pen and of the hand that draws.

    Parameters
    ----------
    tolerance : float
        Distance (pixels) below which two places on the sheet count as the same.
    """

    tolerance: float = 6.0


@dataclass(frozen=True)
class Context:
    """The world around a gesture, frozen at the moment it was made.

    Parameters
    ----------
    camera : Camera
        The view now (a gesture carries its own).
    scene : Scene
        All that is visible, in world coordinates. Where steps of an ink file are taken it is made
        when a tool first looks at it: who needs no surface under the pen does not wait for one.
    pen : PenSettings
    symmetry_point, symmetry_normal : (x, y, z)
        The plane of bilateral symmetry, mm.
    underlay : Image, optional
        The picture under the sheet, if any.
    facts : mapping
        What an ink file says beyond its strokes (`Drawing.facts`), plain JSON values; empty
        where nothing is read from a file. For `Modeler.create`.
    curves : sequence of Curve
        Those of all visible models that are solved, in world coordinates: to snap to, and to
        start from. Where steps of an ink file are taken they are learnt when a tool first asks.
    pictures : mapping of str to Picture
        Those that `facts` name, by the names of their files as they stand there.
    drawings : mapping of str to Drawing
        Those that `facts` name, by the names of their files as they stand there.
    seen : tuple
        States in which the model was a moment ago, newest first, while the view was pinned to it or
        showed it as it was drawn (`ViewAdvice.pinned`, `ViewAdvice.as_drawn`): a hand that is
        quicker than the view draws on what it saw.
    alone : bool
        Whether nothing is visible but this model. Then it may be put elsewhere in space, for the
        view can go along (`ViewAdvice.as_drawn`).
    sources : mapping of str to Shapes
        What the models hand over that `Modeler.sources` names, by their ids, as they were when
        this model was solved last; mm, in the frame of the model, as `Job.sources`. Empty before.
    file : str
        Name, without its ending, of the file that a command writes (`Command.writes`); else "".
    templates : sequence of TemplateFile
        Files that plugins bring for models of this modeler to begin with, where one is read from a
        file; see ``[templates]`` of the manifest.
    """

    camera: Camera = field(default_factory=Camera)
    scene: Scene = field(default_factory=Scene)
    pen: PenSettings = field(default_factory=PenSettings)
    symmetry_point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    symmetry_normal: tuple[float, float, float] = (0.0, 1.0, 0.0)
    underlay: Image | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    curves: Sequence[Curve] = ()
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    drawings: Mapping[str, Drawing] = field(default_factory=dict)
    seen: tuple[Any, ...] = ()
    alone: bool = False
    sources: Mapping[str, Shapes] = field(default_factory=dict)
    file: str = ""
    templates: Sequence[TemplateFile] = ()

    @property
    def has_surface(self) -> bool:
        """Whether anything is visible that ink can be laid on."""
        return any(isinstance(item, Shaded) and item.pickable for _, item in self.scene.items())

    def surface_hit(self, rays: Rays) -> Hits:
        """Find where rays first meet a visible surface, whoever made it."""
        return cast_rays(self.scene, rays)

    def project(
        self, stroke: Stroke, *, models: Collection[str] | None = None, bridge: float = 0.0
    ) -> ProjectedInk:
        """Project a stroke on the visible surfaces under it, whoever made them.

        Parameters
        ----------
        stroke : Stroke
            As a gesture brings it, with the camera that it was drawn through.
        models : collection of str, optional
            Ids of the models whose surfaces count; default all.
        bridge : float
            Longest way beside the surface, px, over which the ink is continued in its tangent
            plane; see `bozzetto.scene.project_stroke`.
        """
        return project_stroke(stroke, self.scene, models=models, bridge=bridge)

    def moved(self, placement: Placement) -> Context:
        """Return the world as it is seen from a frame in which everything is moved."""
        underlay = self.underlay
        if underlay is not None:
            (layer,) = Scene((Layer("underlay", (underlay,)),)).placed(placement).layers
            (underlay,) = (item for item in layer.items if isinstance(item, Image))
        return replace(
            self,
            camera=self.camera.moved(placement),
            scene=self.scene.placed(placement),
            symmetry_point=triple(placement.points(self.symmetry_point)),
            symmetry_normal=triple(placement.directions(self.symmetry_normal)),
            underlay=underlay,
            curves=_moved(self.curves, placement),
        )


def _moved(curves: Sequence[Curve], placement: Placement) -> Sequence[Curve]:
    """Return curves moved by a placement; those that are put off stay so."""
    if isinstance(curves, LazyCurves):
        return LazyCurves(lambda: Shapes(curves=tuple(curves)).placed(placement).curves)
    return Shapes(curves=tuple(curves)).placed(placement).curves
