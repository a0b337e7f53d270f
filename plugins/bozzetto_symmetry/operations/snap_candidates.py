"""The place that an end of a curve snaps to: an end, a curve, an edge, a plane or a face."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto.view import Camera, triple
from bozzetto_symmetry.editing.snap import end_direction
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.perspective import pixel_size
from bozzetto_symmetry.model.state import Snap, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import Point
from bozzetto_symmetry.operations.snap_targets import Targets, targets, without_own
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.solve.picking import solved_curves

TOLERANCE: Final = 8.0
"""Distance on the sheet, px, within which an end is caught."""

SMOOTH: Final = float(np.cos(np.radians(12.0)))
"""Cosine of the angle to a known direction within which a curve is meant to go on smoothly."""

DEPTH_SIGMAS: Final = 2.0
"""How much farther along the line of sight it may be: standard deviations of the end."""


@dataclass(frozen=True, eq=False)
class Reach:
    """How far an end may be from where it is meant to be.

    Attributes
    ----------
    across : float
        8 px on the sheet, mm.
    way : (3,) float
        Unit direction of the line of sight, along which it may be two standard deviations farther.
    """

    across: float
    way: Array

    @classmethod
    def of(cls, place: Array, camera: Camera) -> Reach | None:
        """Return the reach at a place (3,) mm; None where that is not seen."""
        pixels, _ = camera.project(place)
        if not np.isfinite(pixels).all():
            return None
        size = float(pixel_size(camera, place)[0])
        return cls(TOLERANCE * size, camera.rays(pixels).directions[0])

    def reflected(self, side: Array) -> Reach:
        """Return the reach of the mirror image, for factors (3,) of the coordinates."""
        return Reach(self.across, self.way * side)

    def stretched(self, sigma: float) -> tuple[Array, Array]:
        """Return the axes (3, 3) in which all within reach is in the unit ball, and their inverse.

        Parameters
        ----------
        sigma : float
            Standard deviation along the line of sight, mm.
        """
        along, both = self.across + DEPTH_SIGMAS * sigma, np.outer(self.way, self.way)
        return (
            np.eye(3) / self.across + (1.0 / along - 1.0 / self.across) * both,
            np.eye(3) * self.across + (along - self.across) * both,
        )

    def ratios(self, ways: Array, sigma: float) -> Array:
        """Return how far ways (n, 3) mm lead, in reaches, (n,)."""
        return np.asarray(np.linalg.norm(ways @ self.stretched(sigma)[0], axis=1))


def snap_of(
    end: int,
    point: ArrayLike,
    sigma: float,
    camera: Camera,
    known: Targets,
    state: SymmetryState,
    leaving: ArrayLike | None = None,
    *,
    within_plane: bool = False,
) -> Snap | None:
    """Return the place that an end of a curve is meant to be at.

    It is the nearest one within 8 px on the sheet and as much in depth, and besides two
    standard deviations of the end along the line of sight, where the hand says least. A
    point wins over a curve or an edge, that over the centre plane, and that over a face of
    the box. Where a curve goes on within 12° of how another one ends there, or of the normal of
    the centre plane, it takes that direction.

    Parameters
    ----------
    end : {0, 1}
        Of the curve; a curve across the plane has end 1 only.
    point : (3,) array_like
        Where it is now, in the model's frame, mm.
    sigma : float
        Its standard deviation, mm.
    camera : Camera
        Through which the curve was drawn, in the model's frame.
    known : Targets
        Without the curve itself.
    state : SymmetryState
        Its box and plane.
    leaving : (3,) array_like, optional
        Unit direction in which the curve leaves the end, in the model's frame; default: no
        direction is taken.
    within_plane : bool
        The curve lies in the centre plane, and so cannot snap to that.

    Returns
    -------
    Snap or None
    """
    place = np.asarray(point, float)
    reach = Reach.of(place, camera)
    if reach is None:
        return None
    axes = reach.stretched(sigma)
    return snap_within(end, place, axes, known, state, leaving, within_plane=within_plane)


def snap_within(
    end: int,
    place: Array,
    axes: tuple[Array, Array],
    known: Targets,
    state: SymmetryState,
    leaving: ArrayLike | None = None,
    *,
    within_plane: bool = False,
    faces: bool = True,
) -> Snap | None:
    """Return the place that an end is meant to be at, of those within its reach.

    Parameters
    ----------
    end, place, known, state, leaving, within_plane
        As `snap_of` takes them.
    faces : bool
        Whether it may snap to a face of the box.
    axes : pair of (3, 3) float arrays
        Those in which all within reach is in the unit ball about the end, and their inverse.
    """
    shrink, grow = axes
    number = _among_points(place, shrink, known)
    if number is not None:
        return Snap(end, triple(known.points[number]), _continued(leaving, known.tangents[number]))
    found = _among_segments(place, shrink, known)
    if found is not None:
        return Snap(end, triple(found))
    found = None if within_plane else _among_planes(place, grow, _centre_plane(state))
    if found is not None:
        return Snap(end, triple(found), _continued(leaving, np.asarray(state.plane.normal)))
    found = _among_planes(place, grow, _faces(state)) if faces else None
    return None if found is None else Snap(end, triple(found))


def _continued(leaving: ArrayLike | None, known: Array) -> Point | None:
    """Return a known direction, in the sense of the way that is taken, if that is nearly it."""
    cosine = 0.0 if leaving is None else float(np.asarray(leaving, float) @ known)
    return triple(np.copysign(1.0, cosine) * known) if abs(cosine) > SMOOTH else None


def snaps_of(
    curve: SpaceCurve,
    sigma: ArrayLike,
    camera: Camera,
    known: Targets,
    state: SymmetryState,
) -> tuple[Snap, ...]:
    """Return the snaps of the free ends of a curve.

    Parameters
    ----------
    curve : SpaceCurve
        The curve whose ends snap, in the frame of the plane.
    sigma : (k,) array_like
        Standard deviations along the curve, from its first end to its last, mm.
    camera, known, state
        As `snap_of` takes them.
    """
    if curve.closed:
        return ()
    ends = (1,) if curve.reading == "self" else (0, 1)
    spread, to_model = np.asarray(sigma, float), state.plane.placement
    places = to_model.points(curve.spline.value(curve.spline.range))
    ways = to_model.directions(
        [end_direction(curve.spline.reversed()), end_direction(curve.spline)]
    )
    found = (
        snap_of(
            end,
            places[end],
            float(spread[-end]),
            camera,
            known,
            state,
            ways[end],
            within_plane=curve.reading == "plane",
        )
        for end in ends
    )
    return tuple(snap for snap in found if snap is not None)


def with_ends_caught(state: SymmetryState, context: Context) -> SymmetryState:
    """Return the state in which the free ends of the chosen curve snap to what is near them.

    The curve's own last view says how sure its ends are.

    Raises
    ------
    UserError
        If no curve is chosen, it has no free end, or nothing is near its ends.
    """
    node = state.chosen
    trace = None if node is None else trace_of(node, state)
    if node is None or trace is None or trace.curve is None or trace.curve.closed:
        raise UserError("Choose a curve with free ends. They snap to what is near them.")
    others = [curve for other, curve in solved_curves(state) if other.id != node.id]
    camera = node.strokes[-1].camera
    known = targets(state, others, without_own(context, state))
    snaps = snaps_of(trace.curve, trace.sigma, camera, known, state)
    if not snaps:
        raise UserError("There is nothing near the ends of this curve. Draw them closer.")
    return state.with_node(replace(node, edits=(*node.edits, *snaps)))


def plane_near(place: Array, camera: Camera, state: SymmetryState) -> Array | None:
    """Return the nearest place on the centre plane, or else on a face of the box, (3,) mm.

    None beyond 8 px on the sheet and as much in depth.

    Parameters
    ----------
    place : (3,) float
        An end of a curve that is still being drawn, in the model's frame, mm.
    camera : Camera
        Through which it is drawn, in the model's frame.
    state : SymmetryState
        Its box and plane.
    """
    reach = Reach.of(place, camera)
    if reach is None:
        return None
    _, grow = reach.stretched(0.0)
    found = _among_planes(place, grow, _centre_plane(state))
    return _among_planes(place, grow, _faces(state)) if found is None else found


def _among_points(place: Array, shrink: Array, known: Targets) -> int | None:
    if not len(known.points):
        return None
    away = np.linalg.norm((known.points - place) @ shrink, axis=1)
    best = int(np.argmin(away))
    return best if away[best] <= 1.0 else None


def _among_segments(place: Array, shrink: Array, known: Targets) -> Array | None:
    if not len(known.begins):
        return None
    begin, end = (known.begins - place) @ shrink, (known.ends - place) @ shrink
    step = end - begin
    square = np.einsum("nk,nk->n", step, step)
    share = -np.einsum("nk,nk->n", begin, step) / np.where(square > 0, square, 1.0)
    share = np.clip(share, 0.0, 1.0)[:, None]
    away = np.linalg.norm(begin + share * step, axis=1)
    best = int(np.argmin(away))
    if away[best] > 1.0:
        return None
    return np.asarray((1.0 - share[best]) * known.begins[best] + share[best] * known.ends[best])


def _among_planes(place: Array, grow: Array, planes: list[tuple[Array, float]]) -> Array | None:
    """Return the nearest place, in these axes, of planes ``normal · x = height``."""
    best: tuple[float, Array] | None = None
    for normal, height in planes:
        stretched = grow @ normal
        reach = float(np.linalg.norm(stretched))
        gap = (height - float(normal @ place)) / reach
        if abs(gap) <= 1.0 and (best is None or abs(gap) < best[0]):
            best = abs(gap), place + gap / reach * (grow @ stretched)
    return None if best is None else best[1]


def _centre_plane(state: SymmetryState) -> list[tuple[Array, float]]:
    normal = np.asarray(state.plane.normal)
    return [(normal, float(normal @ np.asarray(state.plane.point)))]


def _faces(state: SymmetryState) -> list[tuple[Array, float]]:
    return [
        (np.eye(3)[axis], state.centre[axis] + sign * size)
        for axis, size in enumerate(state.size)
        for sign in (-0.5, 0.5)
    ]
