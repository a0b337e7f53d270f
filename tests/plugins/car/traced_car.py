"""Cameras round a car, and its edges as pens would draw them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly

from bozzetto.view import Camera
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import Network, edge_called

Array = NDArray[np.float64]

SEEN = ["C1-S1.R", "C2-S2.R", "S2.R-S1.R", "S3.R-S2.R", "S4.R-S3.R", "C1-C2", "C2-C3", "S3.R-B3.R",
        "S1.R-B1.R", "B3.R-B2.R", "B4.R-B3.R", "R1.R-S2.R", "R2.R-R1.R"]  # fmt: skip
"""Edges of the sedan that stand alone in the picture from the right front."""

MIDDLE = np.array([2300.0, 0.0, 600.0])


def view(
    azimuth: float,
    elevation: float,
    kind: Literal["perspective", "orthographic"] = "perspective",
) -> Camera:
    """A camera 9 m from the middle of a car; 0 looks at the nose, 90 at the right side."""
    turn, rise = np.radians((azimuth, elevation))
    toward = np.array([-np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    x, y, z = (MIDDLE + 9000.0 * toward).tolist()
    return Camera(
        kind=kind, eye=(x, y, z), target=(2300.0, 0.0, 600.0), fov_y=30.0, height=4800.0,
        viewport=(1200.0, 800.0),
    )  # fmt: skip


def curve(control_points: Array, count: int = 80) -> Array:
    """Places on a cubic, by scipy."""
    bezier = BPoly(np.asarray(control_points)[:, None], [0.0, 1.0])
    return np.asarray(bezier(np.linspace(0.0, 1.0, count)))


def drawn(camera: Camera, control_points: Array, count: int = 80) -> Array:
    """The picture of a cubic, px."""
    return camera.project(curve(control_points, count))[0]


def symmetric(network: Network) -> bool:
    """Whether both halves are equal to the last bit, from the names of the nodes alone."""
    template = network.template
    by_names = {}
    for number, (start, end) in enumerate(template.edges.tolist()):
        by_names[template.names[start], template.names[end]] = number
    swap = str.maketrans("RL", "LR")

    def other(name: str) -> str:
        return name[:-1] + name[-1].translate(swap) if "." in name else name

    for (start, end), number in by_names.items():
        twin = by_names[other(start), other(end)]
        if not np.array_equal(network.tangents[twin], network.tangents[number] * MIRROR):
            return False
    return all(
        np.array_equal(
            network.positions[template.node[other(name)]],
            network.positions[template.node[name]] * MIRROR,
        )
        for name in template.names
    )


def path(camera: Camera, network: Network, names: list[str]) -> Array:
    """The picture of edges named in a row, in the direction of their names."""
    parts = []
    for name in names:
        edge = edge_called(network.template, name)
        own = drawn(camera, network.control_points[edge])
        parts.append(own if network.template.edge_names[edge] == name else own[::-1])
    return np.concatenate(parts)
