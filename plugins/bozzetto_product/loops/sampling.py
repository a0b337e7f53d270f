"""A net as arrays: chains of points, directions at the ends, frames carried along.

Half-edges are numbers here, as in `bozzetto_product.network.half_edges`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.network.half_edges import half_edge_images
from bozzetto_product.network.net import Net

SAMPLES: Final = 13
"""Points on each edge, at equal steps of length: a chord then spans a twelfth of it."""

END_SAMPLES: Final = 1
"""Chords to the first of two places that give the direction of an end, by a parabola through both:
a twelfth and a sixth of the edge. Further ones miss where the spout of the Utah teapot turns back
at its lip."""

STRAIGHT: Final = -0.99
"""Cosine of a turn between two chords below which it counts as a reversal, which turns no frame."""


@dataclass(frozen=True, eq=False)
class SampledNet:
    """The arrays that loops are found by; m edges, n nodes, 2m half-edges.

    Parameters
    ----------
    net : Net
    lines : (m, SAMPLES, 3) float
        Points at equal steps of length along each edge, mm.
    lengths : (m,) float
        mm.
    size : float
        Diagonal of the box around all, mm.
    tails, heads : (2m,) int
        Nodes that half-edges leave and come to; -1 for closed edges without a node.
    leaving : (2m, 3) float
        Unit directions in which half-edges leave their tails.
    turns : (2m, 3, 3) float
        Rotation of a rotation-minimising frame along each half-edge (double reflection: Wang,
        Jüttler, Zheng & Liu 2008).
    normals : (n, 3) float
        The direction least like those of the ends at each node; 0 where fewer than two meet.
    flatness : (n,) float
        Greatest share of any of these directions along the normal.
    outgoing : tuple of tuple of int
        Half-edges that leave each node.
    ways : (n, d) int
        The same as an array; -1 beyond their number.
    degrees : (n,) int
        Their number.
    images : (2m,) int
        The mirror image of each half-edge; -1 for none.
    """

    net: Net
    lines: Array
    lengths: Array
    size: float
    tails: Index
    heads: Index
    leaving: Array
    turns: Array
    normals: Array
    flatness: Array
    outgoing: tuple[tuple[int, ...], ...]
    ways: Index
    degrees: Index
    images: Index

    @classmethod
    def of(cls, net: Net) -> SampledNet:
        """Sample a net."""
        lines = np.reshape([_even(edge.spline) for edge in net.edges], (-1, SAMPLES, 3))
        steps = np.linalg.norm(np.diff(lines, axis=1), axis=2)
        ends = np.reshape([(edge.start, edge.end) for edge in net.edges], (-1, 2)).astype(int)
        leaving = np.stack((_leaving(lines), _leaving(lines[:, ::-1])), axis=1).reshape(-1, 3)
        forward = _frame_turns(lines)
        turns = np.stack((forward, np.swapaxes(forward, 1, 2)), axis=1).reshape(-1, 3, 3)
        tails = ends.ravel()
        outgoing: list[list[int]] = [[] for _ in net.nodes]
        for half, node in enumerate(tails):
            if node >= 0:
                outgoing[node].append(half)
        normals, flatness = _node_normals(leaving, outgoing)
        size = float(np.linalg.norm(np.ptp(lines.reshape(-1, 3), axis=0))) if len(lines) else 0.0
        return cls(
            net,
            lines,
            steps.sum(axis=1),
            size,
            tails,
            ends[:, ::-1].ravel(),
            leaving,
            turns,
            normals,
            flatness,
            tuple(tuple(each) for each in outgoing),
            _padded(outgoing),
            np.array([len(halves) for halves in outgoing] or [0]),
            half_edge_images(net),
        )


def _padded(outgoing: list[list[int]]) -> Index:
    widest = max((len(halves) for halves in outgoing), default=0)
    ways = np.full((max(1, len(outgoing)), max(1, widest)), -1)
    for node, halves in enumerate(outgoing):
        ways[node, : len(halves)] = halves
    return ways


@remembered(limit=4000)
def _even(spline: Spline) -> Array:
    """Return points of a curve at equal steps of length."""
    points = spline.sampled(4 * (SAMPLES - 1) + 1)
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    at = np.linspace(0.0, along[-1], SAMPLES)
    return np.stack([np.interp(at, along, column) for column in points.T], axis=1)


def _leaving(lines: Array) -> Array:
    """Return the directions in which chains begin."""
    near, far = lines[:, END_SAMPLES] - lines[:, 0], lines[:, 2 * END_SAMPLES] - lines[:, 0]
    return _unit(4.0 * near - far)


def _unit(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0, size, 1.0))


def _frame_turns(lines: Array) -> Array:
    """Return the rotations of frames along chains, (m, 3, 3): chord to chord the least turn."""
    chords = _unit(np.diff(lines, axis=1))
    total = np.broadcast_to(np.eye(3), (len(lines), 3, 3))
    for step in range(chords.shape[1] - 1):
        first, second = chords[:, step], chords[:, step + 1]
        axis, cosine = cross_product(first, second), (first * second).sum(axis=1)
        cross = np.zeros((len(lines), 3, 3))
        cross[:, [2, 0, 1], [1, 2, 0]] = axis
        cross[:, [1, 2, 0], [2, 0, 1]] = -axis
        turning: Flags = cosine > STRAIGHT
        share = 1.0 / (1.0 + np.where(turning, cosine, 0.0))
        turn = np.eye(3) + cross + cross @ cross * share[:, None, None]
        total = np.where(turning[:, None, None], turn @ total, total)
    return np.asarray(total)


def _node_normals(leaving: Array, outgoing: list[list[int]]) -> tuple[Array, Array]:
    count = max(1, len(outgoing))
    normals, flatness = np.zeros((count, 3)), np.zeros(count)
    for node, halves in enumerate(outgoing):
        if len(halves) > 1:
            ends = leaving[halves]
            normals[node] = np.linalg.svd(ends)[2][2]
            flatness[node] = np.abs(ends @ normals[node]).max()
    return normals, flatness
