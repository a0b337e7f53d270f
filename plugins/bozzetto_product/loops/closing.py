"""Loops that close a flat sheet: it would be a body without inside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.network.net import Loop, Net

FLAT: Final = 0.01
"""Mean thickness of a closed part, as share of its extent, below which it is a sheet: a hand that
draws on a plane is off by less."""

SHALLOW: Final = 0.045
"""Mean thickness, as share of the square root of its largest area, below which it is one, too: an
area of a round shape that a curve is drawn across is two surfaces, not a body with the old one."""


def flat_lids(net: Net, loops: Sequence[Loop], fixed: int) -> Flags:
    """Tell which loops close a flat sheet.

    Of each part that is closed and flat that is the longest loop that is not fixed, which is the
    one round all others.

    Parameters
    ----------
    net : Net
        The network.
    loops : sequence of Loop
        All of it.
    fixed : int
        How many of the first ones stay, whatever they close.

    Returns
    -------
    (n,) bool
    """
    oriented = orient_loops(net, loops)
    lids = np.zeros(len(loops), bool)
    for part, closed in zip(oriented.parts, oriented.closed, strict=True):
        free = [number for number in part if number >= fixed]
        if closed and free and _is_flat(net, [oriented.loops[n] for n in part]):
            lids[max(free, key=lambda number: _length(net, loops[number]))] = True
    return lids


def _is_flat(net: Net, loops: Sequence[Loop]) -> bool:
    """Tell whether loops that close, all turned outward, hold next to nothing.

    Their volume, each loop as a cone over its own centre, over the area of the largest is a
    thickness.
    """
    rings = [_ring(net, loop) for loop in loops]
    everything = np.vstack(rings)
    volume, largest = 0.0, 0.0
    for ring in rings:
        points = ring - everything.mean(axis=0)
        centre = points.mean(axis=0)
        following = np.roll(points, -1, axis=0)
        area = 0.5 * np.cross(points - centre, following - centre).sum(axis=0)
        volume += float(area @ centre) / 3.0
        largest = max(largest, float(np.linalg.norm(area)))
    extent = float(np.linalg.norm(np.ptp(everything, axis=0)))
    thickness = max(FLAT * extent, SHALLOW * float(np.sqrt(largest)))
    return abs(volume) <= thickness * largest


def _ring(net: Net, loop: Loop) -> Array:
    lines = [net.edges[edge].spline.sampled(17)[:: 1 if forward else -1] for edge, forward in loop]
    return np.vstack([line[:-1] for line in lines])


def _length(net: Net, loop: Loop) -> float:
    return sum(net.edges[edge].spline.length for edge, _ in loop)
