"""Principal and mean curvature of bicubic patches, in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.geometry.patches.patch import FLAT_SINE, grid


@dataclass(frozen=True, eq=False)
class Curvatures:
    """Curvatures of surfaces at places, 1/mm.

    A surface that bulges to the side its normal points to has positive curvature, a hollow
    negative. All are 0 where there is no tangent plane.

    Attributes
    ----------
    most, least : (…) float
        The principal curvatures, ``most >= least``.
    """

    most: Array
    least: Array

    @property
    def mean(self) -> Array:
        """Mean curvature, 1/mm, (…)."""
        return 0.5 * (self.most + self.least)


def grid_curvatures(nets: ArrayLike, u: ArrayLike, v: ArrayLike) -> Curvatures:
    """Return curvatures of all patches on one grid of parameters, each of shape (k, a, b).

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        mm.
    u, v : (a,), (b,) array_like
        Parameters of the grid, 0 … 1.
    """
    nets = np.asarray(nets, float)
    orders = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    return _bent(*(grid(nets, u, v, du=du, dv=dv) for du, dv in orders))


def _bent(by_u: Array, by_v: Array, by_uu: Array, by_uv: Array, by_vv: Array) -> Curvatures:
    """Compute curvatures from first and second derivatives (do Carmo 1976, section 3-3).

    The second fundamental form is written in a frame of two unit tangents, one along x_u. There
    the first form is the identity, and what is left is the eigenvalues of a symmetric matrix;
    the textbook's H² − K would lose half of the digits where both curvatures are alike.
    """
    across = np.cross(by_u, by_v)
    area, along = (np.sqrt((a * a).sum(-1)) for a in (across, by_u))
    sound = area > FLAT_SINE * along * np.sqrt((by_v * by_v).sum(-1))
    area, along = np.where(sound, area, 1.0), np.where(sound, along, 1.0)
    normal = across / area[..., None]
    # With e₁ along x_u:  x_u = p e₁,  x_v = q e₁ + r e₂.
    p, q, r = along, (by_u * by_v).sum(-1) / along, area / along
    uu, uv, vv = (-(d * normal).sum(-1) for d in (by_uu, by_uv, by_vv))
    first = uu / (p * p)
    mixed = (uv - q * uu / p) / (p * r)
    second = (vv - 2.0 * q * uv / p + q * q * first) / (r * r)
    middle, half = 0.5 * (first + second), np.hypot(0.5 * (first - second), mixed)
    return Curvatures(np.where(sound, middle + half, 0.0), np.where(sound, middle - half, 0.0))
