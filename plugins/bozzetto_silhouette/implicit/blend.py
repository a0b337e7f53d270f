"""Blends: two solids as functions of space become one, smoothly within a reach.

All take samples whose values are about signed distances, positive inside, and give such a
sample. A reach k is a length: where the values differ by k or more, or where both lie k
outside, nothing is blended. On a right-angled crease the fillet touches both sides at about
the distance k from it.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.implicit.implicit_solid import Sample
from bozzetto_silhouette.numerics.isotropic_remeshing import dot

ORDER = 3.5
"""Power to which the potential of the scale-invariant kernel falls off around a tube (Zanni
et al. 2013: the compact sextic, integrated along it)."""


def flipped(sample: Sample) -> Sample:
    """Return the sample of the complement."""
    return Sample(-sample.value, -sample.gradient, sample.curvature)


def reach_by_angle(first: Sample, second: Sample, reach: Array | float) -> Array:
    """Return the reach of a blend of two samples, by the angle between their gradients."""
    lengths = np.sqrt(dot(first.gradient, first.gradient) * dot(second.gradient, second.gradient))
    cosine = dot(first.gradient, second.gradient) / np.maximum(lengths, 1e-300)
    narrowed: Array = reach * np.clip(1.0 - cosine, 0.0, 1.0)
    return narrowed


def smooth_maximum(first: Sample, second: Sample, reach: Array | float) -> Sample:
    """Unite two samples by the angle between them: sides that meet smoothly do not bulge.

    The polynomial smooth maximum ``max + (k - |a - b|)^2 / 4k`` with the reach
    ``k = reach * clip(1 - cos, 0, 1)`` of the angle between the gradients. It is a simplified
    form of the gradient-based operators of Gourmel et al., "A Gradient-Based Implicit Blend"
    (2013): no bulge where limbs overlap in line, a full fillet at right angles.

    Notes
    -----
    The gradient leaves out how the reach changes from place to place. It is exact where
    nothing is blended and on flat sides; elsewhere off by at most a quarter of the reach over
    the radius of curvature.
    """
    a, b = first.value, second.value
    k = reach_by_angle(first, second, reach)
    excess = np.maximum(k - np.abs(a - b), 0.0)
    k = np.maximum(k, 1e-300)
    value = np.maximum(a, b) + 0.25 * excess * (excess / k)
    one, other = (a >= b).astype(np.float64), (a < b).astype(np.float64)
    near = excess > 0.0  # elsewhere the quotient may overflow
    half = 0.5 * ((a - b)[near] / k[near])
    # Not one from the other: the same to the last bit in either order.
    one[near], other[near] = 0.5 + half, 0.5 - half
    return _mixed(value, one, first, other, second)


def summed(first: Sample, second: Sample, reach: Array | float) -> Sample:
    """Unite two samples as one field: their potentials are added.

    Around a tube of radius r the scale-invariant kernel of support r + k makes the potential
    ``((r + k)^2 - (r - d)^2)^(7/2)`` at the depth d, which is ``(1 + d / k)^(7/2)`` but for the
    scale and terms of d / r. Sums of these are turned back into a depth the same way. It
    joins what is near, and swells where limbs overlap, as all sums of fields do.
    """
    a, b = (np.maximum(1.0 + s.value / reach, 0.0) for s in (first, second))
    most = np.maximum(np.maximum(a, b), 1e-300)
    lower, upper = np.minimum(a, b) / most, np.maximum(a, b)
    total = upper * (1.0 + lower**ORDER) ** (1.0 / ORDER)
    outside = upper == 0.0
    value = np.where(outside, np.maximum(first.value, second.value), reach * (total - 1.0))
    leads = first.value >= second.value
    safe = np.maximum(total, 1e-300)
    one, other = (
        np.where(outside, side, (amount / safe) ** (ORDER - 1.0))
        for amount, side in ((a, leads), (b, ~leads))
    )
    return _mixed(value, one, first, other, second)


def _mixed(value: Array, one: Array, first: Sample, other: Array, second: Sample) -> Sample:
    """Return a sample with a given value and the weighted sum of two gradients."""
    gradient = one[:, None] * first.gradient + other[:, None] * second.gradient
    total = np.maximum(one + other, 1e-300)
    curvature = (one * first.curvature + other * second.curvature) / total
    return Sample(value, gradient, curvature)
