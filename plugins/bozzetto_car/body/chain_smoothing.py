"""Chains of edges made smooth: one direction at each joint, least bending, shorter tangents.

Where smooth chains cross an edge at both of its ends the surfaces beside it can be smooth, too,
if tangents have the lengths for it (`ratio_locked`).

All functions here change tangents and nothing else: nodes stay where marks or a person have put
them. Kara & Shimada (2008) let both tangents at a joint take the mean of their directions,
weighted by their lengths, and keep these lengths.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.geometry.patches.crease import locked
from bozzetto_car.array_types import Array
from bozzetto_car.template.model import Chain
from bozzetto_car.template.network import HANDLE, Joint, Network, as_hermite, joints, with_tangents

PARALLEL: Final = 1e-12
"""Sine of the angle below which two tangents have one direction already: they stay as they are,
so that smoothing a second time changes no bit."""

CUSP: Final = 1e-9
"""Length of the sum of two tangents, per length of both, below which they point against each
other and have no mean. The longer one tells the direction then."""

LONGEST_HANDLE: Final = 1.0 / 3.0
"""Longest handle that `reduced` leaves, per chord of the edge. With a third at both ends an edge
runs through its chord at an even pace; the handles cannot pass each other, so it has no loop and
no more than one inflection."""

ROUNDING: Final = 1e-12
"""Excess, as a share, that counts as rounding: reducing a second time changes no bit."""


def smoothed(
    network: Network, *, leading: Collection[int] = (), nodes: Collection[int] | None = None
) -> Network:
    """One tangent direction at every joint of the chains, with the lengths of tangents kept.

    The direction is the mean of both, weighted by their lengths, which is that of their sum.
    Where just one of the edges leads, as one does that a person has drawn a moment ago, the
    other follows it. Where a chain goes over to the other side its direction is across the
    car. Idempotent to the last bit.

    Parameters
    ----------
    network : Network
    leading : collection of int
        Edges; their mirror images lead, too.
    nodes : collection of int, optional
        Only the joints there, and their mirror images.
    """
    template = network.template
    image = template.mirrored_edges
    leaders = {edge for own in leading for edge in (own, max(image[own], ~image[own]))}
    wanted = None if nodes is None else {*nodes, *template.mirrored[list(nodes)].tolist()}
    left = set(template.pairs[:, 1].tolist())
    changed = {}
    for joint in joints(template):
        if joint.node in left or not (wanted is None or joint.node in wanted):
            continue
        own = [
            sense * network.tangents[place]
            for sense, place in zip(joint.senses, (joint.before, joint.after), strict=True)
        ]
        lead = [place[0] in leaders for place in (joint.before, joint.after)]
        direction = _direction(network, joint, own[0], own[1], (lead[0], lead[1]))
        for place, sense, tangent in zip(
            (joint.before, joint.after), joint.senses, own, strict=True
        ):
            length = float(np.linalg.norm(tangent))
            off = tangent - (tangent @ direction) * direction
            if np.linalg.norm(off) > PARALLEL * length or tangent @ direction < 0.0:
                changed[place] = sense * length * direction
    return with_tangents(network, changed) if changed else network


def _direction(
    network: Network, joint: Joint, before: Array, after: Array, lead: tuple[bool, bool]
) -> Array:
    """The unit vector along the chain at a joint; 0 where no tangent has a length."""
    if joint.crosses:
        back, ahead = network.positions[list(joint.neighbours)]
        return np.array([0.0, np.sign(ahead[1] - back[1]), 0.0])
    lengths = np.linalg.norm(before), np.linalg.norm(after)
    mean = before + after
    if lead[0] != lead[1] and lengths[lead.index(True)] > 0.0:
        mean = (before, after)[lead.index(True)]
    elif np.linalg.norm(mean) <= CUSP * sum(lengths):
        mean = before if lengths[0] >= lengths[1] else after
    length = np.linalg.norm(mean)
    return np.asarray(mean / length if length > 0.0 else mean)


def ratio_locked(network: Network, firmness: ArrayLike | None = None) -> Network:
    """Tangents as long as they must be for surfaces to be smooth; see `crease.locked`.

    Directions stay, and so does to the last bit what is right already.

    Parameters
    ----------
    network : Network
        Its chains have one direction at each joint.
    firmness : (m,) array_like, optional
        The weight of a change of each edge, the same for mirror images.
    """
    template = network.template
    row = tuple((_leaving(*j.before), _leaving(*j.after)) for j in joints(template))
    old = network.control_points
    points = locked(old, template.sides, row, firmness)
    changed = (points[:, 1:3] != old[:, 1:3]).any(axis=2)
    tangents = np.where(changed[..., None], as_hermite(points)[1], network.tangents)
    return Network(template, network.positions, tangents) if changed.any() else network


def _leaving(edge: int, end: int) -> int:
    """An end of an edge as `crease` calls it: the edge as it leaves the node."""
    return ~edge if end else edge


def reduced(network: Network, edges: Collection[int] | None = None) -> Network:
    """Tangents shortened where their handles are longer than a third of the chord.

    Long tangents make an edge run ahead and come back, a wiggle or a loop. Directions stay as
    they are, so chains stay smooth.

    Parameters
    ----------
    network : Network
    edges : collection of int, optional
        By default all. Mirror images follow.
    """
    changed = {}
    for edge in range(len(network.tangents)) if edges is None else edges:
        start, end = network.ends[edge]
        longest = float(np.linalg.norm(end - start)) * LONGEST_HANDLE / HANDLE
        for side in (0, 1):
            length = float(np.linalg.norm(network.tangents[edge, side]))
            if length > longest * (1.0 + ROUNDING):
                changed[edge, side] = network.tangents[edge, side] * (longest / length)
    return with_tangents(network, changed)


def annealed(network: Network, chains: Collection[str] | None = None) -> Network:
    """Chains with the least bending through their nodes, which stay where they are.

    Between nodes at which a chain is not smooth it becomes the natural cubic spline: of all
    tangents those with the least integral of squared second derivatives (Holladay 1957). An
    edge that is smooth at neither end is left alone. The lengths of the spline's parameter are in
    the ratios of the template's tangents, and not in those of the chords: surfaces are smooth
    across an edge only if the chains that cross it at both of its ends agree in them.

    Parameters
    ----------
    network : Network
    chains : collection of str, optional
        Names of chains; by default all. Mirror images follow.
    """
    template = network.template
    left = set(template.pairs[:, 1].tolist())
    changed = {}
    for chain in template.chains:
        if (chains is not None and chain.name not in chains) or left.issuperset(chain.nodes):
            continue
        for first, last in _smooth_parts(chain):
            nodes, edges = chain.nodes[first : last + 1], chain.edges[first:last]
            steps = _parameter_lengths(network, nodes, edges)
            speeds = _natural_speeds(network.positions[list(nodes)], steps)
            for at, (edge, step) in enumerate(zip(edges, steps, strict=True)):
                begin, finish = step * speeds[at], step * speeds[at + 1]
                if edge >= 0:
                    changed[edge, 0], changed[edge, 1] = begin, finish
                else:
                    changed[~edge, 0], changed[~edge, 1] = -finish, -begin
    return with_tangents(network, changed)


def _smooth_parts(chain: Chain) -> Iterator[tuple[int, int]]:
    """First and last place, in a chain's nodes, of the parts that are smooth within."""
    breaks = [at for at, node in enumerate(chain.nodes) if node not in chain.smooth]
    for first, last in pairwise(breaks):
        if last - first > 1:
            yield first, last


def _parameter_lengths(network: Network, nodes: tuple[int, ...], edges: tuple[int, ...]) -> Array:
    """Lengths of the parameter of edges in a row, in all as long as the polygon of the nodes."""
    template = network.template
    lengths = [1.0]
    for before, after in pairwise(edges):
        arriving = template.tangents[before, 1] if before >= 0 else template.tangents[~before, 0]
        leaving = template.tangents[after, 0] if after >= 0 else template.tangents[~after, 1]
        lengths.append(lengths[-1] * float(np.linalg.norm(leaving) / np.linalg.norm(arriving)))
    polygon = np.linalg.norm(np.diff(network.positions[list(nodes)], axis=0), axis=1).sum()
    return np.asarray(np.array(lengths) * (polygon / sum(lengths)))


def _natural_speeds(places: Array, steps: Array) -> Array:
    """Derivatives, at its knots, of the natural cubic spline through places, (k, 3)."""
    count = len(places)
    matrix, right = np.zeros((count, count)), np.zeros((count, 3))
    for at, step in enumerate(steps):  # both ends of a piece: what its bending adds
        rise = 3.0 * (places[at + 1] - places[at]) / step**2
        for own, other in ((at, at + 1), (at + 1, at)):
            matrix[own, own] += 2.0 / step
            matrix[own, other] += 1.0 / step
            right[own] += rise
    return np.asarray(np.linalg.solve(matrix, right))
