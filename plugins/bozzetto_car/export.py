"""Export of a car: what is seen of it, as parts with names and materials; its edges."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain

import numpy as np

from bozzetto.geometry import Curve, Patchwork, Shapes
from bozzetto_car.body.build import Body
from bozzetto_car.body.wheels import on_tyres
from bozzetto_car.parts.body_lines import body_lines
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.parts.looks import GLASS, PAINT
from bozzetto_car.parts.trim import shut_lines, trim_of
from bozzetto_car.parts.wheel_arches import cut_panels
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.parts.windows import inserts
from bozzetto_car.state import CarState
from bozzetto_car.styling.curve_fit import as_curves
from bozzetto_car.styling.scene import shown_styling

ONE_SPAN = np.repeat((0.0, 1.0), 4)
"""Knots of a cubic of one span."""


def shapes_of(state: CarState, body: Body) -> Shapes:
    """Return the car as it is seen: its body, its wheels, and the visible styling curves.

    The body is one shell of surfaces; of a complete car it is a closed one, beside its panes,
    lamps and trim, and its lines. Whatever is hidden stays out. A car that nobody has begun
    exports nothing: the template is nobody's design.

    Raises
    ------
    UserError
        If a complete body cannot be closed.
    """
    lines = styling_curves(state, body)
    if not state.is_begun:
        return Shapes(curves=lines)
    network, nets = on_tyres(body.network, state.tyre), body.nets
    sunk = state.complete and state.body
    wheels = wheels_of(network, nets, state.tyre, sunk=sunk) if state.wheels else []
    if not state.body:
        return Shapes(curves=lines, breps=tuple(wheels))
    if not state.complete:
        return Shapes(curves=lines, patchworks=(_panels(body),), breps=tuple(wheels))
    trim = trim_of(network, nets, with_mirrors=state.mirrors)
    drawn = chain(shut_lines(network, nets), body_lines(network, nets, cut_panels(network, nets)))
    lines += tuple(Curve(3, ONE_SPAN, points, name=name) for name, points in drawn)
    solids = (closed_body(network, nets), *inserts(network, nets), *wheels, *trim)
    return Shapes(curves=lines, breps=solids)


def _panels(body: Body) -> Patchwork:
    """Return the surfaces with the material of each panel; paint is of the object's colour."""
    paint = PAINT._replace(color=None)
    looks = (GLASS if patch.glass else paint for patch in body.template.patches)
    return replace(body.patchwork, patch_looks=tuple(looks))


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
