"""Outlines in a plane that are bent inward: with a waist, and angles with arms."""

from __future__ import annotations

import itertools

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
