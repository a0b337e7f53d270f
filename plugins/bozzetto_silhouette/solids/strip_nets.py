"""Meshes of bodies that are blended, with how each vertex lies to the body that leads there.

Where triangles are large beside the blend, their edges are halved.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.numerics.isotropic_remeshing import dot, halved, unit
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.contacts import Apart, Pair, Told, is_near, leads_of

CUT = 0.55
"""Level, without its sign, up to which coarse meshes are kept; the blend adds 5 % of its reach
there, and the vertices that are kept are brought onto it."""

FINE_CUT = 0.9
"""The same of meshes that are fine beside the blend: what is replaced needs fewer triangles."""

COARSER = 1.3
"""How fast the level falls with the spacing of the mesh, in reaches."""

NARROWED = 0.4
"""The same where two blends are felt, so that their strips do not touch."""

COARSEST = 0.3
"""Length of edges where a mesh is cut, as a share of the reach; half of that where two are felt."""

LONGEST = 1.4
"""How much longer an edge must be for it to be halved."""

HALVINGS = 5
"""Rounds of halving at most."""

_FAR = 9.0
"""Levels beyond are not told apart."""


class Net(NamedTuple):
    """The meshes of all bodies in a row, and how each vertex lies to the body that leads there.

    Attributes
    ----------
    vertices, normals : (v, 3) float array
    faces : (f, 3) int array
        Those near blends.
    rest : (r, 3) int array
        Those that are kept whatever is done.
    owner : (v,) int array
        The number of its body.
    parents : (v,) int array
        The vertex of the bodies that each is; -1 for new ones.
    pair : (v,) int array
        The number of the pair with the body that leads; -1 where none is near.
    ahead : (v,) float array
        The value of that body less that of the own one.
    reach, local : (v,) float array
        Of the blend: by the angle, and without it.
    crowded : (v,) bool array
        Where more than one blend is felt.
    cut : (v,) float array
        The level, without its sign, up to which the mesh is kept.
    """

    vertices: Array
    normals: Array
    faces: Index
    rest: Index
    owner: Index
    parents: Index
    pair: Index
    ahead: Array
    reach: Array
    local: Array
    crowded: Flags
    cut: Array

    @property
    def level(self) -> Array:
        """The level of each vertex: -1 where the blend begins, above 0 within the other body."""
        found = np.full(len(self.pair), -_FAR)
        near = self.pair >= 0
        found[near] = self.ahead[near] / np.maximum(self.reach[near], 1e-9)
        return np.asarray(np.clip(found, -_FAR, _FAR))


def net_of(bodies: Sequence[Body], pairs: list[Pair]) -> Net:
    """Return the meshes of bodies, fine enough to be cut where they are blended.

    Raises
    ------
    Apart
        Where sharp edges are blended.
    """
    return _refined(_net(bodies, pairs), pairs, bodies)


def mean_edges(vertices: Array, faces: Index) -> Array:
    """Return the mean length (v,) of the edges of faces at vertices; 0 where there are none."""
    corners, lengths = faces.ravel(), _edge_lengths(vertices, faces).ravel()
    count = np.maximum(np.bincount(corners, minlength=len(vertices)), 1)
    return np.asarray(np.bincount(corners, lengths, len(vertices)) / count)


def _edge_lengths(vertices: Array, faces: Index) -> Array:
    """Return the lengths (f, 3) of the edges of faces, each from a corner to the next."""
    square = np.zeros(faces.shape)
    for column in vertices.T.copy():  # by coordinates: pairs of points take twice as long
        at = column.take(faces)
        way = at[:, [1, 2, 0]] - at
        square += way * way
    return np.sqrt(square)


class _Leads(NamedTuple):
    """The last columns of a `Net`."""

    pair: Index
    ahead: Array
    reach: Array
    local: Array
    crowded: Flags
    cut: Array


def _net(bodies: Sequence[Body], pairs: list[Pair]) -> Net:
    counts = [len(body.vertices) for body in bodies]
    starts = np.cumsum([0, *counts])
    owner = np.repeat(np.arange(len(bodies)), counts)
    found = leads_of(pairs, bodies)
    at = [
        np.where(lead.rows < counts[pair.one], starts[pair.one] + lead.rows,
                 starts[pair.other] + lead.rows - counts[pair.one])
        for pair, lead in zip(pairs, found, strict=True)
    ]  # fmt: skip
    number = np.repeat(np.arange(len(pairs)), [len(lead.rows) for lead in found])
    columns = [
        np.concatenate([np.zeros(0), *(lead[k] for lead in found)]) for k in (1, 2, 3)
    ]  # fmt: skip
    rows = np.concatenate([np.zeros(0, np.intp), *at])
    steps = np.array([body.step for body in bodies])[owner]
    leads = _leading(rows, number, columns, steps)
    times = Counter((pair.one, pair.other) for pair in pairs)
    refused = [set(ends) for ends, count in times.items() if count > 1]
    refused += [pair.ends for pair in pairs if pair.solid.reach <= 0.0]
    creases = np.concatenate(
        [body.creases + start for body, start in zip(bodies, starts, strict=False)]
    )
    sharp = creases[leads.ahead[creases] > -leads.reach[creases]]
    refused += [pairs[k].ends for k in np.unique(leads.pair[sharp])]
    if refused:
        raise Apart(*refused)
    return Net(
        np.concatenate([body.vertices for body in bodies]),
        np.concatenate([body.normals for body in bodies]),
        np.concatenate(
            [
                body.faces.astype(np.intp) + start
                for body, start in zip(bodies, starts, strict=False)
            ]
        ),
        np.zeros((0, 3), np.intp),
        owner,
        np.arange(len(owner)),
        *leads,
    )


def _leading(rows: Index, number: Index, columns: Sequence[Array], steps: Array) -> _Leads:
    """Return for every vertex (v,) what the pair says that leads most there.

    Parameters
    ----------
    rows, number : (m,) int array
        Vertices, each with the number of a pair.
    columns : three (m,) float arrays
        By how much the other body leads, and both reaches.
    steps : (v,) float array
        Spacing of the mesh of each vertex.
    """
    count = len(steps)
    ahead, reach, _ = columns
    crowded = np.bincount(rows[ahead > -reach], minlength=count) > 1
    order = np.argsort(ahead, kind="stable")
    pair = np.full(count, -1)
    pair[rows[order]] = number[order]
    most = [np.full(count, -np.inf), np.zeros(count), np.zeros(count)]
    for column, values in zip(most, columns, strict=True):
        column[rows[order]] = values[order]
    cut = np.clip(1.0 - COARSER * steps / np.maximum(most[2], 1e-9), CUT, FINE_CUT)
    return _Leads(pair, most[0], most[1], most[2], crowded, np.where(crowded, NARROWED, cut))


def _refined(net: Net, pairs: list[Pair], bodies: Sequence[Body]) -> Net:
    """Halve edges that are long beside the blend where the mesh is cut."""
    steps = np.array([pair.step for pair in pairs] or [1.0])
    ones = np.array([pair.one for pair in pairs] or [0])
    met = net.faces[(net.pair >= 0)[net.faces].any(axis=1)]
    room = 2.0 * mean_edges(net.vertices, met)
    near = (net.ahead > -(net.local + room)) & (net.ahead < room)
    around = np.zeros(len(near), bool)
    around[net.faces[near[net.faces].any(axis=1)]] = True
    active = around[net.faces].any(axis=1)
    buried = (net.ahead > 0.0)[net.faces].any(axis=1)
    rest, faces = net.faces[~active & ~buried], net.faces[active]
    done = []
    for _ in range(HALVINGS):
        other = faces[:, [1, 2, 0]]
        low, high = np.minimum(faces, other), np.maximum(faces, other)
        first = net.ahead[low] >= net.ahead[high]
        lead, least = np.where(first, low, high), np.where(first, high, low)
        length = _edge_lengths(net.vertices, faces)
        crowded = net.crowded[low] | net.crowded[high]
        target = np.where(crowded, 0.5, 1.0) * COARSEST * net.local[lead]
        target = np.maximum(target, steps[net.pair[lead]])
        long = (net.pair[lead] >= 0) & (length > LONGEST * target)
        # Those that cross the level, and longer ones beside, which a small body may pass between.
        level = -net.cut[lead] * net.reach[lead]
        margin = np.maximum(np.where(crowded, 0.7, 0.3) * length, 0.8 * (length - 2.0 * target))
        long &= (net.ahead[lead] > level - margin) & (net.ahead[least] < level + margin)
        if not long.any():
            break
        count = len(net.vertices)
        key = low * count + high
        keys, at = np.unique(key[long], return_index=True)
        u, v, own = low[long][at], high[long][at], net.pair[lead][long][at]
        owner = net.owner[u]
        middle, normal = _on_body(
            Told.in_any_order(pairs, own, 0.5 * (net.vertices[u] + net.vertices[v])),
            ones[own] == owner, 0.5 * (net.vertices[u] + net.vertices[v]),
            unit(net.normals[u] + net.normals[v]), 0.25 * length[long][at],
        )  # fmt: skip
        place = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
        middles = np.where(keys[place] == key, count + place, -1)
        cut = (middles >= 0).any(axis=1)
        done.append(faces[~cut])  # an edge that is not halved now never is
        faces = halved(faces[cut], middles[cut])
        leads = _at_points(middle, owner, pairs, bodies)
        columns = [np.concatenate(two) for two in zip(net[6:], leads, strict=True)]
        net = Net(
            np.concatenate([net.vertices, middle]),
            np.concatenate([net.normals, normal]),
            net.faces,
            net.rest,
            np.concatenate([net.owner, owner]),
            np.concatenate([net.parents, np.full(len(u), -1)]),
            *columns,
        )
    return net._replace(faces=np.concatenate([*done, faces]), rest=rest)


def _on_body(
    told: Told, is_first: Flags, points: Array, normals: Array, most: Array
) -> tuple[Array, Array]:
    """Bring points (n, 3) onto the body that each belongs to; return them and the normals there."""
    value = np.where(is_first, told.first, told.second)
    slope = np.where(is_first[:, None], told.first_slope, told.second_slope)
    square = dot(slope, slope)
    known = square > 0.25  # of a body that cannot matter only a bound is given
    way = np.clip(np.where(known, value / np.maximum(square, 0.25), 0.0), -most, most)
    return points - way[:, None] * slope, np.where(known[:, None], -unit(slope), normals)


def _at_points(points: Array, owner: Index, pairs: list[Pair], bodies: Sequence[Body]) -> _Leads:
    """Compare bodies at points (n, 3) on the bodies with numbers (n,)."""
    rows, flips, counts = [], [], []
    for pair in pairs:
        total = 0
        for i, j, way in ((pair.one, pair.other, 1.0), (pair.other, pair.one, -1.0)):
            mine = np.flatnonzero(owner == i)
            mine = mine[is_near(pair, points[mine], bodies[i], bodies[j])]
            rows.append(mine)
            flips.append(np.full(len(mine), way))
            total += len(mine)
        counts.append(total)
    at = np.concatenate(rows)
    found = Told.of(pairs, points[at], np.cumsum([0, *counts]))
    ahead = np.concatenate(flips) * (found.second - found.first)
    number = np.repeat(np.arange(len(pairs)), counts)
    steps = np.array([body.step for body in bodies])[owner]
    return _leading(at, number, (ahead, found.reach, found.local), steps)
