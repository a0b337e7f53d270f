"""Places in space from matched places on the sheet, with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_symmetry.stereo.correspondence import Pairing
from bozzetto_symmetry.stereo.degeneracies import intersect_rays, reasons_of
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from bozzetto_symmetry.stereo.uncertainty import pair_covariances, sigmas

ROOM: Final = 0.05
"""Share of the box's size by which a curve may leave it without a price. It decides the
sense of a curve that fits either way, like a hook."""

STRAY_ROOM: Final = 0.2
"""Share of the box's size beyond which single places are left out as strays: the box is a ruler,
and curves may leave it."""

STRAY: Final = 0.2
"""Greatest share of places outside the box that are left out as strays; if there are more,
the curve is meant to be there."""

DOUBTFUL: Final = 0.02
"""Uncertainty for 1 px, as a share of the box's diagonal, from which a place far outside the box
is a stray: what is known better is meant to be there."""

LEVEL: Final = 0.002
"""Distance from a plane, as a share of a curve's extent, that counts as in it."""

SLENDEREST: Final = 30.0
"""Length over width above which a curve is no more slender."""

PLANE_ROUNDS: Final = 4
"""Rounds in which the weights of places settle that a plane is laid through."""

REACH: Final = 3
"""Matched places on either side over which the direction of the far curve is taken."""


@dataclass(frozen=True, eq=False)
class HalfInSpace:
    """One half of a symmetric curve, from matched places.

    Attributes
    ----------
    points : (k, 3) float
        Places in front of the eye, in the order of the pairing, mm.
    covariances : (k, 3, 3) float
        Covariances of the places for 1 px of noise, mm².
    trust : (k,) float
        Weights of the places, which add up to 1: a place that the view hardly knows says
        little about where the curve is.
    kept : float
        Share of the matched places that gave a point.
    astride : float
        How much of the curve lies on the other side of the plane than most of it, 0 … 1.
    askew : float
        How far the plane that fits the points best is from facing one of the box's ways:
        0 if it does, and 0.42 at most.
    reasons : tuple of str
        Why matched places gave no point, and what to do.
    off_plane : float
        Distance of the places from the plane that fits them best (rms), in errors of a hand of
        1 px, and of `LEVEL`.
    slender : float
        Logarithm of how much longer than wide the cloud of its places is.
    """

    points: Array
    covariances: Array
    trust: Array
    kept: float
    astride: float
    askew: float
    reasons: tuple[str, ...] = ()
    off_plane: float = 0.0
    slender: float = 0.0

    @property
    def extent(self) -> float:
        """Diagonal of the box around the places, mm."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0

    def share_outside(self, box: Array | None) -> float:
        """Return the trusted share of the curve outside a box (2, 3) and the room about it."""
        return float(self.trust[_outside(self.points, box, ROOM)].sum())

    def doubtful(self, box: Array | None) -> Flags:
        """Return which places the view hardly knows, (k,) bool: others are where they are."""
        if box is None:
            return np.zeros(len(self.points), bool)
        size = float(np.linalg.norm(box[1] - box[0]))
        return np.asarray(sigmas(self.covariances) > DOUBTFUL * size)

    def without(self, left_out: Flags) -> HalfInSpace:
        """Return the half without some of its places; itself where none is left out."""
        if not left_out.any():
            return self
        keep = ~left_out
        return replace(
            self,
            points=self.points[keep],
            covariances=self.covariances[keep],
            trust=self.trust[keep],
        )


def triangulate(stereo: Stereo, pairing: Pairing) -> HalfInSpace:
    """Intersect the rays of matched places.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    pairing : Pairing
        The places of both sides that belong together.
    """
    points, codes = intersect_rays(stereo, pairing.near, pairing.far)
    seen = np.isfinite(points).all(axis=1)
    reasons = reasons_of(codes)
    if not seen.any():
        return HalfInSpace(
            np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0), 0.0, 0.0, 0.0, reasons
        )
    points, near, far = points[seen], pairing.near[seen], pairing.far[seen]
    covariances = pair_covariances(stereo, near, far, _directions(stereo, far))
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    covariances[pairing.weak[seen], 1, 1] += extent**2
    trust = 1.0 / (sigmas(covariances) + 0.01 * extent + 1e-300) ** 2
    trust /= trust.sum()
    middle = points - trust @ points
    least = np.linalg.svd(middle * np.sqrt(trust)[:, None], full_matrices=False)[2][-1]
    askew = 1.0 - float(np.abs(least).max()) if len(points) > 2 else 0.0
    astride = _astride(points[:, 1], trust)
    off = _off_plane(points, covariances, extent)
    return HalfInSpace(
        points, covariances, trust, float(seen.mean()), astride, askew, reasons, off,
        slenderness(points),
    )  # fmt: skip


def strays(points: Array, box: Array | None) -> Flags:
    """Return which points (n, 3) are far outside a box (2, 3) while most are not, (n,) bool."""
    out = _outside(points, box, STRAY_ROOM)
    return out if out.sum() <= STRAY * len(out) else np.zeros(len(points), bool)


def _outside(points: Array, box: Array | None, share: float) -> Flags:
    """Return which points leave the box by more than a share of its size."""
    if box is None:
        return np.zeros(len(points), bool)
    room = share * (box[1] - box[0])
    return np.asarray(((points < box[0] - room) | (points > box[1] + room)).any(axis=1))


def _astride(y: Array, trust: Array) -> float:
    left, right = float(trust @ np.maximum(y, 0.0)), float(trust @ np.maximum(-y, 0.0))
    return 2.0 * min(left, right) / max(left + right, 1e-300)


def slenderness(points: Array) -> float:
    """Return the logarithm of the length of a cloud of places over its width."""
    if len(points) < 3:
        return 0.0
    length, width, _ = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1]
    return float(np.log(length / max(width, length / SLENDEREST))) if length > 0.0 else 0.0


def _off_plane(points: Array, covariances: Array, extent: float) -> float:
    """Return how far places are from the plane nearest to them, in what each may err by."""
    if len(points) < 4 or not extent > 0.0:
        return 0.0
    weight = np.full(len(points), 1.0 / len(points))
    for _ in range(PLANE_ROUNDS):
        middle = points - weight @ points / weight.sum()
        normal = np.linalg.svd(middle * np.sqrt(weight)[:, None], full_matrices=False)[2][-1]
        variance = np.einsum("i,nij,j->n", normal, covariances, normal) + (LEVEL * extent) ** 2
        weight = 1.0 / variance
    return float(np.sqrt(np.mean((middle @ normal) ** 2 / variance)))


def _directions(stereo: Stereo, far: Array) -> Array:
    """Return unit directions of the far curve; where it stands still, the epipolar line's."""
    index = np.arange(len(far))
    ahead, back = np.minimum(index + REACH, len(far) - 1), np.maximum(index - REACH, 0)
    way = far[ahead] - far[back]
    length = np.linalg.norm(way, axis=1, keepdims=True)
    unit = np.divide(way, length, out=np.zeros_like(way), where=length > 1e-9)
    return np.where(length > 1e-9, unit, stereo.toward_vanishing(far))
