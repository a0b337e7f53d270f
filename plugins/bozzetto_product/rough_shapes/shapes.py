"""Rough shapes to draw on: watertight meshes from length, width and height, by formulas.

All of them are made in the cube from -1 to 1 and stretched; a shape of any size has the same
triangles, so that what is drawn on it goes along when it is sized anew.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto_product.model.rough_shapes import RoughKind, RoughShape
from bozzetto_product.rough_shapes.surfaces import box_surface, closed_rings, mesh_of

SIZES: Final[dict[RoughKind, tuple[float, float, float]]] = {
    "box": (120.0, 80.0, 60.0),
    "rounded box": (120.0, 80.0, 60.0),
    "cylinder": (60.0, 60.0, 120.0),
    "sphere": (100.0, 100.0, 100.0),
    "wedge": (120.0, 80.0, 60.0),
    "bottle": (70.0, 70.0, 220.0),
    "mouse": (120.0, 64.0, 40.0),
    "shoe last": (270.0, 95.0, 90.0),
    "head": (195.0, 155.0, 230.0),
}
"""Length, width and height of a new one, mm: as such things are."""

CELLS: Final = 12
"""Squares along the edge of a box: 1,728 triangles."""

AROUND: Final = 64
"""Places round a body."""

THIN_END: Final = 0.15
"""Height of the thin end of a wedge, as a share of the height."""

BOTTLE: Final = (
    (-1.0, 0.80), (-0.97, 0.93), (-0.92, 0.985), (-0.86, 1.0), (-0.6, 1.0), (-0.3, 1.0), (0.0, 1.0),
    (0.18, 0.985), (0.3, 0.93), (0.4, 0.83), (0.49, 0.69), (0.56, 0.55), (0.62, 0.44), (0.68, 0.38),
    (0.74, 0.355), (0.82, 0.35), (0.92, 0.35), (1.0, 0.35),
)  # fmt: skip
"""Profile of a bottle: height, and radius as a share of the largest."""

ROUNDED: Final = 5.0
"""Exponent of the superellipses of a rounded box: 2 is an ellipsoid."""

SKULL: Final = (
    # height, half width, front, back
    (-1.00, 0.05, 0.62, 0.38),
    (-0.97, 0.26, 0.78, 0.02),
    (-0.88, 0.44, 0.88, -0.22),
    (-0.70, 0.62, 0.94, -0.36),
    (-0.45, 0.78, 0.97, -0.56),
    (-0.15, 0.91, 0.98, -0.82),
    (0.15, 0.98, 0.97, -0.96),
    (0.40, 1.00, 0.93, -1.00),
    (0.62, 0.94, 0.82, -0.95),
    (0.80, 0.76, 0.62, -0.80),
    (0.92, 0.50, 0.36, -0.56),
    (0.98, 0.24, 0.10, -0.32),
    (1.00, 0.05, -0.08, -0.14),
)
"""Sections of a head: where in its height, half width, face and back, in halves of the sizes. The
face is at 1, the chin at the bottom."""

FOOT: Final = (
    # along, half width, middle across, sole, top
    (-1.00, 0.10, 0.00, -0.80, -0.55),
    (-0.97, 0.36, 0.00, -0.93, 0.40),
    (-0.90, 0.54, 0.00, -0.99, 0.88),
    (-0.78, 0.64, 0.00, -1.00, 1.00),
    (-0.60, 0.66, 0.02, -1.00, 1.00),
    (-0.42, 0.64, 0.05, -0.97, 0.92),
    (-0.22, 0.66, 0.09, -0.91, 0.62),
    (0.00, 0.75, 0.10, -0.90, 0.26),
    (0.22, 0.87, 0.06, -0.95, 0.00),
    (0.42, 0.94, 0.02, -1.00, -0.18),
    (0.60, 0.90, 0.00, -0.99, -0.34),
    (0.76, 0.77, 0.00, -0.96, -0.46),
    (0.89, 0.55, 0.02, -0.91, -0.58),
    (0.97, 0.29, 0.04, -0.87, -0.68),
    (1.00, 0.08, 0.05, -0.83, -0.76),
)
"""Sections of a shoe last: where along it, half width, middle, sole and top, in halves of the
length, width and height. The heel is at -1; the cone over it is open for the leg."""


def rough_mesh(shape: RoughShape) -> Mesh:
    """Return a rough shape as a closed mesh.

    Parameters
    ----------
    shape : RoughShape
        Kind, size and centre, mm.

    Returns
    -------
    Mesh
        500 to 5,000 triangles. Normals are left to the display, which breaks them at edges.

    Raises
    ------
    UserError
        If a size is not above 0, or not finite.
    """
    size = np.array((shape.length, shape.width, shape.height), float)
    centre = np.asarray(shape.centre, float)
    if not (np.isfinite(size).all() and np.isfinite(centre).all() and size.min() > 0.0):
        raise UserError("The length, width and height of a rough shape must be above 0.")
    made = _KINDS[shape.kind]()
    points = centre + 0.5 * size * made.vertices.astype(float)
    return Mesh(points.astype(np.float32), made.faces)


def _box() -> Mesh:
    return mesh_of(*box_surface(CELLS))


def _wedge() -> Mesh:
    points, faces = box_surface(CELLS)
    share = 0.5 * (1.0 + points[:, 0])
    height = 1.0 - share * (1.0 - THIN_END)
    points[:, 2] = -1.0 + (points[:, 2] + 1.0) * height
    return mesh_of(points, faces)


def _rounded_box() -> Mesh:
    """Return a box with round edges: superellipses in plan and in height."""
    angle, rise = _angles(), np.linspace(-0.5 * np.pi, 0.5 * np.pi, 37)[1:-1]
    out, up = _rounded(np.cos(rise)), _rounded(np.sin(rise))
    around = np.stack((_rounded(np.cos(angle)), _rounded(np.sin(angle))), axis=1)
    rings = np.empty((len(rise), len(angle), 3))
    rings[..., :2] = out[:, None, None] * around
    rings[..., 2] = up[:, None]
    return closed_rings(rings, np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0)))


def _rounded(share: Array) -> Array:
    return np.asarray(np.sign(share) * np.abs(share) ** (2.0 / ROUNDED))


def _head() -> Mesh:
    """Return a head from sections: broad at the back of the skull, narrow at the chin."""
    from scipy.interpolate import PchipInterpolator

    table = np.array(SKULL)
    at = -np.cos(np.linspace(0.0, np.pi, 40))
    wide, front, back = PchipInterpolator(table[:, 0], table[:, 1:])(at).T
    angle = _angles()
    along = 0.5 * (front + back)[:, None] + 0.5 * (front - back)[:, None] * np.cos(angle)
    across = wide[:, None] * np.sin(angle)
    rings = np.stack((along, across, np.broadcast_to(at[:, None], along.shape)), axis=2)
    for axis in (0, 1):
        low, high = rings[..., axis].min(), rings[..., axis].max()
        rings[..., axis] = (2.0 * rings[..., axis] - low - high) / (high - low)
    return closed_rings(rings[1:-1], rings[0].mean(axis=0), rings[-1].mean(axis=0))


def _cylinder() -> Mesh:
    rise = np.linspace(-1.0, 1.0, 15)
    caps = np.linspace(0.0, 1.0, 6)[1:-1]
    height = np.concatenate((np.full(4, -1.0), rise, np.full(4, 1.0)))
    radius = np.concatenate((caps, np.ones(15), caps[::-1]))
    return _turned(height, radius)


def _sphere() -> Mesh:
    angle = np.linspace(0.0, np.pi, 33)[1:-1]
    return _turned(-np.cos(angle), np.sin(angle))


def _bottle() -> Mesh:
    from scipy.interpolate import PchipInterpolator

    rise, radius = np.array(BOTTLE).T
    at = np.concatenate((rise[:4], np.linspace(-0.76, 1.0, 26)))
    wide = PchipInterpolator(rise, radius)(at)
    floor, mouth = np.array((0.3, 0.6)), np.array((0.67, 0.33))
    return _turned(
        np.concatenate((np.full(2, -1.0), at, np.full(2, 1.0))),
        np.concatenate((floor * wide[0] / 0.8, wide, mouth * wide[-1])),
    )


def _mouse() -> Mesh:
    """Return a computer mouse: the palm's hump towards the back, a flat sole."""
    angle = _angles()
    along = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.8
    across = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** 0.8
    across = across * (1.0 - 0.07 * (1.0 - along**2) ** 2)
    across /= np.abs(across).max()
    # A quarter of a superellipse from the rim of the sole to the top.
    turn = np.linspace(0.0, 0.5 * np.pi, 18)[1:-1]
    out, up = np.cos(turn) ** 0.7, np.sin(turn) ** 0.85
    sole = np.array((0.3, 0.6, 0.85, 0.97))
    share = np.concatenate((sole, [1.0], out))
    rise = np.concatenate((np.zeros(5), up))
    x = share[:, None] * along
    y = share[:, None] * across
    z = -1.0 + 2.0 * rise[:, None] * _hump(x)
    z[4] = -0.9  # the sole's edge is eased
    top = np.array((0.0, 0.0, -1.0 + 2.0 * float(_hump(np.zeros(1))[0])))
    rings = np.stack((x, y, z), axis=2)
    highest = max(float(rings[..., 2].max()), float(top[2]))
    rings[..., 2] = -1.0 + (rings[..., 2] + 1.0) * 2.0 / (highest + 1.0)
    top[2] = -1.0 + (top[2] + 1.0) * 2.0 / (highest + 1.0)
    return closed_rings(rings, np.array((0.0, 0.0, -1.0)), top)


def _hump(along: Array) -> Array:
    """Return the height of the top of a mouse at places along it, front at 1."""
    return np.asarray(
        0.98 - 0.38 * (0.5 * (1.0 + along)) ** 1.7 - 0.12 * (0.5 * (1.0 - along)) ** 3
    )


def _shoe_last() -> Mesh:
    """Return the body of a foot from heel to toe, from sections."""
    from scipy.interpolate import PchipInterpolator

    table = np.array(FOOT)
    # Closer at the ends, where it is round.
    at = -np.cos(np.linspace(0.0, np.pi, 40))
    wide, middle, sole, top = PchipInterpolator(table[:, 0], table[:, 1:])(at).T
    angle = _angles()
    # Seen from the toe: flatter below than above.
    side, up = np.cos(angle), np.sin(angle)
    power = np.where(up < 0.0, 0.45, 0.75)
    flat = np.sign(up) * np.abs(up) ** power
    out = np.sign(side) * np.abs(side) ** 0.8
    # The sole is broad, the instep and the leg are narrow.
    narrow = 1.0 - 0.18 * np.clip(flat, 0.0, 1.0) ** 2
    y = middle[:, None] + wide[:, None] * (out * narrow)
    z = 0.5 * (sole + top)[:, None] + 0.5 * (top - sole)[:, None] * flat
    x = np.broadcast_to(at[:, None], y.shape)
    rings = np.stack((x, y, z), axis=2)
    low, high = rings[..., 1].min(), rings[..., 1].max()
    rings[..., 1] = (2.0 * rings[..., 1] - low - high) / (high - low)
    return closed_rings(rings[1:-1], rings[0].mean(axis=0), rings[-1].mean(axis=0))


def _turned(height: Array, radius: Array) -> Mesh:
    """Return a body of revolution about z with flat ends, rings from below."""
    angle = _angles()
    rings = np.stack(
        (
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
            np.broadcast_to(height[:, None], (len(height), len(angle))),
        ),
        axis=2,
    )
    return closed_rings(rings, np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0)))


def _angles() -> Array:
    return np.asarray(2.0 * np.pi * np.arange(AROUND) / AROUND)


_KINDS: Final[dict[RoughKind, Callable[[], Mesh]]] = {
    "box": _box,
    "rounded box": _rounded_box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "wedge": _wedge,
    "bottle": _bottle,
    "mouse": _mouse,
    "shoe last": _shoe_last,
    "head": _head,
}
