"""Runs along which the epipolar lines touch a curve, and bridges over them."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_symmetry.ink.polyline import runs
from bozzetto_symmetry.stereo.epipolar_signal import Signal
from bozzetto_symmetry.stereo.mirror_camera import Stereo

SHALLOW: Final = 0.06
"""Sine of the angle to the epipolar lines below which a long run says nothing."""

LONG: Final = 0.1
"""Share of a side from which a run is long: about where a turn, rather than a straight line,
would have a radius as large as the whole side."""

LEAST: Final = 1e-9
"""Least length that is divided by."""


def weak_runs(first: Signal, places: Index, second: Signal, partners: Index) -> Flags:
    """Return which samples lie on a long run on which neither signal changes.

    Parameters
    ----------
    first, second : Signal
        The signals of both sides.
    places, partners : (k,) int
        Samples of the one and of the other that belong together.
    """
    weak = _shallow(first, places) & _shallow(second, partners)
    return _long_runs(weak, LONG * len(first.angles))


def _shallow(signal: Signal, places: Index) -> Flags:
    """Return whether a signal hardly changes around some of its samples."""
    count = len(signal.angles)
    reach = max(1, round(0.5 * LONG * count))
    index = np.clip(places, 0, count - 1)
    low, high = np.maximum(index - reach, 0), np.minimum(index + reach, count - 1)
    rise = np.abs(signal.angles[high] - signal.angles[low]) * signal.scales[index]
    return np.asarray(rise < SHALLOW * signal.step * (high - low))


def _long_runs(flags: Flags, shortest: float) -> Flags:
    kept = np.zeros(len(flags), bool)
    for begin, end in runs(flags):
        kept[begin:end] = end - begin >= shortest
    return kept


def bridge_weak_runs(stereo: Stereo, near: Array, far: Array, weak: Flags) -> Array:
    """Return partners on weak runs, from what is known at both their ends.

    Along the epipolar line the place of a partner is taken linear in that of the near one,
    as slopes of rays: a line parallel to the plane's normal then keeps its x and z.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    near, far : (k, 2) float
        Partners on common epipolar lines, px.
    weak : (k,) bool
        The runs; the first and last pair count as known in any case.

    Returns
    -------
    (k, 2) float
        `far`, with other places on the runs.
    """
    if not weak.any():
        return far
    known = ~weak
    known[[0, -1]] = True
    made = far.copy()
    ours, theirs = _along(stereo, near), _along(stereo, far)
    anchors = np.flatnonzero(known)
    for begin, end in pairwise(anchors):
        if end - begin < 2:
            continue
        inner = np.arange(begin + 1, end)
        way = ours[end] - ours[begin]
        share = (
            np.clip((ours[inner] - ours[begin]) / way, 0.0, 1.0)
            if way
            else (inner - begin) / (end - begin)
        )
        slopes = theirs[begin] + share * (theirs[end] - theirs[begin])
        places = _on_line(stereo, near[inner], slopes)
        fine = np.isfinite(places).all(axis=1)
        made[inner[fine]] = places[fine]
    return made


def _along(stereo: Stereo, pixels: Array) -> Array:
    """Return where on their epipolar lines places are: slopes of rays, or px in a parallel view."""
    if stereo.parallel:
        return np.asarray((pixels * stereo.toward_vanishing(pixels)).sum(axis=1))
    way = stereo.rays(pixels).directions
    return np.asarray(way[:, 1] / np.maximum(np.hypot(way[:, 0], way[:, 2]), LEAST))


def _on_line(stereo: Stereo, pixels: Array, along: Array) -> Array:
    """Return places on the epipolar lines of others, px; NaN behind the eye."""
    if stereo.parallel:
        way = stereo.toward_vanishing(pixels)
        return np.asarray(pixels + (along - _along(stereo, pixels))[:, None] * way)
    direction = stereo.rays(pixels).directions
    level = direction * (1.0, 0.0, 1.0)
    level /= np.maximum(np.linalg.norm(level, axis=1, keepdims=True), LEAST)
    eye = np.asarray(stereo.camera.eye)
    points = eye + stereo.camera.distance * (level + along[:, None] * (0.0, 1.0, 0.0))
    way = stereo.toward_vanishing(pixels)
    places = stereo.project(points)
    # Onto the line once more, for it is near and the rounding of the way there is not.
    return np.asarray(pixels + ((places - pixels) * way).sum(axis=1, keepdims=True) * way)
