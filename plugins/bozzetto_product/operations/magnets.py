"""Offers: what the free ends of curves nearly meet, by pixels of a view."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.view import Camera, triple
from bozzetto_product.model.planes import Point
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.clusters import End
from bozzetto_product.operations.free_ends import network_ends
from bozzetto_product.operations.proposals import Proposal, nearest_gap
from bozzetto_product.projection.views import pixel_size, seen_at

DEEPER: Final = 3.0
"""Largest gap in space, in lengths of the tolerance: what only seems to meet is left alone."""


@dataclass(frozen=True)
class NearMiss:
    """A free end that nearly meets something.

    Attributes
    ----------
    proposal : Proposal
        What it would be joined to, and where.
    place : (x, y, z)
        Where the end is, mm.
    pixels : float
        How far apart they are seen.
    """

    proposal: Proposal
    place: Point
    pixels: float


def near_misses(state: ProductState, camera: Camera, *, tolerance: float) -> tuple[NearMiss, ...]:
    """Find the free ends that nearly meet something, as seen in a view.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    camera : Camera
        Of the view.
    tolerance : float
        Largest distance on the sheet, px; in space it may be three times as much.

    Returns
    -------
    tuple of NearMiss
        Nearest on the sheet first.
    """
    ends = network_ends(state, np.inf)
    if not ends:
        return ()
    sizes = DEEPER * tolerance * pixel_size(camera, np.array([end.place for end in ends]))
    reaching = [
        replace(end, gap=min(end.gap, float(size))) for end, size in zip(ends, sizes, strict=True)
    ]
    found = [
        miss
        for end in reaching
        if not end.joint
        if (miss := _miss(end, reaching, state, camera)) is not None and miss.pixels <= tolerance
    ]
    return tuple(sorted(found, key=lambda miss: (miss.pixels, miss.place)))


def _miss(end: End, ends: list[End], state: ProductState, camera: Camera) -> NearMiss | None:
    """Return what an end nearly meets."""
    found = nearest_gap(end, ends, state)
    if found is None:
        return None
    seen = seen_at(camera, np.array((end.place, found.place)))
    pixels = float(np.linalg.norm(seen[1] - seen[0]))
    if not np.isfinite(pixels):
        return None
    return NearMiss(found, triple(end.place), pixels)
