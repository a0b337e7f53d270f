"""The patches of a network: of all that are smooth where it is, those that vary least.

Edges leave one thing open in each corner of a patch: its *twist*, the derivative by both
parameters, for which the inner control point there stands. A Coons patch has a twist of 0, and so
a flat place in every corner. Here all twists of a body are found at once, as those of the least

    ∫∫ |x_uuu|² + |x_uuv|² + |x_uvv|² + |x_vvv|² du dv

of all its patches: how much their bending varies, and not how much they bend (Moreton & Séquin
1992, "Functional optimization for fair surface design", who vary curvature itself).

Over a smooth edge the derivatives across it are as −k to 1, with one k all along
(`geometry.patches.crease`). Coons patches have that, and keep it if the inner control points on
both sides of an end of the edge move as −k to 1, too. Corners round a node that smooth edges join
so have one unknown, a *row*. Edges stay, and with them the tangent plane in every node.

Where four creases meet, as in the rear corner of a car with a tailgate, twists stay 0: nothing
ties the patches to one another there, and each alone turned its corner by up to 180 mm.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product, frozen
from bozzetto.geometry.patches import bernstein, coons_nets
from bozzetto.plugin import remembered
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import KNOWN, Network
from bozzetto_car.template.saddles import bent_one_way
from bozzetto_car.template.weak_creases import creases_between

INNER: Final = ((1, 2, 2, 1), (1, 1, 2, 2))
"""Inner control points of a net, each beside the corner in which the side of its number starts."""

CORNERS: Final = ((0, 3, 3, 0), (0, 0, 3, 3))
ALONG: Final = ((1, 3, 2, 0), (0, 1, 3, 2))
ACROSS: Final = ((0, 2, 3, 1), (1, 0, 2, 3))
"""Each corner of a net, the control point after it round the patch, and the one before it."""

Corner = tuple[int, int]
"""A patch, and the number of the side that starts in the corner."""

GAUSS: Final = np.polynomial.legendre.leggauss(4)
"""Places −1 … 1 and weights that integrate squares of cubics exactly."""

REMEMBERED: Final = 64
"""Number of networks whose patches are remembered: a body that is brought to dimensions is measured
before it is shown."""


@remembered(limit=REMEMBERED)
def fair_nets(network: Network) -> Array:
    """Return the control nets of a network's patches: of least variation, and with few saddles.

    The outer control points are those of the edges, bit for bit, and the halves are mirror images
    to the last bit.

    Parameters
    ----------
    network : Network
        A network, symmetric to the last bit.

    Returns
    -------
    (k, 4, 4, 3) float
        mm; read-only, for the very same network is not worked out twice.
    """
    rows = least_varying(network)
    ways, form = rows.along_normals()
    creases = creases_between(network.template, tuple(rows.corners.patches.tolist()))
    moved = bent_one_way(rows.nets, FLAT, ways, form, creases)
    nets = rows.nets.copy()
    nets[:, *INNER] += np.einsum("n,kcnx->kcx", moved, ways)
    return frozen(_whole(network, rows.corners, nets), np.float64)


def least_varying_nets(network: Network) -> Array:
    """Return the control nets of least variation alone, (k, 4, 4, 3) mm; see `fair_nets`."""
    rows = least_varying(network)
    return _whole(network, rows.corners, rows.nets)


@dataclass(frozen=True, eq=False)
class Rows:
    """The patches of the right half with least variation.

    Attributes
    ----------
    corners : Corners
    nets : (r, 4, 4, 3) float
        mm.
    across : (4 r, n) float
        How far each inner control point moves with its row.
    form : (n, n) float
        The variation by the rows.
    """

    corners: Corners
    nets: Array
    across: Array
    form: Array

    def along_normals(self) -> tuple[Array, Array]:
        """Return how inner control points move, one unknown a row, each along its normal.

        Returns
        -------
        ways : (r, 4, n, 3) float
            Rows beside the middle, and those without a normal, are left out.
        form : (n, n) float
            The variation by these unknowns.
        """
        normals = self.corners.normals(self.nets)
        free = np.flatnonzero(~self.corners.held & (normals != 0.0).any(axis=1))
        ways = self.across[:, free, None] * normals[free]
        form = (self.form * (normals @ normals.T))[np.ix_(free, free)]
        return ways.reshape(len(self.nets), 4, len(free), 3), form


def least_varying(network: Network) -> Rows:
    """Return the patches of the right half that vary least, and how they go on from there."""
    corners = corners_of(network.template)
    nets = coons_nets(network.control_points, network.template.sides)[corners.patches]
    across = corners.factors(network)[:, None] * corners.member
    count = across.shape[1]
    form = across.T @ (_BESIDE @ across.reshape(-1, 4, count)).reshape(-1, count)
    right = -across.T @ (_BY_NET @ nets.reshape(-1, 16, 3)).reshape(-1, 3)
    twists = np.zeros((count, 3))
    twists[:, 1] = np.linalg.solve(form, right[:, 1])
    free = np.flatnonzero(~corners.held)
    twists[free, ::2] = np.linalg.solve(form[np.ix_(free, free)], right[free, ::2])
    nets[:, *INNER] += (across @ twists).reshape(-1, 4, 3)
    return Rows(corners, nets, across, form)


def _whole(network: Network, corners: Corners, right: Array) -> Array:
    """Return the patches of both halves with the inner control points of the right one."""
    nets = coons_nets(network.control_points, network.template.sides)
    inner = right[:, *INNER]
    nets[corners.patches[:, None], *INNER] = inner
    nets[corners.images[:, :, 0], *np.array(INNER)[:, corners.images[:, :, 1]]] = inner * MIRROR
    return nets


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of the patches of the right half, each as one of a row round its node.

    Attributes
    ----------
    patches : (r,) int
        The patches of the right half.
    images : (r, 4, 2) int
        Patch and corner that are the mirror image of each corner.
    member : (4 r, n) float
        1 where a corner is one of a row of those that smooth edges join, else 0. Corners where four
        creases meet are in none.
    held : (n,) bool
        Rows beside a smooth edge in the middle of the car: its twist is across the car.
    signs : (4 r,) float
        The change of each corner is the row's, or opposite to it; 0 of those in none.
    crossed : (c, 2, 2) int
        Two tangents, each as edge and end, that run on in each other over a smooth edge.
    powers : (4 r, c) float
        How often the ratio of their lengths scales the change of each corner.
    """

    patches: Index
    images: Index
    member: Array
    held: Flags
    signs: Array
    crossed: Index
    powers: Array

    def factors(self, network: Network) -> Array:
        """Return the change of each corner per that of its row, (4 r,)."""
        lengths = np.linalg.norm(network.tangents, axis=2)[
            self.crossed[..., 0], self.crossed[..., 1]
        ]
        ratios = np.where((lengths > 0.0).all(axis=1, keepdims=True), lengths, 1.0)
        logarithms = np.log(ratios[:, 1]) - np.log(ratios[:, 0])
        return np.asarray(self.signs * np.exp(self.powers @ logarithms))

    def normals(self, nets: Array) -> Array:
        """Return the unit normal of the corners of each row, 0 where they have none, (n, 3).

        Parameters
        ----------
        nets : (r, 4, 4, 3) float
            The patches of the right half, mm.
        """
        corners, along, across = (nets[:, *places] for places in (CORNERS, ALONG, ACROSS))
        normals = self.member.T @ cross_product(along - corners, across - corners).reshape(-1, 3)
        sizes = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.asarray(normals / np.where(sizes > 0.0, sizes, 1.0))


@lru_cache(maxsize=KNOWN)
def corners_of(template: Template) -> Corners:
    """Return what follows from a template alone."""
    left = set(template.pairs[:, 1].tolist())
    right = [k for k, patch in enumerate(template.patches) if left.isdisjoint(patch.nodes)]
    number = {patch: own for own, patch in enumerate(right)}
    links: dict[Corner, list[tuple[Corner, int, float]]] = {}
    crossed: list[tuple[tuple[int, int], tuple[int, int]]] = []
    held: set[Corner] = set()
    where = {side: divmod(at, 4) for at, side in enumerate(template.sides.ravel().tolist())}
    for edge in np.flatnonzero(template.smooth_edges).tolist():
        (one, side), (two, back) = where[edge], where[~edge]
        for here, there in ((side, (back + 1) % 4), ((side + 1) % 4, back)):
            if one in number and two in number:
                links.setdefault((one, here), []).append(((two, there), len(crossed), 1.0))
                links.setdefault((two, there), []).append(((one, here), len(crossed), -1.0))
                crossed.append(
                    (_crossing(template, one, side, here), _crossing(template, two, back, there))
                )
            elif one in number:
                held.add((one, here))
            elif two in number:
                held.add((two, there))
    rows: list[list[Corner]] = []
    crossings = _crossings(template)
    signs = np.zeros((len(right), 4))
    powers = np.zeros((len(right), 4, len(crossed)))
    for first in ((patch, corner) for patch in right for corner in range(4)):
        if (
            signs[number[first[0]], first[1]]
            or template.patches[first[0]].nodes[first[1]] in crossings
        ):
            continue
        signs[number[first[0]], first[1]] = 1.0
        rows.append([first])
        for patch, corner in rows[-1]:  # it grows
            for other, link, power in links.get((patch, corner), ()):
                at, own = (number[other[0]], other[1]), (number[patch], corner)
                if not signs[at]:
                    signs[at], powers[at] = -signs[own], powers[own]
                    powers[at][link] += power
                    rows[-1].append(other)
    member = np.zeros((len(right), 4, len(rows)))
    for row, corners in enumerate(rows):
        for patch, corner in corners:
            member[number[patch], corner, row] = 1.0
    return Corners(
        np.array(right),
        np.array([_images(template, patch) for patch in right]),
        member.reshape(-1, len(rows)),
        np.array([not held.isdisjoint(row) for row in rows]),
        signs.ravel(),
        np.array(crossed, np.intp).reshape(-1, 2, 2),
        powers.reshape(-1, len(crossed)),
    )


def _crossings(template: Template) -> set[int]:
    """Return the nodes in which four creases meet or more, and nothing else."""
    count = Counter(template.edges[sorted(template.creases)].ravel().tolist())
    others = set(range(len(template.edges))) - template.creases
    return {node for node, creases in count.items() if creases >= 4} - {
        int(node) for node in template.edges[sorted(others)].ravel()
    }


def _crossing(template: Template, patch: int, side: int, corner: int) -> tuple[int, int]:
    """Return the edge that meets a side of a patch in a corner, and which of its ends does."""
    other = corner - 1 if side == corner else corner
    signed = int(template.sides[patch, other])
    starts = other == corner
    return (signed, 0 if starts else 1) if signed >= 0 else (~signed, 1 if starts else 0)


def _images(template: Template, patch: int) -> list[tuple[int, int]]:
    """Return patch and corner that are the mirror images of the corners of a patch."""
    nodes = template.mirrored[list(template.patches[patch].nodes)].tolist()
    (image,) = (k for k, other in enumerate(template.patches) if set(other.nodes) == set(nodes))
    return [(image, template.patches[image].nodes.index(node)) for node in nodes]


def variation() -> Array:
    """Return the sum of squared third derivatives of a patch as a form of its control points.

    Returns
    -------
    (16, 16) float
        Control points in the order of a net.
    """
    places, weights = GAUSS
    at = 0.5 * (1.0 + places)
    products = [
        (row.T * (0.5 * weights)) @ row for row in (bernstein(at, order) for order in range(4))
    ]
    return np.asarray(sum(np.kron(products[k], products[3 - k]) for k in range(4)))


FLAT: Final = tuple(4 * i + j for i, j in zip(*INNER, strict=True))
"""Numbers of the inner control points in a net."""

_BY_NET: Final = variation()[list(FLAT)]
"""How each inner control point would change the variation, by all points of its net, (4, 16)."""

_BESIDE: Final = _BY_NET[:, list(FLAT)]
"""The same by the inner points alone, (4, 4)."""
