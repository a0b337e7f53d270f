"""The skin of a body as a graph: what diffusion of joints' shares over it asks for.

A graph of clusters stands for a fine skin. A cluster is what lies together in one cell of a grid
and is joined there, so that limbs that nearly touch stay apart. The grid lies around the middle of
the skin, whose mirror image thus has the mirrored clusters. With w the weight of an edge of
length l, the edges between two clusters whose centres are d apart weigh w l / d together: as many
resistors in a row conduct less.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.geometry import Rig
from bozzetto.plugin import cached_property

if TYPE_CHECKING:
    from scipy.sparse import csr_array

TURN = np.deg2rad(40.0)
"""Angle by which any joint may be turned."""

STEPS = 2
"""Implicit steps of a diffusion: more have shorter tails."""

FADING = 0.4
"""Loss of the length of the diffusion, per length of way, around where it is needed."""

FLATTEST, SHARPEST = 0.05, 20.0
"""Bounds of the weights of edges: those of long and of flat triangles."""

LEAST = 1e-9
"""Say of a place's own cluster: no place is left with none."""

SLIGHT = 1e-3
"""An edge that gets longer by a smaller share of its length is not stretched."""


@dataclass(frozen=True, eq=False)
class SkinGraph:
    """Places on a skin, and edges between them.

    Attributes
    ----------
    a, b : (e,) int array
        Ends of the edges.
    lengths, weights : (e,) float array
        Weights are half the sums of cotangents.
    areas : (v,) float array
        The part of the skin around each place.
    places : (v, 3) float array
    """

    a: Index
    b: Index
    lengths: Array
    weights: Array
    areas: Array
    places: Array

    @classmethod
    def of(cls, vertices: Array, faces: Faces) -> SkinGraph:
        """Return the graph of a closed mesh, (v, 3) and (f, 3)."""
        from scipy.sparse import coo_array

        i, j, tip = (np.concatenate([faces[:, (k + s) % 3] for k in range(3)]) for s in (1, 2, 0))
        one, other = vertices[i] - vertices[tip], vertices[j] - vertices[tip]
        twice = np.linalg.norm(np.cross(one, other), axis=1)
        least = 1e-12 * max(float(twice.max()), 1e-300)
        cotangents = (one * other).sum(axis=1) / np.maximum(twice, least)
        halves = 0.5 * np.clip(cotangents, FLATTEST, SHARPEST)
        count = len(vertices)
        shape = (count, count)
        edges = coo_array((halves, (np.minimum(i, j), np.maximum(i, j))), shape=shape)
        edges = edges.tocsr().tocoo()
        areas = np.bincount(faces.ravel(), np.repeat(twice[: len(faces)] / 6.0, 3), count)
        a, b = edges.row.astype(np.intp), edges.col.astype(np.intp)
        lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
        return cls(a, b, lengths, edges.data, np.maximum(areas, least), vertices)

    @cached_property
    def middles(self) -> Array:
        """Middles of the edges, (e, 3)."""
        return np.asarray(0.5 * (self.places[self.a] + self.places[self.b]))

    @cached_property
    def real_lengths(self) -> Array:
        """Lengths of the edges, (e,); those of no length count as very short."""
        return np.maximum(self.lengths, 1e-6 * max(float(self.lengths.max(initial=0.0)), 1e-300))

    @cached_property
    def _ways(self) -> tuple[Index, Index, Index]:
        """Ends and numbers of the edges from all places in order, and where those of each begin."""
        ends = np.concatenate([self.a, self.b])
        order = np.argsort(ends, kind="stable")
        begins = np.searchsorted(ends[order], np.arange(len(self.places) + 1))
        edges = np.tile(np.arange(len(self.a)), 2)
        return np.concatenate([self.b, self.a])[order], edges[order], begins

    def around(self, places: Index) -> tuple[Index, Index, Index]:
        """Return the edges that end at some places.

        Returns
        -------
        (k,) int array
            Their ends among these places.
        (k,) int array
            Their other ends.
        (k,) int array
            Their numbers.
        """
        there, edges, begins = self._ways
        count = begins[places + 1] - begins[places]
        before = np.cumsum(count) - count
        at = np.arange(int(count.sum())) + np.repeat(begins[places] - before, count)
        return np.repeat(places, count), there[at], edges[at]

    def steepest(self, joint: Array, stretch: float) -> Array:
        """Return by how much shares may change along edges, (e,), for a turn of a joint (3,)."""
        away = np.linalg.norm(self.middles - joint, axis=1)
        turned = np.maximum(2.0 * np.sin(0.5 * TURN) * away, 1e-300)
        return np.asarray(stretch * self.real_lengths / turned)

    def spread(self, reach: Array) -> Array:
        """Let lengths of diffusion fade around where they are needed."""
        loss = FADING * self.lengths
        while True:
            wider = reach.copy()
            np.maximum.at(wider, self.a, reach[self.b] - loss)
            np.maximum.at(wider, self.b, reach[self.a] - loss)
            if (wider - reach).max(initial=0.0) <= 1e-3 * reach.max():
                return wider
            reach = wider

    def diffused(self, shares: Array, reach: Array) -> Array:
        """Return shares diffused over a length (v,) that differs from place to place."""
        from scipy.sparse import coo_array, diags_array
        from scipy.sparse.linalg import splu

        moved = np.flatnonzero(reach > 0.0)
        number = np.full(len(reach), -1)
        number[moved] = np.arange(len(moved))
        inside = (number[self.a] >= 0) & (number[self.b] >= 0)
        a, b = number[self.a[inside]], number[self.b[inside]]
        square = reach[self.a[inside]] ** 2 + reach[self.b[inside]] ** 2
        pull = 0.5 / STEPS * square * self.weights[inside]
        size = len(moved)
        areas = self.areas[moved]
        pulls = np.concatenate([pull, pull])
        both = (np.concatenate([a, b]), np.concatenate([b, a]))
        around = areas + np.bincount(both[0], pulls, size)
        matrix = diags_array(around) - coo_array((pulls, both), shape=(size, size))
        factors = splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        near = np.flatnonzero((shares[moved] > 0.0).any(axis=0))
        mixed = shares[np.ix_(moved, near)]
        for _ in range(STEPS):
            mixed = factors.solve(areas[:, None] * mixed)
        result = shares.copy()
        result[np.ix_(moved, near)] = np.maximum(mixed, 0.0)
        return result

    def strain(self, rig: Rig, shares: Array, edges: Index | None = None) -> tuple[Array, Array]:
        """Return how much edges stretch by the worst turn of a joint, and how far that is.

        Parameters
        ----------
        rig : Rig
            At rest.
        shares : (v, n) float array
            Of each joint.
        edges : (k,) int array, optional
            Those that are asked about; all otherwise.

        Returns
        -------
        (k,) float array
            What an edge gets longer by, as a share of its length.
        (k,) float array
            The distance of its middle from the joint.
        """
        a, b, middles, lengths = self.a, self.b, self.middles, self.real_lengths
        if edges is not None:
            rows, ends = np.unique(np.concatenate([a[edges], b[edges]]), return_inverse=True)
            a, b = ends.reshape(2, -1)
            shares, middles, lengths = shares[rows], middles[edges], lengths[edges]
        worst, away = np.zeros(len(a)), np.zeros(len(a))
        if not len(a):
            return worst, away
        low, high = middles.min(axis=0), middles.max(axis=0)
        least = 0.5 * SLIGHT / np.sin(0.5 * TURN) * lengths
        for moved, place in zip(beyond(rig, shares), rig.joints, strict=True):
            change = np.abs(moved[a] - moved[b])
            farthest = np.linalg.norm(np.maximum(np.abs(place - low), np.abs(place - high)))
            some = np.flatnonzero(change * farthest > least)
            far = np.linalg.norm(middles[some] - place, axis=1)
            stretch = 2.0 * np.sin(0.5 * TURN) * change[some] * far / lengths[some]
            more = stretch > worst[some]
            worst[some[more]], away[some[more]] = stretch[more], far[more]
        return worst, away

    def averages(self, shares: Array, which: Flags, edges: Index | Flags) -> Array:
        """Return the mean of what is across some edges from each of some places, (k, n)."""
        from scipy.sparse import csr_array

        row = np.where(which, np.cumsum(which) - 1, -1)
        a, b = self.a[edges], self.b[edges]
        to, across = row[np.concatenate([a, b])], np.concatenate([b, a])
        kept = to >= 0
        ends = (to[kept], across[kept])
        table = csr_array((np.ones(len(ends[0])), ends), shape=(int(which.sum()), len(which)))
        return np.asarray((table @ shares) / table.sum(axis=1)[:, None])

    def clusters(self, cell: float) -> Index:
        """Return for each place the number of its cluster, (v,), by the side of a cell."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        middle = 0.5 * (self.places.min(axis=0) + self.places.max(axis=0))
        cells = np.floor((self.places - middle) / cell + 0.5)
        same = (cells[self.a] == cells[self.b]).all(axis=1)
        count = len(self.places)
        links = (np.ones(int(same.sum())), (self.a[same], self.b[same]))
        _, number = connected_components(coo_array(links, shape=(count, count)), directed=False)
        return np.asarray(number, np.intp)

    def of_clusters(self, number: Index) -> SkinGraph:
        """Return the graph whose places are clusters of this one's."""
        from scipy.sparse import coo_array

        areas: Array = np.bincount(number, self.areas).astype(np.float64)
        places = self.mean(number, self.places)
        one, other = number[self.a], number[self.b]
        apart = one != other
        a, b = np.minimum(one, other)[apart], np.maximum(one, other)[apart]
        pulls = self.weights[apart] * self.lengths[apart]
        edges = coo_array((pulls, (a, b)), shape=(len(areas), len(areas))).tocsr().tocoo()
        a, b = edges.row.astype(np.intp), edges.col.astype(np.intp)
        lengths = np.linalg.norm(places[a] - places[b], axis=1)
        least = 1e-6 * max(float(lengths.max(initial=0.0)), 1e-300)
        return SkinGraph(a, b, lengths, edges.data / np.maximum(lengths, least), areas, places)

    def mean(self, number: Index, values: Array) -> Array:
        """Return the means of values (v, n) over clusters, by the areas of their places."""
        from scipy.sparse import csr_array

        count = len(number)
        table = csr_array((self.areas, (number, np.arange(count))))
        return np.asarray((table @ values) / table.sum(axis=1)[:, None])

    def carried(self, number: Index, coarse: SkinGraph, radius: float, rows: Index) -> csr_array:
        """Return the shares of clusters in what some places take of them, (k, clusters).

        A place takes of its own cluster, of those beside it and of those beside these, each
        weighted by (1 - d² / r²)², d being the distance to its centre and r the radius.
        """
        from scipy.sparse import coo_array, csr_array, eye_array

        size = len(coarse.places)
        ends = (np.concatenate([coarse.a, coarse.b]), np.concatenate([coarse.b, coarse.a]))
        links = coo_array((np.ones(len(ends[0])), ends), shape=(size, size)) + eye_array(size)
        near = (links.tocsr() @ links.tocsr())[number[rows]].tocoo()
        gaps = self.places[rows[near.row]] - coarse.places[near.col]
        say = np.maximum(1.0 - (gaps**2).sum(axis=1) / radius**2, 0.0) ** 2
        say += LEAST * (near.col == number[rows[near.row]])
        say /= np.bincount(near.row, say)[near.row]
        return csr_array((say, (near.row, near.col)), shape=(len(rows), size))


def beyond(rig: Rig, shares: Array) -> Array:
    """Return for each joint the share of each place that follows it or one beyond it, (n, v)."""
    moved: NDArray[np.float64] = np.array(shares.T, order="C")
    for joint in range(len(rig.parents) - 1, 0, -1):
        parent = int(rig.parents[joint])
        if parent >= 0:
            moved[parent] += moved[joint]
    return moved
