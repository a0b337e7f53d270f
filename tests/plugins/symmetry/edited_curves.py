"""Curves in space that the tests of editing change, and what they measure of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bozzetto.geometry.spline import Spline
from bozzetto.ink import fit_spline
from bozzetto_symmetry.fitting.half_curve import halves_of
from bozzetto_symmetry.fitting.space_curve import SpaceCurve, across
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import scenes

Array = NDArray[np.float64]


def _through(points: Array, controls: int, *, closed: bool = False) -> Spline:
    return fit_spline(points, controls=controls, closed=closed, pixel=0.6).spline


PAIR = SpaceCurve("pair", _through(scenes.PAIRS["S-wave"], 13))
RAIL = SpaceCurve("pair", _through(scenes.PAIRS["roof rail"], 9))
LOOP = SpaceCurve("pair", _through(scenes.LOOPS["bean"], 11, closed=True))
FLAT = SpaceCurve("plane", _through(scenes.FLAT["roof line"], 9))
ACROSS = SpaceCurve("self", across(_through(scenes.HALVES["wavy bumper"], 9).control_points))
RING = SpaceCurve("self", across(scenes.RINGS["grille"][:151:15], ring=True))

ALL = {"pair": PAIR, "loop": LOOP, "plane": FLAT, "across": ACROSS, "ring": RING}
OPEN = {"pair": PAIR, "plane": FLAT, "across": ACROSS}


def farthest(one: Spline, other: Spline) -> float:
    """How far places of a spline are from another one, mm, at most."""
    near = other.foot_points(one.sampled(400))
    return float(np.linalg.norm(one.sampled(400) - other.value(near), axis=1).max())


def same(one: Spline, other: Spline) -> float:
    """How far two splines are apart, mm, at most."""
    return max(farthest(one, other), farthest(other, one))


def hausdorff(one: Array, other: Array) -> float:
    """How far two dense rows of places are apart at most."""
    return float(max(cKDTree(a).query(b)[0].max() for a, b in ((one, other), (other, one))))


def kink(spline: Spline) -> float:
    """Greatest turn of the direction at a knot, radians."""
    begin, end = spline.range
    knots = np.unique(spline.knots[3:-3])
    knots = knots if spline.closed else knots[1:-1]
    step = 1e-7 * (end - begin)
    before, after = (_directions(spline, knots + side * step) for side in (-1.0, 1.0))
    return float(np.linalg.norm(after - before, axis=1).max(initial=0.0))


def _directions(spline: Spline, at: Array) -> Array:
    velocity = spline.derivative(at)
    return np.asarray(velocity / np.linalg.norm(velocity, axis=1, keepdims=True))


def check(curve: SpaceCurve) -> None:
    """What holds of every curve of a symmetric thing, exactly."""
    points = curve.spline.control_points
    assert np.isfinite(points).all()
    if curve.reading == "plane":
        assert (points[:, 1] == 0.0).all()
    if curve.reading == "self":
        halves = halves_of(curve.spline)
        once = points[:-3] if curve.closed else points
        assert (once[halves.partner] * MIRROR == once).all()
        crossings = [halves.middle, halves.end] if halves.ring else [halves.middle]
        velocity = curve.spline.derivative(crossings)
        along = np.hypot(velocity[:, 0], velocity[:, 2])
        assert (along <= 1e-9 * np.abs(velocity[:, 1])).all()
        size = np.abs(points).max()
        assert np.abs(curve.spline.value(crossings)[:, 1]).max() <= 1e-12 * size
