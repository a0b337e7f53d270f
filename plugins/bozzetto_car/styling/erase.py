"""Erase styling curves with the other end of the pen."""

from __future__ import annotations

from dataclasses import replace
from operator import is_
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import Places
from bozzetto.ink import Stroke, distances_to_polyline, resample
from bozzetto.plugin import PartsState
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import mirror_curve, stem_of, with_paths
from bozzetto_car.styling.curve_fit import Course, courses_on
from bozzetto_car.styling.oversketch import begun_away
from bozzetto_car.styling.picking import seen_parts
from bozzetto_car.styling.scene import shown_styling
from bozzetto_car.styling.surface_path import is_closed, join_paths

RUBBED: Final = 9.0
"""Half the width of the eraser, px."""

ALL: Final = 0.6
"""Share of a curve under the eraser from which the whole curve goes."""

ALONG: Final = 0.5
"""Share, of the most covered curve's places under the eraser, from which another curve is meant."""

LOOKS: Final = 64
"""Places of the eraser's path that are compared with curves."""

SHORTEST: Final = 20.0
"""Length, mm, of the shortest part of a curve that is kept."""


def without_stretch(
    curve: StylingCurve, body: Body, eraser: ArrayLike, camera: Camera
) -> tuple[StylingCurve, ...]:
    """Return the parts of a curve that an eraser leaves.

    Parameters
    ----------
    curve : StylingCurve
        The curve.
    body : Body
        The body that it is on.
    eraser : (n, 2) array_like
        Path of the eraser, px.
    camera : Camera
        The view.

    Returns
    -------
    tuple of StylingCurve
        The same object where it is not touched; none where most of it is erased. A stretch is
        cut out exactly, so up to two parts of each path are left, with the curve's id.
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
    """Return lengths along a curve, mm, of places under the eraser, increasing."""
    found = [np.zeros(0)]
    for part in seen_parts(body, course, camera):
        under = distances_to_polyline(part.pixels, eraser) <= RUBBED
        found.append(part.along[under])
    return np.concatenate(found)


def _left(nets: Array, course: Course, under: Array) -> list[Places]:
    """Return the path before and after the erased lengths; of a closed path both as one."""
    low, high = float(under[0]), float(under[-1])
    cut = course.places(np.array([low, high]))
    before, behind = course.path[course.along < low], course.path[course.along > high]
    left = [join_paths([before, cut[:1]]), join_paths([cut[1:], behind])]
    if is_closed(nets, course.path):
        return [join_paths([left[1], left[0][1:]])]
    lengths = (low, course.length - high)
    return [path for path, rest in zip(left, lengths, strict=True) if rest > SHORTEST]


def erase(state: CarState, body: Body, eraser: Stroke) -> CarState:
    """Return the state without what an eraser covers, on either side of the car.

    Raises
    ------
    UserError
        If there is no styling curve under the eraser.
    """
    nodes = list(state.nodes)
    for curve, image in _meant(state, body, eraser):
        side = mirror_curve(curve) if image else curve
        left = without_stretch(side, body, eraser.points, eraser.camera)
        parts = [mirror_curve(part) if image else part for part in left]
        at = next(k for k, node in enumerate(nodes) if node.id == curve.id)
        nodes[at : at + 1] = parts[:1]
        for k, part in enumerate(parts[1:], start=at + 1):
            row = PartsState(tuple(nodes))
            name = row.unused_name(stem_of(curve.name))
            nodes.insert(k, replace(part, id=row.unused_id(), name=name))
    if len(nodes) == len(state.nodes) and all(map(is_, nodes, state.nodes)):
        raise UserError("There is no styling curve under the eraser. Rub along the curve to erase.")
    kept = state.selected if any(node.id == state.selected for node in nodes) else ""
    return replace(state, nodes=tuple(nodes), selected=kept)


def _meant(state: CarState, body: Body, eraser: Stroke) -> list[tuple[StylingCurve, bool]]:
    """Return the curves that the eraser runs along, and whether over their mirror images.

    Curves that it only crosses are not among them.
    """
    path = resample(eraser.points, count=LOOKS)
    best: dict[str, tuple[int, StylingCurve, bool]] = {}
    for curve in shown_styling(state):
        for image in (False, True) if curve.both else (False,):
            side = mirror_curve(curve) if image else curve
            near = _near(side, body, path, eraser.camera)
            if near > best.get(curve.id, (0,))[0]:
                best[curve.id] = near, curve, image
    most = max((near for near, _, _ in best.values()), default=0)
    return [(curve, image) for near, curve, image in best.values() if near >= ALONG * most]


def _near(curve: StylingCurve, body: Body, path: Array, camera: Camera) -> int:
    """Return how many places of the eraser's path lie over a curve."""
    near = np.zeros(len(path), bool)
    for course in courses_on(curve, body.nets, body.template):
        for part in seen_parts(body, course, camera):
            near |= distances_to_polyline(path, part.pixels) <= RUBBED
    return int(near.sum())
