"""An outline brought to unit size, with its samples and its skeleton: where all sums are done."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import cached_property, remembered
from bozzetto_silhouette.outline.boundary_sampling import Rim, corner_mask, sample_rim
from bozzetto_silhouette.outline.medial_axis import Skeleton, chordal_axis, simplified
from bozzetto_silhouette.outline.mirror_symmetry import mirrored_coordinate
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.outline.sketchco_skeleton import paper_skeleton

SkeletonRule = Literal["exact", "paper"]

SKELETON_STEPS = 230
"""Samples of the outline that the skeleton is drawn from, at least."""

MOST_SAMPLES = 20_000
"""Samples of the outline beyond which the fit's tables would not fit into memory; a horse
has three hundred."""

INTRICATE = (
    "This drawing is too intricate to swell in one piece. Simplify it, or build its parts one by "
    "one."
)

SKELETON_TOLERANCE = 5e-3
"""Simplification of the skeleton, as a share of the longest side."""

MOST_NODES = 400
"""Nodes of the paper's skeleton that are kept as they are: its kernels take half a minute on the
thousands that needles and combs have."""

TOO_MANY_NODES = 800
"""Nodes, after that, with which nobody would wait."""

FINEST_TOLERANCE = SKELETON_TOLERANCE / 32.0
"""With which their simplification begins."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame of the sums, ``(xy - origin) / scale``, and what is known of the outline in it.

    Attributes
    ----------
    outline : Outline
        As drawn, in the object frame.
    scale, origin : float, (2,) float array
        Longest side and middle of the outline.
    inner : Outline
        In the frame of the sums, as drawn.
    rim : Rim
        Samples that the skeleton and the fits are made from.
    axis : (k, 3) float array
        The unsimplified chordal axis: x, y, radius.
    skeleton : Skeleton
    """

    outline: Outline
    scale: float
    origin: Array
    inner: Outline
    rim: Rim
    axis: Array
    skeleton: Skeleton

    @cached_property
    def mirrored(self) -> int | None:
        """Which coordinate changes its sign in the mirror image; see `mirrored_coordinate`."""
        return mirrored_coordinate(self.inner.rings)


# The preview's frame is the final solid's, too: it does not depend on the resolution.
@remembered(limit=64)
def frame_of(outline: Outline, rule: SkeletonRule = "exact") -> Frame:
    """Sample an outline and take its skeleton.

    Parameters
    ----------
    outline : Outline
        In the object frame.
    rule : {"exact", "paper"}
        How the skeleton is taken from the triangles.

    Raises
    ------
    UserError
        If the outline needs more samples than there is room for, or the paper's skeleton has
        more nodes than its kernels can sum up in seconds.
    """
    low, high = outline.bounds
    scale, origin = outline.size, 0.5 * (low + high)
    inner = outline.transformed(1.0 / scale, -origin / scale)
    if sum(int(corner_mask(ring).sum()) for ring in inner.rings) > MOST_SAMPLES:
        raise UserError(INTRICATE)  # every corner becomes a sample
    perimeter = sum(float(np.hypot(*(np.roll(r, -1, axis=0) - r).T).sum()) for r in inner.rings)
    step = min(perimeter / SKELETON_STEPS, 0.03)
    rim = sample_rim(inner.rings, step, step / 6.0, thinness=0.8)
    if not rim.simple:
        rim = sample_rim(inner.rings, step, step / 6.0, thinness=0.8, every_vertex=True)
    if len(rim.points) > MOST_SAMPLES:
        raise UserError(INTRICATE)
    sampled = Outline(rim.rings, inner.parents)
    axis = chordal_axis(sampled)
    skeleton = simplified(axis, SKELETON_TOLERANCE) if rule == "exact" else _papers(sampled)
    return Frame(outline, scale, origin, inner, rim, axis.nodes, skeleton)


def _papers(outline: Outline) -> Skeleton:
    """Return the paper's skeleton; one of very many nodes is simplified."""
    skeleton, tolerance = paper_skeleton(outline), FINEST_TOLERANCE
    thinned = skeleton
    while len(thinned.nodes) > MOST_NODES and tolerance <= SKELETON_TOLERANCE:
        thinned = simplified(skeleton, tolerance)
        tolerance *= 2.0
    if len(thinned.nodes) > TOO_MANY_NODES:
        raise UserError(
            "This drawing is too intricate for the skeleton of SketchCo. Take the one on the "
            "medial axis."
        )
    return thinned
