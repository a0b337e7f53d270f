"""Export of a car: what is seen of it, as parts with names and materials; its edges."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Brep, Curve, Patchwork, Shapes
from bozzetto_car.body.body import Body
from bozzetto_car.parts.part_list import added_lines, added_parts, exact_body, wheel_parts
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
    drawn = added_lines(state, body)
    lines += tuple(Curve(3, ONE_SPAN, points, name=name) for name, points in drawn)
    shell = exact_body(state, body) if state.body else None
    works = (shell,) if isinstance(shell, Patchwork) else ()
    solids = (shell,) if isinstance(shell, Brep) else ()
    parts = [*added_parts(state, body), *wheel_parts(state, body)]
    return Shapes(
        curves=lines, patchworks=works, breps=(*solids, *(part.exact() for part in parts))
    )


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
