"""What a car exports: its surfaces, its edges, and the styling curves."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Curve, Shapes
from bozzetto_car.body.build import Body
from bozzetto_car.state import CarState
from bozzetto_car.styling.curve_fit import as_curves
from bozzetto_car.styling.scene import shown_styling

ONE_SPAN = np.repeat((0.0, 1.0), 4)
"""Knots of a cubic of one span."""


def shapes_of(state: CarState, body: Body) -> Shapes:
    """Return the surfaces as one shell, unless they are hidden, and the visible styling curves.

    A car that nobody has begun exports nothing: the template is nobody's design.
    """
    skin = (body.patchwork,) if state.body and state.is_begun else ()
    return Shapes(curves=styling_curves(state, body), patchworks=skin)


def curves_of(state: CarState, body: Body) -> tuple[Curve, ...]:
    """Return the edges of the body and the visible styling curves."""
    if not state.is_begun:
        return ()
    edges = tuple(
        Curve(3, ONE_SPAN, points, name=name)
        for name, points in zip(body.template.edge_names, body.network.control_points, strict=True)
    )
    return (*edges, *styling_curves(state, body))


def styling_curves(state: CarState, body: Body) -> tuple[Curve, ...]:
    """Return the visible styling curves, and their mirror images where they have some."""
    shown = shown_styling(state)
    return tuple(line for c in shown for line in as_curves(c, body.nets, body.template))
