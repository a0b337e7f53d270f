"""The body of a car as it is shown and handed over: its network, its surfaces and its cameras."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import Patchwork, crease_angles, extent
from bozzetto.plugin import cached_property
from bozzetto.view.calibration import resect
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.dimensions import Dimensions, measure_dimensions
from bozzetto_car.solver.initial_cameras import counted_marks
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network

REMEMBERED: Final = 1024
"""Number of bodies that are remembered, one after each edit; each takes some kilobytes."""

FEW_REMEMBERED: Final = 8
"""Number of cars that are remembered as the first with their edits, or for what marks tell."""


@dataclass(frozen=True)
class Trouble:
    """An edit that cannot be made any more.

    Attributes
    ----------
    number : int
        Index of the edit in the state.
    message : str
    """

    number: int
    message: str


@dataclass(frozen=True, eq=False)
class Body:
    """A car as it is shown and handed over.

    Attributes
    ----------
    network : Network
    solved : Solved
        The solve that it came from.
    drawn : frozenset of int
        Edges that were drawn or bent by hand.
    traced : tuple of (int, tuple of int)
        Numbers of the edits that traced edges, and these edges.
    troubles : tuple of Trouble
        Edits that were left out.
    world : Dimensions
        Dimensions that it was brought to; none given if it is as it was drawn.
    dimensions_problem : str
        Why the body cannot have the dimensions that are wanted; "" if it can.
    is_dragged : bool
        Whether it is seen only while something is dragged: its edits were carried over from another
        body, or its dimensions are about to change; see `preview_of`.
    """

    network: Network
    solved: Solved
    drawn: frozenset[int] = frozenset()
    traced: tuple[tuple[int, tuple[int, ...]], ...] = ()
    troubles: tuple[Trouble, ...] = ()
    world: Dimensions = Dimensions()
    dimensions_problem: str = ""
    is_dragged: bool = False

    @property
    def template(self) -> Template:
        """The template that names its nodes, edges and patches."""
        return self.network.template

    @cached_property
    def sketch_cameras(self) -> Mapping[str, SketchCamera]:
        """The camera through which each sketch sees this body, by the id of the sketch."""
        sketch_cameras = {key: placed.sketch_camera for key, placed in self.solved.placed.items()}
        return sketch_cameras | _seen_again(self) if self.world.given() else sketch_cameras

    @cached_property
    def nets(self) -> Array:
        """Control nets of the patches, (k, 4, 4, 3) mm."""
        return fair_nets(self.network)

    @cached_property
    def patchwork(self) -> Patchwork:
        """The surfaces as one patchwork, with the names of the patches."""
        names = tuple(patch.name for patch in self.template.patches)
        return Patchwork(
            self.nets,
            self.network.control_points,
            self.template.sides.astype(np.int32),
            self.template.title,
            patch_names=names,
        )

    @cached_property
    def creases(self) -> Array:
        """The crease angle along each edge, (m,) degrees; NaN on the rim."""
        return crease_angles(self.nets, self.template.sides, len(self.template.edges))

    @cached_property
    def dimensions(self) -> Dimensions:
        """The dimensions as measured on the surfaces, mm."""
        front, rear = self.network.positions[self.template.wheels[:, 0], 0]
        return measure_dimensions(extent(self.nets), front, rear)


def _seen_again(body: Body) -> dict[str, SketchCamera]:
    """Find the cameras of the sketches for a body that was stretched after it was drawn."""
    sketch_cameras: dict[str, SketchCamera] = {}
    for key in body.solved.solid:
        placed = body.solved.placed[key]
        nodes, marks = counted_marks(placed, body.template)
        assert placed.resection is not None
        try:
            found = resect(
                body.network.positions[nodes], marks, placed.sketch.size,
                kind=placed.sketch_camera.camera.kind, cropped=placed.sketch.cropped,
                before=replace(placed.resection, disagreeing=()),
            )  # fmt: skip
        except UserError:
            continue  # marks that say too little of another body: it is seen as the one before
        sketch_cameras[key] = SketchCamera.behind(found.camera, found.shift, body.network.positions)
    return sketch_cameras
