"""Export of a car: its surfaces, its edges, and the styling curves."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Curve, Shapes
from bozzetto_car.body.build import Body
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.parts.trim import shut_lines, trim_of
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.state import CarState
from bozzetto_car.styling.curve_fit import as_curves
from bozzetto_car.styling.scene import shown_styling

ONE_SPAN = np.repeat((0.0, 1.0), 4)
"""Knots of a cubic of one span."""


def shapes_of(state: CarState, body: Body) -> Shapes:
    """Return the body, unless it is hidden, and the visible styling curves.

    The body is one shell of surfaces; of a complete car it is a closed one, beside its trim, its
    shut lines, and its wheels where these are shown. A car that nobody has begun exports nothing:
    the template is nobody's design.

    Raises
    ------
    UserError
        If a complete body cannot be closed.
    """
    lines = styling_curves(state, body)
    if not (state.body and state.is_begun):
        return Shapes(curves=lines)
    if not state.complete:
        return Shapes(curves=lines, patchworks=(body.patchwork,))
    network, nets = body.network, body.nets
    wheels = wheels_of(network, nets) if state.wheels else []
    trim = trim_of(network, nets, with_mirrors=state.mirrors)
    shut = (Curve(3, ONE_SPAN, points, name=name) for name, points in shut_lines(network, nets))
    return Shapes(curves=(*lines, *shut), breps=(closed_body(network, nets), *wheels, *trim))


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
