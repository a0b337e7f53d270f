"""Fit all strokes along the edges of a car at once: nodes and tangents together.

An edge that is fitted after its neighbour moves what both share, and the neighbour leaves its
stroke. Here the unknowns are the places of nodes that strokes reach, and the tangents of all edges
that are traced. The cost is the sum of squared distances of all samples from the pictures of their
edges (foot points are found again at each step: Hoschek 1988), of nodes from the ends of strokes,
and of how far nodes and handles have moved. So the order of strokes has no say.

Where two traced edges meet smoothly they share one direction, and rows of such joints share one
ratio of lengths (`bozzetto.geometry.patches.joint_rows`), so that lines and surfaces stay smooth.
The mirror image of an edge is the edge itself, seen through a mirrored camera.

A view does not show depth. A handle that one view sees moves along its own tangent, or across it at
a right angle to the ray, and no other way; one in the plane of symmetry moves as far as that is
seen. Views from more than twenty degrees apart show all ways.

Steps are those of Gauss and Newton, halved until the cost falls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property
from bozzetto_car.body.edge_pictures import UNSEEN
from bozzetto_car.body.foot_points import Feet, Samples, Sighting
from bozzetto_car.body.mixed_steps import MixedSteps
from bozzetto_car.camera.rational_projection import AT_EYE, TINY
from bozzetto_car.listening import look
from bozzetto_car.template.network import HANDLE, EdgeJunction, Network

LEEWAY: Final = 0.1
"""Movement of a handle, per chord of the edge, that costs as much as a distance of a pixel.
It matters only where strokes leave a direction open."""

FORESHORTENED: Final = 0.35
"""Sine of the angle to the view rays, twenty degrees, below which handles do not move along their
tangents: they would go too far into the depth."""

LEAST_SEEN: Final = 1e-8
"""Share of a direction that is not seen at all: moving along it costs so many times as much."""

RESOLVED: Final = 1e-3
"""Distance, px, within which a stroke runs where the edge is seen already: samples are kept to
some 1e-4 px. The edge stays as it is then, and tracing it again and again does not change it."""

RATIO: Final = 0.5
"""Standard deviation of the logarithm of the ratio of two tangents that meet smoothly."""

STEPS: Final = 40
"""Most Gauss–Newton steps. Six to twelve are usual."""

HALVINGS: Final = 8
"""Most halvings of a step that does not help."""

SETTLED: Final = 3e-5
"""Longest step of an unknown, mm, at which the iteration ends."""

ROUNDING: Final = 1e-6
"""Gain that a step promises, per cost, below which it is taken untried: samples beyond the end of
an edge, which are not differentiated exactly, hide it."""

UNIT_OF_RATIO: Final = 1e-3
"""Logarithm of a ratio that counts as much as a millimetre."""

NEAR: Final = 1e-2
"""Gain that a step promises, per cost, from which on further steps are mixed."""

LOCAL: Final = 14
"""Unknowns of an edge: three of each node, three of each tangent, a ratio at each end."""


@dataclass(frozen=True, eq=False)
class SeenNode:
    """A place where a node is seen.

    Attributes
    ----------
    node : int
        Of the right half or the middle.
    pixel : (2,) float
    matrix : (3, 4) float
        As in `Sighting`.
    weight : float
    """

    node: int
    pixel: Array
    matrix: Array
    weight: float


@dataclass(frozen=True, eq=False)
class SharedJoint:
    """A smooth joint between two traced edges.

    Attributes
    ----------
    joint : EdgeJunction
    row : int
        Joints of a row share one ratio of lengths, after to before.
    sense : float
        1 or -1: whether the logarithm of this joint's ratio is that of the row, or its negative.
    """

    joint: EdgeJunction
    row: int
    sense: float


@dataclass(frozen=True, eq=False)
class _Try:
    """Unknowns with what they cost, and what a step needs."""

    unknowns: Array
    curves: Array
    scales: Array
    feet: Feet
    seen: Array
    cost: float


class JointFit:
    """The strokes of a car, and its network as they leave it.

    Parameters
    ----------
    network : Network
        The network before.
    sightings : sequence of Sighting
        One at least.
    joints : sequence of SharedJoint
    seen_nodes : sequence of SeenNode
        Nodes that may move, and where they are seen.
    node_form : (n, n) float
        Cost of moving them, as a quadratic form over `node_axes`, mm⁻².
    """

    def __init__(
        self,
        network: Network,
        sightings: Sequence[Sighting],
        joints: Sequence[SharedJoint],
        seen_nodes: Sequence[SeenNode],
        node_form: Array,
    ) -> None:
        self.network = network
        self.edges = sorted({own.edge for own in sightings})
        place = {edge: number for number, edge in enumerate(self.edges)}
        self._samples = Samples.of_sightings(sightings, self.edges)
        self._node_form = node_form
        self.node_axes = node_axes(network, sorted({seen.node for seen in seen_nodes}))
        self._columns, self._starts = self._laid_out(joints, place)
        self._scales = np.ones(len(self._starts))
        self._scales[self._first_ratio :] = UNIT_OF_RATIO
        self._base = network.control_points[self.edges]
        found = {key: number for number, key in enumerate(self.node_axes)}
        self._node_columns = np.array(
            [[found.get((own.node, axis), len(self._starts)) for axis in range(3)]
             for own in seen_nodes], np.intp,
        ).reshape(-1, 3)  # fmt: skip
        self._node_places = network.positions[[own.node for own in seen_nodes]].reshape(-1, 3)
        self._node_matrices = np.array([own.matrix for own in seen_nodes]).reshape(-1, 3, 4)
        self._node_pixels = np.array([own.pixel for own in seen_nodes]).reshape(-1, 2)
        self._node_weights = np.array([own.weight for own in seen_nodes])

    def solved(self) -> tuple[Array, Array] | None:
        """Return places of the nodes, by `node_axes`, and tangents (edges, 2, 3); None if unseen.

        None, too, where nothing has to move: all samples lie on their edges.
        """
        here = self._at(self._starts, None)
        if here is None or (not self.node_axes and np.abs(here.feet.ways).max() <= RESOLVED):
            return None
        mixed = MixedSteps(self._scales)
        for _ in range(STEPS):
            look()
            step, gain = self._step(here)
            if np.abs(step / self._scales).max(initial=0.0) < SETTLED:
                break
            is_near = gain < NEAR * here.cost
            further = mixed.step(here.unknowns, step) if is_near else None
            there = None if further is None else self._tried(here, further, gain)
            for number in range(HALVINGS + 1):
                if there is not None:
                    break
                there = self._tried(here, 0.5**number * step, gain)
            if there is None:
                break
            here = there
        legs = here.curves[:, [1, 3]] - here.curves[:, [0, 2]]
        return here.unknowns[: len(self.node_axes)], legs / HANDLE

    def _tried(self, here: _Try, step: Array, gain: float) -> _Try | None:
        """Return where a step leads; None if that is no better."""
        there = self._at(here.unknowns + step, here.feet.t)
        if there is not None and (there.cost < here.cost or gain < ROUNDING * here.cost):
            return there
        return None

    # -- unknowns --

    def _laid_out(
        self, joints: Sequence[SharedJoint], place: dict[int, int]
    ) -> tuple[Index, Array]:
        """Return the numbers of the unknowns of each edge, (edges, 14), and where all start.

        One more than there are stands for coordinates that do not change. First come nodes, then
        tangents, then ratios.
        """
        network, axes = self.network, {key: number for number, key in enumerate(self.node_axes)}
        starts = [float(network.positions[key]) for key in self.node_axes]
        leads = {one.joint.after: number for number, one in enumerate(joints)}
        columns = np.full((len(self.edges), LOCAL), -1, np.intp)
        self._fixed_ends = network.ends[self.edges]
        self._senses = np.zeros((len(self.edges), 2))
        self._turns = np.ones((len(self.edges), 2))
        slots: dict[tuple[int, int, int], int] = {}
        free = network.free_axes
        for edge in self.edges:
            for end in (0, 1):
                number = leads.get((edge, end))
                key = (edge, end) if number is None else joints[number].joint.before
                node = int(network.template.edges[edge, end])
                for axis in range(3):
                    at = axes.get((node, axis))
                    columns[place[edge], 3 * end + axis] = -1 if at is None else at
                    if free[key][axis]:
                        if (*key, axis) not in slots:
                            slots[*key, axis] = len(starts)
                            starts.append(float(network.tangents[key][axis]))
                        columns[place[edge], 6 + 3 * end + axis] = slots[*key, axis]
        self._first_ratio = len(starts)
        rows = sorted({one.row for one in joints})
        for one in joints:
            edge, end = one.joint.after
            columns[place[edge], 12 + end] = len(starts) + rows.index(one.row)
            self._senses[place[edge], end] = one.sense
            self._turns[place[edge], end] = one.joint.senses[0] * one.joint.senses[1]
        ratios: list[list[float]] = [[] for _ in rows]
        for one in joints:
            before, after = (
                float(np.linalg.norm(network.tangents[at]))
                for at in (one.joint.before, one.joint.after)
            )
            if before > 0.0 < after:
                ratios[rows.index(one.row)].append(one.sense * float(np.log(after / before)))
        starts += [float(np.mean(found)) if found else 0.0 for found in ratios]
        columns[columns < 0] = len(starts)
        return columns, np.array(starts)

    def _curves(self, unknowns: Array) -> tuple[Array, Array]:
        """Return the edges (e, 4, 3), and factors (e, 2) of their tangents' unknowns."""
        every = np.append(unknowns, 0.0)[self._columns]
        moves = (self._columns[:, :6] < len(unknowns)).reshape(-1, 2, 3)
        ends = np.where(moves, every[:, :6].reshape(-1, 2, 3), self._fixed_ends)
        scales = self._turns * np.exp(self._senses * every[:, 12:])
        handles = every[:, 6:12].reshape(-1, 2, 3) * (HANDLE * scales[..., None])
        curves = np.empty((len(self.edges), 4, 3))
        curves[:, 0], curves[:, 3] = ends[:, 0], ends[:, 1]
        curves[:, 1], curves[:, 2] = ends[:, 0] + handles[:, 0], ends[:, 1] - handles[:, 1]
        return curves, scales

    @cached_property
    def _stiff(self) -> Array:
        """The cost of moving each handle relative to its node, as forms, (e, 2, 3, 3) mm⁻²."""
        own = self._base
        legs = np.stack((own[:, 1] - own[:, 0], own[:, 2] - own[:, 3]), axis=1)
        chords = np.maximum(np.linalg.norm(own[:, 3] - own[:, 0], axis=1), 1.0)[:, None, None, None]
        lengths = np.linalg.norm(legs, axis=2, keepdims=True)
        along = np.divide(legs, lengths, out=np.zeros_like(legs), where=lengths > 0.0)
        # The direction that does not move in the picture: the null vector of its derivative.
        matrices, handles = self._samples.matrices[:, 1:3], own[self._samples.of, 1:3]
        seen = np.einsum("shij,shj->shi", matrices[..., :3], handles) + matrices[..., 3]
        rays = np.cross(
            matrices[:, :, 0, :3] * seen[:, :, 2:] - seen[:, :, :1] * matrices[:, :, 2, :3],
            matrices[:, :, 1, :3] * seen[:, :, 2:] - seen[:, :, 1:2] * matrices[:, :, 2, :3],
        )
        rays /= np.maximum(np.linalg.norm(rays, axis=2, keepdims=True), TINY)
        across = np.eye(3) - rays[..., :, None] * rays[..., None, :]
        shown = np.zeros((len(own), 2, 3, 3))
        np.add.at(shown, self._samples.of, across)
        free = self.network.free_axes[self.edges]
        most = np.linalg.eigvalsh(shown)[..., 2:]
        shown = shown * free[..., :, None] * free[..., None, :]
        sizes, ways = np.linalg.eigh(shown)
        seen_at = np.sqrt(np.maximum(sizes, 0.0) / np.maximum(most, TINY))
        hidden = 1.0 / np.maximum(_eased(seen_at), LEAST_SEEN) - 1.0
        ways = np.swapaxes(ways, 2, 3)
        off = ways - (ways * along[:, :, None]).sum(axis=3, keepdims=True) * along[:, :, None]
        sines = np.linalg.norm(off, axis=3, keepdims=True)
        share = _eased(sines) * np.asarray(free.all(axis=2))[..., None, None]
        still = share * off / np.maximum(sines, TINY) + (1.0 - share) * ways
        still /= np.maximum(np.linalg.norm(still, axis=3, keepdims=True), TINY)
        stiff = np.einsum("ehk,ehki,ehkj->ehij", hidden, still, still)
        return np.asarray((stiff + np.eye(3)) / (LEEWAY * chords) ** 2)

    # -- cost and step --

    def _at(self, unknowns: Array, near: Array | None) -> _Try | None:
        curves, scales = self._curves(unknowns)
        feet = self._samples.feet(curves, near)
        if feet is None:
            return None
        cost = float((self._samples.weights * feet.ways**2).sum())
        moved = self._moved(curves)
        cost += float(np.einsum("ehi,ehij,ehj->", moved, self._stiff, moved))
        away = unknowns - self._starts
        nodes, ratios = away[: len(self.node_axes)], away[self._first_ratio :]
        cost += float(nodes @ self._node_form @ nodes) + float(ratios @ ratios) / RATIO**2
        seen = self._seen(unknowns)
        if seen[:, 2].min(initial=np.inf) <= AT_EYE:
            return None
        off = seen[:, :2] / seen[:, 2:] - self._node_pixels
        cost += float(self._node_weights @ (off**2).sum(axis=1))
        return _Try(unknowns, curves, scales, feet, seen, cost)

    def _moved(self, curves: Array) -> Array:
        """Return how far handles have moved relative to their nodes, (e, 2, 3) mm."""
        change = curves - self._base
        return np.asarray(np.stack(
            (change[:, 1] - change[:, 0], change[:, 2] - change[:, 3]), axis=1
        ))  # fmt: skip

    def _seen(self, unknowns: Array) -> Array:
        """Return (u w, v w, w) of the nodes that are seen, (n, 3)."""
        at = self._node_columns
        places = np.where(at < len(unknowns), np.append(unknowns, 0.0)[at], self._node_places)
        found = self._node_matrices[..., :3] @ places[..., None]
        return np.asarray(found[..., 0] + self._node_matrices[..., 3])

    def _step(self, here: _Try) -> tuple[Array, float]:
        """Return the Gauss–Newton step of all unknowns, and what it promises to gain."""
        feet, count = here.feet, len(here.unknowns)
        t, rest = feet.t, 1.0 - feet.t
        shares = np.stack((rest**3, 3.0 * t * rest**2, 3.0 * t**2 * rest, t**3), axis=1)
        # Beyond its ends the edge goes on straight, and turns with its tangent.
        turns = np.stack((-3.0 * rest**2, 3.0 * rest * (rest - 2.0 * t),
                          3.0 * t * (2.0 * rest - t), 3.0 * t**2), axis=1)  # fmt: skip
        shares = shares * (1.0 + feet.beyond * feet.deeper)[:, None] - feet.beyond[:, None] * turns
        across = feet.normals / feet.w[:, None]
        deep = -(across[:, 0] * feet.places[:, 0] + across[:, 1] * feet.places[:, 1])
        leads = np.concatenate((across, deep[:, None]), axis=1)  # of (u w, v w, w), (s, 3, k)
        rows = np.swapaxes(self._samples.matrices[..., :3], 2, 3) @ leads[:, None]
        rows = (rows * shares[:, :, None]).reshape(len(t), 12, -1)
        weighted = rows * self._samples.weights[:, None]
        form = np.zeros((len(self.edges), 12, 12))
        slope = np.zeros((len(self.edges), 12))
        np.add.at(form, self._samples.of, weighted @ np.swapaxes(rows, 1, 2))
        np.add.at(slope, self._samples.of, (weighted @ feet.ways[..., None])[..., 0])
        self._hold_handles(here, form, slope)
        ways = self._led(here)
        back = np.swapaxes(ways, 1, 2)
        local, pull = back @ form @ ways, (back @ slope[..., None])[..., 0]
        columns, whole = self._columns, count + 1
        at = columns[:, :, None] * whole + columns[:, None]
        every: Array = np.asarray(np.bincount(at.ravel(), local.ravel(), whole**2), float)
        pulls: Array = np.asarray(np.bincount(columns.ravel(), pull.ravel(), whole), float)
        columns, local, pull = self._node_pulls(here)
        at = columns[:, :, None] * whole + columns[:, None]
        every = every + np.bincount(at.ravel(), local.ravel(), whole * whole)
        steep: Array = (pulls + np.bincount(columns.ravel(), pull.ravel(), whole))[:count]
        total: Array = every.reshape(whole, whole)[:count, :count]
        away = here.unknowns - self._starts
        nodes, first = len(self.node_axes), self._first_ratio
        total[:nodes, :nodes] += self._node_form
        steep[:nodes] += self._node_form @ away[:nodes]
        ratios = np.arange(first, count)
        total[ratios, ratios] += 1.0 / RATIO**2
        steep[first:] += away[first:] / RATIO**2
        step = np.asarray(-np.linalg.solve(total, steep))
        return step, -float(steep @ step)

    def _node_pulls(self, here: _Try) -> tuple[Index, Array, Array]:
        """Return unknowns (n, 3), forms and slopes that say where nodes are seen."""
        places = here.seen[:, :2] / here.seen[:, 2:]
        matrices = self._node_matrices[..., :3]
        turns = (matrices[:, :2] - places[..., None] * matrices[:, 2:]) / here.seen[:, 2:, None]
        weighted = np.swapaxes(turns, 1, 2) * self._node_weights[:, None, None]
        off = (places - self._node_pixels)[..., None]
        return self._node_columns, weighted @ turns, (weighted @ off)[..., 0]

    def _hold_handles(self, here: _Try, form: Array, slope: Array) -> None:
        """Add the cost of moved handles to the normal equations of the edges."""
        pulled = (self._stiff @ self._moved(here.curves)[..., None])[..., 0]
        for end, (node, handle) in enumerate(((slice(0, 3), slice(3, 6)),
                                              (slice(9, 12), slice(6, 9)))):  # fmt: skip
            stiff = self._stiff[:, end]
            form[:, node, node] += stiff
            form[:, handle, handle] += stiff
            form[:, node, handle] -= stiff
            form[:, handle, node] -= stiff
            slope[:, handle] += pulled[:, end]
            slope[:, node] -= pulled[:, end]

    def _led(self, here: _Try) -> Array:
        """Return the derivatives of the Bézier points by the unknowns of each edge, (e, 12, 14)."""
        ways = np.zeros((len(self.edges), 12, LOCAL))
        axes = np.arange(3)
        for end, (node, handle, sign) in enumerate(((0, 3, HANDLE), (9, 6, -HANDLE))):
            ways[:, node + axes, 3 * end + axes] = 1.0
            ways[:, handle + axes, 3 * end + axes] = 1.0
            ways[:, handle + axes, 6 + 3 * end + axes] = sign * here.scales[:, end, None]
            leg = here.curves[:, handle // 3] - here.curves[:, node // 3]
            ways[:, handle : handle + 3, 12 + end] = self._senses[:, end, None] * leg
        return ways


def _eased(sines: Array) -> Array:
    """Return how far directions count as seen: 0 up to ten degrees, 1 from twenty on."""
    share = np.clip((sines - UNSEEN) / (FORESHORTENED - UNSEEN), 0.0, 1.0)
    return np.asarray(share**2 * (3.0 - 2.0 * share))


def node_axes(network: Network, nodes: Sequence[int]) -> list[tuple[int, int]]:
    """Return the coordinates (node, axis) that nodes of the right half or the middle may change."""
    middle = set(network.template.centre.tolist())
    return [(node, axis) for node in nodes for axis in range(3) if axis != 1 or node not in middle]
