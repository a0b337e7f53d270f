"""A closed surface from a plan with heights: both sides sewn along the rim, with normals."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto_silhouette.outline.domain_mesh import Plan

_ROUNDS = 3
"""Rounds in which gradients are made exact for quadratic functions."""


def sewn_shell(plan: Plan, front: Array, back: Array) -> tuple[Array, Faces]:
    """Sew the front and the back of a height field along the rim of its plan.

    Parameters
    ----------
    plan : Plan
        Counter-clockwise triangles; the rim's samples come first.
    front, back : (n,) float array
        Heights and depths at the plan's points, not negative; those of the rim are not used.

    Returns
    -------
    vertices : (v, 3) float array
        Rim at z = 0, then the front (z > 0), then the back.
    faces : (f, 3) int32 array
        Oriented outwards.
    """
    rim, count = len(plan.after), len(plan.points)
    inner = plan.points[rim:]
    vertices = np.vstack([
        np.column_stack([plan.points[:rim], np.zeros(rim)]),
        np.column_stack([inner, front[rim:]]),
        np.column_stack([inner, -back[rim:]]),
    ])  # fmt: skip
    upper = plan.triangles
    lower = np.where(upper >= rim, upper + (count - rim), upper)[:, ::-1]
    return vertices, np.concatenate([upper, lower]).astype(np.int32)


def shell_normals(plan: Plan, front: Array, back: Array) -> Array:
    """Return unit normals of the surfaces z^2 = u over a plan, for the vertices of its shell.

    They come from the slope of u, which is nearly quadratic where z itself, upright at the
    rim, is hard to differentiate: the facets of the mesh do not show in them.

    Parameters
    ----------
    plan : Plan
        Triangles of the inside of the outline.
    front, back : (n,) float array
        u of either side, 0 on the rim.

    Returns
    -------
    (v, 3) float array
        In the order of `sewn_shell`.
    """
    rim = len(plan.after)
    upper = _normals(plan, front)
    lower = upper if back is front else _normals(plan, back)
    return np.concatenate([upper, lower[rim:] * (1.0, 1.0, -1.0)])


def _normals(plan: Plan, square: Array) -> Array:
    normal = np.column_stack([-plan_gradients(plan, square), 2.0 * np.sqrt(square)])
    normal /= np.maximum(np.sqrt((normal**2).sum(axis=1)), 1e-300)[:, None]
    return normal


def plan_gradients(plan: Plan, values: Array) -> Array:
    """Return gradients at the points of a plan (n, 2), exact for quadratic functions.

    Along an edge e a quadratic function grows by the mean of its end gradients times e.
    So every point fits its gradient to its edges by least squares, the change of gradient
    along each edge being taken from the round before.
    """
    count = len(plan.points)
    t = plan.triangles
    # Two triangles run along an inner edge both ways; along the rim one way is missing.
    rim = np.arange(len(plan.after))
    a = np.concatenate([t.ravel(), plan.after])
    b = np.concatenate([np.roll(t, -1, axis=1).ravel(), rim])
    # By coordinates: columns of pairs take twice as long.
    x, y = (plan.points[b] - plan.points[a]).T.copy()
    length2 = np.maximum(x * x + y * y, 1e-300)
    weight_x, weight_y = x / length2, y / length2
    rise = values[b] - values[a]

    def gathered(amounts: Array) -> Array:
        return np.bincount(a, amounts, count).astype(np.float64)

    xx, xy, yy = gathered(weight_x * x), gathered(weight_x * y), gathered(weight_y * y)
    determinant = np.maximum(xx * yy - xy * xy, 1e-12)
    slope_x, slope_y = np.zeros((2, count))
    for turn in range(_ROUNDS + 1):
        if turn:
            bend = (slope_x[b] - slope_x[a]) * x + (slope_y[b] - slope_y[a]) * y
        rest = rise - 0.5 * bend if turn else rise
        along_x, along_y = gathered(weight_x * rest), gathered(weight_y * rest)
        slope_x = (yy * along_x - xy * along_y) / determinant
        slope_y = (xx * along_y - xy * along_x) / determinant
    return np.stack([slope_x, slope_y], axis=1)


def vertex_normals(vertices: Array, faces: Faces) -> Array:
    """Return unit normals (v, 3), each face weighted by its angle at the vertex."""
    corner = vertices[faces]
    edge = np.roll(corner, -1, axis=1) - corner
    normal = np.cross(edge[:, 0], edge[:, 1])
    normal /= np.maximum(np.sqrt((normal**2).sum(axis=1)), 1e-300)[:, None]
    edge /= np.maximum(np.sqrt((edge**2).sum(axis=2)), 1e-300)[..., None]
    cosine = -(edge * np.roll(edge, 1, axis=1)).sum(axis=2)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    index = faces.ravel()
    total = np.stack([
        np.bincount(index, (angle * normal[:, k : k + 1]).ravel(), len(vertices)) for k in range(3)
    ], axis=1)  # fmt: skip
    unit: Array = total / np.maximum(np.sqrt((total**2).sum(axis=1)), 1e-300)[:, None]
    return unit
