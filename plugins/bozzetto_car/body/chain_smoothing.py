"""Smooth chains of edges: one direction at each junction, least bending, shorter tangents.

Where smooth chains cross an edge at both of its ends, the surfaces beside it can be smooth, too,
if tangents have the right lengths (`lock_ratios`).

All functions here change only tangents: nodes stay where marks or a person have put them. Kara &
Shimada (2008) give both tangents at a junction the mean of their directions, weighted by their
lengths, and keep these lengths.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import lru_cache
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.geometry.patches import locked
from bozzetto_car.template.model import Chain, Template
from bozzetto_car.template.network import (
    HANDLE,
    KNOWN,
    EdgeJunction,
    Network,
    as_hermite,
    junctions,
    with_tangents,
)

PARALLEL: Final = 1e-12
"""Sine of the angle below which two tangents have the same direction. They stay as they are then,
so that smoothing a second time changes no bit."""

CUSP: Final = 1e-9
"""Length of the sum of two tangents, per length of both, below which they point against each
other and have no mean. The longer one then gives the direction."""

LONGEST_HANDLE: Final = 1.0 / 3.0
"""Longest handle that `shorten_tangents` leaves, per chord of the edge. With a third at both ends
an edge has an even speed along its chord; the handles cannot pass each other, so it has no loop
and at most one inflection."""

ROUNDING: Final = 1e-12
"""Excess, as a share, that counts as rounding: reducing a second time changes no bit."""


def smooth_chains(
    network: Network, *, leading: Collection[int] = (), nodes: Collection[int] | None = None
) -> Network:
    """Give the chains one tangent direction at every junction, and keep the lengths of tangents.

    The direction is the mean of both, weighted by their lengths, which is that of their sum.
    Where just one of the edges leads, for example because a person has just drawn it, the other
    takes its direction. Where a chain crosses the plane of symmetry, its direction is across
    the car. Idempotent to the last bit.

    Parameters
    ----------
    network : Network
        The network to smooth.
    leading : collection of int
        Edges that lead; their mirror images lead, too.
    nodes : collection of int, optional
        Smooth only the junctions at these nodes and their mirror images.
    """
    template = network.template
    image = template.mirrored_edges
    leaders = {edge for own in leading for edge in (own, max(image[own], ~image[own]))}
    wanted = None if nodes is None else {*nodes, *template.mirrored[list(nodes)].tolist()}
    left = set(template.pairs[:, 1].tolist())
    changed = {}
    for joint in junctions(template):
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
    network: Network, joint: EdgeJunction, before: Array, after: Array, lead: tuple[bool, bool]
) -> Array:
    """Return the unit vector along the chain at a junction; 0 where no tangent has a length."""
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


def lock_ratios(network: Network, firmness: ArrayLike | None = None) -> Network:
    """Set the lengths of tangents so that surfaces are smooth; see `crease.locked`.

    Directions stay; lengths that are right already stay to the last bit.

    Parameters
    ----------
    network : Network
        A network whose chains have one direction at each junction.
    firmness : (m,) array_like, optional
        The weight of a change of each edge, equal for mirror images.
    """
    template = network.template
    old = network.control_points
    points = locked(old, template.sides, smooth_joints(template), firmness)
    changed = (points[:, 1:3] != old[:, 1:3]).any(axis=2)
    tangents = np.where(changed[..., None], as_hermite(points)[1], network.tangents)
    return Network(template, network.positions, tangents) if changed.any() else network


@lru_cache(maxsize=KNOWN)
def smooth_joints(template: Template) -> tuple[tuple[int, int], ...]:
    """Return the smooth joints of a template in the notation of `crease`."""
    return tuple((_leaving(*one.before), _leaving(*one.after)) for one in junctions(template))


def _leaving(edge: int, end: int) -> int:
    """Return the end of an edge in the notation of `crease`: the edge as it leaves the node."""
    return ~edge if end else edge


def shorten_tangents(network: Network, edges: Collection[int] | None = None) -> Network:
    """Shorten tangents whose handles are longer than a third of the chord.

    Long tangents make an edge overshoot and turn back in a wiggle or a loop. Directions stay as
    they are, so chains stay smooth.

    Parameters
    ----------
    network : Network
        The network to change.
    edges : collection of int, optional
        The edges to change; all by default. Mirror images follow.
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


def anneal(
    network: Network, chains: Collection[str] | None = None, character: float = 0.0
) -> Network:
    """Give chains the least bending through their nodes, which stay where they are.

    Between nodes at which a chain is not smooth it becomes the natural cubic spline: of all
    tangents those with the least integral of squared second derivatives (Holladay 1957). An
    edge that is smooth at neither end is left alone. The lengths of the spline's parameter are in
    the ratios of the template's tangents, and not in those of the chords: surfaces are smooth
    across an edge only if the chains that cross it at both of its ends agree in them.

    Parameters
    ----------
    network : Network
        The network to change.
    chains : collection of str, optional
        Names of chains; all by default. Mirror images follow.
    character : float
        From 0 to 1: the share of the second derivatives of the given edges from which bending is
        measured. With 0 straight edges are the best ones, with 1 the given ones.
    """
    changed: dict[tuple[int, int], Array] = {}
    for chain, first, last in smooth_parts(network.template):
        if chains is None or chain.name in chains:
            changed |= _bent_least(network, chain, first, last, character)
    return with_tangents(network, changed)


def with_one_curvature(network: Network, edges: Collection[int]) -> Network:
    """Return a network in which the smooth lines along some edges have no jumps of curvature (G2).

    Each becomes the natural spline through its nodes, as in `anneal`, from one end of its smooth
    part to the other. Nodes stay, and so does what the line is not smooth with.

    Parameters
    ----------
    network : Network
        The network to change.
    edges : collection of int
        An edge or more of each line, of either half.
    """
    changed: dict[tuple[int, int], Array] = {}
    for chain, first, last in smooth_parts(network.template):
        if own_edges(network.template, chain.edges[first:last]).intersection(
            own_edges(network.template, edges)
        ):
            changed |= _bent_least(network, chain, first, last)
    return with_tangents(network, changed)


def own_edges(template: Template, edges: Collection[int]) -> set[int]:
    """Return edges of the right half or the middle: those given, or their mirror images."""
    image = template.mirrored_edges
    plain = [max(edge, ~edge) for edge in edges]
    return {min(edge, int(max(image[edge], ~image[edge]))) for edge in plain}


def _bent_least(
    network: Network, chain: Chain, first: int, last: int, character: float = 0.0
) -> dict[tuple[int, int], Array]:
    """Return the tangents of a smooth part of a chain with the least bending."""
    changed = {}
    nodes, edges = chain.nodes[first : last + 1], chain.edges[first:last]
    steps = _parameter_lengths(network, nodes, edges)
    places = network.positions[list(nodes)]
    straight = (np.diff(places, axis=0) / steps[:, None])[:, None]
    given = np.array([_along(network, edge) for edge in edges]) / steps[:, None, None]
    speeds = _least_bending(straight + character * (given - straight), steps)
    for at, (edge, step) in enumerate(zip(edges, steps, strict=True)):
        begin, finish = step * speeds[at], step * speeds[at + 1]
        if edge >= 0:
            changed[edge, 0], changed[edge, 1] = begin, finish
        else:
            changed[~edge, 0], changed[~edge, 1] = -finish, -begin
    return changed


def _along(network: Network, edge: int) -> Array:
    """Return both tangents of an edge in the sense in which its chain runs, (2, 3)."""
    return network.tangents[edge] if edge >= 0 else -network.tangents[~edge, ::-1]


def smooth_parts(template: Template) -> Iterator[tuple[Chain, int, int]]:
    """Yield chains, but for the left side, with the first and last node of each smooth part."""
    left = set(template.pairs[:, 1].tolist())
    for chain in template.chains:
        if not left.issuperset(chain.nodes):
            for first, last in _smooth_parts(chain):
                yield chain, first, last


def _smooth_parts(chain: Chain) -> Iterator[tuple[int, int]]:
    """Yield the first and last index, in a chain's nodes, of the parts that are smooth within."""
    breaks = [at for at, node in enumerate(chain.nodes) if node not in chain.smooth]
    for first, last in pairwise(breaks):
        if last - first > 1:
            yield first, last


def _parameter_lengths(network: Network, nodes: tuple[int, ...], edges: tuple[int, ...]) -> Array:
    """Return the parameter lengths of edges in a row; they add up to the polygon of the nodes."""
    template = network.template
    lengths = [1.0]
    for before, after in pairwise(edges):
        arriving = template.tangents[before, 1] if before >= 0 else template.tangents[~before, 0]
        leaving = template.tangents[after, 0] if after >= 0 else template.tangents[~after, 1]
        lengths.append(lengths[-1] * float(np.linalg.norm(leaving) / np.linalg.norm(arriving)))
    polygon = np.linalg.norm(np.diff(network.positions[list(nodes)], axis=0), axis=1).sum()
    return np.asarray(np.array(lengths) * (polygon / sum(lengths)))


def _least_bending(wanted: Array, steps: Array) -> Array:
    """Return the derivatives of the cubic spline whose second ones differ least from given ones.

    Parameters
    ----------
    wanted : (k - 1, 2, 3) float
        Derivatives at both ends of each piece, which has the same ends. Those of a straight piece
        give the natural cubic spline.
    steps : (k - 1,) float
        Lengths of the parameter.

    Returns
    -------
    (k, 3) float
        The derivatives at the knots.
    """
    count = len(steps) + 1
    matrix, right = np.zeros((count, count)), np.zeros((count, 3))
    for at, step in enumerate(steps):  # both ends of a piece: what its bending adds
        for own, other in ((0, 1), (1, 0)):
            matrix[at + own, at + own] += 2.0 / step
            matrix[at + own, at + other] += 1.0 / step
            right[at + own] += (2.0 * wanted[at, own] + wanted[at, other]) / step
    return np.asarray(np.linalg.solve(matrix, right))
