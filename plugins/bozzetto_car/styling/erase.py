"""The pen's other end on styling curves: it takes away what it rubs over."""

from __future__ import annotations

from dataclasses import replace
from operator import is_
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.geometry.patches.patch import Places
from bozzetto.ink import Stroke
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.ink.curves.resample import resample
from bozzetto.plugin import unused_id, unused_name
from bozzetto.view import Camera
from bozzetto_car.array_types import Array
from bozzetto_car.body.build import Body
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import mirrored, stem_of, with_paths
from bozzetto_car.styling.curve_fit import Course, courses_on
from bozzetto_car.styling.oversketch import begun_away
from bozzetto_car.styling.picking import seen_parts
from bozzetto_car.styling.scene import shown_styling
from bozzetto_car.styling.surface_path import is_closed, joined

RUBBED: Final = 9.0
"""Half the width of the eraser, px."""

ALL: Final = 0.6
"""Share of a curve that must be rubbed over for all of it to go."""

ALONG: Final = 0.5
"""Share of the eraser's path over the curve that it covers most, from which another is meant."""

LOOKS: Final = 64
"""Places of the eraser's path that are looked at."""

SHORTEST: Final = 20.0
"""Length, mm, of what is worth keeping of a curve."""


def without_stretch(
    curve: StylingCurve, body: Body, eraser: ArrayLike, camera: Camera
) -> tuple[StylingCurve, ...]:
    """What is left of a curve where an eraser went over it.

    Parameters
    ----------
    curve : StylingCurve
    body : Body
    eraser : (n, 2) array_like
        Its path, px.
    camera : Camera

    Returns
    -------
    tuple of StylingCurve
        The same object where it is not touched; none where most of it is rubbed over. A part is
        cut out with its ends, so up to two parts of each path are left, with the curve's id.
    """
    paths, rubbed, length = [], 0.0, 0.0
    turned = begun_away(curve, body, eraser, camera)
    for course in courses_on(turned, body.nets, body.template):
        under = _rubbed(body, course, np.asarray(eraser, float), camera)
        length += course.length
        if len(under):
            rubbed += float(under[-1] - under[0])
            paths += _left(body.nets, course, under)
        else:
            paths.append(course.path)
    if not rubbed:
        return (curve,)
    if rubbed >= ALL * length:
        return ()
    return tuple(with_paths(curve, body, [path]) for path in paths)


def _rubbed(body: Body, course: Course, eraser: Array, camera: Camera) -> Array:
    """Lengths along a curve, mm, of places under the eraser, increasing."""
    found = [np.zeros(0)]
    for part in seen_parts(body, course, camera):
        under = distances_to_polyline(part.pixels, eraser) <= RUBBED
        found.append(part.along[under])
    return np.concatenate(found)


def _left(nets: Array, course: Course, under: Array) -> list[Places]:
    """A path before and behind the lengths that are rubbed over; of a closed one both as one."""
    low, high = float(under[0]), float(under[-1])
    cut = course.places(np.array([low, high]))
    before, behind = course.path[course.along < low], course.path[course.along > high]
    left = [joined([before, cut[:1]]), joined([cut[1:], behind])]
    if is_closed(nets, course.path):
        return [joined([left[1], left[0][1:]])]
    lengths = (low, course.length - high)
    return [path for path, rest in zip(left, lengths, strict=True) if rest > SHORTEST]


def erased(state: CarState, body: Body, eraser: Stroke) -> CarState:
    """Without what the eraser's path lies over, on whichever side of the car it is.

    Raises
    ------
    UserError
        If there is no styling curve under the eraser.
    """
    nodes = list(state.nodes)
    for curve, image in _meant(state, body, eraser):
        side = mirrored(curve) if image else curve
        left = without_stretch(side, body, eraser.points, eraser.camera)
        parts = [mirrored(part) if image else part for part in left]
        at = next(k for k, node in enumerate(nodes) if node.id == curve.id)
        nodes[at : at + 1] = parts[:1]
        for k, part in enumerate(parts[1:], start=at + 1):
            name = unused_name(nodes, stem_of(curve.name))
            nodes.insert(k, replace(part, id=unused_id(nodes), name=name))
    if len(nodes) == len(state.nodes) and all(map(is_, nodes, state.nodes)):
        raise UserError("There is no styling curve under the eraser. Rub along what is to go.")
    kept = state.selected if any(node.id == state.selected for node in nodes) else ""
    return replace(state, nodes=tuple(nodes), selected=kept)


def _meant(state: CarState, body: Body, eraser: Stroke) -> list[tuple[StylingCurve, bool]]:
    """Curves that the path runs along, and whether over their mirror images.

    Those that it only crosses are not meant.
    """
    path = resample(eraser.points, count=LOOKS)
    best: dict[str, tuple[int, StylingCurve, bool]] = {}
    for curve in shown_styling(state):
        for image in (False, True) if curve.both else (False,):
            side = mirrored(curve) if image else curve
            near = _near(side, body, path, eraser.camera)
            if near > best.get(curve.id, (0,))[0]:
                best[curve.id] = near, curve, image
    most = max((near for near, _, _ in best.values()), default=0)
    return [(curve, image) for near, curve, image in best.values() if near >= ALONG * most]


def _near(curve: StylingCurve, body: Body, path: Array, camera: Camera) -> int:
    """How many places of the eraser's path lie over a curve."""
    near = np.zeros(len(path), bool)
    for course in courses_on(curve, body.nets, body.template):
        for part in seen_parts(body, course, camera):
            near |= distances_to_polyline(path, part.pixels) <= RUBBED
    return int(near.sum())
