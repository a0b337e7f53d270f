"""Bicubic Bézier patches in space: values, derivatives, normals, exact pieces and images.

A patch is a *control net*, (4, 4, 3) mm: ``net[i, j]`` weighs with the i-th Bernstein polynomial
of u and the j-th of v, both over 0 … 1. Many patches are one array, (k, 4, 4, 3). All functions
here are plain array work, quick enough to follow a pen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index

FLAT_SINE: Final = 1e-9
"""Sine of the angle between the tangents in u and v below which they tell no tangent plane."""

INWARD: Final = 1e-3
"""Share of the way to the middle of its patch that is gone for a normal where there is none, as
in a corner whose two edges run on into each other."""

EXTENT_TOLERANCE: Final = 1e-10
"""Error of `extent`, per unit of the largest coordinate."""

HALVES: Final = np.array(
    [
        [[8, 0, 0, 0], [4, 4, 0, 0], [2, 4, 2, 0], [1, 3, 3, 1]],
        [[1, 3, 3, 1], [0, 2, 4, 2], [0, 0, 4, 4], [0, 0, 0, 8]],
    ],
    float,
) / 8.0  # fmt: skip
"""Control points of both halves of a cubic from those of the whole (de Casteljau 1959)."""

EXTENT_PIECES: Final = 1 << 15
"""Most pieces kept in the search for an extent. Along a ridge that is level all pieces reach as
far; those dropped then are so small that they stick out by less than 10⁻⁹ of the patch."""


@dataclass(frozen=True, eq=False)
class Places:
    """Places on patches, which follow when the patches change.

    Attributes
    ----------
    patches : (n,) int
        −1 where there is none.
    parameters : (n, 2) float
        u and v, 0 … 1; 0 where there is no place.
    """

    patches: Index
    parameters: Array

    def __len__(self) -> int:
        return len(self.patches)

    def __getitem__(self, which: slice | Flags | Index) -> Places:
        return Places(self.patches[which], self.parameters[which])


def bernstein(at: ArrayLike, order: int = 0) -> Array:
    """Evaluate the cubic Bernstein polynomials, or a derivative of them.

    Parameters
    ----------
    at : (n,) array_like
        Parameters, 0 … 1.
    order : int
        Order of the derivative: 0 … 3.

    Returns
    -------
    (n, 4) float
    """
    t = np.asarray(at, float)
    s = 1.0 - t
    degree = 3 - order
    if degree == 3:
        rows = np.stack((s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t), axis=-1)
    elif degree == 2:
        rows = np.stack((s * s, 2.0 * t * s, t * t), axis=-1)
    elif degree == 1:
        rows = np.stack((s, t), axis=-1)
    else:
        rows = np.ones((*t.shape, 1))
    for level in range(order):  # forward differences of the control points, one by one
        padded = np.zeros((*rows.shape[:-1], rows.shape[-1] + 1))
        padded[..., :-1] -= rows
        padded[..., 1:] += rows
        rows = (degree + 1 + level) * padded
    return rows


def grid(nets: ArrayLike, u: ArrayLike, v: ArrayLike, *, du: int = 0, dv: int = 0) -> Array:
    """Evaluate all patches, or derivatives of them, on one grid of parameters.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control points, mm.
    u, v : (a,), (b,) array_like
        Parameters of the grid, 0 … 1.
    du, dv : int
        Orders of the derivatives by u and by v.

    Returns
    -------
    (k, a, b, 3) float
    """
    return np.ascontiguousarray(np.moveaxis(_columns(nets, u, v, du, dv), 0, -1))


def _columns(nets: ArrayLike, u: ArrayLike, v: ArrayLike, du: int, dv: int) -> Array:
    """Evaluate like `grid`, each coordinate by itself, (3, k, a, b): quicker to go on with."""
    nets = np.asarray(nets, float)
    rows, columns = bernstein(u, du), bernstein(v, dv)
    both = (rows.T[:, None, :, None] * columns.T[None, :, None, :]).reshape(
        16, len(rows) * len(columns)
    )
    flat = np.ascontiguousarray(nets.reshape(-1, 16, 3).transpose(2, 0, 1))
    return np.asarray(
        (flat.reshape(-1, 16) @ both).reshape(*flat.shape[:2], len(rows), len(columns))
    )


def grid_normals(nets: ArrayLike, u: ArrayLike, v: ArrayLike) -> Array:
    """Return unit normals of all patches on one grid of parameters, along x_u × x_v.

    Parameters
    ----------
    nets, u, v
        As in `grid`.

    Returns
    -------
    (k, a, b, 3) float
        In a corner without a tangent plane that of a place just inside; 0 where the patch has
        none there either.
    """
    nets = np.asarray(nets, float)
    across, sound = _unit_across(_columns(nets, u, v, 1, 0), _columns(nets, u, v, 0, 1))
    normals = np.ascontiguousarray(np.moveaxis(across, 0, -1))
    if not sound.all():
        patches, i, j = np.nonzero(~sound)
        at = np.column_stack((np.asarray(u, float)[i], np.asarray(v, float)[j]))
        normals[patches, i, j] = normals_at(nets, Places(patches, at))
    return normals


def points_at(nets: ArrayLike, places: Places, *, du: int = 0, dv: int = 0) -> Array:
    """Evaluate patches, or derivatives of them, at places.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control points, mm.
    places : Places
        All of them on patches.
    du, dv : int
        Orders of the derivatives by u and by v.

    Returns
    -------
    (n, 3) float
    """
    own = np.asarray(nets, float)[places.patches]
    u, v = places.parameters.T
    across = (bernstein(u, du)[:, None] @ own.reshape(-1, 4, 12)).reshape(-1, 4, 3)
    return np.asarray((bernstein(v, dv)[:, None] @ across)[:, 0])


def normals_at(nets: ArrayLike, places: Places) -> Array:
    """Return unit normals at places, (n, 3), as `grid_normals` gives them."""
    across, sound = _unit_across(points_at(nets, places, du=1).T, points_at(nets, places, dv=1).T)
    normals = np.ascontiguousarray(across.T)
    if not sound.all():
        hidden = places[~sound]
        inside = Places(hidden.patches, hidden.parameters + INWARD * (0.5 - hidden.parameters))
        normals[~sound] = _unit_across(
            points_at(nets, inside, du=1).T, points_at(nets, inside, dv=1).T
        )[0].T
    return normals


def _unit_across(a: Array, b: Array) -> tuple[Array, Flags]:
    """Return unit vectors across two, (3, …), 0 where they are parallel, and where they are not."""
    across = np.stack(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )
    length = np.sqrt(_squares(across))
    sound = length > FLAT_SINE * np.sqrt(_squares(a) * _squares(b))
    across *= sound / np.where(sound, length, 1.0)
    return across, sound


def _squares(a: Array) -> Array:
    """Return squared lengths of vectors (3, …)."""
    return np.asarray(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


# -- pieces and images -----------------------------------------------------------------------------


def split(nets: ArrayLike, at: float, axis: int) -> tuple[Array, Array]:
    """Split patches along a line of one parameter (de Casteljau 1959).

    Parameters
    ----------
    nets : (k, 4, 4, d) array_like
        Control points.
    at : float
        0 … 1.
    axis : int
        0 cuts at u, 1 at v.

    Returns
    -------
    low, high : (k, 4, 4, d) float
        Each over its own 0 … 1. Their common control points are the same numbers.
    """
    row = np.moveaxis(np.asarray(nets, float), axis + 1, 1)
    low, high = np.empty_like(row), np.empty_like(row)
    for level in range(4):
        low[:, level], high[:, 3 - level] = row[:, 0], row[:, -1]
        row = (1.0 - at) * row[:, :-1] + at * row[:, 1:]
    return np.moveaxis(low, 1, axis + 1), np.moveaxis(high, 1, axis + 1)


def halved(nets: Array) -> Array:
    """Return all quarters of patches, (4, k, 4, 4, d): halves of u, and in each those of v."""
    return np.stack([part for half in split(nets, 0.5, 0) for part in split(half, 0.5, 1)])


def turned_over(nets: ArrayLike) -> Array:
    """Return the same patches with u reversed, so that their normals point the other way."""
    return np.asarray(nets, float)[:, ::-1].copy()


def mirrored(nets: ArrayLike, axis: int = 1) -> Array:
    """Return mirror images in the plane where one coordinate is 0, exact to the last bit.

    They are turned over, too: normals that pointed outward still do.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control points, mm.
    axis : int
        Number of the coordinate that changes its sign.
    """
    made = turned_over(nets)
    made[..., axis] *= -1.0
    return made


# -- extent ----------------------------------------------------------------------------------------


def extent(nets: ArrayLike) -> Array:
    """Return the bounding box of the surface itself; that of the control points is larger.

    Branch and bound: a patch lies within its control points, and its corners lie on it. What
    cannot reach further than a corner does is dropped, the rest is cut in quarters.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        ``k >= 1``.

    Returns
    -------
    (2, 3) float
        Least and largest coordinates, within `EXTENT_TOLERANCE`, mm.
    """
    nets = np.asarray(nets, float)
    slack = EXTENT_TOLERANCE * float(np.abs(nets).max())
    # All six ways at once: downward along the three axes, then upward.
    heights = np.stack([sign * nets[..., axis] for sign in (-1.0, 1.0) for axis in range(3)])
    found = _highest(heights, slack).reshape(2, 3)
    return found * [[-1.0], [1.0]]


def _highest(heights: Array, slack: float) -> Array:
    """Return upper bounds, tight within slack, of each row of polynomials (r, k, 4, 4)."""
    rows, patches = heights.shape[:2]
    row, pieces = np.repeat(np.arange(rows), patches), heights.reshape(-1, 4, 4)
    best = np.full(rows, -np.inf)
    while True:
        np.maximum.at(best, row, pieces[:, ::3, ::3].max(axis=(1, 2)))
        reach = pieces.max(axis=(1, 2)) - best[row]
        open_ = np.flatnonzero(reach > slack)
        if not len(open_):
            return best
        if len(open_) > EXTENT_PIECES:
            order = open_[np.argsort(-reach[open_], kind="stable")]
            each = [order[row[order] == number][:EXTENT_PIECES] for number in range(rows)]
            open_ = np.concatenate(each)
        quarters = (HALVES[:, None] @ pieces[open_])[:, None] @ HALVES.transpose(0, 2, 1)[:, None]
        pieces, row = quarters.reshape(-1, 4, 4), np.tile(row[open_], 4)
