"""Whether something was taken away, and whether something is left."""

from __future__ import annotations

from bozzetto.errors import UserError
from bozzetto_silhouette.inflation.manifold_check import volume_of
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.view.picking import shape_seen

__all__ = ["check_that_it_carves", "volume_left"]

NOTHING = 1e-6
"""Share of the volume that counts as nothing."""


def volume_left(state: SilhouetteState) -> float:
    """Volume of the whole shape, mm³; 0 where there is none."""
    touch = shape_seen(state)
    return 0.0 if touch is None else volume_of(touch.body.vertices, touch.body.faces)


def check_that_it_carves(before: SilhouetteState, after: SilhouetteState) -> float:
    """The volume that is left.

    Raises
    ------
    UserError
        If there was nothing before, or nothing was taken away, or nothing is left.
    """
    whole = volume_left(before)
    if not whole > 0.0:
        raise UserError("There is nothing to cut yet. Draw a shape first.")
    left = volume_left(after)
    if left >= (1.0 - NOTHING) * whole:
        raise UserError("This passes the shape by. Draw it over the shape.")
    if left <= NOTHING * whole:
        raise UserError("Nothing of the shape would be left. Draw it over a part of the shape.")
    return left
