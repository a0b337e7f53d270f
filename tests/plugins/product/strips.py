"""Outlines that no place sees all of, flat and bent: strips like letters, and half a frame."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.network.net import Loop, Net
from tests.plugins.product.known_surfaces import fitted, net_of_splines
from tests.plugins.product.plane_outlines import LETTERS

STRIPS = {
    "C": LETTERS["C"],
    "L": LETTERS["L"],
    "S": LETTERS["S"],
    "U": [(0, 0), (5, 0), (5, 6), (4, 6), (4, 1.2), (1, 1), (1, 4), (0, 4)],
    "half a frame": [(0, 0), (7, 0), (7, 3), (5.5, 3.2), (5.5, 1.4), (1.2, 1), (1, 3.4), (0, 3)],
}


def flat_strip(name: str, seed: int) -> tuple[Array, ...]:
    """Return sides of a strip as chains of points, (65, 2) each, its corners moved a little."""
    random = np.random.default_rng(seed)
    corners = np.array(STRIPS[name], float)
    corners += random.normal(scale=0.06, size=corners.shape)
    share = np.linspace(0.0, 1.0, 65)[:, None]
    made = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side = np.array((one[1] - two[1], two[0] - one[0]))
        made.append(
            one + share * (two - one) + random.normal(scale=0.02) * np.sin(np.pi * share) * side
        )
    return tuple(made)


def rolled(chains: tuple[Array, ...], radius: float) -> tuple[Net, Loop]:
    """Return a flat strip rolled on a cylinder about the second axis, as a network."""
    rows = []
    for chain in chains:
        turn = (chain[:, 0] - 2.5) / radius
        places = (radius * np.sin(turn), chain[:, 1], radius * np.cos(turn) - radius)
        rows.append(fitted(np.column_stack(places), 13))
    return net_of_splines(rows)


def flat_area(chains: tuple[Array, ...]) -> float:
    """Return the area within a flat strip."""
    x, y = np.concatenate([chain[:-1] for chain in chains]).T
    return 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
