"""The convolution field of a silhouette: positive inside, zero on the surface.

The sum of the kernels F is turned into a level that reads like a squared radius,

    U = (sigma^2 - 1) ((F / T)^(2/7) - 1),

because on a cylinder of radius r the sextic kernel gives ``U = 1 - (distance / r)^2``
exactly; the other kernels have a function of their own that does it (`kernels`). In these
units the correction that brings the zero line onto the drawn outline keeps the section
round, and the height above a point is found in two or three Newton steps, U being nearly
linear in z^2.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.kernel_sums import THINNEST, Summation, Sums, summation_of
from bozzetto_silhouette.implicit.weight_fit import fit_weights
from bozzetto_silhouette.model.state import Kernel
from bozzetto_silhouette.outline.boundary_sampling import Rim
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.normalized import Frame
from bozzetto_silhouette.outline.signed_distance import ClosestPoints, RimDistance

FLOOR = 0.45
"""The surface stands at least this share of a round section high (squared): where the
pruned skeleton does not reach (sharp tips, serifs) there is still a body."""

CORRECTION_DEPTH = 0.9
"""Depth that the correction reaches, in local radii."""

RIPPLE_DEPTH = 0.3
"""The part of that depth that the quickly varying share of the correction reaches."""

SUMMIT_ERROR = 0.06
"""Above a node of the skeleton the height may differ by this share from its ball; where it
differs more (many limbs in one place) it is brought there."""

MOST_STEPS = 12
"""Rounds of the search for a height; the default kernel needs two or three."""

_PAIRS = 1 << 18
"""Samples times edges of the skeleton that are looked at together."""

_FAINT = 1e-5
"""Field, in iso-values, below which the level is held constant."""


@dataclass(frozen=True, eq=False)
class Correction:
    """The amount added to the level at points of the plane, whatever their depth.

    Attributes
    ----------
    lift : (n,) float array
        Added to the level; on the outline it makes the level zero.
    distance : (n,) float array
        Signed distance to the outline, positive inside.
    radius : (n,) float array
        Local radius at the foot on the outline.
    """

    lift: Array
    distance: Array
    radius: Array

    @property
    def floor(self) -> Array:
        """Level of the guard at depth 0: has the sign of the distance."""
        t = np.clip(self.distance / self.radius, -1.0, 1.0)
        return FLOOR * t * (2.0 - np.abs(t))

    def of(self, rows: Index) -> Correction:
        """Return the correction at some of the points."""
        return Correction(self.lift[rows], self.distance[rows], self.radius[rows])


@dataclass(frozen=True, eq=False)
class ConvolutionField:
    """Field of one silhouette, symmetric in depth.

    All in the frame of the sums (`Frame`). The field falls monotonically with the depth, so
    the solid is a height field over the outline, which lies in z = 0.

    Attributes
    ----------
    skeleton : Skeleton
    weights : (s,) float array
        One per edge of the skeleton.
    softness : float
        Support of the kernel in radii (sigma).
    summation : Summation
        The kernels along the skeleton.
    rim, excess, calm_excess : Rim, (m,) and (m,) float arrays
        Samples of the outline, what the level lacks there, and its running average.
    summits : (k, 4) float array
        Where the height is corrected: x, y, radius and what the level lacks.
    """

    skeleton: Skeleton
    weights: Array
    softness: float
    summation: Summation = field(repr=False)
    rim: Rim = field(repr=False)
    excess: Array = field(repr=False)
    calm_excess: Array = field(repr=False)
    summits: Array = field(repr=False)
    _distance: RimDistance = field(repr=False)

    def correction(self, xy: Array, closest: ClosestPoints | None = None) -> Correction:
        """Return the correction at points (n, 2) of the frame of the sums.

        Their `closest` points of the outline are found where they are not given.
        """
        closest = self.closest(xy) if closest is None else closest
        following = self.rim.after[closest.segment]

        def between(values: Array) -> Array:
            return (1.0 - closest.along) * values[closest.segment] + closest.along * values[
                following
            ]

        radius = between(self.rim.radius)
        depth = np.square(closest.distance / (CORRECTION_DEPTH * radius))
        calm = between(self.calm_excess)
        lift = calm * np.square(np.clip(1.0 - depth, 0.0, 1.0))
        # What varies faster along the outline than the limb is thick stays at the rim.
        lift += (between(self.excess) - calm) * np.square(
            np.clip(1.0 - depth / RIPPLE_DEPTH**2, 0.0, 1.0)
        )
        if len(self.summits):
            gap2 = ((xy[:, None, :] - self.summits[None, :, :2]) ** 2).sum(axis=2)
            bump = np.square(np.clip(1.0 - gap2 / np.square(self.summits[:, 2]), 0.0, 1.0))
            lift += bump @ self.summits[:, 3] / np.maximum(bump.sum(axis=1), 1.0)
        return Correction(lift, closest.distance, radius)

    def raw_level(self, xy: Array, height2: Array, radius: Array) -> Array:
        """Return the uncorrected level U at points (n, 2) and squared heights, in local radii."""
        level, _ = self._summed(self.summation.over(xy), height2, radius, slope=False)
        return level

    def level(self, xy: Array, height2: Array) -> Array:
        """Return the corrected level at points (n, 2) and squared heights."""
        correction = self.correction(xy)
        level = self.raw_level(xy, height2, correction.radius)
        corrected, _ = _guarded(level, None, height2, correction)
        return corrected

    def _summed(
        self, sums: Sums, height2: Array, radius: Array, *, slope: bool
    ) -> tuple[Array, Array | None]:
        """Return the uncorrected level U and its derivative by z^2."""
        total, descent = sums.total(self.weights, height2, slope=slope)
        level, rise = self.summation.level(np.maximum(total, _FAINT), radius)
        return level, None if descent is None else rise * descent

    def closest(self, xy: Array) -> ClosestPoints:
        """Return the closest points of the outline to points (n, 2)."""
        return self._distance(xy)

    def heights(self, xy: Array, closest: ClosestPoints | None = None) -> Array:
        """Return the half thickness of the solid at points (n, 2) of the plane; 0 outside.

        Their `closest` points of the outline are found where they are not given.
        """
        corrected = self.correction(xy, closest)
        # The guard alone stands that high, so the surface does not lie below.
        square = np.maximum(corrected.floor, 0.0) * corrected.radius**2
        inside = corrected.distance > 0.0
        rows = np.flatnonzero(inside)
        sums, corrected = self.summation.over(xy).of(rows), corrected.of(rows)
        low, high = square[rows], np.full(len(rows), np.inf)
        for _ in range(MOST_STEPS):
            now = square[rows]
            level, fall = self._summed(sums, now, corrected.radius, slope=True)
            level, fall = _guarded(level, fall, now, corrected)
            assert fall is not None
            low = np.where(level >= 0.0, np.maximum(low, now), low)
            high = np.where(level < 0.0, np.minimum(high, now), high)
            following = now + level / -fall
            # U is nearly linear in z^2; where it is not, Newton's step may leave the bracket.
            astray = (following < low) | (following > high)
            following[astray] = 0.5 * (low + high)[astray]
            square[rows] = following
            on = np.flatnonzero(np.abs(following - now) > 1e-3 * following)
            if not len(on):
                break
            rows, low, high = rows[on], low[on], high[on]
            sums, corrected = sums.of(on), corrected.of(on)
        return np.where(inside, np.sqrt(square), 0.0)


def _guarded(
    level: Array, fall: Array | None, height2: Array, correction: Correction
) -> tuple[Array, Array | None]:
    """Correct the level and hold its sign to that of the drawn outline.

    Inside, the smooth maximum with a round tube along the outline (`FLOOR`); outside, the
    minimum with a level that falls away from the outline.
    """
    a = level + correction.lift
    floor = correction.floor
    inverse = 1.0 / correction.radius**2
    b = floor - height2 * inverse
    inside = correction.distance >= 0.0
    width = np.maximum(0.5 * np.abs(floor), 1e-12)
    mix = np.clip(0.5 + (a - b) / (2.0 * width), 0.0, 1.0)
    best = b + (a - b) * mix + width * mix * (1.0 - mix)
    result = np.where(inside, best, np.minimum(a, b))
    if fall is None:
        return result, None
    slope = np.where(inside, fall * mix - inverse * (1.0 - mix), -inverse)
    return result, np.minimum(slope, -1e-2)


# The preview's field is the final solid's, too: it does not depend on the resolution.
@remembered(limit=16)
def convolution_field(
    frame: Frame, *, softness: float = 1.4, kernel: Kernel = "scalis"
) -> ConvolutionField:
    """Fit the weights of a skeleton to its outline; the field is not corrected yet.

    Parameters
    ----------
    frame : Frame
        The outline, its samples and its skeleton.
    softness : float
        Support of the kernel in radii, 1.25 to 2: how far limbs blend into each other.
    kernel : str
        The function that is summed along the skeleton.
    """
    rim = frame.rim
    summation = summation_of(frame.skeleton, kernel, softness, float(rim.radius.max()))
    return ConvolutionField(
        frame.skeleton,
        fit_weights(frame.skeleton, summation, rim.points),
        softness,
        summation,
        rim,
        np.zeros(len(rim.points)),
        np.zeros(len(rim.points)),
        np.zeros((0, 4)),
        RimDistance(rim.points, rim.after),
    )


def with_correction(raw: ConvolutionField, rim: Rim) -> ConvolutionField:
    """Correct a field so that its zero line in z = 0 is the sampled outline."""
    rim = replace(rim, radius=_skeleton_radii(rim, raw.skeleton))
    level = raw.raw_level(rim.points, np.zeros(len(rim.points)), rim.radius)
    # Never so much that the body would reach beyond the support of the kernel.
    most = 0.8 * (raw.softness**2 - 1.0)
    excess = np.minimum(-level, most)
    field_ = replace(
        raw,
        rim=rim,
        excess=excess,
        calm_excess=rim.averaged(excess),
        _distance=RimDistance(rim.points, rim.after),
    )
    nodes = raw.skeleton
    wanted = nodes.heights(nodes.nodes[:, :2])
    height = field_.heights(nodes.nodes[:, :2])
    error = np.abs(height - wanted) / np.maximum(wanted, THINNEST)
    # The correction sets in gradually: how a shape is drawn must not switch it on or off.
    share = np.clip(2.0 * error / SUMMIT_ERROR - 1.0, 0.0, 1.0)
    off = np.flatnonzero((share > 0.0) & (wanted > THINNEST))
    summit = nodes.nodes[off]
    missing = -share[off] * field_.level(summit[:, :2], wanted[off] ** 2)
    return replace(field_, summits=np.column_stack([summit, np.clip(missing, -0.5, 0.5)]))


def _skeleton_radii(rim: Rim, skeleton: Skeleton) -> Array:
    """Return the local radius at the samples of a rim as the skeleton has it, (m,).

    The largest ball that touches the outline shrinks to nothing in every corner. Where the
    skeleton has no branch into it (a blunt corner, a kink of the hand) the body is as thick as
    the ball that stands there, and the correction reaches as far.
    """
    radius: Array = rim.radius.copy()
    if not len(skeleton.edges):
        return np.asarray(np.maximum(radius, skeleton.nodes[:, 2].max()))
    start, end = skeleton.nodes[skeleton.edges[:, 0]], skeleton.nodes[skeleton.edges[:, 1]]
    edge = end - start
    length2 = np.maximum((edge[:, :2] ** 2).sum(axis=1), 1e-300)
    medial = rim.points + rim.radius[:, None] * rim.inward
    rows = max(_PAIRS // len(edge), 1)
    for first in range(0, len(medial), rows):
        some = slice(first, first + rows)
        offset = medial[some, None, :] - start[:, :2]
        along = np.clip((offset * edge[:, :2]).sum(axis=2) / length2, 0.0, 1.0)
        gap2 = ((offset - along[..., None] * edge[:, :2]) ** 2).sum(axis=2)
        best = gap2.argmin(axis=1)
        share = np.take_along_axis(along, best[:, None], axis=1)[:, 0]
        radius[some] = np.maximum(radius[some], start[best, 2] + share * edge[best, 2])
    return radius
