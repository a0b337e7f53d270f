"""Loops that close what is not meant to be closed: a flat sheet, or a body that is half drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, cross_product
from bozzetto_product.loops.candidates import Halves
from bozzetto_product.loops.costs import BLUNT, STRAIGHT
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.half_edges import half_edges
from bozzetto_product.network.net import Loop, Net

FLAT: Final = 0.01
"""Mean thickness of a closed part, as share of its extent, below which it is a sheet: a hand that
draws on a plane is off by less."""

SHALLOW: Final = 0.045
"""Mean thickness, as share of the square root of its largest area, below which it is one, too: an
area of a round shape that a curve is drawn across is two surfaces, not a body with the old one."""


UPRIGHT: Final = 0.7
"""Cosine of the angle (45°) between two loops from which on one stands on the other as a wall."""

WALLED: Final = 0.95
"""Share of the length of a loop that has walls from which on it closes a plate: what a sheet is
divided into lies in its plane, but slivers between strokes drawn twice may lean anywhere."""

FAR_SIDE: Final = 0.5
"""Area of what does not touch the largest loop of a plate, by that of the loop, from which on it is
the plate's other side."""

PLANE: Final = 0.02
"""Root mean square distance from its plane, as share of its extent, below which a ring round
several surfaces may well be their bottom."""


def flat_lids(net: Net, sampled: SampledNet, loops: Sequence[Loop], fixed: int) -> Flags:
    """Tell which loops close a flat sheet.

    Of each part that is closed and flat that is the longest loop that is not fixed, which is the
    one round all others. A plate is a body, however thin: walls stand all round its largest loop.

    Parameters
    ----------
    net : Net
        The network.
    sampled : SampledNet
        The same.
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
            lid = max(free, key=lambda number: _length(net, loops[number]))
            lids[lid] = not _is_plate(net, sampled, [loops[number] for number in part])
    return lids


def unfinished_rims(net: Net, sampled: SampledNet, loops: Sequence[Loop], fixed: int) -> Flags:
    """Tell which loops are the rim of a body that is half drawn.

    A *free corner* is a sharp one at which only two edges end: both loops there have both edges. It
    is where a surface stops, or the tip of a leaf, which has one other side. A loop that shares
    free corners with several others runs round all of these. In a plane it is their bottom; else it
    closes what nobody drew: of three sides of a box that is the ring of six edges behind them.

    Parameters
    ----------
    net : Net
        The network.
    sampled : SampledNet
        The same.
    loops : sequence of Loop
        All of it.
    fixed : int
        How many of the first ones stay.

    Returns
    -------
    (n,) bool
    """
    corners = [_free_corners(sampled, half_edges(loop)) for loop in loops]
    owners: dict[frozenset[int], set[int]] = {}
    for number, own in enumerate(corners):
        for corner in own:
            owners.setdefault(corner, set()).add(number)
    partners = [
        set().union(*(owners[corner] for corner in own)) - {number}
        for number, own in enumerate(corners)
    ]
    return np.array(
        [
            number >= fixed and len(others) > 1 and not _is_plane(_ring(net, loop))
            for number, (loop, others) in enumerate(zip(loops, partners, strict=True))
        ],
        bool,
    )


def _free_corners(sampled: SampledNet, loop: Halves) -> set[frozenset[int]]:
    """Return the free corners of a loop, each as its two edges."""
    found = set()
    for half, following in zip(loop, [*loop[1:], loop[0]], strict=True):
        node = sampled.heads[half]
        cosine = float(-sampled.leaving[half ^ 1] @ sampled.leaving[following])
        if node >= 0 and sampled.degrees[node] == 2 and cosine < STRAIGHT:
            found.add(frozenset((half // 2, following // 2)))
    return found


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
        area = _area(points)
        volume += float(area @ points.mean(axis=0)) / 3.0
        largest = max(largest, float(np.linalg.norm(area)))
    extent = float(np.linalg.norm(np.ptp(everything, axis=0)))
    thickness = max(FLAT * extent, SHALLOW * float(np.sqrt(largest)))
    return abs(volume) <= thickness * largest


def _is_plate(net: Net, sampled: SampledNet, loops: Sequence[Loop]) -> bool:
    """Tell whether loops stand on the largest of some, all along it, and others are beyond them."""
    areas = [_area(_ring(net, loop)) for loop in loops]
    sizes = [float(np.linalg.norm(area)) for area in areas]
    largest = int(np.argmax(sizes))
    edges = {edge for edge, _ in loops[largest]}
    beyond = sum(
        size
        for loop, size in zip(loops, sizes, strict=True)
        if not any(edge in edges for edge, _ in loop)
    )
    if beyond < FAR_SIDE * sizes[largest]:
        return False
    normals = [
        _corner_normals(sampled, half_edges(loop), area)
        for loop, area in zip(loops, areas, strict=True)
    ]
    length = walled = 0.0
    for half, own in normals[largest].items():
        others = [each for number, each in enumerate(normals) if number != largest]
        edge = net.edges[half // 2].spline.length
        length += edge
        for other in others:
            # At the start of a half-edge is the end of the one that runs against it.
            beside = other.get(half, other.get(half ^ 1, own)[::-1])
            walled += edge * float(np.abs((own * beside).sum(axis=1)).max() < UPRIGHT)
    return walled >= WALLED * length


def _corner_normals(sampled: SampledNet, loop: Halves, area: Array) -> dict[int, Array]:
    """Return the unit normals of a loop at the start and the end of each half-edge, (2, 3).

    Where it hardly turns that is the normal of its area.
    """
    halves = np.array(loop)
    arriving, leaving = -sampled.leaving[np.roll(halves, 1) ^ 1], sampled.leaving[halves]
    normal = cross_product(arriving, leaving)
    sine = np.linalg.norm(normal, axis=1, keepdims=True)
    whole = area / max(float(np.linalg.norm(area)), 1e-300)
    unit = np.where(sine > BLUNT, normal / np.maximum(sine, 1e-300), whole)
    return {
        half: np.stack((first, last))
        for half, first, last in zip(loop, unit, np.roll(unit, -1, axis=0), strict=True)
    }


def _area(ring: Array) -> Array:
    """Return the vector of the area of a ring of points."""
    points = ring - ring.mean(axis=0)
    return np.asarray(0.5 * cross_product(points, np.roll(points, -1, axis=0)).sum(axis=0))


def _is_plane(ring: Array) -> bool:
    spread = np.linalg.svd(ring - ring.mean(axis=0), compute_uv=False) / np.sqrt(len(ring))
    return bool(spread[2] <= PLANE * np.linalg.norm(np.ptp(ring, axis=0)))


def _ring(net: Net, loop: Loop) -> Array:
    lines = [net.edges[edge].spline.sampled(17)[:: 1 if forward else -1] for edge, forward in loop]
    return np.vstack([line[:-1] for line in lines])


def _length(net: Net, loop: Loop) -> float:
    return sum(net.edges[edge].spline.length for edge, _ in loop)
