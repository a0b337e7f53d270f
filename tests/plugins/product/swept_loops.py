"""Loops on surfaces that are a profile turned, pushed, or both, and their distance from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from bozzetto.geometry import Spline
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.network_fills import fill_net
from tests.plugins.product.known_surfaces import (
    KnownLoop,
    estimated_normals,
    filled,
    fitted,
    net_of_splines,
    points_of,
)


@dataclass(frozen=True, eq=False)
class SweptLoop:
    """A loop and its surface as dense places with normals."""

    chains: list[np.ndarray]
    places: np.ndarray
    normals: np.ndarray

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(np.ptp(np.concatenate(self.chains), axis=0)))

    def splines(self) -> list[Spline]:
        return [fitted(chain, 9) for chain in self.chains]

    def alone(self) -> Fill:
        """The surface of the loop by itself: no edge is smooth to anything."""
        net, loop = net_of_splines(self.splines())
        (fill,) = fill_net(net, [loop])
        return fill

    def smooth(self) -> Fill:
        """The surface of the loop as one among others to which it is smooth."""
        net, loop = net_of_splines(self.splines())
        known = KnownLoop("", None, net, loop)
        return filled(known, estimated_normals(known))

    def error(self, fill: Fill) -> float:
        """Mean distance of a surface, % of the diagonal."""
        points = points_of(fill)
        distance, near = cKDTree(self.places).query(points)
        plane = np.abs(((points - self.places[near]) * self.normals[near]).sum(axis=1))
        return 100 * float(np.minimum(distance, plane).mean()) / self.diagonal


def turned(seed: int, *, pole: bool = False, pushed: float = 0.0, scale: float = 1.0) -> SweptLoop:
    """A random profile that is turned by 23° to 150° about z, and pushed along it."""
    random = np.random.default_rng(seed)
    t = np.linspace(0, 1, 5)
    radius = random.uniform(0.5, 1.0, 5)
    height = np.linspace(0, random.uniform(0.7, 2.0), 5) + random.uniform(-0.12, 0.12, 5)
    if pole:
        radius[:2], height[1] = (0.0, 0.5), height[0] + random.uniform(-0.05, 0.1)
    ends = ((1, (3.0, 0.0)), (2, np.zeros(2))) if pole else "not-a-knot"
    profile = CubicSpline(t, np.column_stack((radius, height)), bc_type=ends)
    whole = random.uniform(0.4, 2.6)

    def place(along: np.ndarray, angle: np.ndarray) -> np.ndarray:
        r, z = profile(along).T
        z = z + pushed * angle / whole
        return scale * np.column_stack((r * np.cos(angle), r * np.sin(angle), z))

    x = np.linspace(0, 1, 129)
    chains = [place(x, 0 * x), place(1 + 0 * x, whole * x), place(1 - x, whole + 0 * x)]
    if not pole:
        chains.append(place(0 * x, whole * (1 - x)))
    along, angle = (g.ravel() for g in np.meshgrid(np.linspace(0, 1, 301), whole * x))
    step = 1e-4
    across = np.cross(
        place(along + step, angle) - place(along - step, angle),
        place(along, angle + step) - place(along, angle - step),
    )
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    return SweptLoop(chains, place(along, angle), across)
