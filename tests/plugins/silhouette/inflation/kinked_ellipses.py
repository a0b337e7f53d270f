"""Ellipses by a hand that slips: a kink of about a pixel somewhere, or a tremor all along."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.inflation.inflation import HeightModel
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid, solidify
from bozzetto_silhouette.outline.outline import outline_from_rings

Points = NDArray[np.float64]
LONG, SHORT = 60.0, 30.0


def ellipse(samples: int = 160) -> tuple[Points, Points]:
    """Points, and normals outwards."""
    t = np.linspace(0.0, 2.0 * np.pi, samples, endpoint=False)
    normal = np.column_stack([np.cos(t) / LONG, np.sin(t) / SHORT])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.column_stack([LONG * np.cos(t), SHORT * np.sin(t)]), normal


def slipped(seed: int, count: int) -> Iterator[Points]:
    """Each with one kink of half a pixel to a pixel and a half, in or out, anywhere."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        points, normal = ellipse()
        at = random.integers(len(points)) if random.random() < 0.5 else random.choice([0, 80])
        size = float(random.uniform(0.5, 1.5) * random.choice([-1.0, 1.0]))
        points[at] += size * normal[at]
        yield points


def trembling(seed: int, count: int) -> Iterator[Points]:
    """Each with a tremor of 0.3 px across the line."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        points, normal = ellipse(120)
        yield points + random.normal(0.0, 0.3, 120)[:, None] * normal


def inflated(points: Points, heights: HeightModel) -> SilhouetteSolid:
    return solidify(outline_from_rings([points]), resolution=64, height_model=heights)


def end_shares(solid: SilhouetteSolid) -> Any:
    """Squared height over that of the ellipsoid, in the last sixth on the left and the right."""
    x, y, z = solid.vertices.T
    square = (1.0 - (x / LONG) ** 2 - (y / SHORT) ** 2) * SHORT**2
    shares = []
    for side in (x < -LONG * 5 / 6, x > LONG * 5 / 6):
        inside = side & (z >= 0.0) & (square > 9.0)
        shares.append(float((z[inside] ** 2).sum() / square[inside].sum()))
    return shares
