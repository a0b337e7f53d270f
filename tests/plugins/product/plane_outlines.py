"""Outlines in a plane that are bent inward: with a waist, and angles with arms."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from bozzetto_product.network.net import Loop, Net
from tests.plugins.product.known_surfaces import fitted, net_of_splines


def waisted(seed: int) -> tuple[Net, Loop]:
    """An outline with a waist and a notch at both ends, as of a guitar, of four to eight curves."""
    random = np.random.default_rng(seed)
    count = 2 * int(random.integers(2, 5))
    stretch, waist, lean, notch = random.uniform((1.3, 0.1, -0.15, 0.02), (2.5, 0.25, 0.15, 0.1))
    starts = np.arange(count) + random.uniform(-0.2, 0.2, count)
    starts[[0, count // 2]] = 0, count // 2
    starts = 2 * np.pi / count * np.append(starts, count)
    chains = []
    for start, end in itertools.pairwise(starts):
        turn = np.linspace(start, end, 129)
        ends = np.sign(np.cos(turn)) * np.exp(-np.abs(np.sin(turn)) / 0.3)
        x = stretch * np.cos(turn) - notch * ends
        y = np.sin(turn) * (1.0 - waist + 2.0 * waist * np.cos(turn) ** 2 + lean * np.cos(turn))
        chains.append(np.column_stack((x, y, 0.0 * turn)))
    for k, chain in enumerate(chains):
        chain[0] = chains[k - 1][-1]
    return net_of_splines([fitted(chain, 9) for chain in chains])


def angled(seed: int) -> tuple[Net, Loop]:
    """An L of six curves, each a little bent, with arms of any length and width."""
    random = np.random.default_rng(seed)
    long, high = random.uniform(1.0, 2.0, 2)
    wide, thick = random.uniform(0.3, 0.6, 2)
    corners = np.array(
        [(0, 0), (long, 0), (long, thick), (wide, thick), (wide, high), (0, high)], float
    )
    corners += random.normal(scale=0.02, size=corners.shape)
    share = np.linspace(0, 1, 65)[:, None]
    chains = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side = np.array((one[1] - two[1], two[0] - one[0]))
        bent = one + share * (two - one) + random.normal(scale=0.02) * np.sin(np.pi * share) * side
        chains.append(np.column_stack((bent, np.zeros(len(bent)))))
    return net_of_splines([fitted(chain) for chain in chains])


LETTERS = {
    "L": [(0, 0), (4, 0), (4, 1), (1, 1), (1, 5), (0, 5)],
    "C": [(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (4, 4), (4, 5), (0, 5)],
    "E": [(0, 0), (4, 0), (4, 1), (1, 1), (1, 2), (3, 2),
          (3, 3), (1, 3), (1, 4), (4, 4), (4, 5), (0, 5)],
    "S": [(0, 0), (4, 0), (4, 3), (1, 3), (1, 4), (4, 4),
          (4, 5), (0, 5), (0, 2), (3, 2), (3, 1), (0, 1)],
    "T": [(1.5, 0), (2.5, 0), (2.5, 4), (4, 4), (4, 5), (0, 5), (0, 4), (1.5, 4)],
}  # fmt: skip
"""Corners of letters, counter-clockwise."""


def star(points: int, inner: float) -> list[tuple[float, float]]:
    """Corners of a star of radius 1 and an inner radius."""
    turn = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2, 1.0, inner)
    return [
        (float(x), float(y))
        for x, y in zip(radius * np.cos(turn), radius * np.sin(turn), strict=True)
    ]


def gear(teeth: int) -> list[tuple[float, float]]:
    """Corners of a gear of radius 1, four for each tooth."""
    turn = (np.arange(teeth)[:, None] + (0.0, 0.25, 0.5, 0.75)).ravel() * 2 * np.pi / teeth
    radius = np.tile((0.8, 1.0, 1.0, 0.8), teeth)
    return [
        (float(x), float(y))
        for x, y in zip(radius * np.cos(turn), radius * np.sin(turn), strict=True)
    ]


def turned(corners: Sequence[Sequence[float]], seed: int) -> np.ndarray:
    """Corners in a plane that lies anywhere in space, (n, 3)."""
    random = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return np.asarray(corners, float) @ axes[:2] + random.normal(scale=20.0, size=3)


def trembling(corners: Sequence[Sequence[float]] | np.ndarray, seed: int) -> tuple[Net, Loop]:
    """An outline of one curve a side, each a little bent in the plane of the corners."""
    random = np.random.default_rng(seed)
    points = np.asarray(corners, float)
    if points.shape[1] == 2:
        points = np.column_stack((points, np.zeros(len(points))))
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle)[2][:2]
    flat = (points - middle) @ axes.T
    shortest = np.linalg.norm(flat - np.roll(flat, -1, axis=0), axis=1).min()
    flat = flat + random.normal(scale=0.03 * shortest, size=flat.shape)
    share = np.linspace(0, 1, 33)[:, None]
    chains = []
    for one, two in zip(flat, np.roll(flat, -1, axis=0), strict=True):
        side = np.array((one[1] - two[1], two[0] - one[0]))
        bend = random.normal(scale=0.02) * np.sin(np.pi * share) * side
        chains.append(middle + (one + share * (two - one) + bend) @ axes)
    return net_of_splines([fitted(chain) for chain in chains])
