"""Ends at the places that they were drawn to, and lines straight along an axis of the box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.ink import Stroke
from bozzetto.view import triple
from bozzetto_symmetry.editing.edit_sequence import snapped
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.perspective import pixel_size
from bozzetto_symmetry.model.state import Curve, EndSnap, Snap, SymmetryState
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

BESIDE: Final = 20.0
"""Distance, px, from the image of an end of the curve within which a stroke ends there."""

REACH: Final = 16.0
"""Distance on the sheet, px, over which an end goes to the place that it was drawn to: twice that
within which it was caught, for the curve may be read anew."""

DEPTH_SIGMAS: Final = 3.0
"""How much farther it may go along the line of sight: standard deviations of the end."""

ASKEW: Final = float(np.sin(np.radians(10.0)))
"""Sine of the angle between a curve and the axis that it was drawn along, above which it was read
as something else."""


SAME_PLACE: Final = 1e-6
"""Distance, in diagonals of the box, between an end and the place that it settled on."""

LOOKS: Final = 65
"""Places of a line of which the middle is taken."""


@dataclass(frozen=True)
class DrawnEnd:
    """An end of the curve in space that an end of a stroke shows.

    Attributes
    ----------
    end : {0, 1}
        Of the curve.
    mirrored : bool
        The stroke shows the mirror image of that end.
    pixels : float
        How far apart they are on the sheet.
    """

    end: int
    mirrored: bool
    pixels: float


def drawn_end(curve: SpaceCurve, stroke: Stroke, end: int, state: SymmetryState) -> DrawnEnd | None:
    """Return which end of an open curve an end of a stroke shows; None if it shows none.

    Parameters
    ----------
    curve : SpaceCurve
        In the frame of the plane.
    stroke : Stroke
        In the frame of the model.
    end : {0, 1}
        Of the stroke.
    state : SymmetryState
        For its plane.
    """
    pen = stroke.points[-end]
    ends = (1,) if curve.reading == "self" else (0, 1)
    sides = (False,) if curve.reading == "plane" else (False, True)
    found = []
    for number in ends:
        place = curve.spline.value(curve.spline.range[number : number + 1])
        for mirrored in sides:
            seen, _ = stroke.camera.project(_in_model(place, mirrored, state))
            away = float(np.linalg.norm(seen[0] - pen))
            if away <= BESIDE:
                found.append(DrawnEnd(number, mirrored, away))
    return min(found, key=lambda each: each.pixels, default=None)


def with_end_snaps(
    curve: SpaceCurve, node: Curve, sigma: Array, state: SymmetryState
) -> SpaceCurve:
    """Return a curve as it was drawn, straight along its axis and with its ends where they go.

    What the ink, as it is read, contradicts is left out: an end that is elsewhere in depth, an
    axis that the curve does not run along.

    Parameters
    ----------
    curve : SpaceCurve
        What the ink says, in the frame of the plane.
    node : Curve
        Its recipe.
    sigma : (k,) float
        Standard deviations along the curve, mm.
    state : SymmetryState
        For its plane.
    """
    if curve.closed:
        return curve
    found = [_meant(curve, snap, node.strokes, sigma, state) for snap in node.end_snaps]
    taken = {snap.end: snap for snap in found if snap is not None}
    if node.axis >= 0 and curve.reading != "self":
        frame = state.plane.inverse
        held = {end: frame.points(snap.point)[0] for end, snap in taken.items()}
        straight = _straight(curve, frame.directions(AXES[node.axis])[0], held)
        if straight is not None:
            return straight
    for snap in taken.values():
        curve = snapped(curve, snap, state)
    return curve


def settled_ends(curve: SpaceCurve, node: Curve, state: SymmetryState) -> int:
    """Return how many ends of a solved curve are where they settled.

    Of a curve that is its own mirror image both ends are, or none is: its second half is solved.

    Parameters
    ----------
    curve : SpaceCurve
        In the frame of the plane.
    node : Curve
        Its recipe.
    state : SymmetryState
        For its plane.
    """
    if not node.settles or curve.closed or not node.end_snaps:
        return 0
    numbers = (1,) if curve.reading == "self" else (0, 1)
    meant = state.plane.inverse.points([snap.point for snap in node.end_snaps])
    both = np.vstack((meant, meant * MIRROR))
    ends = curve.spline.value([curve.spline.range[number] for number in numbers])
    away = np.linalg.norm(ends[:, None] - both, axis=2).min(axis=1)
    found = int((away <= SAME_PLACE * state.diagonal).sum())
    return 2 * found if curve.reading == "self" else found


def _meant(
    curve: SpaceCurve, snap: EndSnap, strokes: Sequence[Stroke], sigma: Array, state: SymmetryState
) -> Snap | None:
    """Return where an end of the curve goes; None where it cannot be meant."""
    if snap.stroke >= len(strokes):
        return None
    stroke = strokes[snap.stroke]
    shown = drawn_end(curve, stroke, snap.end, state)
    if shown is None:
        return None
    now = _in_model(curve.spline.value(curve.spline.range[shown.end :][:1]), shown.mirrored, state)
    way = np.asarray(snap.point) - now[0]
    size = float(pixel_size(stroke.camera, now)[0])
    sight = stroke.camera.rays(stroke.camera.project(now)[0]).directions[0]
    deep = abs(float(way @ sight))
    across = float(np.linalg.norm(way - (way @ sight) * sight))
    reach = REACH * size
    if across > reach or deep > reach + DEPTH_SIGMAS * float(sigma[-shown.end]):
        return None
    point, tangent = np.asarray(snap.point), snap.tangent
    if shown.mirrored:
        frame = state.plane
        point = frame.placement.points(frame.inverse.points(point) * MIRROR)[0]
        if tangent is not None:
            turned = frame.inverse.directions(tangent) * MIRROR
            tangent = triple(frame.placement.directions(turned)[0])
    return Snap(shown.end, triple(point), tangent)


def _straight(curve: SpaceCurve, axis: Array, held: Mapping[int, Array]) -> SpaceCurve | None:
    """Return a curve as a straight line along an axis; None if it does not run along that.

    It passes through the first of the places that hold its ends, and ends beside the others.
    """
    spline = curve.spline
    chord = np.diff(spline.value(spline.range), axis=0)[0]
    length = float(np.linalg.norm(chord))
    if not float(np.linalg.norm(np.cross(chord, axis))) < ASKEW * length:
        return None
    base = next(iter(held.values()), spline.sampled(LOOKS).mean(axis=0))
    along = (spline.control_points - base) @ axis
    first, last = (
        float((held[end] - base) @ axis) if end in held else float(along[-end]) for end in (0, 1)
    )
    along = first + (along - along[0]) * (last - first) / (along[-1] - along[0])
    points = base + np.outer(along, axis)
    if curve.reading == "plane":
        points[:, 1] = 0.0
    return SpaceCurve(curve.reading, Spline(spline.knots, points))


def _in_model(points: Array, mirrored: bool, state: SymmetryState) -> Array:
    return np.asarray(state.plane.placement.points(points * MIRROR if mirrored else points))
