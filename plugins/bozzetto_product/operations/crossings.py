"""Places where curves cross, or nearly do: they are joined there, so that loops can turn there."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import meeting_place, share_at, splines_of
from bozzetto_product.operations.own_crossings import own_crossings
from bozzetto_product.projection.planes import mirror_image
from bozzetto_product.projection.spline_basis import chord_length

PIECES: Final = 8
"""Segments by which a span of a curve is known: a crossing is found from its nearest corner."""

STEPS: Final = 12
"""Steps of Newton's method to the places where two curves are closest."""

FLATTEST: Final = float(np.sin(np.radians(15.0)))
"""Sine of the least angle of a crossing: what runs along a curve does not cross it."""

APART: Final = 2.0
"""Least distance, in gaps, from other joints of the two curves."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """Two curves that cross, or one that crosses itself.

    Attributes
    ----------
    meetings : (Meeting, Meeting)
        Where, on either.
    place : (3,) float
        Between them, mm: nearer to the longer curve.
    """

    meetings: tuple[Meeting, Meeting]
    place: Array


@dataclass(frozen=True, eq=False)
class _Course:
    """A curve, or its mirror image, with places along it."""

    name: str
    mirrored: bool
    spline: Spline
    at: Array
    points: Array
    length: float
    low: Array
    high: Array


def crossings_of(
    state: ProductState, gap: float, only: Collection[str] | None = None
) -> list[Crossing]:
    """Find where the insides of curves cross, or one crosses itself, that are not joined there.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    gap : float
        Largest distance between the curves, mm.
    only : collection of str, optional
        Ids of curves: only their crossings.

    Returns
    -------
    list of Crossing
    """
    found: list[Crossing] = []
    taken = _joined_places(state.joints, state)
    for one, other in _near_pairs(state, gap):
        if only is not None and one.name not in only and other.name not in only:
            continue
        known = [place for names, place in taken if {one.name, other.name} <= names]
        for first, second in _closest_places(one, other, gap):
            crossing = _crossing(one, other, first, second, gap)
            if crossing is None:
                continue
            near = [np.linalg.norm(place - crossing.place) for place in known]
            if min(near, default=np.inf) > APART * gap:
                known.append(crossing.place)
                found.append(crossing)
    for name, spline in splines_of(state).items():
        if only is None or name in only:
            known = [place for names, place in taken if name in names]
            found.extend(_of_itself(name, spline, gap, known))
    return found


def _of_itself(name: str, spline: Spline, gap: float, known: Sequence[Array]) -> Iterator[Crossing]:
    """Yield where a curve crosses itself and is not joined."""
    for first, second, place in own_crossings(spline, gap):
        near = [np.linalg.norm(other - place) for other in known]
        if min(near, default=np.inf) > APART * gap:
            yield Crossing((Meeting(name, first), Meeting(name, second)), place)


def _near_pairs(state: ProductState, gap: float) -> Iterator[tuple[_Course, _Course]]:
    """Yield pairs of curves whose boxes are near; a mirror image only as the second."""
    own: list[_Course] = []
    images: dict[str, _Course] = {}
    for curve in state.of_kind(Curve):
        if curve.spline is None:
            continue
        own.append(_course(curve.id, curve.spline))
        if curve.mirrored:
            images[curve.id] = _image(own[-1], state.symmetry)
    own.sort(key=lambda course: (course.length, *course.points[0].tolist()))
    for number, one in enumerate(own):
        for other in own[number + 1 :]:
            pairs = [(one, other)]
            if other.name in images:
                pairs.append((one, images[other.name]))
            elif one.name in images:
                pairs.append((other, images[one.name]))
            yield from (pair for pair in pairs if _is_near(*pair, gap))


def _is_near(one: _Course, other: _Course, gap: float) -> bool:
    """Whether the boxes of two curves are within the gap."""
    return bool((one.low <= other.high + gap).all() and (other.low <= one.high + gap).all())


def _course(name: str, spline: Spline, *, mirrored: bool = False) -> _Course:
    at = np.linspace(*spline.range, PIECES * len(spline.control_points) + 1)
    points = spline.value(at)
    low, high = spline.control_points.min(axis=0), spline.control_points.max(axis=0)
    return _Course(name, mirrored, spline, at, points, chord_length(spline), low, high)


def _image(course: _Course, symmetry: Plane) -> _Course:
    old = course.spline
    spline = Spline(old.knots, mirror_image(old.control_points, symmetry), old.closed)
    return _course(course.name, spline, mirrored=True)


def _joined_places(joints: Collection[Joint], state: ProductState) -> list[tuple[set[str], Array]]:
    """Return the curves that meet in each joint, and where, on both sides of the plane."""
    splines = splines_of(state)
    found = []
    for joint in joints:
        known = [meet for meet in joint.meetings if meet.curve in splines]
        if known:
            names = {meet.curve for meet in known}
            place = meeting_place(splines, known[0], state.symmetry)
            found.extend([(names, place), (names, mirror_image(place, state.symmetry))])
    return found


def _closest_places(one: _Course, other: _Course, gap: float) -> Iterator[tuple[float, float]]:
    """Yield parameters of places at which two curves are closer than around."""
    apart = np.linalg.norm(one.points[:, None] - other.points, axis=2)
    step = max(
        float(np.linalg.norm(np.diff(course.points, axis=0), axis=1).max())
        for course in (one, other)
    )
    padded = np.pad(apart, 1, constant_values=np.inf)
    rows, columns = apart.shape
    around = [
        padded[1 + i : 1 + i + rows, 1 + j : 1 + j + columns]
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
        if i or j
    ]
    least = (apart <= np.min(around, axis=0)) & (apart <= gap + step)
    for row, column in zip(*np.nonzero(least), strict=True):
        yield float(one.at[row]), float(other.at[column])


def _crossing(
    one: _Course, other: _Course, first: float, second: float, gap: float
) -> Crossing | None:
    """Return the crossing near two parameters; None if there is none."""
    at = np.array((first, second))
    low = np.array((one.spline.range[0], other.spline.range[0]))
    high = np.array((one.spline.range[1], other.spline.range[1]))
    for _ in range(STEPS):
        away = one.spline.value([at[0]])[0] - other.spline.value([at[1]])[0]
        slopes = np.stack(
            (one.spline.derivative([at[0]])[0], -other.spline.derivative([at[1]])[0]), axis=1
        )
        at = np.clip(at - np.linalg.lstsq(slopes, away, rcond=1e-9)[0], low, high)
    places = one.spline.value([at[0]])[0], other.spline.value([at[1]])[0]
    if np.linalg.norm(places[0] - places[1]) > gap:
        return None
    ways = one.spline.derivative([at[0]])[0], other.spline.derivative([at[1]])[0]
    size = float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1]))
    if not np.linalg.norm(cross_product(*ways)) > FLATTEST * size:
        return None
    for course, place in zip((one, other), places, strict=True):
        ends = course.spline.control_points[[0, -1]]
        if not course.spline.closed and np.linalg.norm(ends - place, axis=1).min() <= gap:
            return None
    share = other.length / (one.length + other.length)
    meetings = (
        Meeting(one.name, share_at(one.spline, float(at[0]))),
        Meeting(other.name, share_at(other.spline, float(at[1])), other.mirrored),
    )
    return Crossing(meetings, places[0] + share * (places[1] - places[0]))
