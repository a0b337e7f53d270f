"""Trace edges: bend them to strokes along the picture of the car, from any side."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import joint_rows
from bozzetto.view import Camera
from bozzetto_car.body.chain_smoothing import smooth_chains, smooth_joints
from bozzetto_car.body.drag import drag_place
from bozzetto_car.body.edge_runs import Run
from bozzetto_car.body.foot_points import Sighting
from bozzetto_car.body.joint_fit import JointFit, SeenNode, SharedJoint, node_axes
from bozzetto_car.body.stroke_reader import (
    Goal,
    Line,
    Said,
    StrokeReader,
    edge_matrices,
    node_matrix,
)
from bozzetto_car.body.traced import Traced
from bozzetto_car.solver.prior import DEVIATION
from bozzetto_car.template.network import Network, junctions, with_positions, with_tangents


@dataclass(frozen=True, eq=False)
class Fitted:
    """A network after strokes.

    Attributes
    ----------
    network : Network
    runs : mapping of int to Run
        By the number of the stroke: the edges that it was taken to trace.
    problems : mapping of int to str
        Why other strokes were left out.
    """

    network: Network
    runs: Mapping[int, Run]
    problems: Mapping[int, str]


def trace(
    network: Network,
    stroke: ArrayLike,
    camera: Camera,
    *,
    edges: Sequence[int] = (),
    nodes_follow: bool = False,
) -> Traced:
    """Bend the edges that a stroke runs along until they are seen where it is; see `trace_all`.

    Parameters
    ----------
    network : Network
        The network to change.
    stroke : (k, 2) array_like
        Samples of the stroke, px, in either direction.
    camera : Camera
        The view that the stroke was drawn in.
    edges : sequence of int, optional
        The edges that are meant, in the order of the row that they make; by default the
        nearest ones.
    nodes_follow : bool
        Nodes that the stroke passes, or reaches with an end, go to it, parallel to the image
        plane. Otherwise no node moves.

    Raises
    ------
    UserError
        If the stroke runs along no edge, or along nothing but edges that are seen end-on.
    """
    line = Line(np.asarray(stroke, float), camera, tuple(edges), nodes_follow)
    made = trace_all(network, (line,))
    if made.problems:
        raise UserError(made.problems[0])
    return Traced(made.network, made.runs[0], camera)


def trace_all(
    network: Network,
    lines: Sequence[Line],
    *,
    even: bool = True,
    information: Array | None = None,
) -> Fitted:
    """Bend the edges that strokes run along until they are seen along all of them.

    All strokes are fitted at once, so their order has no say, unless one traces again what another
    one has traced. On the same sketch the later one replaces the stretch that it runs along. It
    is then meant as a correction, as one in another view of the car is, and counts a hundred times
    as much as what was drawn along that stretch before. Strokes on two sketches, or on both sides
    of the car, count alike.

    A node that one stroke reaches goes to it, parallel to the image plane. One that several reach
    goes to where all of them, and what was known of it, are met best. Neighbours in smooth chains
    take the new directions and keep the lengths of their tangents. The other side of the car
    follows.

    Parameters
    ----------
    network : Network
        The network to change.
    lines : sequence of Line
        The strokes in the order in which they were drawn.
    even : bool
        Whether joints that make smooth surfaces share one ratio of the lengths of tangents.
    information : (q, q) float, optional
        Information about the variables of the car, mm⁻²: what moving a node costs.
    """
    fit = _Fit(network, tuple(lines), even, information)
    first = fit.made(network)
    return fit.made(first.network) if fit.depends_on_network(first) else first


class _Fit:
    """Strokes and the network before them."""

    def __init__(
        self, network: Network, lines: tuple[Line, ...], even: bool, information: Array | None
    ) -> None:
        self.network, self.lines, self.even, self.information = network, lines, even, information
        self.reader = StrokeReader(network.template, lines)

    def depends_on_network(self, first: Fitted) -> bool:
        """Whether moved nodes change how strokes are split, or how they are seen in a stretch."""
        if first.network is self.network or not any(line.nodes_follow for line in self.lines):
            return False
        return any(
            self.lines[number].map_ is not None or len(run.edges) > 1
            for number, run in first.runs.items()
        )

    def made(self, seen_on: Network) -> Fitted:
        """Return the network after all strokes, which are looked at on another network."""
        said = self.reader.said(seen_on)
        network = self._fitted(said, seen_on) if said.parts else self.network
        return Fitted(network, said.runs, said.problems)

    def _fitted(self, said: Said, seen_on: Network) -> Network:
        network, parts, goals = self.network, said.parts, said.goals
        counts: dict[int, set[int]] = {}
        for goal in goals:
            counts.setdefault(goal.node, set()).add(goal.number)
        alone = [goal for goal in goals if len(counts[goal.node]) == 1]
        if alone:
            network = with_positions(network, self._placed(alone))
        shared = [goal for goal in goals if len(counts[goal.node]) > 1]
        fit = JointFit(
            network,
            [
                Sighting(
                    part.edge, part.points, part.weights,
                    edge_matrices(part.edge, part.flip, self.lines[part.number], seen_on),
                )
                for part in parts
            ],
            self._joints({part.edge for part in parts}),
            [
                SeenNode(
                    goal.node, goal.pixel,
                    node_matrix(goal.node, goal.flip, self.lines[goal.number], seen_on),
                    goal.weight,
                )
                for goal in shared
            ],
            self._cost_of_moving(sorted({goal.node for goal in shared})),
        )  # fmt: skip
        found = fit.solved()
        if found is None:
            return network
        places: dict[int, Array] = {}
        for (node, axis), value in zip(fit.node_axes, found[0].tolist(), strict=True):
            places.setdefault(node, network.positions[node].copy())[axis] = value
        made = with_positions(network, places) if places else network
        made = with_tangents(made, {
            (edge, end): found[1][number, end]
            for number, edge in enumerate(fit.edges) for end in (0, 1)
            if not np.array_equal(found[1][number, end], network.tangents[edge, end])
        })  # fmt: skip
        nodes = {node for run in said.runs.values() for node in run.nodes}
        return smooth_chains(made, leading=fit.edges, nodes=nodes)

    def _placed(self, goals: Iterable[Goal]) -> dict[int, Array]:
        """Return nodes, which one stroke reaches, at the places that belong to them there."""
        network, found = self.network, dict[int, list[Array]]()
        for goal in goals:
            line = self.lines[goal.number]
            place = network.positions[goal.node]
            there = place if line.map_ is None else line.map_.points(place)
            free = np.array([True, bool(network.template.mirrored[goal.node] != goal.node), True])
            moved = drag_place(there * goal.flip, goal.pixel, line.camera, free) * goal.flip
            back = moved if line.map_ is None else line.map_.points_before(moved)
            found.setdefault(goal.node, []).append(back)
        return {node: np.mean(places, axis=0) for node, places in found.items()}

    def _joints(self, traced: set[int]) -> list[SharedJoint]:
        """Return the smooth joints between two traced edges of the right half or the middle."""
        template = self.network.template
        left = set(template.pairs[:, 1].tolist())
        rows = joint_rows(template.sides, smooth_joints(template)) if self.even else ()
        row_of = {
            number: (at, sense) for at, row in enumerate(rows) for number, sense in row.items()
        }
        return [
            SharedJoint(joint, *row_of.get(number, (len(rows) + number, 1.0)))
            for number, joint in enumerate(junctions(template))
            if not joint.crosses and joint.node not in left
            and traced.issuperset((joint.before[0], joint.after[0]))
        ]  # fmt: skip

    def _cost_of_moving(self, nodes: Sequence[int]) -> Array:
        axes = node_axes(self.network, nodes)
        if self.information is None:
            return np.eye(len(axes)) / DEVIATION**2
        first = np.argmax(self.network.template.basis == 1.0, axis=0).tolist()
        found = {divmod(row, 3): number for number, row in enumerate(first)}
        own = [found[key] for key in axes]
        return np.asarray(self.information[np.ix_(own, own)])
