"""The smooth course of a line on the body, and the spline that other programs get.

Between two places the line is a cubic spline in u and v over its length, patch by patch: it is on
the surface everywhere and passes through its places. A spline in space is on the surface only at
its knots; between them it is within a tolerance.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import DEGREE, Curve, Spline
from bozzetto.geometry.patches import Places, points_at
from bozzetto.ink import arc_length
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.cubic_splines import not_a_knot_splines
from bozzetto_car.styling.curve import curve_paths
from bozzetto_car.styling.surface_path import SAME, is_closed, join_paths
from bozzetto_car.template.model import MIRROR, Template

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


TOLERANCE: Final = 0.005
"""Largest distance, mm, between an exported spline and the line on the body."""

LOOKS: Final = (0.25, 0.5, 0.75)
"""Shares of a span at which that distance is measured."""

BEGUN: Final = 4
"""Number of spans over one patch that the fit of a spline starts with."""

ROUNDS: Final = 12
"""Most times that spans are halved."""

CORNER: Final = 2.0
"""Angle, degrees, from which the line has a corner where it crosses an edge of the body."""

CLOSE: Final = 0.01
"""Distance, mm, before and after an edge of the body at which the directions are compared."""


@dataclass(frozen=True, eq=False)
class Course:
    """A line on the body, parametrized by its length.

    Attributes
    ----------
    along : (n,) float
        Length of the polygon up to each place, mm; crossings are there twice.
    path : Places
    borders : (r + 1,) float
        Lengths at which the runs over one patch begin and end, mm.
    """

    along: Array
    path: Places
    borders: Array
    _pieces: _Pieces

    @property
    def length(self) -> float:
        """The length of the whole line, mm."""
        return float(self.borders[-1])

    def places(self, along: Array) -> Places:
        """Return the places on the body at lengths (m,), mm, that do not decrease."""
        return self._pieces.places(along)


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Cubic pieces of a line in u and v, one after the other.

    Attributes
    ----------
    begins : (m,) float
        Length at which each piece begins to count, mm.
    knots : (m,) float
        Length from which its powers count, mm: the same, but for pieces whose first place was
        left out.
    patches : (m,) int
    coefficients : (4, m, 2) float
        Of the powers 3, 2, 1 and 0.
    """

    begins: Array
    knots: Array
    patches: Index
    coefficients: Array

    def places(self, along: Array) -> Places:
        which = np.maximum(np.searchsorted(self.begins, along, "right") - 1, 0)
        step = (along - self.knots[which])[:, None]
        third, second, first, zeroth = self.coefficients[:, which]
        at = ((third * step + second) * step + first) * step + zeroth
        return Places(self.patches[which], np.clip(at, 0.0, 1.0))


def courses_on(curve: StylingCurve, nets: Array, template: Template) -> list[Course]:
    """Return the courses of a styling curve on a body: one, if the body has all of its patches.

    Parameters
    ----------
    curve : StylingCurve
        The styling curve.
    nets : (k, 4, 4, 3) float
        Control nets of the body, mm.
    template : Template
        The template of the body.
    """
    return courses_of((curve,), nets, template)[0]


def courses_of(
    curves: Sequence[StylingCurve], nets: Array, template: Template
) -> list[list[Course]]:
    """Return the courses of several styling curves; see `courses_on`.

    The splines of all of them are found at once: while a body is dragged, numpy's time goes into
    the calls.
    """
    paths = [(owner, path) for owner, curve in enumerate(curves)
             for path in curve_paths(curve, nets, template)]  # fmt: skip
    if not paths:
        return [[] for _ in curves]
    ends = np.cumsum([len(path) for _, path in paths])
    points = np.split(points_at(nets, join_paths([path for _, path in paths])), ends[:-1])
    drafts: list[tuple[int, Places, Array, Array, list[int]]] = []
    runs: list[tuple[Array, Array]] = []
    patches: list[int] = []
    for (owner, path), own in zip(paths, points, strict=True):
        along = arc_length(own)
        cuts = [0, *(np.flatnonzero(np.diff(path.patches)) + 1).tolist(), len(path)]
        numbers, borders = [], [0.0]
        for first, last in itertools.pairwise(cuts):
            kept = first + np.flatnonzero(np.append(np.diff(along[first:last]) > SAME, True))
            if len(kept) > 1:
                numbers.append(len(runs))
                runs.append((along[kept], path.parameters[kept]))
                patches.append(int(path.patches[first]))
                borders.append(float(along[last - 1]))
        if numbers:
            drafts.append((owner, path, along, np.array(borders), numbers))
    splines = not_a_knot_splines(runs)
    courses: list[list[Course]] = [[] for _ in curves]
    for owner, path, along, limits, numbers in drafts:
        begins = [runs[number][0][:-1].copy() for number in numbers]
        for own, border in zip(begins, limits[:-1], strict=True):
            own[0] = border
        pieces = _Pieces(
            np.concatenate(begins),
            np.concatenate([runs[number][0][:-1] for number in numbers]),
            np.repeat([patches[number] for number in numbers], [len(own) for own in begins]),
            np.concatenate([splines[number] for number in numbers], axis=1),
        )
        courses[owner].append(Course(along, path, limits, pieces))
    return courses


def spline_of(nets: Array, course: Course) -> Spline:
    """Return a cubic spline through places of a line on the body.

    Its knots are as far apart as `TOLERANCE` allows. Where the line has a corner on an edge of
    the body, the spline has one, too (a knot of multiplicity three); elsewhere its curvature
    is continuous.
    """
    corners = _corners(nets, course)
    knots, points = [np.repeat(corners[0], DEGREE + 1)], []
    for begin, end in itertools.pairwise(corners):
        piece = _interpolated(nets, course, begin, end)
        knots += [piece.t[DEGREE + 1 : -DEGREE - 1], np.repeat(end, DEGREE)]
        points.append(piece.c[:-1] if end < corners[-1] else piece.c)
    return Spline(np.append(np.concatenate(knots), corners[-1]), np.vstack(points))


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


def _interpolated(nets: Array, course: Course, begin: float, end: float) -> BSpline:
    """Return a spline with continuous curvature along a part of the line without corners."""
    from scipy.interpolate import make_interp_spline

    inner = course.borders[(course.borders > begin) & (course.borders < end)]
    borders = np.concatenate(([begin], inner, [end]))
    first, width = np.repeat(borders[:-1], BEGUN), np.repeat(np.diff(borders) / BEGUN, BEGUN)
    sites = np.append(first + width * np.tile(np.arange(BEGUN), len(borders) - 1), end)
    looks = np.array(LOOKS)
    for _ in range(ROUNDS):
        spline = make_interp_spline(sites, points_at(nets, course.places(sites)), DEGREE)
        spans = np.diff(sites)
        between = sites[:-1, None] + spans[:, None] * looks
        there = points_at(nets, course.places(between.ravel()))
        away = np.linalg.norm(spline(between.ravel()) - there, axis=1).reshape(-1, len(looks))
        wide = away.max(axis=1) > TOLERANCE
        if not wide.any():
            break
        sites = np.sort(np.append(sites, sites[:-1][wide] + 0.5 * spans[wide]))
    return spline


def _corners(nets: Array, course: Course) -> list[float]:
    """Return both ends of a line and its corners, mm along it."""
    found = [0.0, course.length]
    for before, border, after in zip(
        course.borders[:-2], course.borders[1:-1], course.borders[2:], strict=True
    ):
        step = min(CLOSE, 0.5 * (border - before), 0.5 * (after - border))
        points = points_at(nets, course.places(border + np.array([-step, 0.0, step])))
        one, other = np.diff(points, axis=0)
        angle = np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other)
        if np.degrees(angle) > CORNER:
            found.append(float(border))
    return sorted(found)
