"""The convolution field of a silhouette: positive inside, zero on the surface.

The sum of the kernels F is turned into a level that reads like a squared radius,

    U = (sigma^2 - 1) ((F / T)^(2/7) - 1),

because on a cylinder of radius r the sextic kernel gives ``U = 1 - (distance / r)^2``
exactly. In these units the correction that brings the zero line onto the drawn outline
keeps the section round, and the height above a point is found in two or three Newton
steps, U being nearly linear in z^2.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto_silhouette.distance import RimDistance
from bozzetto_silhouette.kernel import (
    Pairs,
    Segments,
    iso_value,
    pairs_within_reach,
    segment_integrals,
)
from bozzetto_silhouette.memory import Memory
from bozzetto_silhouette.outline import Outline
from bozzetto_silhouette.sampling import Rim, sample_rim
from bozzetto_silhouette.skeleton import Skeleton, chordal_axis, simplified
from bozzetto_silhouette.weights import fit_weights

__all__ = ["ConvolutionField", "Correction", "convolution_field", "with_correction"]

Points = NDArray[np.float64]
Singles = NDArray[np.float32]

SKELETON_STEPS = 230
"""Samples of the outline that the skeleton is drawn from, at least."""

MOST_SAMPLES = 20_000
"""Samples of the outline beyond which the fit's tables would not fit into memory; a horse
has three hundred."""

SKELETON_TOLERANCE = 5e-3
"""Simplification of the skeleton, as a share of the longest side."""

THINNEST = 2e-3
"""Smallest radius of the kernel, as a share of the longest side."""

FLOOR = 0.45
"""The surface stands at least this share of a round section high (squared): where the
pruned skeleton does not reach (sharp tips, serifs) there is still a body."""

CORRECTION_DEPTH = 0.9
"""How deep the correction reaches, in local radii."""

RIPPLE_DEPTH = 0.3
"""The part of that depth that the quickly varying share of the correction reaches."""

SUMMIT_ERROR = 0.06
"""Above a node of the skeleton the height may differ by this share from its ball; where it
differs more (many limbs in one place) it is brought there."""

GRADIENT_STEP = 2e-3
"""Half step of the central differences, as a share of the longest side: well above the
jitter of foot points on a sampled outline, well below a cell."""

_FAINT = 1e-5
"""Field, in iso-values, below which the level is held constant."""


@dataclass(frozen=True, eq=False)
class Correction:
    """What is added to the level at points of the plane, whatever their depth.

    Attributes
    ----------
    lift : (n,) float array
        Added to the level; on the outline it makes the level zero.
    distance : (n,) float array
        Signed distance to the outline, positive inside.
    radius : (n,) float array
        Local radius at the foot on the outline.
    """

    lift: Points
    distance: Points
    radius: Points

    @property
    def floor(self) -> Points:
        """Level of the guard at depth 0: has the sign of the distance."""
        t = np.clip(self.distance / self.radius, -1.0, 1.0)
        return FLOOR * t * (2.0 - np.abs(t))


@dataclass(frozen=True, eq=False)
class ConvolutionField:
    """Field of one silhouette, symmetric in depth.

    Points are rows (x, y, z) in the object frame: the outline lies in z = 0. The field
    falls monotonically with the depth, so the solid is a height field over the outline.

    Attributes
    ----------
    skeleton : Skeleton
        In the object frame.
    weights : (s,) float array
        One per edge of the skeleton.
    softness : float
        Support of the kernel in radii (sigma).
    inflation : float
        Factor on the depth.
    rim, excess, calm_excess : Rim, (m,) and (m,) float arrays
        Samples of the outline, what the level lacks there, and its running average.
    summits : (k, 4) float array
        Where the height is corrected: x, y, radius and what the level lacks.
    scale, origin : float, (2,) float array
        The frame in which the sums are done: ``(xy - origin) / scale``.
    """

    skeleton: Skeleton
    weights: Points
    softness: float
    inflation: float
    scale: float
    origin: Points
    segments: Segments = field(repr=False)
    rim: Rim = field(repr=False)
    excess: Points = field(repr=False)
    calm_excess: Points = field(repr=False)
    summits: Points = field(repr=False)
    _distance: RimDistance = field(repr=False)

    # -- in the object frame ------------------------------------------------------------

    def value(self, points: ArrayLike) -> Points:
        """Level at points (n, 3): positive inside, zero on the surface, dimensionless.

        Near the surface it is about twice the distance over the local radius.
        """
        xy, z = self._inner(points)
        return self._level(xy, z * z)

    def gradient(self, points: ArrayLike) -> Points:
        """Gradient of `value` at points (n, 3), per unit of length; it points inwards."""
        xy, z = self._inner(points)
        step = GRADIENT_STEP
        columns = []
        for axis in np.eye(2):
            ahead, back = (self._level(xy + s * step * axis, z * z) for s in (1.0, -1.0))
            columns.append((ahead - back) / (2.0 * step * self.scale))
        ahead, back = (self._level(xy, np.square(z + s * step)) for s in (1.0, -1.0))
        columns.append((ahead - back) / (2.0 * step * self.scale * self.inflation))
        return np.stack(columns, axis=1)

    def heights(self, xy: ArrayLike) -> Points:
        """Half thickness of the solid at points (n, 2) of the plane; 0 outside."""
        inner = (np.asarray(xy, dtype=np.float64) - self.origin) / self.scale
        return self.heights_inner(inner) * self.scale * self.inflation

    # -- in the frame of the sums -------------------------------------------------------

    def _inner(self, points: ArrayLike) -> tuple[Points, Points]:
        p = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        return (p[:, :2] - self.origin) / self.scale, p[:, 2] / (self.scale * self.inflation)

    def correction(self, xy: Points) -> Correction:
        """Correction at points (n, 2) of the frame of the sums."""
        feet = self._distance(xy)
        following = self.rim.after[feet.segment]

        def between(values: Points) -> Points:
            return (1.0 - feet.along) * values[feet.segment] + feet.along * values[following]

        radius = between(self.rim.radius)
        depth = np.square(feet.distance / (CORRECTION_DEPTH * radius))
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
        return Correction(lift, feet.distance, radius)

    def _level(self, xy: Points, height2: Points) -> Points:
        pairs = pairs_within_reach(xy, self.segments)
        level, _ = self._convolved(pairs, len(xy), height2, slope=False)
        corrected, _ = _guarded(level, None, height2, self.correction(xy))
        return corrected

    def _convolved(
        self, pairs: Pairs, count: int, height2: Points, *, slope: bool
    ) -> tuple[Points, Points | None]:
        """Uncorrected level U and its derivative by z^2."""
        value, change = segment_integrals(self.segments, pairs, height2, slope=slope)
        top = iso_value(self.softness)
        room = self.softness**2 - 1.0
        weight = self.weights[pairs.segment] / top
        total: Points = np.bincount(pairs.point, value * weight, count).astype(np.float64)
        total = np.maximum(total, _FAINT)
        level = room * (total ** (2.0 / 7.0) - 1.0)
        if change is None:
            return level, None
        descent = np.bincount(pairs.point, change * weight, count).astype(np.float64)
        return level, room * (2.0 / 7.0) * total ** (-5.0 / 7.0) * descent

    def heights_inner(self, xy: Points) -> Points:
        """`heights` in the frame of the sums, without inflation."""
        pairs = pairs_within_reach(xy, self.segments)
        corrected = self.correction(xy)
        square = np.maximum(corrected.floor, 0.0) * corrected.radius**2
        inside = corrected.distance > 0.0
        active = inside.copy()
        for _ in range(8):
            level, fall = self._convolved(pairs, len(xy), square, slope=True)
            level, fall = _guarded(level, fall, square, corrected)
            assert fall is not None
            move = np.where(active, level / -fall, 0.0)
            # Convex and falling: from below Newton never overshoots; from above it may.
            before = square
            square = np.maximum(square + move, 0.25 * square)
            active &= np.abs(square - before) > 1e-3 * square
            if not active.any():
                break
        return np.where(inside, np.sqrt(square), 0.0)


def _guarded(
    level: Points, fall: Points | None, height2: Points, correction: Correction
) -> tuple[Points, Points | None]:
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


_fields: Memory[tuple[ConvolutionField, Points]] = Memory(limit=16)
"""The preview's field is the final solid's, too: it does not depend on the resolution."""


def convolution_field(
    outline: Outline, *, softness: float = 1.4, inflation: float = 1.0
) -> tuple[ConvolutionField, Points]:
    """Skeleton, weights and correction for an outline.

    Parameters
    ----------
    outline : Outline
        In the object frame.
    softness : float
        Support of the kernel in radii, 1.25 to 2: how far limbs blend into each other.
    inflation : float
        Factor on the depth.

    Returns
    -------
    field : ConvolutionField
    axis : (k, 3) float array
        The unsimplified chordal axis, in the frame of the sums.
    """
    question = (outline, softness, inflation)
    return _fields.recall(question, lambda: _fitted(outline, softness, inflation))


def _fitted(outline: Outline, softness: float, inflation: float) -> tuple[ConvolutionField, Points]:
    low, high = outline.bounds
    scale, origin = outline.size, 0.5 * (low + high)
    inner = outline.transformed(1.0 / scale, -origin / scale)
    perimeter = sum(float(np.hypot(*(np.roll(r, -1, axis=0) - r).T).sum()) for r in inner.rings)
    step = min(perimeter / SKELETON_STEPS, 0.03)
    rim = sample_rim(inner.rings, step, step / 6.0, thinness=0.8)
    if not rim.simple:
        rim = sample_rim(inner.rings, step, step / 6.0, thinness=0.8, every_vertex=True)
    if len(rim.points) > MOST_SAMPLES:
        raise UserError(
            "This drawing is too intricate to swell in one piece. Simplify it, or build its "
            "parts one by one."
        )
    axis = chordal_axis(Outline(rim.rings, inner.parents))
    skeleton = simplified(axis, SKELETON_TOLERANCE)
    segments = Segments.of(skeleton, softness, THINNEST)
    fitted = fit_weights(skeleton, segments, rim.points)
    raw = ConvolutionField(
        skeleton.transformed(scale, origin),
        fitted,
        softness,
        inflation,
        scale,
        origin,
        segments,
        rim,
        np.zeros(len(rim.points)),
        np.zeros(len(rim.points)),
        np.zeros((0, 4)),
        RimDistance(rim.points, rim.after),
    )
    return raw, axis.nodes


def with_correction(raw: ConvolutionField, rim: Rim) -> ConvolutionField:
    """The same field, corrected so that its zero line in z = 0 is the sampled outline."""
    from dataclasses import replace

    pairs = pairs_within_reach(rim.points, raw.segments)
    level, _ = raw._convolved(pairs, len(rim.points), np.zeros(len(rim.points)), slope=False)
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
    nodes = raw.skeleton.transformed(1.0 / raw.scale, -raw.origin / raw.scale)
    wanted = nodes.heights(nodes.nodes[:, :2])
    height = field_.heights_inner(nodes.nodes[:, :2])
    error = np.abs(height - wanted) / np.maximum(wanted, THINNEST)
    # The correction sets in gradually: how a shape is drawn must not switch it on or off.
    share = np.clip(2.0 * error / SUMMIT_ERROR - 1.0, 0.0, 1.0)
    off = np.flatnonzero((share > 0.0) & (wanted > THINNEST))
    summit = nodes.nodes[off]
    missing = -share[off] * field_._level(summit[:, :2], wanted[off] ** 2)
    return replace(field_, summits=np.column_stack([summit, np.clip(missing, -0.5, 0.5)]))
