"""Styling curves as seen in one view, and the curve that a stroke is drawn over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry.patches import normals_at, points_at, ray_hits
from bozzetto.ink import FARTHEST, distances_to_polyline, resample
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.curve import mirror_curve
from bozzetto_car.styling.curve_fit import Course, courses_on

LOOKS: Final = 1024
"""Number of places of a curve that are projected into the view."""

FACING: Final = 0.02
"""Least cosine between the normal and the line of sight of a place of a curve that is seen."""

REACH: Final = 14.0
"""Distance, px, within which a stroke is beside a curve."""

MOST: Final = 0.6
"""Share of a stroke that must run beside a curve, in its direction, to be drawn over it."""

ALONG: Final = 0.8
"""Least cosine between the directions of a stroke and of a curve that it runs along."""

FAITHFUL: Final = 0.6
"""Factor on the distance of the chosen curve: a person tends to go on with it."""

SAMPLES: Final = 48
"""Number of places of a stroke that are compared with curves."""

BEHIND: Final = 20.0
"""Distance, mm, behind what is seen from which a place of a curve is hidden."""


class SeenPart(NamedTuple):
    """A part of a curve that faces the eye: lengths along the curve, mm, and places, px."""

    along: Array
    pixels: Array


@dataclass(frozen=True, eq=False)
class Target:
    """The curve that a stroke is drawn over.

    Attributes
    ----------
    curve : StylingCurve
    mirrored : bool
        Whether the stroke is drawn over the curve's mirror image.
    """

    curve: StylingCurve
    mirrored: bool


def seen_parts(body: Body, course: Course, camera: Camera) -> list[SeenPart]:
    """Return the parts of a curve that face the eye, whether or not something hides them."""
    along = np.linspace(0.0, course.length, LOOKS)
    places = course.places(along)
    points = points_at(body.nets, places)
    pixels = camera.project(points)[0]
    away = -sight_of(points, camera)
    seen = (normals_at(body.nets, places) * away).sum(axis=1) > FACING
    seen &= (np.abs(np.nan_to_num(pixels, nan=np.inf)) <= FARTHEST).all(axis=1)
    parts = np.split(np.arange(LOOKS), np.flatnonzero(np.diff(seen)) + 1)
    return [SeenPart(along[p], pixels[p]) for p in parts if seen[p[0]] and len(p) > 1]


def sight_of(points: Array, camera: Camera) -> Array:
    """Return unit vectors from the eye to points, (n, 3)."""
    if camera.kind == "orthographic":
        return np.broadcast_to(camera.axes[2], points.shape)
    ways = points - camera.eye
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


def target_of(
    curves: Sequence[StylingCurve], body: Body, stroke: Array, camera: Camera, chosen: str = ""
) -> Target | None:
    """Return the curve that most of a stroke runs along; None if there is none near by.

    Parameters
    ----------
    curves : sequence of StylingCurve
        The curves that are shown.
    body : Body
        The body that the curves are on.
    stroke : (n, 2) float
        Samples of the stroke, px.
    camera : Camera
        The view that the stroke was drawn in.
    chosen : str
        Id of the curve that is preferred to others at a similar distance.
    """
    ink = resample(stroke, count=SAMPLES)
    found: list[tuple[float, Target]] = []
    for curve in curves:
        for image in (False, True) if curve.both else (False,):
            side = mirror_curve(curve) if image else curve
            distance = _distance(side, body, ink, camera)
            if distance is not None:
                factor = FAITHFUL if curve.id == chosen else 1.0
                found.append((factor * distance, Target(curve, image)))
    return min(found, key=lambda one: one[0], default=(0.0, None))[1]


def _distance(curve: StylingCurve, body: Body, ink: Array, camera: Camera) -> float | None:
    """Return the mean distance, px, of a stroke from a curve that it runs along; else None."""
    best = None
    way = _directions(ink)
    for course in courses_on(curve, body.nets, body.template):
        for part in seen_parts(body, course, camera):
            away = distances_to_polyline(ink, part.pixels)
            near = away <= REACH
            if not near.any():
                continue
            foot = np.linalg.norm(ink[:, None] - part.pixels, axis=2).argmin(axis=1)
            beside = np.abs((way * _directions(part.pixels)[foot]).sum(axis=1)) >= ALONG
            over = near & beside
            if over.mean() < MOST:
                continue
            distance = float(away[over].mean())
            if best is None or distance < best:
                at = course.places(np.sort(part.along[foot[over]]))
                if _is_in_front(body, points_at(body.nets, at), camera):
                    best = distance
    return best


def _directions(line: Array) -> Array:
    """Return unit vectors along a line, (n, 2); 0 where it stands still."""
    ways = np.gradient(line, axis=0)
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.asarray(ways / np.where(length > 0.0, length, 1.0))


def _is_in_front(body: Body, points: Array, camera: Camera) -> bool:
    """Whether most of some points of the body are not hidden by another part of it."""
    some = points[:: max(1, len(points) // 8)]
    sight = sight_of(some, camera)
    origins = camera.rays(camera.project(some)[0]).origins
    distances = ray_hits(body.nets, origins, sight)[1]
    own = ((some - origins) * sight).sum(axis=1)
    return bool((distances > own - BEHIND).mean() > 0.5)
