"""Groups of a mesh's triangles, as writers meet them: without the degenerate triangles."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.color import WHITE
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.geometry.shapes import FaceGroup, Solid, Surface


def proper_groups(part: Solid | Surface) -> tuple[FaceGroup, ...]:
    """Return the groups of a part with its proper triangles counted; none that has no triangle."""
    bounds = np.cumsum([0, *(group.count for group in part.groups)])
    proper = np.concatenate(([0], np.cumsum(~is_degenerate(part.mesh.faces))))[bounds]
    counted = (
        replace(group, count=int(last - first))
        for group, (first, last) in zip(part.groups, pairwise(proper), strict=True)
    )
    return tuple(group for group in counted if group.count)


def triangle_colors(part: Solid | Surface) -> NDArray[np.uint8] | None:
    """Return RGBA of every proper triangle, (f, 4), where groups have colours of their own.

    None where the colours of the vertices or of the whole part say it all.
    """
    groups = proper_groups(part)
    if part.mesh.colors is not None or not any(group.color for group in groups):
        return None
    rows = [(*(group.color or part.color or WHITE), 255) for group in groups]
    counts = [group.count for group in groups]
    return np.repeat(np.array(rows, np.uint8), counts, axis=0)
