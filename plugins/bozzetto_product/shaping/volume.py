"""The volume under a surface, as an exact cubic in the size of a displacement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import BSplineSurface
from bozzetto_product.fill.quintic import DEGREE

GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)
"""Quadrature on every span, -1 … 1: exact for the degree of the integrand, 3 · 5 - 1."""

AT: Final = (-1.0, 0.0, 1.0, 2.0)
"""Sizes at which the volume is computed: a cubic is known by four."""

REAL: Final = 1e-7
"""Imaginary part, as share of a root, below which it is real."""


def volume_of(patches: Sequence[BSplineSurface], origin: Array) -> float:
    """Return the volume between patches and a point, by Gauss's theorem; mm³.

    Only differences between surfaces of one boundary do not depend on the point.
    """
    return sum(
        _volume_under(patch.control_points - origin, patch.knots_u, patch.knots_v)
        for patch in patches
    )


def displaced_volume(
    patches: Sequence[BSplineSurface], moved: Sequence[BSplineSurface], origin: Array
) -> Callable[[float], float]:
    """Return the volume by the size of a displacement that takes patches to others at size one."""
    nets = [
        (one.control_points - origin, other.control_points - one.control_points, one.knots)
        for one, other in zip(patches, moved, strict=True)
    ]
    return lambda size: sum(_volume_under(net + size * way, *knots) for net, way, knots in nets)


def _volume_under(net: Array, knots_u: Array, knots_v: Array) -> float:
    weights_u, values_u, slopes_u = _rows(knots_u.tobytes())
    weights_v, values_v, slopes_v = _rows(knots_v.tobytes())
    along, bent = values_v @ net, slopes_v @ net
    shape = (len(weights_u), len(weights_v), 3)
    place = (values_u @ along.reshape(len(net), -1)).reshape(shape)
    by_u = (slopes_u @ along.reshape(len(net), -1)).reshape(shape)
    by_v = (values_u @ bent.reshape(len(net), -1)).reshape(shape)
    height = (place * cross_product(by_u, by_v)).sum(axis=-1)
    return float(weights_u @ height @ weights_v) / 3.0


@lru_cache(maxsize=256)
def _rows(knots: bytes) -> tuple[Array, Array, Array]:
    """Return weights, values and first derivatives of all basis functions at Gauss nodes."""
    from scipy.interpolate import BSpline

    row = np.frombuffer(knots)
    spans = np.unique(row)
    width = 0.5 * np.diff(spans)[:, None]
    at = (0.5 * (spans[1:] + spans[:-1])[:, None] + width * GAUSS_NODES).ravel()
    basis = BSpline(row, np.eye(len(row) - DEGREE - 1), DEGREE)
    return (width * GAUSS_WEIGHTS).ravel(), basis(at), basis(at, 1)


def size_for(volume: Callable[[float], float], wanted: float, scale: float) -> float | None:
    """Return the displacement of least size that has a volume; None where none has it.

    Parameters
    ----------
    volume : callable
        Volume by the size of the displacement: a cubic.
    wanted : float
        In the same units.
    scale : float
        A size of the displacement near the one that is looked for.
    """
    values = [volume(scale * at) for at in AT]
    roots = np.roots(np.polyfit(AT, np.array(values) - wanted, 3))
    real = roots[np.abs(roots.imag) <= REAL * np.maximum(np.abs(roots), 1.0)].real
    if not len(real):
        return None
    return scale * float(real[np.argmin(np.abs(real))])
