"""The plane over which a detail is drawn: places on a surface by two coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface
from bozzetto.plugin import remembered

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

STEEPEST: Final = np.cos(np.radians(76.0))
"""Least cosine between a surface under an outline and its chart: beyond it a floor would fold."""

STEPS: Final = 400
"""Steps towards the axis of a cone."""

GRID: Final = 21
"""Places along each parameter of a surface from which a search begins."""

ROUNDS: Final = 40
"""Most steps of Newton's method."""

EXACT: Final = 1e-13
"""Distance in the chart, as share of the size of the surface, that counts as found."""

STILL: Final = 1e-15
"""Change of a parameter below which a step moved nothing: the place is on the border."""

FOUND: Final = 1e-9
"""Distance in the chart, as share of the size of the surface, beyond which a place is not there."""


@dataclass(frozen=True, eq=False)
class Chart:
    """A plane that faces a region of a surface.

    Parameters
    ----------
    origin : (3,) float
        mm.
    axes : (3, 3) float
        Rows: x, y, and the normal, which points outward.
    """

    origin: Array
    axes: Array

    @classmethod
    def facing(cls, points: Array, normals: Array) -> Chart:
        """Return the chart at the mean of places (n, 3), across the mean of their normals.

        Where that is too far from one of them it is across the axis of the narrowest cone round
        all, so that an outline may go from a top over its rim down an upright wall.

        Raises
        ------
        UserError
            If the surface turns too far from one place to another.
        """
        mean = normals.mean(axis=0)
        for way in (mean, _axis_of(normals)):
            length = float(np.linalg.norm(way))
            if length >= 1e-6 and float((normals @ way).min()) >= STEEPEST * length:
                break
        else:
            raise UserError(
                "The outline goes too far round the shape. Draw it in two parts, each on one side."
            )
        up = way / length
        x = cross_product(np.eye(3)[int(np.argmin(np.abs(up)))], up)
        x /= np.linalg.norm(x)
        return cls(points.mean(axis=0), np.stack((x, cross_product(up, x), up)))

    @property
    def normal(self) -> Array:
        """Unit vector that points outward, (3,)."""
        return np.asarray(self.axes[2])

    def flat(self, points: Array) -> Array:
        """Return the coordinates of points in space, (n, 2)."""
        return np.asarray((points - self.origin) @ self.axes[:2].T)

    def heights(self, points: Array) -> Array:
        """Return the distances of points from the plane, outward, (n,)."""
        return np.asarray((points - self.origin) @ self.axes[2])


def _axis_of(normals: Array) -> Array:
    """Return about the axis of the narrowest cone round unit vectors, (3,), not of unit length.

    Bădoiu & Clarkson 2003, *Smaller core-sets for balls*, section 3: a step towards the farthest
    one, each shorter than the last.
    """
    axis = normals.mean(axis=0)
    for number in range(1, STEPS + 1):
        farthest = normals[int(np.argmin(normals @ axis))]
        axis = axis + (farthest - axis) / (number + 1.0)
    return np.asarray(axis)


@remembered(
    limit=4096,
    key=lambda surface, chart, places, outward: (surface, chart, places.tobytes(), outward),
)
def parameters_at(surface: BSplineSurface, chart: Chart, places: Array, outward: float) -> Array:
    """Return where a surface is over places of a chart.

    Remembered: while depth, draft or gap of a detail change, the same places are asked for.

    Parameters
    ----------
    surface : BSplineSurface
        Whose parameters are sought.
    chart : Chart
        Its plane.
    places : (n, 2) float
        In the chart, mm.
    outward : float
        1 for a side that faces the chart, −1 for one that faces away.

    Returns
    -------
    (n, 2) float
        u and v; NaN where the surface is not there.
    """
    made = np.full((len(places), 2), np.nan)
    seeds, tree, reach = _seeds(surface, chart, outward)
    if tree is None:
        return made
    gaps, first = tree.query(places)
    rows = np.flatnonzero(gaps <= reach)
    at = seeds[np.asarray(first)[rows]]
    size = surface.size
    low, high = np.transpose(surface.ranges)
    for _ in range(ROUNDS):
        if not len(rows):
            break
        off = places[rows] - chart.flat(surface.value(*at.T))
        far = np.abs(off).max(axis=1) > EXACT * size
        step = _newton_step(surface, chart, at[far], off[far], size) * (high - low)
        after = np.clip(at[far] + step, low, high)
        moved = np.abs(after - at[far]).max(axis=1, initial=0.0) > STILL
        at[far] = after
        going = np.flatnonzero(far)[moved]
        made[rows] = at
        rows, at = rows[going], at[going]
    there = np.isfinite(made[:, 0])
    off = np.linalg.norm(places[there] - chart.flat(surface.value(*made[there].T)), axis=1)
    facing = surface.normals(*made[there].T) @ chart.normal * outward > 0.0
    made[np.flatnonzero(there)[(off > FOUND * size) | ~facing]] = np.nan
    return made


def _newton_step(
    surface: BSplineSurface, chart: Chart, at: Array, off: Array, size: float
) -> Array:
    """Return steps of Newton's method as shares of the ranges, none longer than a fifth."""
    width = np.diff(surface.ranges, axis=1).ravel()
    along_u = surface.derivative(at[:, 0], at[:, 1], 1, 0) @ chart.axes[:2].T * width[0]
    along_v = surface.derivative(at[:, 0], at[:, 1], 0, 1) @ chart.axes[:2].T * width[1]
    whole = along_u[:, 0] * along_v[:, 1] - along_u[:, 1] * along_v[:, 0]
    least = 1e-12 * size * size
    whole = np.where(np.abs(whole) > least, whole, least)
    step = np.column_stack(
        (
            (off[:, 0] * along_v[:, 1] - off[:, 1] * along_v[:, 0]) / whole,
            (along_u[:, 0] * off[:, 1] - along_u[:, 1] * off[:, 0]) / whole,
        )
    )
    return np.asarray(np.clip(step, -0.2, 0.2))


@remembered(limit=1024, key=lambda surface, chart, outward: (surface, chart, outward))
def _seeds(
    surface: BSplineSurface, chart: Chart, outward: float
) -> tuple[Array, cKDTree | None, float]:
    """Return parameters on a grid that faces the chart, a tree of them there, and its reach."""
    from scipy.spatial import cKDTree

    axes = [np.linspace(low, high, GRID) for low, high in surface.ranges]
    u, v = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    flat = chart.flat(surface.value(u, v))
    cells = flat.reshape(GRID, GRID, 2)
    reach = 2.0 * max(float(np.linalg.norm(np.diff(cells, axis=k), axis=2).max()) for k in range(2))
    facing = surface.normals(u, v) @ chart.normal * outward > 0.0
    seeds = np.column_stack((u, v))[facing]
    return seeds, cKDTree(flat[facing]) if facing.any() else None, reach
