"""Faces that were made one by one, sewn along edges that are the same curve."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.geometry.brep.brep import Brep, Face, ParameterCurve, Trim, gap_tolerance

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.geometry.curve import Color, Curve

SAME_SHARE: Final = 1e-9
"""Difference of knots, as share of the range, and of weights, as share of the largest, that
counts as none."""


def sewn(breps: Iterable[Brep], name: str = "brep", color: Color | None = None) -> Brep:
    """Return faces as one, with edges shared that are the same curve.

    Curves are the same if their control points, knots and weights agree, in the same sense or
    the opposite one, within the gap that a `Brep` allows. A face may be sewn to itself: that is
    a seam. Surfaces stay what they are.

    Parameters
    ----------
    breps : iterable of Brep
        At least one. What looks outward must do so everywhere: only edges that two faces run in
        opposite senses are sewn. Where more than two faces meet, the first two that fit are.
        Faces keep the colours of their parts.
    name : str
        What the shape is called.
    color : (r, g, b), optional
        sRGB.
    """
    parts = list(breps)
    if not parts:
        raise ValueError("there is nothing to sew")
    edges = [edge for part in parts for edge in part.edges]
    starts = np.cumsum([0, *(len(part.edges) for part in parts)]).tolist()
    faces = [
        replace(
            face,
            loops=_renumbered(face, {e: e + start for e in range(len(part.edges))}),
            color=face.color or part.color,
        )
        for part, start in zip(parts, starts, strict=False)
        for face in part.faces
    ]
    senses: dict[int, list[bool]] = {}
    for face in faces:
        for trim in face.trims:
            if trim.edge is not None:
                senses.setdefault(trim.edge, []).append(trim.forward)
    tolerance = gap_tolerance([face.surface.control_points for face in faces])
    taken: dict[int, tuple[int, bool]] = {}
    free = {edge for edge, uses in senses.items() if len(uses) == 1}
    for one, two in _near(edges, tolerance):
        if one not in free or two not in free:
            continue
        for opposite in (True, False):
            fits = (senses[one][0] == senses[two][0]) == opposite
            if fits and same_curve(edges[one], edges[two], tolerance, opposite=opposite):
                taken[two] = one, opposite
                free -= {one, two}
                break
    kept = [number for number in range(len(edges)) if number not in taken]
    numbers = {old: new for new, old in enumerate(kept)}
    sewn_faces = tuple(
        replace(
            face,
            loops=tuple(
                tuple(_moved(trim, edges, taken, numbers) for trim in loop) for loop in face.loops
            ),
        )
        for face in faces
    )
    return Brep(tuple(edges[number] for number in kept), sewn_faces, name, color)


def same_curve(one: Curve, two: Curve, tolerance: float, *, opposite: bool) -> bool:
    """Whether two clamped curves agree, or agree if the second is run from its end.

    Parameters
    ----------
    one, two : Curve
        Their ranges may differ.
    tolerance : float
        Largest distance of control points, mm.
    opposite : bool
        Whether the second is run from its end to its start.
    """
    if one.degree != two.degree or len(one.control_points) != len(two.control_points):
        return False
    other = two.reversed() if opposite else two
    return (
        bool((np.abs(one.control_points - other.control_points) <= tolerance).all())
        and bool((np.abs(_shares(one) - _shares(other)) <= SAME_SHARE).all())
        and bool((np.abs(_relative_weights(one) - _relative_weights(other)) <= SAME_SHARE).all())
    )


def _near(edges: list[Curve], tolerance: float) -> list[tuple[int, int]]:
    """Return pairs of edges that agree at three places, whichever way they are run, in order."""
    from scipy.spatial import cKDTree

    rows = []
    for edge in edges:
        begin, end = edge.range
        a, b, c = edge.value(begin + (end - begin) * np.array([0.25, 0.5, 0.75]))
        rows.append(np.concatenate((0.5 * (a + c), b)))
    pairs = cKDTree(np.array(rows)).query_pairs(4.0 * tolerance, output_type="ndarray")
    return [(one, two) for one, two in sorted(map(tuple, pairs.tolist()))]


def _shares(curve: Curve) -> Array:
    begin, end = curve.range
    return (curve.knots - begin) / (end - begin)


def _relative_weights(curve: Curve) -> Array:
    """Return weights as shares of the largest."""
    if curve.weights is None:
        return np.ones(len(curve.control_points))
    return np.asarray(curve.weights / curve.weights.max())


def _renumbered(face: Face, numbers: dict[int, int]) -> tuple[tuple[Trim, ...], ...]:
    return tuple(
        tuple(
            trim if trim.edge is None else replace(trim, edge=numbers[trim.edge]) for trim in loop
        )
        for loop in face.loops
    )


def _moved(
    trim: Trim, edges: list[Curve], taken: dict[int, tuple[int, bool]], numbers: dict[int, int]
) -> Trim:
    """Return a side as one of the edge that took the place of its own."""
    if trim.edge is None:
        return trim
    if trim.edge not in taken:
        return replace(trim, edge=numbers[trim.edge])
    kept, opposite = taken[trim.edge]
    curve = over_range(trim.curve, edges[kept].range, opposite=opposite)
    return Trim(numbers[kept], trim.forward != opposite, curve)


def over_range(
    curve: ParameterCurve, target: tuple[float, float], *, opposite: bool
) -> ParameterCurve:
    """Return the same curve over another range, from its end where that is opposite."""
    (begin, end), (low, high) = curve.range, target
    share = (curve.knots - begin) / (end - begin)
    weights = curve.weights
    points = curve.control_points
    if opposite:
        share, points = 1.0 - share[::-1], points[::-1]
        weights = None if weights is None else weights[::-1]
    knots = np.where(share == 1.0, high, low + (high - low) * share)
    return ParameterCurve(curve.degree, knots, points, weights)
