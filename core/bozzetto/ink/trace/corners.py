"""Corners of traced lines: an open line that turns sharply is several strokes of a hand."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array

ARM: Final = 6.0
"""Length along a line, on both sides of a place, that tells how it turns there, in widths."""

SHARP: Final = np.deg2rad(35.0)
"""Least turn of a corner."""

LOCAL: Final = 0.75
"""Least share of the turn that half as long arms see, too: on an arc it is a half."""


def split_at_corners(line: Array, width: float) -> list[Array]:
    """Split an open line at its corners.

    Parameters
    ----------
    line : (n, 2) float
        Evenly sampled.
    width : float
        Width of the lines, in the units of the points.

    Returns
    -------
    list of (m, 2) float
        Neighbours share the corner; the line itself where it has none.
    """
    spacing = float(np.linalg.norm(np.diff(line, axis=0), axis=1).mean())
    arm = max(2, round(ARM * width / max(spacing, 1e-9)))
    half = max(1, arm // 2)
    if len(line) < 2 * arm + 1:
        return [line]
    near, far = _turns(line, half)[arm - half : len(line) - arm - half], _turns(line, arm)
    is_corner = (far > SHARP) & (near > LOCAL * far)
    cuts: list[int] = []
    for place in np.argsort(-near):
        # Of places that are closer than an arm the sharpest is the corner.
        if is_corner[place] and all(abs(int(place) + arm - cut) >= arm for cut in cuts):
            cuts.append(int(place) + arm)
    stations = [0, *sorted(cuts), len(line) - 1]
    return [line[a : b + 1] for a, b in pairwise(stations)]


def _turns(line: Array, arm: int) -> Array:
    """Return the angle, rad, by which a line turns at each place that has two arms."""
    behind = line[arm:-arm] - line[: -2 * arm]
    ahead = line[2 * arm :] - line[arm:-arm]
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (behind * ahead).sum(1))))
