"""Advice on a view: whether both sides can be drawn in it, and how to turn it if not."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Job
from bozzetto.view import Camera, fit_points, turn
from bozzetto_symmetry.model.box_geometry import box_corners
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane, Point
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.degeneracies import CAUSES, REMEDIES, Case, special_case
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import image_slopes, point_covariances, sigmas

Level = Literal["good", "warn", "refuse"]

REFUSED: Final = 5.0
"""Angle to the centre plane below which a view shows next to no depth, degrees."""

WARNED: Final = 12.0
"""Angle to the centre plane below which depth is poor, degrees."""

FARTHEST: Final = 35.0
"""Largest turn that is advised, degrees: with more, one loses sight of what one drew."""

STRIDE: Final = 5.0
"""Degrees between the turns that are tried at first; around the best one, single degrees."""

ENOUGH: Final = 1.1
"""Uncertainty, in that of the best turn, at which the smaller turn is taken."""

WORTH: Final = 1.25
"""Gain from which it is worth turning a view that is good already."""

MANY: Final = 20.0
"""Gain above which its figure says no more than that it is large."""

LYING: Final = 10.0
"""Height of the eye, degrees, up to which a view is nearly level."""

ABOVE: Final = 20.0
"""Height of the eye, degrees, from which one first looks into the box."""

ROOM: Final = 0.15
"""Part of the sheet that is left free on each side of an empty box."""

LEVEL: Final = 1e-6
"""Rise of the sheet's horizontal, as a sine, below which the view is upright."""

STEEP: Final = np.cos(np.radians(20.0))
"""Share of the z axis in the sight above which a view is one from above or below: turning it
about the z axis would only spin the sheet, so it is turned about the sheet's own axes."""

CUBE: Final = np.array([(0.0, 0.0, 0.0), *itertools.product((-1.0, 1.0), repeat=3)])
"""Places that are looked at: the middle and the corners of a cube, in units of `SPREAD`."""

SPREAD: Final = 0.25 / np.sqrt(3.0)
"""Half the edge of the cube in diagonals of the box: its own diagonal is half the box's."""

LEAST: Final = 1.02
"""Gain from which a turn is advised for a view that is not good."""

MOST: Final = 12
"""Directions looked at; more of them change a median little."""

DIAGONAL: Final = np.sqrt(0.5)

LOOKS: Final = 12
"""Places of a curve whose directions a view is judged by."""

NEWEST: Final = 8
"""Curves that a view is judged by, the last ones: what is drawn next goes with these, and a
drawing of many curves that was just opened is not solved for the sake of advice."""

USUAL: Final = np.array(
    [(1, 0, 0), (0, 0, 1), (DIAGONAL, 0, DIAGONAL), (DIAGONAL, 0, -DIAGONAL)], float
)
"""Directions of lines in a drawing of which nothing is known, in the plane's frame: edges and
diagonals of a box's side. Its edges along the normal are known by their ends alone."""

WAYS: Final = {(1, 0): "to the right", (-1, 0): "to the left", (0, 1): "up", (0, -1): "down"}
"""Where the eye goes, as azimuth and elevation, and how one says it."""


@dataclass(frozen=True)
class Advice:
    """The judgement of a view.

    Parameters
    ----------
    level : {"good", "warn", "refuse"}
    message : str
        A sentence or two, with figures.
    better : Camera, optional
        The view turned to where it serves best near by, in the model's frame; None if it is
        best where it is.
    gain : float
        How many times more exact points are there; 1 without a better view.
    """

    level: Level
    message: str
    better: Camera | None = None
    gain: float = 1.0


@dataclass(frozen=True)
class Turn:
    """A turn of the view in one of four directions, by so many degrees."""

    azimuth: int
    elevation: int
    degrees: float

    @property
    def words(self) -> str:
        """The turn as one would say it."""
        return f"Turn {self.degrees:.0f}° {WAYS[self.azimuth, self.elevation]}"

    def of(self, camera: Camera) -> Camera:
        """Return the camera turned about its target, upright as before."""
        right, up, forward = camera.axes
        table = bool(abs(right[2]) < LEVEL and up[2] > 0.0 and abs(forward[2]) < STEEP)
        way = self.azimuth * self.degrees, self.elevation * self.degrees
        return turn(camera, *way, turntable=table)


def advice(
    camera: Camera,
    plane: CentrePlane,
    centre: Point,
    diagonal: float,
    directions: ArrayLike | None = None,
    *,
    above: bool = False,
) -> Advice:
    """Judge a view by what it would make of a drawing.

    Two things spoil a view: a short baseline, which is the sine of the angle between the
    sight and the centre plane, and lines that run towards their mirror images. The first is
    judged by itself; both are in the uncertainty that is predicted for points around the
    centre, by which the turn is chosen: the smallest one that comes within a tenth of the
    best in reach.

    Parameters
    ----------
    camera : Camera
        In the model's frame, like all that follows.
    plane : CentrePlane
        The plane of symmetry.
    centre : (x, y, z)
        Of the box, mm.
    diagonal : float
        Of the box, mm.
    directions : (k, 3) array_like, optional
        Tangents of the curves that are drawn, of any length; lines of all directions along
        the plane's side if there are none.
    above : bool
        Advise no level view but one from above: in a level one all that is level, and as high
        as the eye, is seen on edge.

    Returns
    -------
    Advice
    """
    middle, target = plane.inverse.points((centre, camera.target))
    points = _places(middle, target, diagonal, camera.visible_height)
    lines = _lines(directions, plane)

    def uncertainty(view: Camera) -> float:
        return _predicted(Stereo.of(view, plane), points, lines)

    now = uncertainty(camera)
    way, then = _best_turn(camera, uncertainty)
    level, cause, remedy = _judged(Stereo.of(camera, plane), now)
    gain = now / then
    if gain < (WORTH if level == "good" else LEAST):
        return Advice(level, f"{cause} {remedy}".strip())
    better, words = way.of(camera), way.words
    if above:
        better, raised = _raised(better)
        words += raised
        gain = now / uncertainty(better)
    times = f"{gain:.1f}" if gain < MANY else f"more than {MANY:.0f}"
    return Advice(level, f"{cause} {words}: {times} times more exact.", better, gain)


def _raised(camera: Camera) -> tuple[Camera, str]:
    """Return a view from above in the place of a level one, and the words for it."""
    right, up, forward = camera.axes
    height = -float(np.degrees(np.arcsin(np.clip(forward[2], -1.0, 1.0))))
    if abs(right[2]) > LEVEL or not up[2] > 0.0 or abs(height) > LYING:
        return camera, ""
    return turn(camera, 0.0, ABOVE - height), f" and {ABOVE - height:.0f}° up"


def _judged(stereo: Stereo, uncertainty: float) -> tuple[Level, str, str]:
    """Return how good a view is, why, and what to do if no other is found near by."""
    middle = np.multiply(stereo.camera.viewport, 0.5)[None]
    case = Case(int(special_case(stereo, middle, middle)[0]))
    if case == Case.EYE_ON_PLANE or (stereo.parallel and case == Case.BOTH_ALONG_NORMAL):
        return "refuse", CAUSES[case], REMEDIES[case]
    slant = float(np.degrees(stereo.slant))
    if slant < REFUSED:
        return "refuse", "This view shows next to no depth.", "Turn it by about 15°."
    if slant < WARNED:
        return "warn", "This view shows little depth.", "Turn it a little."
    spread = uncertainty * stereo.camera.pixels_per_mm
    if spread > 1.0 / np.sin(np.radians(WARNED)):
        if slant > 90.0 - WARNED:
            return "warn", "Left and right nearly coincide.", "Turn the view."
        return "warn", "Lines run towards their mirror images.", "Turn the view."
    return "good", f"Good: a slip of 1 px moves a curve by {_length(uncertainty)}.", ""


def _best_turn(camera: Camera, uncertainty: Callable[[Camera], float]) -> tuple[Turn, float]:
    """Return the smallest turn that does nearly as well as any, and the uncertainty there."""
    strides = np.arange(STRIDE, FARTHEST + 0.5, STRIDE)
    turns = [Turn(*way, float(step)) for step in strides for way in WAYS]
    spreads = [uncertainty(each.of(camera)) for each in turns]
    enough = ENOUGH * min(spreads)
    found = next(k for k, spread in enumerate(spreads) if spread <= enough)
    best, then = turns[found], spreads[found]
    for fewer in np.arange(1.0, STRIDE):
        tried = replace(turns[found], degrees=turns[found].degrees - float(fewer))
        spread = uncertainty(tried.of(camera))
        if spread > enough:
            break
        best, then = tried, spread
    return best, then


def _predicted(stereo: Stereo, points: Array, lines: Array) -> float:
    """Return the median uncertainty of points on some lines, mm for 1 px; in the plane's frame."""
    slopes = image_slopes(stereo, points * MIRROR)
    tangents = np.einsum("pij,lj->pli", slopes, lines * MIRROR).reshape(-1, 2)
    length = np.linalg.norm(tangents, axis=1, keepdims=True)
    tangents = np.divide(tangents, length, out=np.zeros_like(tangents), where=length > 0.0)
    places = np.repeat(points, len(lines), axis=0)
    return float(np.median(sigmas(point_covariances(stereo, places, tangents))))


def _places(centre: Array, target: Array, diagonal: float, visible: float) -> Array:
    """Return places around what the view is about, no farther apart than what is seen."""
    way = target - centre
    length = float(np.linalg.norm(way))
    near = centre + way * min(1.0, 0.5 * diagonal / length if length > 0.0 else 1.0)
    return np.asarray(near + SPREAD * min(diagonal, visible) * CUBE)


def _lines(directions: ArrayLike | None, plane: CentrePlane) -> Array:
    """Return unit directions in the plane's frame, a dozen at most."""
    if directions is None:
        return USUAL
    ways = np.reshape(np.asarray(directions, float), (-1, 3))
    length = np.linalg.norm(ways, axis=1)
    ways = ways[np.isfinite(length) & (length > 0.0)]
    if not len(ways):
        return USUAL
    chosen = np.unique(np.linspace(0, len(ways) - 1, MOST).round().astype(int))
    ways = plane.inverse.directions(ways[chosen])
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


def _length(mm: float) -> str:
    return f"{mm:.1f} mm" if mm >= 1.0 else f"{mm:.2g} mm"


def first_advice(camera: Camera, state: SymmetryState) -> Advice:
    """Judge a view of an empty box; a better one is from above, and holds all of the box."""
    judged = advice(camera, state.plane, state.centre, state.diagonal, above=True)
    if judged.better is None:
        return judged
    return replace(judged, better=fit_points(judged.better, box_corners(state), ROOM))


def directions(state: SymmetryState, job: Job) -> Array | None:
    """Return tangents of the newest curves shown, (n, 3) in the model's frame; None if none."""
    found = []
    for curve in state.shown_curves[-NEWEST:]:
        job.checkpoint(0.5, curve.name)
        try:
            made = trace_of(curve, state).curve
        except UserError:
            continue
        if made is not None:
            steps = np.diff(made.spline.sampled(LOOKS), axis=0)
            found.append(state.plane.placement.directions(steps))
    return np.vstack(found) if found else None
