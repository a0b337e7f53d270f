"""The default shape of a body: side panels and the corners of nose and tail bulge.

Marks give the places of nodes, but not how far the metal bulges between them. Kara & Shimada (2008)
therefore give side panels and corners a default curvature after the deformation. Which edges
these are is read off the template's patches, so that other templates have them, too: they are the
*posts*, the edges that rise from the rim of the body, between two patches that face sideways (a
panel) or one that does and one that faces forward or backward (a corner).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import HANDLE, Network, with_tangents

PANEL: Final = 30.0
"""How far the middle of a post between two side panels stands out from its chord, mm."""

CORNER: Final = 60.0
"""How far the middle of a post in a corner of the nose or the tail stands out, mm."""

SIDEWAYS: Final = 0.7
"""Least share of y in the normal of a patch that faces sideways: 45 degrees."""

MIDDLE: Final = 3.0 / 8.0
"""Movement of the middle of a cubic per movement of one of its inner Bézier points."""

ROUNDING: Final = 1e-9
"""Missing bulge, mm, that counts as none."""


def pull_out_panels(network: Network, panel: float = PANEL, corner: float = CORNER) -> Network:
    """Move posts outward that stand out less than their default measure; nodes stay.

    Both handles of a post move by the same way: outward along the mean normal of the two
    patches beside it, as far as that is across the post. Posts that stand out farther already
    are left alone, so doing it again changes nothing.

    Parameters
    ----------
    network : Network
        The network to change.
    panel, corner : float
        How far the middles of posts stand out from their chords, mm.
    """
    changed = {}
    for edge, normals in posts(network):
        wanted = panel if (np.abs(normals[:, 1]) > SIDEWAYS).all() else corner
        start, end = network.ends[edge]
        mean = normals.sum(axis=0)
        outward = cross_product(cross_product(end - start, mean), end - start)
        size = float(np.linalg.norm(outward))
        if not size > 0.0:  # both nodes in one place, or the post points outward
            continue
        outward /= size
        handles = network.control_points[edge, 1:3]
        bulge = MIDDLE * float(((handles - start) @ outward).sum())
        if bulge < wanted - ROUNDING:
            way = (wanted - bulge) / (2.0 * MIDDLE * HANDLE) * outward
            changed[edge, 0] = network.tangents[edge, 0] + way
            changed[edge, 1] = network.tangents[edge, 1] - way
    return with_tangents(network, changed)


def posts(network: Network) -> Iterator[tuple[int, Array]]:
    """Yield the posts of the right side, each with the unit normals (2, 3) of its two patches.

    Parameters
    ----------
    network : Network
        Its nodes tell the normals; edges count as straight.
    """
    template = network.template
    beside = _beside(template)
    rim = {
        int(node)
        for edge, patches in beside.items()
        if len(patches) == 1
        for node in template.edges[edge]
    }
    right = set(template.pairs[:, 0].tolist())
    for edge, patches in beside.items():
        nodes = template.edges[edge].tolist()
        if len(patches) != 2 or not right.issuperset(nodes):
            continue
        if len(rim.intersection(nodes)) != 1:
            continue
        corners = network.positions[[template.patches[patch].nodes for patch in patches]]
        across = cross_product(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        sizes = np.linalg.norm(across, axis=1, keepdims=True)
        if sizes.min() > 0.0:
            normals = across / sizes
            if (np.abs(normals[:, 1]) > SIDEWAYS).any():
                yield edge, normals


def _beside(template: Template) -> dict[int, list[int]]:
    """Return the patches at each edge."""
    found: dict[int, list[int]] = {}
    for number, patch in enumerate(template.patches):
        for edge in patch.edges:
            found.setdefault(max(edge, ~edge), []).append(number)
    return found
