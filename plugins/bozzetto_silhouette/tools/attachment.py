"""Attachment: a part that touches nothing is pulled onto the rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import Command, Context, Job, remembered
from bozzetto_silhouette.model.state import Node, Part, SilhouetteState
from bozzetto_silhouette.solids.assembly import Assembly
from bozzetto_silhouette.solids.body import Body, meet
from bozzetto_silhouette.solids.evaluate import assembly_of
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.solids.placements import carried, drawn_rings, is_shown, shown_parts
from bozzetto_silhouette.solids.traversal import without_blends
from bozzetto_silhouette.tools.arrange import after_motion
from bozzetto_silhouette.view.picking import TOUCHED_CELLS, shape_seen

SUNK = 0.3
"""How deep a part that is pulled on goes in, as a share of its largest inscribed radius."""

MOST_PLACES = 1500
"""Vertices of the part from which the rest is looked for along its line of sight."""

NOT_FLOATING = "This part touches the others already."


class Gap(NamedTuple):
    """The way from a part to the rest, in the model's frame: (3,), and how deep it then goes."""

    way: Array
    depth: float


def attach(state: SilhouetteState, context: Context) -> SilhouetteState:
    """Move the chosen part until it touches the rest.

    Raises
    ------
    UserError
        If nothing is chosen, or it touches already.
    """
    part = floating_part(state)
    if part is None:
        raise UserError(NOT_FLOATING)
    gap = _gap(state, part)
    if gap is None:
        raise UserError(NOT_FLOATING)
    length = float(np.linalg.norm(gap.way))
    far = gap.way * (1.0 + gap.depth / max(length, 1e-12))
    x, y, z = (float(v) for v in far)
    return state.with_node(after_motion(state, part, Placement(offset=(x, y, z))))


def floating_part(state: SilhouetteState) -> Part | None:
    """Return the chosen part if it touches nothing of the rest; None else, or without a rest."""
    return _floating(state, state.selected)


def offers_to_attach(state: SilhouetteState, job: Job) -> list[str]:
    """Return for each part that touches nothing of the rest what pulls it on, a sentence each."""
    found = []
    for part in shown_parts(state):
        job.checkpoint(1.0, part.name)
        if _floating(state, part.id) is not None:
            found.append(offer_to_attach(part))
    return found


def offer_to_attach(part: Part) -> str:
    """Say of a part that touches nothing what pulls it on."""
    return f"“{part.name}” touches nothing. {ATTACH.title} ({ATTACH.key}) pulls it on."


def _floating(state: SilhouetteState, part_id: str) -> Part | None:
    part = next((part for part in state.parts if part.id == part_id), None)
    if part is None or part.surface == "straight" or part.operation not in ("add", "merge"):
        return None
    if not is_shown(state, part) or _gap(state, part) is None:
        return None
    return part


@remembered(limit=16, key=lambda state, part: (state.nodes, part.id))
def _gap(state: SilhouetteState, part: Part) -> Gap | None:
    """Find the way along the part's line of sight, else the shortest one; None if it touches."""
    from scipy.spatial import cKDTree

    others = state.without_nodes(part.id)
    try:
        alone = body_of(part, TOUCHED_CELLS).placed(_outer(state, part))
        if _meets_a_part(others, alone):
            return None
        whole = assembly_of(without_blends(others), TOUCHED_CELLS)
        if whole is None or _overlap(alone, whole):
            return None
        touch = shape_seen(others)
    except UserError:
        return None
    if touch is None:
        return None
    rest = touch.body
    if rest.manifold.min_gap(alone.manifold, 0.5 * alone.step) <= 0.0:
        return None
    places = alone.vertices[:: len(alone.vertices) // MOST_PLACES + 1]
    sight = carried(state, part).directions(part.sheet.normal)[0]
    sight = sight / np.linalg.norm(sight)
    depth = SUNK * alone.radius
    along: Array = rest.vertices @ sight
    across = rest.vertices - along[:, None] * sight
    flat = places - (places @ sight)[:, None] * sight
    beside, near = (np.asarray(found) for found in cKDTree(across).query(flat))
    seen = np.flatnonzero(beside < rest.step)
    if len(seen):
        way: Array = along[near[seen]] - places[seen] @ sight
        return Gap(float(way[np.abs(way).argmin()]) * sight, depth)
    distance, nearest = (np.asarray(found) for found in cKDTree(rest.vertices).query(places))
    k = int(np.argmin(distance))
    return Gap(rest.vertices[nearest[k]] - places[k], depth)


def _meets_a_part(others: SilhouetteState, alone: Body) -> bool:
    """Whether a body overlaps one of the others, the nearest drawn first; none is made in vain.

    Nothing is known this way where some are taken away from others.
    """
    if any(node.operation not in ("add", "merge") for node in others.shown(Node)):
        return False
    middle = alone.bounds.mean(axis=0)
    gaps = [
        min(float(np.sqrt(((ring - middle) ** 2).sum(axis=1)).min()) for ring in rings)
        for rings in (drawn_rings(others, part) for part in shown_parts(others))
    ]
    for k in np.argsort(gaps, kind="stable"):
        part = shown_parts(others)[k]
        body = body_of(part, TOUCHED_CELLS).placed(_outer(others, part))
        if _overlap(alone, Assembly.of(body)):
            return True
    return False


def _overlap(alone: Body, whole: Assembly) -> bool:
    """Whether a body has a place within others, or they in it: asked after every stroke.

    The others need not be united for that.
    """
    if not meet(alone.bounds, whole.box):
        return False
    return bool(
        (whole.implicit.value(alone.vertices) > 0.0).any()
        or (alone.implicit.value(whole.places(alone.bounds)) > 0.0).any()
    )


def _outer(state: SilhouetteState, part: Part) -> Placement:
    """Return what the groups around a part do to it."""
    return carried(state, part).after(part.pose.inverse())


ATTACH = Command(
    "attach",
    "Attach",
    "Pull the chosen part, which touches nothing, onto the others.",
    attach,
    key="Shift+A",
    enabled=lambda state: bool(state.selected) and len(state.nodes) > 1,
)
