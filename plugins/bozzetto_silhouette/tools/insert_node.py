"""Where what the pen does to a shape goes in the tree: into the group of what it acts on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.placements import carried, groups_around
from bozzetto_silhouette.tools.carve_check import volume_left

__all__ = ["landed"]

ALIKE = 1e-3
"""Difference between two changes of the volume, as a share of either, up to which they are the
same: meshes of one solid differ by less."""


def landed(state: SilhouetteState, node: Part, touched: Iterable[Part]) -> SilhouetteState:
    """The state with a new node, drawn in the model's frame, that belongs to some parts.

    It is the last of the innermost group around all of them in which it does to the shape what
    it would do after everything: so it moves with that group, and does not spare what it was
    drawn over.

    Parameters
    ----------
    state : SilhouetteState
    node : Part
    touched : parts of the state

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    outermost = state.with_node(node)
    groups = _around_all(state, touched)
    if not groups:
        return outermost
    before = volume_left(state)
    wanted = volume_left(outermost) - before
    for group in groups:
        inside = replace(node, within=group.id, pose=carried(state, group).inverse())
        inner = state.with_node(inside)
        if abs(volume_left(inner) - before - wanted) <= ALIKE * abs(wanted):
            return inner
    return outermost


def _around_all(state: SilhouetteState, parts: Iterable[Part]) -> list[Group]:
    """The groups that some parts are all in, the innermost first."""
    chains = [groups_around(state, part) for part in parts]
    if not chains:
        return []
    shared = set.intersection(*({group.id for group in chain} for chain in chains))
    return [group for group in chains[0] if group.id in shared]
