"""The tree of nodes put together, from the first to the last; what did not change is kept."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from bozzetto.geometry import Placement
from bozzetto.plugin import remembered
from bozzetto_silhouette.inflation.solidify import Checkpoint, SilhouetteSolid, ignore
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import combined
from bozzetto_silhouette.solids.extrude import acts_on, straight_body
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


def evaluated(state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore) -> Tree:
    """Put all nodes that are switched on together.

    Raises
    ------
    UserError
        If a part's ink is no outline; the message begins with the name of the part.
    """
    making = _Making(max(1, len(state.parts)), resolution, checkpoint)
    body = put_together(state, making.part, making.moved, making.joined)
    return Tree(body, making.solids)


# By the two bodies themselves: leaves are remembered by their recipes, so that equal recipes
# give the same body. Each entry may hold a mesh of the whole.
@remembered(
    limit=256,
    key=lambda before, body, node, checkpoint: (before, body, node.operation, node.blend),
)
def _joined(before: Body, body: Body, node: Part | Group, checkpoint: Checkpoint) -> Body | None:
    return combined(before, body, node.operation, node.blend, checkpoint)


@remembered(limit=16)
def _moved(body: Body, pose: Placement) -> Body:
    """Return a group where it was moved to."""
    return body.placed(pose)


@dataclass
class _Making:
    """One pass over the tree, and how far it has come."""

    parts: int
    resolution: int
    checkpoint: Checkpoint
    begun: int = 0
    shown: float = 0.0
    solids: dict[str, SilhouetteSolid] = field(default_factory=dict)

    def part(self, part: Part, before: Body | None) -> Body:
        self.begun += 1
        if before is not None and acts_on(part):
            return straight_body(part, before.bounds, self.resolution)
        body = body_of(part, self.resolution, self._step)
        if body.solid is not None:
            # Held from here on: the bodies of a large tree may push it out of the memory.
            self.solids[part.id] = body.solid
        return body

    def moved(self, body: Body, group: Group) -> Body:
        return _moved(body, group.pose)

    def joined(self, before: Body, body: Body, node: Part | Group) -> Body | None:
        return _joined(before, body, node, self._step)

    def _step(self, fraction: float, words: str) -> None:
        # A leaf and what is made of it are both a part's work: the bar never goes back.
        share = (self.begun - 1 + fraction) / self.parts
        self.shown = max(self.shown, min(1.0, share))
        self.checkpoint(self.shown, words)
