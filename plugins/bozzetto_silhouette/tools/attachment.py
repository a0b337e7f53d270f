"""Attachment: a part that touches nothing is pulled onto the rest."""

from __future__ import annotations

from collections.abc import Iterator
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

MOST_NAMED = 3
"""Parts that touch nothing which are named each."""

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
    """Return for each part that touches nothing of the rest what pulls it on, a sentence each.

    Of many such parts, as of a handful of beads, the first ones are named and the others counted.
    """
    found = []
    for part in shown_parts(state):
        job.checkpoint(1.0, part.name)
        if _floating(state, part.id) is not None:
            found.append(part)
    offers = [offer_to_attach(part) for part in found[:MOST_NAMED]]
    if len(found) > MOST_NAMED:
        offers.append(f"{len(found) - MOST_NAMED} parts more touch nothing.")
    return offers


def offer_to_attach(part: Part) -> str:
    """Say of a part that touches nothing what pulls it on."""
    return f"“{part.name}” touches nothing. {ATTACH.title} ({ATTACH.key}) pulls it on."


def _floating(state: SilhouetteState, part_id: str) -> Part | None:
    part = next((part for part in state.parts if part.id == part_id), None)
    if part is None or part.surface == "straight" or part.operation not in ("add", "merge"):
        return None
    return part if is_shown(state, part) and not _touches(state, part) else None


# Asked for every part after every stroke: the rest is united only where something is cut from it.
@remembered(limit=256, key=lambda state, part: (state.unpainted, part.id))
def _touches(state: SilhouetteState, part: Part) -> bool:
    """Whether a part touches something of the rest, or nothing can be said of it."""
    others = state.without_nodes(part.id)
    try:
        alone = body_of(part, TOUCHED_CELLS).placed(_outer(state, part))
        if all(node.operation in ("add", "merge") for node in others.shown(Node)):
            rest = shown_parts(others)
            return not rest or any(_meet(alone, each) for each in _nearest(others, alone))
        whole = assembly_of(without_blends(others), TOUCHED_CELLS)
        if whole is None or _overlap(alone, whole):
            return True
        touch = shape_seen(others)
    except UserError:
        return True
    return touch is None or _touch(alone, touch.body)


@remembered(limit=16, key=lambda state, part: (state.unpainted, part.id))
def _gap(state: SilhouetteState, part: Part) -> Gap | None:
    """Find the way along the part's line of sight, else the shortest one; None if it touches."""
    from scipy.spatial import cKDTree

    if _touches(state, part):
        return None
    try:
        alone = body_of(part, TOUCHED_CELLS).placed(_outer(state, part))
        touch = shape_seen(state.without_nodes(part.id))
    except UserError:
        return None
    if touch is None:
        return None
    rest = touch.body
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


def _nearest(others: SilhouetteState, alone: Body) -> Iterator[Body]:
    """Yield the bodies of all other parts, the nearest drawn first; none is made in vain."""
    middle = alone.bounds.mean(axis=0)
    parts = shown_parts(others)
    gaps = [
        min(float(np.sqrt(((ring - middle) ** 2).sum(axis=1)).min()) for ring in rings)
        for rings in (drawn_rings(others, part) for part in parts)
    ]
    for k in np.argsort(gaps, kind="stable"):
        yield body_of(parts[k], TOUCHED_CELLS).placed(_outer(others, parts[k]))


def _meet(alone: Body, other: Body) -> bool:
    """Whether two bodies overlap or touch."""
    return _overlap(alone, Assembly.of(other)) or _touch(alone, other)


def _touch(alone: Body, other: Body) -> bool:
    """Whether there is no way between two bodies."""
    if not meet(alone.bounds, other.bounds):
        return False
    return bool(other.manifold.min_gap(alone.manifold, 0.5 * alone.step) <= 0.0)


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
