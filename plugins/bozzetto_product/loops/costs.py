"""How much speaks against a loop: shape, size, corners, what it would cover, whether it twists."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto_product.loops.candidates import Halves, edges_of
from bozzetto_product.loops.sampling import SAMPLES, SampledNet

STRAIGHT: Final = 0.9
"""Cosine of the angle (26°) below which two edges that follow one another are two sides."""

BLUNT: Final = 0.3
"""Sine of a corner's angle below which it defines no normal."""

SHARP: Final = 0.4
"""Sine of a corner's angle above which its normal is compared with others; wholly from twice it."""

FLAT: Final = 0.4
"""Share of directions along the normal of a node below which the ends there lie in one plane."""

CROWDED: Final = 4
"""Ends at a node from which on running straight through it leaves others on both sides."""

AGREEING: Final = 0.6
"""Signed sum of a loop's corners by their unsigned sum below which its surface would have to twist:
an L has two thirds, the halves of a tube mixed up have none."""

BESIDE: Final = 0.35
"""Radians (20°) between an end and a side of a loop above which it lies wholly inside."""

ABOVE: Final = 0.7
"""Share of a direction along the normal above which an end leaves the surface, and is not
covered."""

SHORT: Final = 0.25
"""Length of an edge, in sizes of the loop, below which covering it counts for less: the tails of
curves drawn a little too far."""

WEIGHTS: Final = {
    "any": 0.15,
    "bent": 4.8,
    "large": 0.8,
    "thin": 0.5,
    "concave": 0.8,
    "off node": 1.0,
    "straight through": 0.7,
    "turning": 2.4,
    "many sides": 0.3,
    "reversed": 2.0,
    "twisted": 2.0,
    "covering": 0.75,
}
"""Prices of what speaks against a loop. Set by hand, then each halved or raised by 60 % as long as
that helped, on drawn networks, the teapot, and random ones of seeds below 1000 with faults."""

OF_SHAPE: Final = ("thin", "concave", "twisted", "many sides")
"""What speaks against no outline in a plane, where there is no other surface that it could be."""


@dataclass(frozen=True, eq=False)
class LoopCosts:
    """Cost of each loop, and the number of its sides.

    Parameters
    ----------
    costs : (k,) float
    sides : (k,) float
        Corners, and one more for each quarter turn between them: a circle has four.
    corners : (k,) int
    """

    costs: Array
    sides: Array
    corners: Index


@dataclass(frozen=True, eq=False)
class _Steps:
    """All half-edges of all loops in one row, N of them.

    Parameters
    ----------
    halves, following : (N,) int
        Each half-edge, and the next one of its loop.
    loop : (N,) int
        Number of the loop.
    starts : (k,) int
        Where each loop begins in the row.
    """

    halves: Index
    following: Index
    loop: Index
    starts: Index

    @classmethod
    def of(cls, loops: Sequence[Halves]) -> _Steps:
        counts = np.array([len(loop) for loop in loops])
        starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
        halves = np.array([half for loop in loops for half in loop])
        following = np.roll(halves, -1)
        following[starts + counts - 1] = halves[starts]
        return cls(halves, following, np.repeat(np.arange(len(loops)), counts), starts)

    def sums(self, values: Array) -> Array:
        """Return the sum over each loop of values, (N, …)."""
        return np.asarray(np.add.reduceat(values, self.starts, axis=0))


def loop_costs(
    sampled: SampledNet, loops: Sequence[Halves], outlines: Collection[frozenset[int]] = ()
) -> LoopCosts:
    """Rate loops.

    Parameters
    ----------
    sampled : SampledNet
        The net.
    loops : sequence of tuple of int
        Half-edges, head to tail.
    outlines : collection of frozenset of int
        The edges of plane outlines: these may have any shape (`plane_outlines`).
    """
    if not loops:
        return LoopCosts(np.zeros(0), np.zeros(0), np.zeros(0, int))
    steps = _Steps.of(loops)
    shape, area, size = _shapes(sampled, steps)
    corners = _corners(sampled, steps, area, size)
    count = corners.pop("count")
    smooth = np.maximum(0.0, 2.0 * np.pi - corners.pop("cornering"))
    sides = count + smooth / (0.5 * np.pi)
    amounts = {
        "any": np.ones(len(loops)),
        **shape,
        **corners,
        "many sides": np.maximum(0.0, sides - 4.0),
    }
    if outlines:
        shaped = np.array([edges_of(loop) not in outlines for loop in loops])
        for name in OF_SHAPE:
            amounts[name] = amounts[name] * shaped
    costs = sum((WEIGHTS[name] * amount for name, amount in amounts.items()), np.zeros(len(loops)))
    return LoopCosts(np.asarray(costs), sides, count.astype(int))


def _shapes(sampled: SampledNet, steps: _Steps) -> tuple[dict[str, Array], Array, Array]:
    """Return how bent, large and thin loops are, the vectors of their areas, and their sizes."""
    lines = sampled.lines[steps.halves // 2]
    lines = np.where((steps.halves % 2 == 1)[:, None, None], lines[:, ::-1], lines)
    count = steps.sums(np.full(len(lines), SAMPLES - 1.0))
    centre = steps.sums(lines[:, :-1].sum(axis=1)) / count[:, None]
    lines = lines - centre[steps.loop][:, None]
    points = lines[:, :-1]
    moments = steps.sums(np.einsum("kpi,kpj->kij", points, points)) / count[:, None, None]
    thickness = np.sqrt(np.maximum(0.0, np.linalg.eigvalsh(moments)[:, 0]))
    high = np.maximum.reduceat(points.max(axis=1), steps.starts)
    low = np.minimum.reduceat(points.min(axis=1), steps.starts)
    size = np.maximum(np.linalg.norm(high - low, axis=1), 1e-300)
    area = steps.sums(0.5 * cross_product(points, lines[:, 1:]).sum(axis=1))
    perimeter = np.maximum(steps.sums(sampled.lengths[steps.halves // 2]), 1e-300)
    compact = 4.0 * np.pi * np.linalg.norm(area, axis=1) / perimeter**2
    amounts = {
        "bent": thickness / size,
        "large": size / max(sampled.size, 1e-300),
        "thin": 1.0 - compact,
    }
    return amounts, area, size


def _corners(sampled: SampledNet, steps: _Steps, area: Array, size: Array) -> dict[str, Array]:
    """Return what the corners of loops, each at the head of its half-edge, amount to."""
    halves, following = steps.halves, steps.following
    nodes = sampled.heads[halves]
    met = nodes >= 0
    arriving, leaving = -sampled.leaving[halves ^ 1], sampled.leaving[following]
    cosine = np.where(met, (arriving * leaving).sum(axis=1), 1.0)
    normal = np.where(met[:, None], cross_product(arriving, leaving), 0.0)
    sine = np.linalg.norm(normal, axis=1)
    angle = np.arctan2(sine, cosine)
    degree = np.where(met, sampled.degrees[nodes], 2)
    up, broken = _surface_normals(sampled, steps, normal, _unit(area)[steps.loop])
    turned = steps.sums(angle * np.sign((up * normal).sum(axis=1)))
    up *= np.where(turned < 0, -1.0, 1.0)[steps.loop][:, None]
    inward = -np.minimum(0.0, (up * normal).sum(axis=1))
    total = steps.sums(angle)
    torn = np.maximum(0.0, AGREEING - np.abs(turned) / np.maximum(total, 1e-300))
    side = cosine < STRAIGHT
    clear = np.clip((sine - SHARP) / SHARP, 0.0, 1.0)
    compared = clear * ((degree > 2) & (sampled.flatness[nodes] < FLAT))
    aligned = np.abs((normal * sampled.normals[nodes]).sum(axis=1)) / np.maximum(sine, 1e-300)
    return {
        "count": steps.sums(side.astype(float)),
        "cornering": steps.sums(np.where(side, angle, 0.0)),
        "concave": steps.sums(inward * (sine > SHARP)),
        "off node": steps.sums((1.0 - aligned) * compared),
        "straight through": steps.sums(((cosine > STRAIGHT) & (degree >= CROWDED)).astype(float)),
        "turning": np.maximum(0.0, np.abs(turned) / (2.0 * np.pi) - 1.0),
        "reversed": broken,
        "twisted": torn * np.minimum(1.0, total / (2.0 * np.pi)),
        "covering": steps.sums(_covered(sampled, steps, up, size[steps.loop])),
    }


def _surface_normals(
    sampled: SampledNet, steps: _Steps, normal: Array, upward: Array
) -> tuple[Array, Array]:
    """Return the normal of the surface at each corner, and how much it comes back reversed.

    It is carried along the edges; each sharp corner puts it upright on its two edges, towards the
    side where it was. It goes round twice: first from the sharpest corner, to find the corner
    where the side is least sure, then from there, so that no other corner hangs on that one.
    """
    sine = np.linalg.norm(normal, axis=1)
    sharpest = np.lexsort((-sine, steps.loop))[steps.starts] - steps.starts
    _, sure = _carried_round(sampled, steps, normal, upward, sharpest)
    doubtful = np.lexsort((np.abs(sure), steps.loop))[steps.starts] - steps.starts
    up, sure = _carried_round(sampled, steps, normal, upward, doubtful)
    return up, np.maximum(0.0, -sure[steps.starts + doubtful])


def _carried_round(
    sampled: SampledNet, steps: _Steps, normal: Array, upward: Array, first: Index
) -> tuple[Array, Array]:
    """Carry normals round all loops, each from its own first corner.

    Returns
    -------
    up : (N, 3) float
        Unit normals.
    sure : (N,) float
        Cosine between the normal that comes to a corner and the corner's own, taken positive but
        at the first corner, where it comes back; 1 where a corner has none.
    """
    counts = np.diff(np.concatenate((steps.starts, [len(normal)])))
    unit, sharp = _unit(normal), np.linalg.norm(normal, axis=1) > BLUNT
    up, sure = np.zeros_like(normal), np.ones(len(normal))
    at = steps.starts + first
    carried = np.where(sharp[at, None], unit[at], upward[at])
    for step in range(int(counts.max()) + 1):
        at = steps.starts + (first + step) % counts
        cosine = (carried * unit[at]).sum(axis=1)
        here = np.where(sharp[at, None], np.where(cosine < 0, -1, 1)[:, None] * unit[at], carried)
        leaving = sampled.leaving[steps.following[at]]
        here = _unit(here - (here * leaving).sum(axis=1, keepdims=True) * leaving)
        new, back = step < counts, (step == counts) & sharp[at]
        up[at[new]] = here[new]
        sure[at[new & sharp[at]]] = np.abs(cosine[new & sharp[at]])
        sure[at[back]] = (carried[back] * up[at[back]]).sum(axis=1)
        carried = np.einsum("kij,kj->ki", sampled.turns[steps.following[at]], here)
    return up, sure


def _covered(sampled: SampledNet, steps: _Steps, up: Array, size: Array) -> Array:
    """Return for each corner how much another edge at its node lies within the loop's surface."""
    nodes = sampled.heads[steps.halves]
    ahead = sampled.leaving[steps.following]
    back = sampled.leaving[steps.halves ^ 1]
    left = cross_product(up, ahead)
    others = sampled.ways[nodes]
    ends = sampled.leaving[others]
    opening = _angle(back[:, None], ahead, left)[:, 0]
    turn = _angle(ends, ahead, left)
    inside = np.minimum(turn, opening[:, None] - turn) / BESIDE
    above = np.abs((ends * up[:, None]).sum(axis=2)) / ABOVE
    long = sampled.lengths[others // 2] / (SHORT * size[:, None])
    share = np.clip(inside, 0.0, 1.0) * np.clip(1.5 - above * 1.5, 0.0, 1.0) * np.minimum(1.0, long)
    there: Flags = (others >= 0) & (nodes >= 0)[:, None]
    there &= (others != steps.following[:, None]) & (others != steps.halves[:, None] ^ 1)
    return np.asarray((share * there).max(axis=1, initial=0.0))


def _angle(ends: Array, ahead: Array, left: Array) -> Array:
    """Return the angles of directions (N, d, 3) about a normal, 0 … 2π from straight ahead."""
    along, across = (np.einsum("kdi,ki->kd", ends, each) for each in (ahead, left))
    return np.asarray(np.mod(np.arctan2(across, along), 2.0 * np.pi))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))
