"""Normals of a surface along a curve on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property, remembered

STEPS: Final = 12
"""Steps of the moving frame on every span of a curve."""

MOST_SHARED: Final = 128
"""Parameters of a field up to which its cubic spline is shared by all fields that have them."""

VANISHING: Final = 1e-24
"""Square of the turn of a tangent that tells no direction."""

SHORT: Final = 1e-9
"""Length of a tangent, as share of the curve's size, that tells no direction."""


@dataclass(frozen=True, eq=False)
class NormalField:
    """Unit normals by the parameter of a curve.

    Parameters
    ----------
    spline : Spline
        Open.
    parameters : (m,) float
        Rising, over its range.
    normals : (m, 3) float
        Of about unit length, across the curve.
    """

    spline: Spline
    parameters: Array
    normals: Array

    @cached_property
    def _own_spline(self) -> Any:
        from scipy.interpolate import CubicSpline

        return CubicSpline(self.parameters, self.normals)

    def _between(self, at: Array, order: int = 0) -> Array:
        """Return the normals between those given, or their derivative, (n, 3)."""
        if len(self.parameters) > MOST_SHARED:
            return np.asarray(self._own_spline(at, order))
        return np.asarray(_shares_of(self.parameters)(at, order) @ self.normals)

    def value(self, at: Array) -> Array:
        """Return unit normals, exactly across the curve, (n, 3)."""
        return across(self._between(at), unit_tangents(self.spline, at))

    @cached_property
    def end_torsions(self) -> Array:
        """The geodesic torsions at start and end, (2,), radians by mm."""
        at = self.parameters[[0, -1]]
        tangents = unit_tangents(self.spline, at)
        normals = self.value(at)
        speed = np.linalg.norm(self.spline.derivative(at), axis=1)
        rate = (self._between(at, 1) * cross_product(tangents, normals)).sum(axis=1)
        return np.asarray(rate / np.where(speed > 0.0, speed, np.inf))

    @cached_property
    def end_curvatures(self) -> Array:
        """The curvature vectors of the curve at start and end, (2, 3), by mm."""
        at = self.parameters[[0, -1]]
        way, bend = self.spline.derivative(at), self.spline.derivative(at, 2)
        square = (way * way).sum(axis=1, keepdims=True)
        square = np.where(square > 0.0, square, np.inf)
        return np.asarray((bend - (bend * way).sum(axis=1, keepdims=True) / square * way) / square)

    @cached_property
    def length(self) -> float:
        """Length of a chain of places on the curve, mm."""
        places = self.spline.value(self.parameters)
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())

    def reversed_sign(self) -> NormalField:
        """Return the field that points to the other side."""
        return NormalField(self.spline, self.parameters, -self.normals)

    def turned(self, angles: Callable[[Array], Array]) -> NormalField:
        """Return the field turned about the curve.

        Parameters
        ----------
        angles : callable
            Gives radians (m,) by the shares (m,) of the curve's length.
        """
        tangents = unit_tangents(self.spline, self.parameters)
        angle = angles(length_shares(self.spline, self.parameters))
        normals = across(self.normals, tangents)
        return NormalField(self.spline, self.parameters, rotated(normals, tangents, angle))


@remembered(limit=256, key=lambda parameters: parameters.tobytes())
def _shares_of(parameters: Array) -> Any:
    """Return the cubic spline of the share that each of the values at parameters has, (m,)."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(parameters, np.eye(len(parameters)))


def unit_tangents(spline: Spline, at: Array) -> Array:
    """Return unit tangents of a curve; where one vanishes, that of a place beside it, (n, 3)."""
    way = spline.derivative(at)
    length = np.linalg.norm(way, axis=1)
    size = float(np.linalg.norm(np.ptp(spline.control_points, axis=0)))
    begin, end = spline.range
    low = length <= SHORT * size / (end - begin)
    if low.any():
        step = 1e-3 * (end - begin)
        here = np.asarray(at)[low]
        way[low] = spline.value(here + step) - spline.value(here - step)
        length = np.linalg.norm(way, axis=1)
        still = length <= 0.0
        way[still] = spline.value(np.array([end]))[0] - spline.value(np.array([begin]))[0]
        way[still & (np.abs(way).max(axis=1) == 0.0)] = (1.0, 0.0, 0.0)
        length = np.linalg.norm(way, axis=1)
    return np.asarray(way / length[:, None])


def across(vectors: Array, tangents: Array) -> Array:
    """Return unit vectors across tangents; any one where a vector runs along its tangent."""
    made = vectors - (vectors * tangents).sum(axis=-1, keepdims=True) * tangents
    length = np.linalg.norm(made, axis=-1, keepdims=True)
    weak = length[..., 0] <= 1e-9
    if weak.any():
        axes = np.eye(3)[np.argmin(np.abs(tangents), axis=-1)]
        other = axes - (axes * tangents).sum(axis=-1, keepdims=True) * tangents
        made = np.where(weak[..., None], other, made)
        length = np.linalg.norm(made, axis=-1, keepdims=True)
    return np.asarray(made / length)


def rotated(vectors: Array, axes: Array, angles: Array) -> Array:
    """Return vectors turned about unit axes across them, (n, 3)."""
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return np.asarray(cosine * vectors + sine * cross_product(axes, vectors))


def length_shares(spline: Spline, at: Array) -> Array:
    """Return the shares of a chain's length through places on a curve, 0 … 1."""
    steps = np.linalg.norm(np.diff(spline.value(at), axis=0), axis=1)
    arc = np.concatenate(((0.0,), np.cumsum(steps)))
    if arc[-1] <= 0.0:
        return np.linspace(0.0, 1.0, len(at))
    return np.asarray(arc / arc[-1])


def frame_parameters(spline: Spline) -> Array:
    """Return the parameters at which a frame is carried along a curve."""
    begin, end = spline.range
    breaks = np.unique(np.concatenate(((begin, end), spline.knots)))
    breaks = breaks[(breaks >= begin) & (breaks <= end)]
    steps = max(STEPS, -(-32 // (len(breaks) - 1)))
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(steps) / steps
    return np.append(inner.ravel(), end)


def frame_of(spline: Spline, first: Array) -> NormalField:
    """Return normals that do not turn about a curve.

    The rotation-minimising frame by double reflection (Wang et al. 2008, "Computation of rotation
    minimizing frames").

    Parameters
    ----------
    spline : Spline
        Open.
    first : (3,) float
        Normal at its start.
    """
    at = frame_parameters(spline)
    tangents = unit_tangents(spline, at)
    steps = np.diff(spline.value(at), axis=0)
    one = _reflections(steps, 0.0)
    bends = tangents[1:] - np.einsum("kij,kj->ki", one, tangents[:-1])
    two = _reflections(bends, VANISHING)
    normals = np.empty_like(tangents)
    normals[0] = across(np.asarray(first, float)[None], tangents[:1])[0]
    for k, turn in enumerate(two @ one):
        normals[k + 1] = turn @ normals[k]
    return NormalField(spline, at, across(normals, tangents))


@remembered(limit=4000, key=lambda spline, first, last: (spline, first.tobytes(), last.tobytes()))
def carried(spline: Spline, first: Array, last: Array) -> NormalField:
    """Return normals that turn evenly, and as little as possible, between two given ones.

    Parameters
    ----------
    spline : Spline
        Open.
    first, last : (3,) float
        Normals at its ends.
    """
    frame = frame_of(spline, first)
    tangent = unit_tangents(spline, frame.parameters[-1:])
    end = across(np.asarray(last, float)[None], tangent)[0]
    angle = angle_about(tangent[0], frame.normals[-1], end)
    return frame.turned(lambda shares: angle * shares)


def angle_about(axis: Array, one: Array, other: Array) -> float:
    """Return the angle from one vector to another about a unit axis, radians."""
    return float(
        np.arctan2(cross_product(one, other) @ axis, one @ other - (one @ axis) * (other @ axis))
    )


def _reflections(vectors: Array, least: float) -> Array:
    """Return the matrices (n, 3, 3) that reflect along longer vectors (n, 3)."""
    square = (vectors * vectors).sum(axis=1)
    factors = np.divide(2.0, square, out=np.zeros_like(square), where=square > least)
    return np.asarray(np.eye(3) - factors[:, None, None] * vectors[:, :, None] * vectors[:, None])
