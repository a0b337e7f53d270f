"""The network of a car that is being shaped: its template's edges at places of its own.

An edge is a cubic in one of two equivalent forms: two ends with the derivatives there (Hermite's
form), or four Bézier points, whose inner ones, the *handles*, lie a third of a tangent from the
ends. A `Network` keeps the first form, in which nodes move independently of tangents;
`Network.control_points` is the second.

Symmetry is kept wherever tangents change: `with_tangents` lets the mirror image follow bit for
bit, holds edges of the middle in their plane, and those that cross it at a right angle to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry import frozen
from bozzetto.plugin import cached_property
from bozzetto_car.template.model import MIRROR, Template

HANDLE: Final = 1.0 / 3.0
"""Length of a handle, the end leg of a cubic's Bézier polygon, per length of the tangent."""

KNOWN: Final = 16
"""Number of templates whose junctions are remembered."""


def as_bezier(ends: ArrayLike, tangents: ArrayLike) -> Array:
    """Return the four Bézier points of cubics from their ends and the derivatives there.

    Parameters
    ----------
    ends, tangents : (…, 2, 3) array_like
        Ends of the cubics and the derivatives there, mm.

    Returns
    -------
    (…, 4, 3) float
        The first and the last point are the ends, bit for bit.
    """
    places, slopes = np.asarray(ends, float), np.asarray(tangents, float)
    first = places[..., 0, :] + slopes[..., 0, :] * HANDLE
    last = places[..., 1, :] - slopes[..., 1, :] * HANDLE
    return np.stack((places[..., 0, :], first, last, places[..., 1, :]), axis=-2)


def as_hermite(control_points: ArrayLike) -> tuple[Array, Array]:
    """Return the ends of cubics and the derivatives there from four Bézier points.

    Parameters
    ----------
    control_points : (…, 4, 3) array_like
        Bézier points, mm.

    Returns
    -------
    ends, tangents : (…, 2, 3) float
    """
    points = np.asarray(control_points, float)
    legs = points[..., [1, 3], :] - points[..., [0, 2], :]
    return points[..., [0, 3], :], legs / HANDLE


@dataclass(frozen=True, eq=False)
class Network:
    """The nodes and edges of a car; names and everything else are its template's.

    Parameters
    ----------
    template : Template
    positions : (n, 3) float
        Places of the nodes, mm.
    tangents : (m, 2, 3) float
        Derivatives of each edge by its parameter 0 … 1 at its start and at its end, mm.

    Raises
    ------
    ValueError
        If the arrays do not fit the template, or are not finite.
    """

    template: Template
    positions: Array
    tangents: Array

    def __post_init__(self) -> None:
        for name in ("positions", "tangents"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.float64))
            if getattr(self, name).shape != getattr(self.template, name).shape:
                raise ValueError(f"a network's {name} must be those of its template in number")

    @classmethod
    def of(cls, template: Template, positions: ArrayLike | None = None) -> Self:
        """Return the edges of a template, with its tangents, through nodes that may have moved."""
        places = template.positions if positions is None else np.asarray(positions, float)
        return cls(template, places, template.tangents)

    @cached_property
    def ends(self) -> Array:
        """The start and end of each edge, (m, 2, 3) mm."""
        return np.asarray(self.positions[self.template.edges])

    @cached_property
    def control_points(self) -> Array:
        """The edges as cubic Bézier curves, (m, 4, 3) mm."""
        return as_bezier(self.ends, self.tangents)

    @property
    def free_axes(self) -> Flags:
        """Which coordinates the tangents of a symmetric car may have, (m, 2, 3).

        An edge in the middle has no y; an edge that crosses the middle smoothly has only y there.
        """
        return _free_axes(self.template)


@dataclass(frozen=True)
class EdgeJunction:
    """A node at which a chain is smooth, with the ends of the two edges that meet there.

    Attributes
    ----------
    node : int
    before, after : (edge, end)
        The edges in the order of the chain; end is 0 for the start of an edge, 1 for its end.
    senses : (int, int)
        1 where an edge runs along with the chain, -1 where it runs against it.
    crosses : bool
        Whether the chain crosses the middle here: each edge is the other's mirror image.
    neighbours : (int, int)
        The chain's nodes before and after this one.
    """

    node: int
    before: tuple[int, int]
    after: tuple[int, int]
    senses: tuple[int, int]
    crosses: bool
    neighbours: tuple[int, int]


@lru_cache(maxsize=KNOWN)
def _free_axes(template: Template) -> Flags:
    free = np.ones(template.tangents.shape, bool)
    free[np.isin(template.edges, template.centre).all(axis=1), :, 1] = False
    for joint in junctions(template):
        if joint.crosses:
            for edge, end in (joint.before, joint.after):
                free[edge, end] = (False, True, False)
    free.flags.writeable = False
    return free


@lru_cache(maxsize=KNOWN)
def junctions(template: Template) -> tuple[EdgeJunction, ...]:
    """Return all smooth nodes of all chains."""
    return tuple(_junctions(template))


def _junctions(template: Template) -> Iterator[EdgeJunction]:
    image = template.mirrored_edges
    for chain in template.chains:
        for node in chain.smooth:
            at = chain.nodes.index(node)
            before, after = chain.edges[at - 1], chain.edges[at]
            one, other = max(before, ~before), max(after, ~after)
            yield EdgeJunction(
                node,
                (one, 1 if before >= 0 else 0),
                (other, 0 if after >= 0 else 1),
                (1 if before >= 0 else -1, 1 if after >= 0 else -1),
                one != other and int(image[one]) in (other, ~other),
                (chain.nodes[at - 1], chain.nodes[at + 1]),
            )


# -- names -----------------------------------------------------------------------------------------


def edge_called(template: Template, name: str) -> int:
    """Return the index of an edge by its ends in either order, ``C1-S1.R`` or ``S1.R-C1``.

    Raises
    ------
    UserError
        If there is none.
    """
    start, _, end = name.partition("-")
    found = template.edge_between.get((template.node.get(start, -1), template.node.get(end, -1)))
    if found is None:
        raise UserError(
            f"The {template.noun} has no edge “{name[:40]}”. Name the nodes at both of "
            f"its ends, as in {template.edge_names[0]}."
        )
    return max(found, ~found)


def node_called(template: Template, name: str) -> int:
    """Return the index of a node by its name.

    Raises
    ------
    UserError
        If there is none.
    """
    if name not in template.node:
        raise UserError(
            f"The {template.noun} has no node “{name[:40]}”. Take one of its names, "
            f"such as {template.names[0]}."
        )
    return template.node[name]


# -- change that keeps the symmetry ----------------------------------------------------------------


def with_tangents(network: Network, tangents: Mapping[tuple[int, int], ArrayLike]) -> Network:
    """Return a network with other tangents at some ends of edges and at their mirror images.

    Parameters
    ----------
    network : Network
        The network to change.
    tangents : mapping of (edge, end) to (3,) array_like
        Tangents, mm; end 0 is the start of an edge, 1 its end. Coordinates that
        `Network.free_axes` does not allow become 0. Of an end and its mirror image the later
        one counts.
    """
    image, free = network.template.mirrored_edges, network.free_axes
    made = np.array(network.tangents)
    for (edge, end), tangent in tangents.items():
        own = np.where(free[edge, end], np.asarray(tangent, float), 0.0)
        made[edge, end] = own
        twin = int(image[edge])
        if twin >= 0 and twin != edge:
            made[twin, end] = own * MIRROR
        elif twin < 0:
            made[~twin, 1 - end] = -own * MIRROR
    return Network(network.template, network.positions, made)


def with_positions(network: Network, positions: Mapping[int, ArrayLike]) -> Network:
    """Return a network with some nodes and their mirror images elsewhere, and the same tangents.

    Parameters
    ----------
    network : Network
        The network to change.
    positions : mapping of int to (3,) array_like
        By node, mm. Nodes in the middle stay there. Of a node and its mirror image the later
        one counts.
    """
    image = network.template.mirrored
    made = np.array(network.positions)
    for node, place in positions.items():
        at = np.asarray(place, float)
        made[node] = at
        made[image[node]] = at * MIRROR
        if image[node] == node:
            made[node, 1] = 0.0
    return Network(network.template, made, network.tangents)
