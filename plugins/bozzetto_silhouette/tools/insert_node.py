"""A new node that cuts or grows: the group that it goes into, and whether it changes the shape."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto_silhouette.inflation.manifold_check import volume_of
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.placements import carried, groups_around
from bozzetto_silhouette.view.picking import shape_seen

ALIKE = 1e-3
"""Difference between two changes of the volume, as a share of either, up to which they are the
same: meshes of one solid differ by less."""

NOTHING = 1e-6
"""Share of the volume that counts as nothing."""


def volume_left(state: SilhouetteState) -> float:
    """Return the volume of the whole shape, mm³; 0 where there is none."""
    touch = shape_seen(state)
    return 0.0 if touch is None else volume_of(touch.body.vertices, touch.body.faces)


def check_that_it_carves(before: SilhouetteState, after: SilhouetteState) -> float:
    """Return the volume that is left, mm³.

    Raises
    ------
    UserError
        If there was nothing before, or nothing was taken away, or nothing is left.
    """
    whole = volume_left(before)
    if not whole > 0.0:
        raise UserError("There is nothing to cut yet. Draw a shape first.")
    left = volume_left(after)
    if left >= (1.0 - NOTHING) * whole:
        raise UserError("This passes the shape by. Draw it over the shape.")
    if left <= NOTHING * whole:
        raise UserError("Nothing of the shape would be left. Draw it over a part of the shape.")
    return left


def insert_node(state: SilhouetteState, node: Part, touched: Iterable[Part]) -> SilhouetteState:
    """Add a node, drawn in the model's frame, to the group of the parts that it acts on.

    It is the last of the innermost group around all of them in which it does to the shape what
    it would do after everything: so it moves with that group, and does not spare what it was
    drawn over.

    Parameters
    ----------
    state : SilhouetteState
        The tree of nodes.
    node : Part
        The new one.
    touched : iterable of Part
        The parts that it acts on.

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
    """Return the groups that all of some parts are in, the innermost first."""
    chains = [groups_around(state, part) for part in parts]
    if not chains:
        return []
    shared = set.intersection(*({group.id for group in chain} for chain in chains))
    return [group for group in chains[0] if group.id in shared]
