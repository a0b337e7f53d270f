"""The tree of nodes put together, from the first to the last; what did not change is kept."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from bozzetto.errors import UserError
from bozzetto.plugin import Memory
from bozzetto_silhouette.body import REMEMBERED, Body
from bozzetto_silhouette.combine import combined
from bozzetto_silhouette.leaf import body_of
from bozzetto_silhouette.solid import Checkpoint, ignore
from bozzetto_silhouette.state import Group, Part, SilhouetteState
from bozzetto_silhouette.straight import straight_body

__all__ = ["tree_body"]


def _weight(body: Body | None) -> int:
    return 0 if body is None else body.weight()


_joined: Memory[Body | None] = Memory(limit=256, weight=_weight, most=REMEMBERED)
"""By the two bodies themselves: leaves are remembered by their recipes, so that equal recipes
give the same body. Each entry may hold a mesh of the whole."""

_moved: Memory[Body] = Memory(limit=16)
"""Groups where they were moved to."""


def tree_body(
    state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore
) -> Body | None:
    """The body of all nodes that are switched on, in the model's frame; None for nothing.

    The first node of a group is the shape that the others act on, whatever its own operation.

    Raises
    ------
    UserError
        If a part's ink is no outline; the message begins with the name of the part.
    """
    return _Fold(state, resolution, checkpoint).of("")


@dataclass
class _Fold:
    """One pass over the tree."""

    state: SilhouetteState
    resolution: int
    checkpoint: Checkpoint
    done: int = 0
    told: float = 0.0

    def of(self, within: str) -> Body | None:
        """The nodes of one group, put together."""
        before: Body | None = None
        first = True
        for node in self.state.nodes:
            if node.within != within or not node.visible:
                continue
            with _naming(node):
                body = self._alone(node, before)
                if body is not None:
                    before = body if first else self._with(before, body, node)
                    first = False
            self.done += isinstance(node, Part)
        return before

    def _alone(self, node: Part | Group, before: Body | None) -> Body | None:
        """A node by itself, in the frame of its group."""
        if isinstance(node, Part):
            acts = node.surface == "straight" and node.operation in ("carve", "intersect")
            if acts and before is not None:
                return straight_body(node, before.bounds, self.resolution)
            return body_of(node, self.resolution, self._step)
        body = self.of(node.id)
        if body is None:
            return None
        return _moved.recall((body, node.pose), lambda: body.placed(node.pose))

    def _with(self, before: Body | None, body: Body, node: Part | Group) -> Body | None:
        """What a node makes of what comes before it."""
        if before is None:
            return body if node.operation in ("add", "merge") else None
        return _joined.recall(
            (before, body, node.operation, node.blend),
            lambda: combined(before, body, node.operation, node.blend, self._step),
        )

    def _step(self, fraction: float, words: str) -> None:
        parts = max(1, len(self.state.parts))
        # A leaf and what is made of it are both a part's work: the bar never goes back.
        self.told = max(self.told, min(1.0, (self.done + fraction) / parts))
        self.checkpoint(self.told, words)


@contextmanager
def _naming(node: Part | Group) -> Iterator[None]:
    """Let a mistake in a part begin with the part's name."""
    try:
        yield
    except UserError as error:
        if isinstance(node, Group) or not node.name:
            raise
        raise UserError(f"{node.name}: {error.message}", places=error.places) from error
