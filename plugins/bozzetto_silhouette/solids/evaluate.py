"""The tree of nodes put together, from the first to the last; what did not change is kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from bozzetto.geometry import Placement
from bozzetto.plugin import remembered
from bozzetto_silhouette.inflation.solidify import Checkpoint, SilhouetteSolid, ignore
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.assembly import Assembly
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import joined, meshed
from bozzetto_silhouette.solids.extrude import acts_on, straight_body
from bozzetto_silhouette.solids.part_cells import cells_of
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.solids.traversal import put_together


class Tree(NamedTuple):
    """The nodes that are switched on, combined.

    Attributes
    ----------
    body : Body or None
        In the model's frame; None for nothing.
    solids : dict of str to SilhouetteSolid
        The solid of every part in its object frame, by the id of the part; without those that
        go straight through.
    """

    body: Body | None
    solids: dict[str, SilhouetteSolid]


def tree_body(
    state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore
) -> Body | None:
    """Return the body of all nodes that are switched on, in the model's frame; None for nothing."""
    return evaluated(state, resolution, checkpoint).body


def assembly_of(state: SilhouetteState, resolution: int) -> Assembly | None:
    """Return all nodes that are switched on, not united; None for nothing.

    Raises
    ------
    UserError
        As `evaluated`.
    """
    making = _making(state, resolution, ignore)
    return put_together(state, making.part, making.moved, making.joined)


def evaluated(state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore) -> Tree:
    """Put all nodes that are switched on together.

    Raises
    ------
    UserError
        If a part's ink is no outline; the message begins with the name of the part.
    """
    making = _making(state, resolution, checkpoint)
    whole = put_together(state, making.part, making.moved, making.joined)
    return Tree(None if whole is None else _meshed(whole, making.step), making.solids)


# By the two themselves: leaves are remembered by their recipes, so that equal recipes give the
# same body. Entries of unions are small; those of what was carved hold a mesh of the whole.
@remembered(
    limit=256,
    key=lambda before, body, node, checkpoint: (before, body, node.operation, node.blend),
)
def _joined(
    before: Assembly, body: Assembly, node: Part | Group, checkpoint: Checkpoint
) -> Assembly | None:
    return joined(before, body, node.operation, node.blend, checkpoint)


@remembered(limit=64)
def _alone(body: Body) -> Assembly:
    return Assembly.of(body)


@remembered(limit=16, key=lambda whole, checkpoint: whole)
def _meshed(whole: Assembly, checkpoint: Checkpoint) -> Body:
    return meshed(whole, checkpoint)


@remembered(limit=16)
def _moved(whole: Assembly, pose: Placement) -> Assembly:
    """Return a group where it was moved to."""
    if pose.is_identity:
        return whole
    return Assembly.of(_meshed(whole, ignore).placed(pose))


def _making(state: SilhouetteState, resolution: int, checkpoint: Checkpoint) -> _Making:
    cells = cells_of(state, resolution)
    return _Making(max(1, len(state.parts)), resolution, cells, checkpoint)


@dataclass
class _Making:
    """One pass over the tree, and how far it has come."""

    parts: int
    resolution: int
    cells: Mapping[str, int]
    checkpoint: Checkpoint
    begun: int = 0
    shown: float = 0.0
    solids: dict[str, SilhouetteSolid] = field(default_factory=dict)

    def part(self, part: Part, before: Assembly | None) -> Assembly:
        self.begun += 1
        if before is not None and acts_on(part):
            return _alone(straight_body(part, before.box, self.resolution))
        body = body_of(part, self.cells.get(part.id, self.resolution), self.step)
        if body.solid is not None:
            # Held from here on: the bodies of a large tree may push it out of the memory.
            self.solids[part.id] = body.solid
        return _alone(body)

    def moved(self, whole: Assembly, group: Group) -> Assembly:
        return _moved(whole, group.pose)

    def joined(self, before: Assembly, whole: Assembly, node: Part | Group) -> Assembly | None:
        return _joined(before, whole, node, self.step)

    def step(self, fraction: float, words: str) -> None:
        # A leaf and what is made of it are both a part's work: the bar never goes back.
        share = (self.begun - 1 + fraction) / self.parts
        self.shown = max(self.shown, min(1.0, share))
        self.checkpoint(self.shown, words)
