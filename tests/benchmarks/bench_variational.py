"""Variational surfaces: from the last sample of a stroke to the solid, and against SciPy.

SciPy gets the constraints for nothing, and is timed on the full grid around the solid: that is
what a person would write with it. Ours is the whole line, constraints, plan and mesh included.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.implicit.interpolation_constraints import Fit, fitted
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.inflation.variational_relief import VariationalHeights
from bozzetto_silhouette.outline.normalized import frame_of
from bozzetto_silhouette.outline.outline import Outline
from tests.benchmarks.timing import Row, median_ms, processor_ms
from tests.plugins.silhouette import outlines as o

CELLS = 128
"""Cells along the longest side."""

SHARE = 40
"""One in so many nodes of the full grid is given to SciPy, and its time multiplied: the whole
takes half a minute."""

NAMES = ("heart", "key", "hand-paper", "horse_skimage", "spider")

_NUDGES = itertools.count(1)


def nudged(outline: Outline) -> Outline:
    """Another drawing, a hair aside: results are remembered by what was drawn."""
    hair = 1e-6 * outline.size * next(_NUDGES)
    return outline.transformed(1.0, np.array([hair, 0.0]))


def full_grid(fit: Fit) -> NDArray[np.float64]:
    """Some of the nodes of a grid around the surface, `CELLS` along its longest side."""
    low, high = fit.surface.bounds
    axes = [np.arange(a, b, 1.0 / CELLS) for a, b in zip(low, high, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return nodes[::SHARE]


def rows() -> Iterator[Row]:
    """Outlines from simple to spindly, each against the full grid."""
    from scipy.interpolate import RBFInterpolator

    for name in NAMES:
        drawn = o.outline(name)

        def line(drawn: Outline = drawn) -> object:
            return solidify(nudged(drawn), resolution=CELLS, height_model=VariationalHeights())

        fit = fitted(frame_of(drawn))
        held = fit.constraints
        unknowns = int((held.points[:, 2] >= 0.0).sum())
        scipys = RBFInterpolator(held.points, held.values, kernel="cubic", degree=1)
        nodes = full_grid(fit)
        other = SHARE * processor_ms(partial(scipys, nodes), repeats=3)
        what = f"outline to final solid, {CELLS} cells, {unknowns} unknowns: {name}"
        yield Row("variational", what, median_ms(line, repeats=5), budget="≤ 300 ms")
        yield Row(
            "variational", "the same, processor time", processor_ms(line, repeats=5), "ms", "≥ 5×",
            "RBFInterpolator on the full grid, values only", other,
        )  # fmt: skip
