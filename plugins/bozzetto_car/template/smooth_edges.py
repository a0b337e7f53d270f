"""Where the surface of a car is smooth without being told: over edges that smooth chains cross."""

from __future__ import annotations

from bozzetto_car.template.model import Template
from bozzetto_car.template.network import junctions


def smooth_by_chains(template: Template) -> frozenset[int]:
    """Return the inner edges that smooth chains cross in both ends."""
    joints = {
        frozenset((_leaving(*joint.before), _leaving(*joint.after)))
        for joint in junctions(template)
    }
    # The ends that leave the start and the end of each side within its patch.
    beside = {
        side: (frozenset((~patch.edges[at - 1],)), frozenset((patch.edges[(at + 1) % 4],)))
        for patch in template.patches
        for at, side in enumerate(patch.edges)
    }
    return frozenset(
        side
        for side, (start, end) in beside.items()
        if side >= 0
        and ~side in beside
        and {start | beside[~side][1], end | beside[~side][0]} <= joints
    )


def _leaving(edge: int, end: int) -> int:
    """Return an edge as it leaves a node: ``e`` from its start, ``~e`` from its end."""
    return ~edge if end else edge
