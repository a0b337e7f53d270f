"""Bodies put together: sharp, blended, and as a smooth maximum on a full grid."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from bozzetto_silhouette.body import Body
from bozzetto_silhouette.combine import combined
from bozzetto_silhouette.composite import Composite
from tests.benchmarks.timing import Row, processor_ms
from tests.plugins.silhouette import bodies as b

BLEND = 0.5


def rows() -> Iterator[Row]:
    """Two balls that overlap, at the resolution of previews and at that of results."""
    for cells, sharp, blended in ((64, "", "≤ 150 ms"), (128, "≤ 100 ms", "")):
        one, other = b.ball(0.0, 50.0, cells), b.ball(70.0, 50.0, cells, "b")
        combined(one, other, "add", BLEND)
        grid = processor_ms(partial(_on_a_grid, one, other), repeats=3)
        for words, blend, budget in (("sharp", 0.0, sharp), ("blended", BLEND, blended)):
            yield Row(
                "blends", f"two parts of {len(one.faces):,} triangles, {words}, processor time",
                processor_ms(
                    partial(combined, one, other, "add", blend),
                    repeats=5,
                ),
                budget=budget, alternative="smooth maximum on a full grid, marching cubes",
                other=grid,
            )  # fmt: skip


def _on_a_grid(one: Body, other: Body) -> object:
    """What most programs do: every node of the grid, at the same spacing."""
    from skimage.measure import marching_cubes

    solid = Composite(
        one.implicit, other.implicit, "add", BLEND, BLEND * min(one.radius, other.radius)
    )
    low, high = solid.bounds
    axes = [
        np.arange(a - one.step, c + 2.0 * one.step, one.step)
        for a, c in zip(low, high, strict=True)
    ]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = solid.value(nodes.reshape(-1, 3)).reshape(nodes.shape[:3])
    return marching_cubes(values, 0.0)
