"""What the sides of a loop ask of a surface: tangent planes, and likely ways off the sides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_product.fill.domain import cross
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.patch_space import PatchSpace, side_nodes
from bozzetto_product.fill.quintic import DEGREE

TANGENCY: Final = 1e5
"""Weight of tangent planes, in mean diagonals of the stiffness: held to a hundredth of a degree."""

PULL: Final = 0.1
"""Weight of the way that a surface leaves its side: it decides the sense only."""


@dataclass(frozen=True, eq=False)
class SideConditions:
    """Conditions of the sides of a loop on a surface: squares of rows, and loads of what is known.

    Parameters
    ----------
    space : PatchSpace
    loop : LoopSides
    tangency : (Array, Array)
        (3 z, 3 z) and (3, z): what derivatives across the sides have along the normals.
    pull : (Array, Array)
        (z, z) and (3, z): what they differ from likely ones.
    """

    space: PatchSpace
    loop: LoopSides
    tangency: tuple[Array, Array] | None
    pull: tuple[Array, Array] | None

    @classmethod
    def of(cls, space: PatchSpace, loop: LoopSides) -> SideConditions:
        """Return the conditions along the sides with normals."""
        held = np.isfinite(loop.normals[..., 0])
        if not held.any():
            return cls(space, loop, None, None)
        by_basis, by_sides = space.across
        weights = np.sqrt(np.broadcast_to(side_nodes()[1], held.shape)[held])[:, None]
        known = by_sides[held] @ loop.controls
        normals = loop.normals[held] * weights
        rows = (normals[:, :, None] * by_basis[held][:, None, :]).reshape(len(normals), -1)
        offset = -(normals * known).sum(axis=1)
        basis = by_basis[held] * weights
        target = _likely_slopes(space, loop)[held] / DEGREE - known
        return cls(
            space,
            loop,
            (rows.T @ rows, (rows.T @ offset).reshape(3, -1)),
            (basis.T @ basis, (basis.T @ (weights * target)).T),
        )

    def hold(self, matrix: Array, right: Array, scale: float) -> None:
        """Add tangent planes to a system of equations."""
        if self.tangency is not None:
            matrix += TANGENCY * scale * self.tangency[0]
            right += TANGENCY * scale * self.tangency[1]

    def draw(self, matrix: Array, right: Array, scale: float) -> None:
        """Add the likely ways off the sides to a system of equations."""
        if self.pull is not None:
            size = right.shape[1]
            for axis in range(3):
                part = slice(axis * size, (axis + 1) * size)
                matrix[part, part] += PULL * scale * self.pull[0]
            right += PULL * scale * self.pull[1]


def _likely_slopes(space: PatchSpace, loop: LoopSides) -> Array:
    """Return derivatives across the halves as the domain's own, carried to space, (n, 2, 11, 3).

    Along a side they are scaled as the side is, across it as the sides beside it are at its ends.
    """
    domain, at = space.domain, side_nodes()[0][:, None]
    corners, middles = domain.corners, domain.middles
    made = np.zeros_like(loop.slopes)
    count = len(corners)
    speeds = np.ones((count, 2))
    for k in range(count):
        for half in range(2):
            speeds[k, half] = _speed_across(space, loop, k, half)
    for k in range(count):
        for half in range(2):
            corner = corners[(k + half) % count]
            beside = middles[k - 1] if half == 0 else middles[(k + 1) % count]
            way = middles[k] - corner
            length = float(np.hypot(*way))
            sense = 1.0 if half == 0 else -1.0
            domain_across = (1 - at) * (beside - corner) + at * (domain.centre - middles[k])
            slopes = loop.slopes[k, half]
            inward = cross_product(loop.normals[k, half], sense * slopes)
            inward /= np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-12)
            speed = (1 - at) * speeds[k, half] + at * 0.5 * (speeds[k, 0] + speeds[k, 1])
            height = sense * cross(way, domain_across)[:, None] / length
            along = (domain_across @ way)[:, None] / length**2
            made[k, half] = speed * height * inward + along * slopes
    return made


def _speed_across(space: PatchSpace, loop: LoopSides, side: int, half: int) -> float:
    """Return how many times longer than in the domain the way across a side is at an end."""
    domain = space.domain
    count = len(domain.corners)
    corner = domain.corners[(side + half) % count]
    if half == 0:
        other, beside = loop.sides[side - 1].halves[1], domain.middles[side - 1]
    else:
        after = (side + 1) % count
        other, beside = loop.sides[after].halves[0], domain.middles[after]
    own = loop.sides[side].halves[half]
    tangent = own.end_slopes[0]
    slope = other.end_slopes[0] / loop.size
    straight = float(np.linalg.norm(slope)) / max(float(np.hypot(*(beside - corner))), 1e-12)
    normal = loop.normals[side, half, 0]
    if not np.isfinite(normal[0]):
        return straight
    inward = cross_product(normal, tangent if half == 0 else -tangent)
    inward /= max(float(np.linalg.norm(inward)), 1e-300)
    way = domain.middles[side] - corner
    height = abs(float(cross(way, beside - corner))) / float(np.hypot(*way))
    return max(float(slope @ inward) / max(height, 1e-12), 0.1 * straight)
