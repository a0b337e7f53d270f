"""A bounding volume hierarchy over the triangles of a mesh, walked for many rays at once.

Triangles are sorted along a Morton curve and packed into leaves; every `FAN` neighbours
share a parent box, up to one root. There are no pointers: the children of box i are boxes
``FAN i … FAN i + FAN - 1`` one level down. Rays walk the levels breadth-first, so that the
inner loop is numpy's and not Python's.

Sources: Morton order, Lauterbach et al., "Fast BVH construction on GPUs", 2009, section 4;
the triangle test, Möller & Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags, Index

if TYPE_CHECKING:
    from bozzetto.geometry.mesh import Mesh

LEAF = 8
"""Triangles in a leaf."""

FAN = 8
"""Children of a box."""

MORTON_BITS = 10
"""Bits per axis of the curve that sorts the triangles."""

PAIRS_AT_ONCE = 400_000
"""Pairs of ray and box or triangle examined in one sweep; bounds the memory used."""

EDGE_TOLERANCE = 1e-9
"""How far outside a triangle (barycentric) still counts as a hit, so that a ray through
a shared edge cannot slip between the two triangles."""

SMALLEST_SLOPE = 1e-200
"""Stands in for a ray's zero slope along an axis, whose inverse the box test needs."""


@dataclass(frozen=True, eq=False)
class BoundingTree:
    """Boxes over the triangles of one mesh.

    Attributes
    ----------
    corner, edge1, edge2 : (f, 3) float
        First corner and the two edges from it, in the order of the leaves, mm.
    order : (f,) int
        Which face of the mesh each of these is.
    levels : tuple of (low, high)
        Boxes (n, 3) from the root down to the leaves, mm.
    """

    corner: Array
    edge1: Array
    edge2: Array
    order: Index
    levels: tuple[tuple[Array, Array], ...]


_trees: weakref.WeakKeyDictionary[Mesh, BoundingTree] = weakref.WeakKeyDictionary()


def tree_of(mesh: Mesh) -> BoundingTree:
    """Return the tree of a mesh, built on first use and kept as long as the mesh lives."""
    tree = _trees.get(mesh)
    if tree is None:
        tree = _trees[mesh] = _build(mesh)
    return tree


def _build(mesh: Mesh) -> BoundingTree:
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    low, high = corners.min(1), corners.max(1)
    order = np.argsort(_morton_codes(0.5 * (low + high)), kind="stable")
    corners, low, high = corners[order], low[order], high[order]
    levels = []
    group = LEAF
    while len(low):
        firsts = np.arange(0, len(low), group)
        low, high = np.minimum.reduceat(low, firsts), np.maximum.reduceat(high, firsts)
        levels.append((low, high))
        if len(low) == 1:
            break
        group = FAN
    return BoundingTree(
        corners[:, 0].copy(),  # a view would keep the two other corners, too
        corners[:, 1] - corners[:, 0],
        corners[:, 2] - corners[:, 0],
        order,
        tuple(reversed(levels)),
    )


def _morton_codes(places: Array) -> NDArray[np.int64]:
    if not len(places):
        return np.zeros(0, np.int64)
    low = places.min(0)
    size = float(np.max(places.max(0) - low)) or 1.0
    cells = ((places - low) * ((1 << MORTON_BITS) - 1) / size).astype(np.int64)
    codes = np.zeros(len(places), np.int64)
    for bit in range(MORTON_BITS):
        for axis in range(3):
            codes |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return codes


def first_hits(tree: BoundingTree, origins: Array, directions: Array) -> tuple[Array, Index]:
    """Find the nearest triangle on each ray, from either side.

    Parameters
    ----------
    tree : BoundingTree
        The tree of the mesh.
    origins, directions : (n, 3) float
        Half-lines; directions of unit length, mm.

    Returns
    -------
    distance : (n,) float
        mm; inf where nothing is hit.
    face : (n,) int
        Face of the mesh; -1 where nothing is hit. Rays that lie in a face's plane, and
        faces without area, do not meet.
    """
    count = len(origins)
    distance = np.full(count, np.inf)
    face = np.full(count, -1, np.intp)
    if not tree.levels or not count:
        return distance, face
    slopes = np.where(np.abs(directions) < SMALLEST_SLOPE, SMALLEST_SLOPE, directions)
    inverse = 1.0 / slopes
    # Depth first over batches, breadth first within one: memory stays bounded even where
    # every box overlaps every other.
    ray = np.arange(count, dtype=np.intp)
    pending = [(0, ray, np.zeros(count, np.intp))]
    while pending:
        level, ray, box = pending.pop()
        if len(ray) > PAIRS_AT_ONCE:
            for begin in range(0, len(ray), PAIRS_AT_ONCE):
                part = slice(begin, begin + PAIRS_AT_ONCE)
                pending.append((level, ray[part], box[part]))
            continue
        low, high = tree.levels[level]
        met = _meets_boxes(origins, inverse, ray, low, high, box, distance)
        ray, box = ray[met], box[met]
        if not len(ray):
            continue
        last = level + 1 == len(tree.levels)
        size, end = (LEAF, len(tree.order)) if last else (FAN, len(tree.levels[level + 1][0]))
        children = (box[:, None] * size + np.arange(size)).ravel()
        ray = np.repeat(ray, size)
        inside = children < end
        ray, children = ray[inside], children[inside]
        if last:
            _meet_triangles(tree, origins, directions, ray, children, distance, face)
        else:
            pending.append((level + 1, ray, children))
    return distance, face


def _meets_boxes(
    origins: Array,
    inverse: Array,
    ray: Index,
    low: Array,
    high: Array,
    box: Index,
    distance: Array,
) -> Flags:
    """Return which rays meet their box in front of what they have already met (slab test)."""
    enter = np.zeros(len(ray))
    leave = distance[ray]
    for axis in range(3):
        start, scale = origins[ray, axis], inverse[ray, axis]
        with np.errstate(over="ignore"):
            one = (low[box, axis] - start) * scale
            two = (high[box, axis] - start) * scale
        np.maximum(enter, np.minimum(one, two), out=enter)
        np.minimum(leave, np.maximum(one, two), out=leave)
    # Rounding must not lose a ray that grazes a flat box.
    met: Flags = enter <= leave * (1.0 + 1e-12) + 1e-300
    return met


def _meet_triangles(
    tree: BoundingTree,
    origins: Array,
    directions: Array,
    ray: Index,
    triangle: Index,
    distance: Array,
    face: Index,
) -> None:
    """Intersect triangles (Möller–Trumbore); write nearer hits into `distance` and `face`."""
    for begin in range(0, len(ray), PAIRS_AT_ONCE):
        part = slice(begin, begin + PAIRS_AT_ONCE)
        which, tri = ray[part], triangle[part]
        toward, edge1, edge2 = directions[which], tree.edge1[tri], tree.edge2[tri]
        across = _cross(toward, edge2)
        volume = _dot(edge1, across)
        offset = origins[which] - tree.corner[tri]
        sideways = _cross(offset, edge1)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            u = _dot(offset, across) / volume
            v = _dot(toward, sideways) / volume
            along = _dot(edge2, sideways) / volume
            good = (u >= -EDGE_TOLERANCE) & (v >= -EDGE_TOLERANCE)
            good &= (u + v <= 1.0 + EDGE_TOLERANCE) & (along >= 0) & (along < distance[which])
        which, tri, along = which[good], tri[good], along[good]
        # Farthest first, so that the nearest is written last; ties go to the lower face.
        final = np.lexsort((-tree.order[tri], -along))
        distance[which[final]] = along[final]
        face[which[final]] = tree.order[tri[final]]


def _cross(a: Array, b: Array) -> Array:
    """Return cross products row by row; several times faster than ``numpy.cross``."""
    result = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        result[:, i] = a[:, j] * b[:, k] - a[:, k] * b[:, j]
    return result


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b), np.float64)
