"""Bodies that a USD scene tells by their measures, as meshes: cubes, spheres, cylinders and so on.

Of their attributes those of OpenUSD's `UsdGeomGprim` classes: size, radius, height, axis, and of
Cylinder_1 and Capsule_1 the radii of bottom and top.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE
from bozzetto.exchange.usd.usda_text import ReadPrim

AROUND: Final = 72
"""Corners around an axis; a sphere has half as many from pole to pole."""

OFF: Final = 0.5 * (1.0 - float(np.cos(np.pi / AROUND)))
"""How far triangles are off, as a share of the diameter."""

ROUND: Final = frozenset(("Sphere", "Cylinder", "Cone", "Capsule", "Cylinder_1", "Capsule_1"))
ANALYTIC: Final = ROUND | {"Cube", "Plane"}

AXES: Final = {"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)}
"""By its axis, which coordinates of a body along z are its x, y and z."""

PLANES: Final = {"X": ((2, 1), (1, 0)), "Y": ((0, 2), (1, 0)), "Z": ((0, 1), (0, 1))}
"""By its axis, along which coordinates a plane is wide and long, and which of them comes first
around its normal."""


def put_mesh(prim: ReadPrim) -> bool:
    """Turn a body into the mesh of it, and return whether it is round.

    Raises
    ------
    FormatError
        If one of its measures is none.
    """
    kind = prim.type
    axis = prim.word("axis") or "Z"
    if axis not in AXES:
        raise FormatError(f"The axis “{axis[:20]}” of a body is none. Save it again.")
    if kind == "Cube":
        points, faces = _cube(_measure(prim, "size", 2.0))
    elif kind == "Plane":
        points, faces = _plane([_measure(prim, name, 2.0) for name in ("width", "length")], axis)
    else:
        points, faces = _turned(_profile(prim, kind))
        points = points if kind == "Sphere" else points[:, AXES[axis]]
    prim.type = "Mesh"
    sizes = np.array([len(face) for face in faces])
    prim.values |= {
        "points": points.ravel(),
        "faceVertexCounts": sizes,
        "faceVertexIndices": np.array([corner for face in faces for corner in face]),
        "subdivisionScheme": "none",
    }
    return kind in ROUND


def _measure(prim: ReadPrim, name: str, usual: float) -> float:
    found = prim.number(name)
    found = usual if found is None else found
    if not 0.0 <= found <= MAX_COORDINATE:
        raise FormatError(f"The {name} of a body is no length. Save it again.")
    return found


def _cube(size: float) -> tuple[Array, list[tuple[int, ...]]]:
    corner = np.indices((2, 2, 2)).reshape(3, 8).T
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.asarray(size * (corner - 0.5)), list(faces)


def _plane(size: list[float], axis: str) -> tuple[Array, list[tuple[int, ...]]]:
    places, order = PLANES[axis]
    points = np.zeros((4, 3))
    first, second = order
    points[:, places[first]] = 0.5 * size[first] * np.array([-1.0, 1.0, 1.0, -1.0])
    points[:, places[second]] = 0.5 * size[second] * np.array([-1.0, -1.0, 1.0, 1.0])
    return points, [(0, 1, 2, 3)]


def _profile(prim: ReadPrim, kind: str) -> Array:
    """Return radius and height along the half section of a body, from below, (n, 2)."""
    if kind == "Sphere":
        radius = _measure(prim, "radius", 1.0)
        return _arc(radius, -90.0, 90.0, 0.0)
    capsule = kind.startswith("Capsule")
    half = 0.5 * _measure(prim, "height", 1.0 if capsule else 2.0)
    usual = 0.5 if capsule else 1.0
    if kind.endswith("_1"):
        low, high = (_measure(prim, f"radius{end}", usual) for end in ("Bottom", "Top"))
    else:
        low = _measure(prim, "radius", usual)
        high = 0.0 if kind == "Cone" else low
    if capsule:
        return np.concatenate([_arc(low, -90.0, 0.0, -half), _arc(high, 0.0, 90.0, half)])
    return np.array([(0.0, -half), (low, -half), (high, half), (0.0, half)])


def _arc(radius: float, first: float, last: float, middle: float) -> Array:
    steps = round(abs(last - first) / 360.0 * AROUND)
    angles = np.radians(np.linspace(first, last, steps + 1))
    across, along = radius * np.cos(angles), middle + radius * np.sin(angles)
    across[np.abs(np.linspace(first, last, steps + 1)) == 90.0] = 0.0
    return np.column_stack([across, along])


def _turned(profile: Array) -> tuple[Array, list[tuple[int, ...]]]:
    """Return the body of a half section that begins and ends on the axis."""
    kept = np.concatenate([[True], (np.diff(profile, axis=0) != 0.0).any(axis=1)])
    profile = profile[kept]
    angles = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    points: list[Array] = []
    rows: list[list[int]] = []
    count = 0
    for radius, height in profile.tolist():
        if radius == 0.0:
            points.append(np.array([(0.0, 0.0, height)]))
            rows.append([count] * AROUND)
            count += 1
        else:
            points.append(np.column_stack([radius * ring, np.full(AROUND, height)]))
            rows.append(list(range(count, count + AROUND)))
            count += AROUND
    faces: list[tuple[int, ...]] = []
    for low, high in pairwise(rows):
        for k in range(AROUND):
            corners = (low[k - 1], low[k], high[k], high[k - 1])
            face = tuple(dict.fromkeys(corners))
            if len(face) > 2:
                faces.append(face)
    return np.concatenate(points), faces
