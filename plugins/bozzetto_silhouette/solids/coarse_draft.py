"""A draft of the whole tree: its function of space, polygonized coarsely, many times a second.

What `tree_body` makes keeps every outline and every crease exactly, which takes a while. While
something is dragged its shape changes at every move of the pen; then the blended function is
enough, on a lattice of a few dozen cells. Limbs thinner than two cells may be lost in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.extrude import acts_on, straight_body
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.solids.polygonize import Surface, extract
from bozzetto_silhouette.solids.traversal import put_together


class _Draft(NamedTuple):
    """A solid as a function of space, and its largest inscribed radius."""

    implicit: Implicit
    radius: float


def draft_surface(state: SilhouetteState, cells: int) -> Surface | None:
    """Polygonize all nodes that are switched on; None for nothing.

    Parameters
    ----------
    state : SilhouetteState
        The tree of nodes.
    cells : int
        Along the longest side of the whole.

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    whole = put_together(state, lambda part, before: _part(part, before, cells), _moved, _combined)
    if whole is None:
        return None
    bounds = whole.implicit.bounds
    surface = extract(whole.implicit, bounds, float(np.ptp(bounds, axis=0).max()) / cells)
    return surface if len(surface.faces) else None


def _part(part: Part, before: _Draft | None, cells: int) -> _Draft:
    if before is not None and acts_on(part):
        body = straight_body(part, before.implicit.bounds, cells)
    else:
        body = body_of(part, cells)
    return _Draft(body.implicit, body.radius)


def _moved(draft: _Draft, group: Group) -> _Draft:
    return _Draft(Placed(draft.implicit, group.pose), draft.radius * group.pose.scale)


def _combined(before: _Draft, draft: _Draft, node: Part | Group) -> _Draft:
    reach = node.blend * min(before.radius, draft.radius)
    solid = Composite(before.implicit, draft.implicit, node.operation, node.blend, reach)
    return _Draft(solid, max(before.radius, draft.radius))
