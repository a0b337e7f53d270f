"""The heat band: how well each place of a curve is known, drawn over the curve."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.ink import arc_length
from bozzetto.scene import Lines, Paint
from bozzetto_symmetry.ink.polyline import interpolate
from bozzetto_symmetry.stereo.uncertainty import heat

COLORS: Final[tuple[Paint, Paint, Paint]] = ((0, 140, 130), "warning", (200, 52, 60))
"""Well known, doubtful, nearly unknown. The green is bluish, so that people who confuse red and
green can separate these; all three stand out on the paper of both themes."""

WIDTHS: Final = (2.5, 3.0, 3.5)
"""Pixels: what is less known is wider, whatever its colour."""

WORST: Final = 2
"""The heat that is drawn in dashes: nobody should trust such a line."""

DASHES: Final = 40
"""Dashes that a whole curve would have, with gaps as long between them."""


def heat_bands(curves: Sequence[tuple[Array, Array]], diagonal: float) -> tuple[Lines, ...]:
    """Return bands over curves: green, yellow, and red in dashes.

    A piece between two samples is as hot as the hotter of them. Stretches of different heat
    share the point where they meet.

    Parameters
    ----------
    curves : sequence of ((n, 3) float, (n,) float)
        Samples along each curve, mm, and how far each may be off for 1 px of noise, mm. A
        closed curve ends where it began. Samples that are not finite leave a gap.
    diagonal : float
        Of the box, mm.

    Returns
    -------
    tuple of Lines
        One for each heat that occurs, the hottest last.
    """
    runs: tuple[list[Array], ...] = ([], [], [])
    for points, sigma in curves:
        for level, run in _runs(points, heat(sigma, diagonal)):
            pieces = _dashes(run, _length(points) / (2 * DASHES - 1)) if level == WORST else [run]
            runs[level].extend(pieces)
    return tuple(
        Lines(
            np.concatenate(found).astype(np.float32),
            np.cumsum([0, *(len(run) for run in found[:-1])], dtype=np.int32),
            color=color,
            width=width,
            hidden="show",
        )
        for found, color, width in zip(runs, COLORS, WIDTHS, strict=True)
        if found
    )


def _runs(points: Array, level: NDArray[np.int8]) -> Iterator[tuple[int, Array]]:
    """Yield stretches of equal heat, each from the point where the one before it ends."""
    known = np.asarray(np.isfinite(points).all(axis=1))
    hotter = np.where(known[1:] & known[:-1], np.maximum(level[1:], level[:-1]), -1)
    edges = np.concatenate(([0], np.flatnonzero(np.diff(hotter)) + 1, [len(hotter)]))
    for first, last in itertools.pairwise(edges):
        if last > first and hotter[first] >= 0:
            yield int(hotter[first]), points[first : last + 1]


def _dashes(run: Array, dash: float) -> list[Array]:
    """Return a polyline in dashes of about one length, mm, one at either end."""
    along = arc_length(run)
    if along[-1] <= 0.0:
        return [run]
    count = max(1, round(0.5 * (along[-1] / dash + 1.0)))
    cuts = np.linspace(0.0, along[-1], 2 * count)
    corners = interpolate(cuts, along, run)
    return [
        np.vstack((corners[k], run[(along > cuts[k]) & (along < cuts[k + 1])], corners[k + 1]))
        for k in range(0, 2 * count, 2)
    ]


def _length(points: Array) -> float:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return float(steps[np.isfinite(steps)].sum())
