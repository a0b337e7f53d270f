"""Ink without a partner: it is no part of the curve, and must not vanish silently."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin import remembered
from bozzetto_symmetry.ink.polyline import length_of, runs
from bozzetto_symmetry.solve.curve_solver import Trace, View
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

LOOSE: Final = 8.0
"""Distance, px, from the pictures of a curve beyond which ink is not part of it: several times
the error of a hand."""

SHORTEST: Final = 12.0
"""Length, px, from which such ink is shown."""


@remembered(limit=64, key=lambda trace: (trace.curve, trace.views))
def unmatched_ink(trace: Trace) -> list[Array]:
    """Return the stretches of ink that lie on neither picture of the curve.

    Parameters
    ----------
    trace : Trace
        A curve without edits: ink of what was cut off does not count as unmatched.

    Returns
    -------
    list of (n, 3) float
        In the frame of the plane, mm: seen where they were drawn, at the depth of the place
        of the curve that is nearest on the sheet.
    """
    if trace.curve is None:
        return []
    return [end for view in trace.views for end in _in_view(view, trace.points)]


def _in_view(view: View, points: Array) -> Iterator[Array]:
    images = (points, points * MIRROR)
    seen = [view.stereo.project(image) for image in images]
    if not all(np.isfinite(pixels).all() for pixels in seen):
        return
    for side in view.sides:
        away = np.min([distances_to_polyline(side.pixels, line) for line in seen], axis=0)
        for run in _runs(away > LOOSE):
            ink = side.pixels[run]
            if length_of(ink) < SHORTEST:
                continue
            gaps = np.vstack([np.linalg.norm(line - ink[0], axis=1) for line in seen])
            image, place = np.unravel_index(int(gaps.argmin()), gaps.shape)
            camera = view.stereo.camera
            yield camera.on_plane(ink, images[image][place], camera.axes[2])


def _runs(loose: Flags) -> Iterator[slice]:
    """Yield the stretches of places that are unmatched, a place longer at either side."""
    for begin, end in runs(loose):
        yield slice(max(0, begin - 1), end + 1)
