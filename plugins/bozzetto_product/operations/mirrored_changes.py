"""Changes of a curve that is its own mirror image: what one half does, the other does as well."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import DEGREE, Spline
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.reflection import OWN_IMAGE, Reflection, size_of

SAME_KNOT: Final = 1e-9
"""Distance of knots, as share of the curve's parameters, up to which they are one."""

LOOKS: Final = 33
"""Places at which both halves are compared."""


def changed_on_both_sides(before: Spline, after: Spline, symmetry: Plane) -> Spline:
    """Return a changed curve with the change on both halves, if it was its own mirror image.

    Over the knots of both, control points go where the change and its mirror image take them; where
    both do, each counts as much as it moves, so that the change stays smooth in the middle. What
    is changed on both sides alike stays what it is.

    Parameters
    ----------
    before, after : Spline
        The curve, over the same parameters.
    symmetry : Plane
        In which it is mirrored.

    Returns
    -------
    Spline
        `after` itself where the curve was not its own mirror image from end to end.
    """
    reflection = Reflection(symmetry)
    if after is before or before.closed or not _runs_evenly(before, reflection):
        return after
    image = reflection.spline(after).reversed()
    knots = _joined_knots(before, after, image)
    base, one, other = (_over(spline, knots) for spline in (before, after, image))
    change, mirrored = one - base, other - base
    weight, weight_mirrored = (np.linalg.norm(rows, axis=1)[:, None] for rows in (change, mirrored))
    total = weight + weight_mirrored
    share = np.divide(weight, total, out=np.zeros_like(total), where=total > 0.0)
    return reflection.symmetric(
        Spline(knots, base + share * change + (1.0 - share) * mirrored, before.closed)
    )


def _runs_evenly(spline: Spline, reflection: Reflection) -> bool:
    """Whether each half runs as the mirror image of the other, backwards."""
    at = np.linspace(*spline.range, LOOKS)
    miss = np.linalg.norm(reflection.points(spline.value(at)) - spline.value(at[::-1]), axis=1)
    return bool(miss.max() <= OWN_IMAGE * size_of(spline))


def _joined_knots(*splines: Spline) -> Array:
    """Return all knots of curves over the same parameters, each as often as the one with most."""
    begin, end = splines[0].range
    near = SAME_KNOT * (end - begin)
    rows = [spline.knots[DEGREE + 1 : -DEGREE - 1] for spline in splines]
    every = np.sort(np.concatenate(rows))
    apart = np.concatenate(([True], np.diff(every) > near)) if len(every) else np.zeros(0, bool)
    knots: list[float] = []
    for value in every[apart].tolist():
        count = max(int((np.abs(row - value) <= near).sum()) for row in rows)
        knots += [value] * count
    ends = np.repeat(begin, DEGREE + 1), np.repeat(end, DEGREE + 1)
    return np.concatenate((ends[0], knots, ends[1]))


def _over(spline: Spline, knots: Array) -> Array:
    """Return the control points of the same curve over more knots."""
    from scipy.interpolate import BSpline

    near = SAME_KNOT * float(knots[-1] - knots[0])
    inner, own = knots[DEGREE + 1 : -DEGREE - 1], spline.knots[DEGREE + 1 : -DEGREE - 1]
    finer = BSpline(spline.knots, spline.control_points, DEGREE)
    for value in np.unique(inner).tolist():
        more = int((inner == value).sum()) - int((np.abs(own - value) <= near).sum())
        if more > 0:
            finer = finer.insert_knot(value, more)
    return np.asarray(finer.c)
