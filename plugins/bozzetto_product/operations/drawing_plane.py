"""The plane that a new curve is drawn in."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.scene import Scene
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.projection.planes import LOOKS, plane_standing_on, plane_through
from bozzetto_product.projection.sheet_curve import curve_on_sheet


def drawing_plane(state: ProductState, strokes: Sequence[Stroke], scene: Scene) -> Plane | None:
    """Return the plane in which strokes make a curve; None where they lie on the surface.

    Parameters
    ----------
    state : ProductState
        Says how new curves lie.
    strokes : sequence of Stroke
        Of one curve, drawn in one view.
    scene : Scene
        What they are drawn on.

    Raises
    ------
    UserError
        If the plane is not determined, or none is set.
    """
    if state.lay == "plane":
        return plane_of_places(state)
    if state.lay == "upright":
        sheet = curve_on_sheet(strokes)
        x, y = sheet.spline.sampled(LOOKS).T
        return plane_standing_on(Stroke(x, y, sheet.camera), scene)
    return None


def plane_of_places(state: ProductState) -> Plane:
    """Return the plane of the three places that were touched.

    Raises
    ------
    UserError
        If less than three were.
    """
    if len(state.plane_places) < 3:
        raise UserError(
            "No plane is set. Touch three places with the tool “Plane”, or let new curves lie on "
            "the surface."
        )
    return plane_through(state.plane_places)
