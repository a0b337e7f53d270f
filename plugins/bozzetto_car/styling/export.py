"""Styling curves for export: splines in space, named and coloured."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.geometry import Curve
from bozzetto_car.array_types import Array
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.curve_fit import courses_on, spline_of
from bozzetto_car.styling.surface_path import is_closed
from bozzetto_car.template.model import MIRROR, Template


def as_curves(curve: StylingCurve, nets: Array, template: Template) -> tuple[Curve, ...]:
    """Return a styling curve on a body, with its mirror image where it is on both sides.

    Parameters
    ----------
    curve : StylingCurve
        The styling curve.
    nets : (k, 4, 4, 3) float
        Control nets of the body, mm.
    template : Template
        The template of the body.

    Returns
    -------
    tuple of Curve
        Cubic splines; one for each part, if the body lacks some of the curve's patches. Mirror
        images have the same numbers but for the sign of y.
    """
    made = [
        replace(
            spline_of(nets, course).to_curve(curve.name, curve.color),
            closed=is_closed(nets, course.path),
        )
        for course in courses_on(curve, nets, template)
    ]
    if not curve.both:
        return tuple(made)
    images = (
        replace(one, name=f"{one.name} mirrored", control_points=one.control_points * MIRROR)
        for one in made
    )
    return (*made, *images)
