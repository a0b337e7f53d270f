"""A draft of the whole tree: its function of space, polygonized coarsely, many times a second.

What `tree_body` makes keeps every outline and every crease exactly, which takes a while. While
something is dragged its shape changes at every move of the pen; then the blended function is
enough, on a lattice of a few dozen cells. Limbs thinner than two cells may be lost in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bozzetto_silhouette.composite import Composite
from bozzetto_silhouette.implicit import Implicit, Placed
from bozzetto_silhouette.leaf import body_of
from bozzetto_silhouette.state import Group, Part, SilhouetteState
from bozzetto_silhouette.straight import straight_body
from bozzetto_silhouette.surface import Surface, extract

__all__ = ["draft_surface"]


class _Draft(NamedTuple):
    """A solid as a function of space, and its largest inscribed radius."""

    implicit: Implicit
    radius: float


def draft_surface(state: SilhouetteState, cells: int) -> Surface | None:
    """The surface of all nodes that are switched on; None for nothing.

    Parameters
    ----------
    state : SilhouetteState
    cells : int
        Along the longest side of the whole.

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    whole = _Fold(state, cells).of("")
    if whole is None:
        return None
    bounds = whole.implicit.bounds
    surface = extract(whole.implicit, bounds, float(np.ptp(bounds, axis=0).max()) / cells)
    return surface if len(surface.faces) else None


@dataclass(frozen=True, eq=False)
class _Fold:
    """One pass over the tree, as in `tree_body`."""

    state: SilhouetteState
    cells: int

    def of(self, within: str) -> _Draft | None:
        """The nodes of one group, put together."""
        before: _Draft | None = None
        first = True
        for node in self.state.nodes:
            if node.within != within or not node.visible:
                continue
            alone = self._alone(node, before)
            if alone is None:
                continue
            if before is not None:
                before = _combined(before, alone, node)
            elif first or node.operation in ("add", "merge"):
                before = alone
            first = False
        return before

    def _alone(self, node: Part | Group, before: _Draft | None) -> _Draft | None:
        """A node by itself, in the frame of its group."""
        if isinstance(node, Part):
            acts = node.surface == "straight" and node.operation in ("carve", "intersect")
            if acts and before is not None:
                body = straight_body(node, before.implicit.bounds, self.cells)
            else:
                body = body_of(node, self.cells)
            return _Draft(body.implicit, body.radius)
        inside = self.of(node.id)
        if inside is None:
            return None
        return _Draft(Placed(inside.implicit, node.pose), inside.radius * node.pose.scale)


def _combined(before: _Draft, draft: _Draft, node: Part | Group) -> _Draft:
    reach = node.blend * min(before.radius, draft.radius)
    solid = Composite(before.implicit, draft.implicit, node.operation, node.blend, reach)
    return _Draft(solid, max(before.radius, draft.radius))
