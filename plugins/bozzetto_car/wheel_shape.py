"""Wheels, to be looked at: a tyre and a rim turned about the axle."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry import Mesh
from bozzetto_car.edges import Network

__all__ = ["wheel_meshes"]

Array = NDArray[np.float64]

TYRE: Final = (58, 57, 55, 255)
RIM: Final = (172, 170, 166, 255)

WIDTH: Final = 0.62
"""Width of a tyre per radius: 200 mm of a wheel of 650."""

PROFILE: Final = np.array(
    [(0.0, 0.36), (0.10, 0.42), (0.16, 0.40), (0.60, 0.36), (0.64, 0.44), (0.66, 0.50),
     (0.80, 0.52), (0.93, 0.46), (0.985, 0.34), (1.0, 0.18), (1.0, -0.18), (0.985, -0.34),
     (0.93, -0.46), (0.66, -0.50), (0.0, -0.50)]
)  # fmt: skip
"""Half of the section from the middle of the outer face to that of the inner one: distance from
the axle per radius, and place along it per width."""

RIM_ENDS: Final = 5
"""Points of the section that belong to the rim; the rest is tyre."""

STEPS: Final = 48
"""Round the axle."""


def wheel_meshes(network: Network) -> tuple[Mesh, ...]:
    """The four wheels; they stand on the ground, so their height tells their radius."""
    made = []
    for pair in network.template.wheels:
        for node in pair:
            centre = network.positions[node]
            if centre[2] > 0.0:
                made.append(_wheel(centre, float(centre[2])))
    return tuple(made)


def _wheel(centre: Array, radius: float) -> Mesh:
    """Turned about the axle; the outer face looks away from the middle of the car."""
    out = 1.0 if centre[1] >= 0.0 else -1.0
    # Sharp profile points twice, so that each face of the section has its own normals.
    begin, end = PROFILE[:-1], PROFILE[1:]
    ring = np.linspace(0.0, 2.0 * np.pi, STEPS + 1)
    section = np.stack((begin, end), axis=1)  # (s, 2, 2)
    away, along = section[..., 0] * radius, section[..., 1] * WIDTH * radius * out
    x = away[..., None] * np.cos(ring)
    z = away[..., None] * np.sin(ring)
    y = np.broadcast_to(along[..., None], x.shape)
    vertices = np.stack((x, y, z), axis=-1) + centre
    slope = (end - begin) * (1.0, WIDTH)
    tilt = np.stack((-slope[:, 1], slope[:, 0]), axis=1)
    tilt = -tilt / np.linalg.norm(tilt, axis=1, keepdims=True)
    normals = np.stack(
        (
            np.broadcast_to(tilt[:, 0, None, None] * np.cos(ring), x.shape),
            np.broadcast_to(tilt[:, 1, None, None] * out, x.shape),
            np.broadcast_to(tilt[:, 0, None, None] * np.sin(ring), x.shape),
        ),
        axis=-1,
    )
    at = np.arange(x.size).reshape(x.shape)
    a, b, c, d = at[:, 0, :-1], at[:, 1, :-1], at[:, 1, 1:], at[:, 0, 1:]
    faces = np.stack((np.stack((a, b, c), axis=-1), np.stack((a, c, d), axis=-1)), axis=-2)
    if out > 0.0:
        faces = faces[..., ::-1]
    colors = np.array([RIM if row < RIM_ENDS else TYRE for row in range(len(begin))], np.uint8)
    painted = np.broadcast_to(colors[:, None, None], (*x.shape, 4)).reshape(-1, 4)
    return Mesh(
        vertices.reshape(-1, 3).astype(np.float32),
        faces.reshape(-1, 3).astype(np.int32),
        normals.reshape(-1, 3).astype(np.float32),
        painted,
    )
