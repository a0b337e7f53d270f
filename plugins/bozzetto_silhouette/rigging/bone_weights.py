"""The bones of one piece of a rig, and how much each of its joints moves a point.

A bone is the stretch between a joint and its parent, and turns with the parent. At a joint a
point follows the bones on both sides alike; the change takes a radius to either side. Beyond
a free end it follows the last bone. So all bones at a junction agree there, and which of them
a point belongs to matters only where limbs have parted. The gap to the
nearest ball on the axis of the limb decides there, for the axis bends where the bone is straight:
with x the point, c the ball's centre and r its radius,

    |x - c| - r,

which is 0 for the bone whose skin it is, however near another limb passes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.rigging.armature import Limbs

Numbers = NDArray[np.floating]
Singles = NDArray[np.float32]

LEAK = 0.35
"""How much farther than the nearest a bone may be and still have a say, in radii of the thinner
one of both: over this width points between two limbs change from one to the other."""

THINNEST = 1e-3
"""Radii and lengths below this share of the largest radius count as that: points have none."""


def eased(x: Numbers) -> Singles:
    """Ease from 0 to 1 with no slope at either end; constant beyond them."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x), np.float32)


class Gaps(NamedTuple):
    """Distances of n points from the nearest ball of each of m bones.

    Attributes
    ----------
    gap, radius : (m, n) float32 array
        From the ball's surface, negative inside it; and the ball's radius.
    """

    gap: Singles
    radius: Singles

    def nearest(self) -> Gaps:
        """Return the distance to the nearest bone, (n,)."""
        own, row = self.gap.argmin(axis=0), np.arange(self.gap.shape[1])
        return Gaps(self.gap[own, row], self.radius[own, row])

    def widths(self, nearest: Gaps) -> Numbers:
        """Return how much farther than the nearest each bone may be.

        Far outside of all balls, as in a spike that the skeleton left out, gaps differ more.
        """
        wide: Numbers = np.minimum(self.radius, nearest.radius) + np.maximum(nearest.gap, 0.0)
        return LEAK * wide


class _Axis(NamedTuple):
    """The axis of a bone in straight pieces, in the plane of the part.

    Attributes
    ----------
    nodes : (k + 1, 3) float32 array
        x, y and radius.
    lengths : (k,) float32 array
        Of the pieces.
    """

    nodes: Singles
    lengths: Singles

    @classmethod
    def of(cls, path: Numbers, least: float) -> _Axis:
        """Make a bone from x, y and radius along it, (n, 3), at least `least` long and thick."""
        steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
        kept = path[np.concatenate([[True], steps[:-1] > least, [True]])]
        radii = np.maximum(kept[:, 2], least)
        lengths = np.maximum(np.hypot(*np.diff(kept[:, :2], axis=0).T), least)
        nodes = np.column_stack([kept[:, :2], radii])
        return cls(nodes.astype(np.float32), lengths.astype(np.float32))

    def nearest(self, x: Singles, y: Singles, square: Singles) -> Gaps:
        """Find the nearest ball to each of n points.

        Parameters
        ----------
        x, y, square : (n,) float32 arrays
            In the plane, and the square of the height above it.
        """
        found = Gaps(np.full_like(x, np.inf), np.zeros_like(x))
        for k, length in enumerate(self.lengths):
            (xa, ya, ra), (xb, yb, rb) = self.nodes[k], self.nodes[k + 1]
            t = _projected(x - xa, y - ya, (xb - xa) / length, (yb - ya) / length, length)
            radius = ra + t * (rb - ra)
            across, up = x - xa - t * (xb - xa), y - ya - t * (yb - ya)
            gap = np.sqrt(across * across + up * up + square) - radius
            nearer = gap < found.gap
            np.copyto(found.gap, gap, where=nearer)
            np.copyto(found.radius, radius, where=nearer)
        return found


def _projected(x: Singles, y: Singles, ux: Singles, uy: Singles, length: Singles) -> Singles:
    """Return how far along a stretch in a unit direction places lie; 0 to 1."""
    return np.clip((x * ux + y * uy) / length, np.float32(0.0), np.float32(1.0))


class Bones:
    """The bones of one connected piece; those that were cut to open loops count, too.

    Parameters
    ----------
    limbs : Limbs
    """

    def __init__(self, limbs: Limbs) -> None:
        self.limbs = limbs
        count = len(limbs.nodes)
        tree = np.column_stack([limbs.parents[1:], np.arange(1, count)])
        self._links = np.concatenate([tree, limbs.cuts]).astype(np.intp)
        least = THINNEST * limbs.nodes[:, 2].max()
        radii = np.maximum(limbs.nodes[:, 2], least)
        self._nodes = np.column_stack([limbs.nodes[:, :2], radii]).astype(np.float32)
        self._axes = [_Axis.of(path, least) for path in limbs.paths]
        across = self._nodes[self._links[:, 1]] - self._nodes[self._links[:, 0]]
        self._lengths = np.maximum(np.hypot(across[:, 0], across[:, 1]), np.float32(least))
        self._degrees = np.bincount(self._links.ravel(), minlength=count)

    def shares(self, points: Numbers) -> tuple[Singles, Gaps]:
        """Return how much each joint moves points.

        Parameters
        ----------
        points : (n, 3) float array
            In the model's frame.

        Returns
        -------
        shares : (n, k) float32 array
            Sum 1.
        nearest : Gaps
            Of the nearest bone, in the model's unit.
        """
        limbs = self.limbs
        local = limbs.placement.inverse().points(points)
        local[:, 2] /= limbs.flatness  # as if it were as thick as a round part
        x, y, z = local.astype(np.float32).T
        square = z * z
        scale = np.float32(limbs.placement.scale)
        if not len(self._links):
            x0, y0, radius = self._nodes[0]
            gap = np.sqrt((x - x0) ** 2 + (y - y0) ** 2 + square) - radius
            ball = Gaps(scale * gap, np.full_like(gap, scale * radius))
            return np.ones((len(x), 1), np.float32), ball

        along, gaps, radii = np.empty((3, len(self._links), len(x)), np.float32)
        for bone, axis in enumerate(self._axes):
            gaps[bone], radii[bone] = axis.nearest(x, y, square)
            (xa, ya, _), (xb, yb, _) = self._nodes[self._links[bone]]
            length = self._lengths[bone]
            ux, uy = (xb - xa) / length, (yb - ya) / length
            along[bone] = _projected(x - xa, y - ya, ux, uy, length)
        found = Gaps(gaps, radii)
        nearest = found.nearest()
        says = 1.0 - (gaps - nearest.gap) / found.widths(nearest)
        shares = np.zeros((len(self._nodes), len(x)), np.float32)
        total = np.zeros(len(x), np.float32)
        for bone in range(len(self._links)):
            near = np.flatnonzero(says[bone] > 0.0)
            t = along[bone, near]
            say = eased(says[bone, near]) * self._part(bone, t)
            total[near] += say
            for joint, share in self._split(bone, t):
                shares[joint, near] += say * share
        shares /= total
        return np.ascontiguousarray(shares.T), Gaps(scale * nearest.gap, scale * nearest.radius)

    def _part(self, bone: int, along: Singles) -> Singles:
        """Divide a joint's weight among the bones that meet there; the shares sum to one."""
        part = np.ones_like(along)
        for joint, away in zip(self._links[bone], (along, 1.0 - along), strict=True):
            others = 1.0 - 1.0 / self._degrees[joint]
            reach = away * self._lengths[bone] / self._nodes[joint, 2]
            part -= others * (1.0 - eased(2.0 * reach))
        return np.maximum(part, THINNEST)

    def _split(self, bone: int, along: Singles) -> list[tuple[int, Singles]]:
        """Return which joints a bone's places follow, and how much; sum 1."""
        a, b = (int(joint) for joint in self._links[bone])
        at_a = self._change(bone, a, along)
        at_b = self._change(bone, b, 1.0 - along)
        above_a, above_b = (int(self.limbs.parents[joint]) for joint in (a, b))
        if bone < len(self._nodes) - 1:
            if above_a < 0:
                return [(a, 1.0 - at_b), (b, at_b)]
            return [(above_a, at_a), (a, 1.0 - at_a - at_b), (b, at_b)]
        # A loop was cut here: from what its one end follows to what its other end does.
        there = eased(along)
        split = []
        for joint, above, change, say in (
            (a, above_a, at_a, 1.0 - there),
            (b, above_b, at_b, there),
        ):
            if above >= 0:
                split += [(joint, say * (1.0 - change)), (above, say * change)]
            else:
                split.append((joint, say))
        return split

    def _change(self, bone: int, joint: int, away: Singles) -> Singles:
        """Return the progress of the change at a joint: one half at it, 0 a radius away from it."""
        if self._degrees[joint] == 1:
            return np.zeros_like(away)
        length = self._lengths[bone]
        width = min(self._nodes[joint, 2], 0.5 * length)
        return eased(0.5 - 0.5 * away * (length / width))
