"""The styling curves as scene items."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry.patches import Places, points_at
from bozzetto.plugin import remembered
from bozzetto.scene import Item, Lines, Paint
from bozzetto_car.body.body import Body
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve_fit import Course, courses_of
from bozzetto_car.styling.surface_path import join_paths
from bozzetto_car.template.model import MIRROR

WIDTH: Final = 2.0
"""Width of a curve, px."""

CHOSEN_WIDTH: Final = 3.0
"""Width of the chosen curve, px."""

SPACING: Final = 4.0
"""Distance of the vertices of a line that is shown, mm: straight pieces so short look round from
any usual distance."""

REMEMBERED: Final = 16
"""Number of bodies whose styling lines are remembered."""


def shown_styling(state: CarState) -> tuple[StylingCurve, ...]:
    """Return the styling curves that are visible, in the order of the list."""
    return state.shown(StylingCurve)


def styling_items(state: CarState, body: Body) -> tuple[Item, ...]:
    """Return the items of the visible styling curves; mirror images in the second colour.

    All mirror images come first, below the curves: neighbours of one style are drawn at once.
    """
    made: list[Item] = []
    images: list[Item] = []
    for curve, points, starts in _drawn(state, body):
        made.append(_line(points, starts, curve.color or "ink", WIDTH))
        if curve.both:
            images.append(_line(points * MIRROR, starts, "second", WIDTH))
    return (*images, *made)


def chosen_styling(state: CarState, body: Body) -> tuple[Item, ...]:
    """Return the items of the chosen styling curve, which lie over those of all."""
    made: list[Item] = []
    for curve, points, starts in _drawn(state, body):
        if curve.id == state.selected:
            made.append(_line(points, starts, "accent", CHOSEN_WIDTH))
            if curve.both:
                made.insert(0, _line(points * MIRROR, starts, "second", CHOSEN_WIDTH))
    return tuple(made)


def _drawn(state: CarState, body: Body) -> Iterator[tuple[StylingCurve, Array, Index]]:
    """Yield the visible curves with their places on the body, (n, 3) mm, and where lines begin."""
    curves = shown_styling(state)
    for curve, lines in zip(curves, _all_laid_out(curves, body), strict=True):
        if lines:
            yield curve, np.concatenate(lines), np.cumsum([0, *(len(line) for line in lines[:-1])])


def _line(points: Array, starts: Index, paint: Paint, width: float) -> Lines:
    return Lines(points.astype(np.float32), starts.astype(np.int32), color=paint, width=width)


@remembered(limit=REMEMBERED)
def _all_laid_out(curves: tuple[StylingCurve, ...], body: Body) -> tuple[tuple[Array, ...], ...]:
    """Return the parts of curves on a body as polylines."""
    courses = courses_of(curves, body.nets, body.template)
    places = [_sampled(course) for own in courses for course in own]
    if not places:
        return tuple(() for _ in curves)
    ends = np.cumsum([len(own) for own in places])
    lines = iter(np.split(points_at(body.nets, join_paths(places)), ends[:-1]))
    return tuple(tuple(itertools.islice(lines, len(own))) for own in courses)


def _sampled(course: Course) -> Places:
    """Return the places of the polyline that is shown of a line on the body."""
    count = max(2, round(course.length / SPACING))
    along = np.union1d(np.linspace(0.0, course.length, count), course.borders)
    return course.places(along)
