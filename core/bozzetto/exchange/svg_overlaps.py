"""Painted outlines that overlap: one outline around everything that they paint.

Nested outlines are left as they are. Overlapping ones cannot be nested, and on the screen
they are one area with one outline: icons and logos are full of them. An outline that runs
to and fro along a slit to reach its hole is an outer one and a hole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError

__all__ = ["Area", "without_overlaps"]

Array = NDArray[np.float64]

HAIR: Final = 1e-4
"""Half the width of what is cut away where an outline touches itself, as a share of the
size: outlines that touch enclose no solid."""

SPECK: Final = 1e-8
"""Area of a ring that is left out, as a share of the squared size: a rest of rounding."""

SAME_AREA: Final = 1e-6
"""Areas of one outline, counted in two ways, that differ by less (a share of the area): no
part of it is inside twice, or inside out."""

MAX_MEETINGS: Final = 200_000
"""Pairs of outlines whose boxes overlap."""

ARC_CORNERS: Final = 32
"""Corners that a whole turn gets where a tip is rounded by a hair."""


@dataclass(frozen=True)
class Area:
    """The painted element that a line belongs to.

    Parameters
    ----------
    element : int
        Lines of one element have the same number.
    rule : {"nonzero", "evenodd"}
        What counts as its inside.
    """

    element: int
    rule: Literal["nonzero", "evenodd"]


def without_overlaps(
    lines: Sequence[Array], areas: Sequence[Area | None]
) -> list[tuple[int, Array]]:
    """Join painted elements whose outlines cross or touch those of others.

    A line that only crosses itself stays: that is a slip of the pen, and the person is told.

    Parameters
    ----------
    lines : sequence of (n, 2) arrays
        Closed ones repeat their first point at the end.
    areas : sequence of Area or None
        For each line, the element whose inside is painted; None for mere lines.

    Returns
    -------
    list of (int, (n, 2) array)
        Lines, each with the number of the given one that it stands for.
    """
    rings: list[int] = []
    known: set[bytes] = set()
    kept: list[int] = []
    for k, (line, area) in enumerate(zip(lines, areas, strict=True)):
        if area is not None and len(line) > 3 and (line[0] == line[-1]).all():
            content = line.tobytes()
            if content in known:
                continue  # painted twice is painted
            known.add(content)
            rings.append(k)
        kept.append(k)
    meeting = _meeting([lines[k] for k in rings])
    meeting += [(n, n) for n, k in enumerate(rings) if _only_touches_itself(lines[k])]
    element_of = {k: area.element for k in rings if (area := areas[k]) is not None}
    group_of = _groups([(element_of[rings[a]], element_of[rings[b]]) for a, b in meeting])
    result: list[tuple[int, Array]] = []
    done: set[int] = set()
    for k in kept:
        group = group_of.get(element_of.get(k, -1))
        if group is None:
            result.append((k, lines[k]))
        elif group not in done:
            done.add(group)
            members = [j for j in rings if group_of.get(element_of[j]) == group]
            joined = _joined([lines[j] for j in members], [areas[j] for j in members])
            result.extend((k, ring) for ring in joined)
    return result


def _meeting(rings: Sequence[Array]) -> list[tuple[int, int]]:
    """Pairs of different rings that share a point."""
    import shapely

    if len(rings) < 2:
        return []
    boxes = np.array([(*ring.min(axis=0), *ring.max(axis=0)) for ring in rings])
    near, _ = shapely.STRtree(shapely.box(*boxes.T)).query(shapely.box(*boxes.T))
    if len(near) > 2 * MAX_MEETINGS:
        raise FormatError(
            "Too many of its areas overlap. Unite them in the program that made it, and save "
            "it again."
        )
    starts = np.concatenate([ring[:-1] for ring in rings])
    ends = np.concatenate([ring[1:] for ring in rings])
    owner = np.repeat(np.arange(len(rings)), [len(ring) - 1 for ring in rings])
    sides = shapely.linestrings(np.stack((starts, ends), axis=1))
    a, b = shapely.STRtree(sides).query(sides, predicate="intersects")
    pairs = np.stack((owner[a], owner[b]), axis=1)
    return [(int(i), int(j)) for i, j in np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)]


def _only_touches_itself(ring: Array) -> bool:
    """Whether a ring meets itself, but nowhere crosses over to its other side."""
    if _is_simple(ring):
        return False
    from manifold3d import CrossSection, FillRule

    low = ring.min(axis=0)
    unit = (ring[:-1] - low) / (float(np.ptp(ring, axis=0).max()) or 1.0)
    signed = abs(_area(unit))
    painted = [CrossSection([unit], r).area() for r in (FillRule.NonZero, FillRule.EvenOdd)]
    return bool(max(abs(area - signed) for area in painted) <= SAME_AREA * signed)


def _groups(pairs: Sequence[tuple[int, int]]) -> dict[int, int]:
    """Numbers that pairs connect, each with the smallest of those it is connected to."""
    parent: dict[int, int] = {}

    def root(k: int) -> int:
        while parent.setdefault(k, k) != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b in pairs:
        low, high = sorted((root(a), root(b)))
        parent[high] = low
    return {k: root(k) for k in list(parent)}


def _joined(rings: Sequence[Array], areas: Sequence[Area | None]) -> list[Array]:
    """The outline of everything that the rings of some elements paint."""
    from manifold3d import CrossSection, FillRule, JoinType, OpType

    points = np.concatenate(rings)
    low = points.min(axis=0)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    rules = {"nonzero": FillRule.NonZero, "evenodd": FillRule.EvenOdd}
    by_area: dict[Area, list[Array]] = {}
    for ring, area in zip(rings, areas, strict=True):
        if area is not None:
            by_area.setdefault(area, []).append((ring[:-1] - low) / size)
    painted = [CrossSection(contours, rules[area.rule]) for area, contours in by_area.items()]
    whole: Any = CrossSection.batch_boolean(painted, OpType.Add)
    found = _closed(whole.to_polygons())
    if _meeting(found) or not all(_is_simple(ring) for ring in found):
        for change in (-HAIR, HAIR):
            whole = whole.offset(change, JoinType.Round, 2.0, ARC_CORNERS)
        found = _closed(whole.to_polygons())
    return [ring * size + low for ring in found]


def _closed(polygons: Sequence[Array]) -> list[Array]:
    """Rings that repeat their first point, without specks."""
    rings = [np.vstack((p, p[:1])).astype(np.float64) for p in polygons if len(p) > 2]
    return [ring for ring in rings if abs(_area(ring)) > SPECK]


def _area(ring: Array) -> float:
    x, y = (ring - ring[0]).T
    return 0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def _is_simple(ring: Array) -> bool:
    import shapely

    return bool(shapely.LinearRing(ring).is_simple)
