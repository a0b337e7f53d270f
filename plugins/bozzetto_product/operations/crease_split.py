"""Curves cut where the surface under them has an edge."""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import spline_weights
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.end_moves import moved_to_ends
from bozzetto_product.operations.meetings import curve_of, joint_at, laid_anew, spline_of
from bozzetto_product.operations.pieces import split_curve
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.depth_fit import SAMPLES, at_depth, look_along
from bozzetto_product.projection.ink_curve import creases_along
from bozzetto_product.projection.spline_basis import with_controls
from bozzetto_product.projection.views import seen_at


def split_at_creases(state: ProductState, curve_id: str, scene: Scene) -> ProductState:
    """Return the network with a curve cut where the surface that it was drawn on has an edge.

    A curve over an edge is rounded by its own control points; each of its pieces is laid on its
    side of the edge anew, with the image that it had. Outer ends in joints stay.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    curve_id : str
        Id of the curve.
    scene : Scene
        What it was drawn on.

    Raises
    ------
    UserError
        If it was not drawn, or there is no edge under it.
    """
    curve, spline = curve_of(state, curve_id), spline_of(state, curve_id)
    if not len(curve.strokes):
        raise UserError("This curve was not drawn on a surface. Split it with the tool “Split”.")
    camera = curve.strokes[0].camera
    cuts = creases_along(seen_at(camera, spline.sampled(SAMPLES)), camera, scene)
    if not cuts:
        raise UserError(
            "The surface under this curve has no edge that is seen from where it was drawn. Show "
            "the rough shape, or split the curve with the tool “Split”."
        )
    state, names = split_curve(state, curve_id, cuts)
    made = {}
    for name in names:
        before = spline_of(state, name)
        after = _laid(before, camera, scene)
        ends = after.control_points[[0, -1]]
        inner = (name != names[0] or spline.closed, name != names[-1] or spline.closed)
        for end, is_inner in enumerate(inner):
            if not is_inner and joint_at(state, name, float(end)) is not None:
                ends[end] = before.control_points[-end]
        made[name] = moved_to_ends(after, *ends)
    return settled_state(laid_anew(state, *names), made)


def _laid(spline: Spline, camera: Camera, scene: Scene) -> Spline:
    """Return a piece of a curve at the depth of the surface under all of it, else as it is."""
    # Its few control points made a curve over both faces; on one face it needs some of its own.
    breaks = np.unique(spline.within(spline.knots))
    finer = spline.refined(0.5 * (breaks[:-1] + breaks[1:]))
    at = np.linspace(*spline.range, SAMPLES)
    seen = seen_at(camera, spline.value(at))
    if not np.isfinite(seen).all():
        return spline
    controls = np.linalg.lstsq(spline_weights(finer, at), seen, rcond=None)[0]
    sheet = with_controls(finer, np.asarray(controls, float))
    sight = look_along(sheet, camera, scene)
    # The ends are on the edge itself: rays through them may pass it.
    return at_depth(sheet, camera, sight) if sight.on[2:-2].all() else spline
