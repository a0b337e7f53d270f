"""The tree of nodes put together, from the first to the last; what did not change is kept."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

from bozzetto_silhouette.body import Body
from bozzetto_silhouette.combine import combined
from bozzetto_silhouette.leaf import body_of
from bozzetto_silhouette.memory import Memory
from bozzetto_silhouette.solid import Checkpoint, ignore
from bozzetto_silhouette.state import Group, Part, SilhouetteState
from bozzetto_silhouette.straight import straight_body

__all__ = ["tree_body"]

_prefixes: Memory[Body | None] = Memory(limit=256)


@dataclass(frozen=True)
class _Step:
    """A node to be combined with what comes before it, and the question it answers."""

    node: Part | Group
    question: Hashable


def tree_body(
    state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore
) -> Body | None:
    """The body of all nodes that are switched on, in the model's frame; None for nothing.

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    total = max(1, len(state.nodes))
    done = 0

    def folded(within: str) -> tuple[Hashable, Body | None]:
        """The nodes of one group, put together; and what that hangs on."""
        nonlocal done
        so_far: Body | None = None
        question: tuple[Hashable, ...] = (resolution,)
        first = True
        for node in state.nodes:
            if node.within != within or not node.visible:
                continue

            def step(fraction: float, words: str) -> None:
                checkpoint(min(1.0, (done + fraction) / total), words)

            if isinstance(node, Group):
                inside, body = folded(node.id)
                if body is not None:
                    body = body.placed(node.pose)
                asked: Hashable = (inside, node.pose)
            else:
                through = node.surface == "straight" and node.operation in ("carve", "intersect")
                if through and so_far is not None:
                    body = straight_body(node, so_far.bounds, resolution)
                else:
                    body = body_of(node, resolution, step)
                asked = (node.recipe, node.id, node.pose)
                done += 1
            if body is None:
                continue
            if first:
                question, so_far, first = (*question, asked), body, False
                continue
            question = (*question, (asked, node.operation, node.blend))
            before = so_far

            def work(
                node: Part | Group = node, body: Body = body, before: Body | None = before
            ) -> Body | None:
                if before is None:
                    return body if node.operation in ("add", "merge") else None
                return combined(before, body, node.operation, node.blend, step)

            so_far = _prefixes.recall(question, work)
        return question, so_far

    return folded("")[1]
