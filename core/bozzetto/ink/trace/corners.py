"""Corners of traced lines: an open line that turns sharply is several strokes of a hand."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

ARM: Final = 6.0
"""Length along a line, on both sides of a place, that tells how it turns there, in widths."""

SHORTEST_ARM: Final = 2.5
"""Least length of an arm near an end of the line, in widths: dashes that touch make a corner."""

SHARP: Final = np.deg2rad(35.0)
"""Least turn of a corner."""

SHARP_AT_ENDS: Final = np.deg2rad(12.0)
"""Least turn of a corner at which another line ends, too."""

AT_END: Final = 2.5
"""Distance from the end of another line to such a corner, in widths, at most."""

LOCAL: Final = 0.65
"""Least share of the turn that half as long arms see, too: on an arc it is a half."""


def split_at_corners(line: Array, width: float, others: Array) -> list[Array]:
    """Split an open line at its corners.

    Parameters
    ----------
    line : (n, 2) float
        Evenly sampled.
    width : float
        Width of the lines, in the units of the points.
    others : (m, 2) float
        Ends of the other lines. A hand that ends a line at another one ends it at its corner: so
        less of a turn is a corner there.

    Returns
    -------
    list of (m, 2) float
        Neighbours share the corner; the line itself where it has none.
    """
    spacing = float(np.linalg.norm(np.diff(line, axis=0), axis=1).mean())
    long, short = (max(2, round(each * width / max(spacing, 1e-9))) for each in (ARM, SHORTEST_ARM))
    places = np.arange(short, len(line) - short)
    if not len(places):
        return [line]
    arms = np.minimum(long, np.minimum(places, len(line) - 1 - places))
    near, far = _turns(line, places, np.maximum(1, arms // 2)), _turns(line, places, arms)
    least = np.where(_beside(line[places], others, AT_END * width), SHARP_AT_ENDS, SHARP)
    is_corner = (far > least) & (near > LOCAL * far)
    cuts: list[int] = []
    for number in np.argsort(-near):
        # Of places that are closer than an arm the sharpest is the corner.
        place = int(places[number])
        if is_corner[number] and all(abs(place - cut) >= arms[number] for cut in cuts):
            cuts.append(place)
    stations = [0, *sorted(cuts), len(line) - 1]
    return [line[a : b + 1] for a, b in pairwise(stations)]


def _turns(line: Array, places: Index, arms: Index) -> Array:
    """Return the angle, rad, by which a line turns at places, seen with arms of so many samples."""
    behind = line[places] - line[places - arms]
    ahead = line[places + arms] - line[places]
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (behind * ahead).sum(1))))


def _beside(places: Array, others: Array, reach: float) -> Flags:
    """Whether places are within reach of one of the others, (n,)."""
    from scipy.spatial import cKDTree

    if not len(others):
        return np.zeros(len(places), bool)
    apart, _ = cKDTree(others).query(places, distance_upper_bound=reach)
    near: Flags = np.isfinite(apart)
    return near
