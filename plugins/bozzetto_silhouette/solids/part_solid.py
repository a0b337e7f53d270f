"""The solid of a part, remembered by its recipe, and the body that can be combined."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.plugin import remembered
from bozzetto_silhouette.inflation.heightfield import Relief
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights, HeightModel
from bozzetto_silhouette.inflation.membrane import MembraneHeights
from bozzetto_silhouette.inflation.pen_pressure import PenPressure
from bozzetto_silhouette.inflation.profile import profile_of
from bozzetto_silhouette.inflation.solidify import Checkpoint, SilhouetteSolid, ignore, solidify
from bozzetto_silhouette.inflation.thickness import InTurn, Thickness, Uniform
from bozzetto_silhouette.inflation.variational_relief import VariationalHeights
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.extrude import straight_body
from bozzetto_silhouette.solids.surface_constraints import constraints_on

if TYPE_CHECKING:
    from bozzetto_silhouette.implicit.interpolation_constraints import Constraints


def _recipe(part: Part, resolution: int, checkpoint: Checkpoint) -> Hashable:
    return part.recipe, resolution


@remembered(limit=256, key=_recipe)
def solid_of(part: Part, resolution: int, checkpoint: Checkpoint = ignore) -> SilhouetteSolid:
    """Return the solid of a part in its object frame, at a resolution; remembered.

    Raises
    ------
    UserError
        If the part's ink is no outline.
    """
    return solidify(
        outline_of(part),
        resolution=resolution,
        height_model=_height_model(part),
        thickness=_thickness(part),
        rule=part.skeleton,
        checkpoint=checkpoint,
    )


def body_of(part: Part, resolution: int, checkpoint: Checkpoint = ignore) -> Body:
    """Return a part as a body, in the frame of its group; a slab where it goes straight through."""
    if part.surface == "straight":
        return straight_body(part, None, resolution)
    return _placed(_at_rest(part, resolution, checkpoint), part)


@dataclass(frozen=True, eq=False)
class _AtRest:
    """What a part's body is made of, wherever it stands: the same for all parts drawn alike.

    What is moved or mirrored keeps the function of space that was fitted to it.
    """

    solid: SilhouetteSolid
    relief: Relief
    constraints: Constraints | None


# A drag makes one at every move of the pen.
@remembered(limit=256, key=lambda rest, part: (rest, part.id, part.pose))
def _placed(rest: _AtRest, part: Part) -> Body:
    solid = rest.solid
    body = Body(
        solid.vertices,
        solid.faces,
        solid.normals,
        np.zeros(len(solid.vertices), np.int32),
        (part.id,),
        rest.relief,
        float(solid.skeleton.nodes[:, 2].max()),
        solid.step,
        constraints=rest.constraints,
        solid=solid,
    )
    return body.placed(part.placement)


@remembered(limit=256, key=_recipe)
def _at_rest(part: Part, resolution: int, checkpoint: Checkpoint) -> _AtRest:
    solid = solid_of(part, resolution, checkpoint)
    relief = Relief(solid)
    interpolates = part.surface == "variational"
    return _AtRest(solid, relief, constraints_on(solid, relief) if interpolates else None)


def _height_model(part: Part) -> HeightModel:
    if part.surface == "variational":
        return VariationalHeights()
    if part.surface == "inflation":
        return MembraneHeights()
    return ConvolutionHeights(part.softness, part.kernel)


def _thickness(part: Part) -> Thickness:
    steps: list[Thickness] = [Uniform(part.inflation)]
    if part.pressure > 0.0:
        steps.append(PenPressure.of(part))
    if len(part.profile):
        steps.append(profile_of(part))
    return InTurn(tuple(steps)) if len(steps) > 1 else steps[0]
