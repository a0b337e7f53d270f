"""Rounded corners that remember what was there, and are rounded anew by another radius."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from typing import Any, Final

from bozzetto.errors import UserError
from bozzetto_product.model.arcs import Arc, Course, Rounded
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.fillet import fillet

CHANGED: Final = (
    "Curves at this corner were changed since it was rounded, so its radius stays. Undo these "
    "changes first, or delete the arc and draw the corner anew."
)


def rounded_corner(
    state: ProductState,
    joint: str,
    first: str,
    second: str,
    radius: float,
    ways: tuple[int, int] = (0, 0),
) -> ProductState:
    """Return the network with a corner rounded by an arc, chosen; see `fillet`.

    Raises
    ------
    UserError
        If the curves make no corner there, or the radius is too large.
    """
    made, name = fillet(state, joint, first, second, radius, ways)
    courses = tuple(
        Course(old.id, old.spline, old.laid, old.stretches)
        for old in state.of_kind(Curve)
        if old.spline is not None and made.node(old.id).spline is not old.spline
    )
    known = {one.id: one for one in made.joints}
    joints = tuple(one for one in state.joints if known.get(one.id) != one)
    was = {one.id for one in state.joints}
    boundaries = tuple(
        (old.id, old.boundary)
        for old in state.of_kind(Patch)
        if made.node(old.id).boundary != old.boundary
    )
    record = Rounded(
        joint, first, second, ways, courses, joints,
        tuple(one.id for one in made.joints if one.id not in was),
        boundaries, state.rejected, "",
    )  # fmt: skip
    record = replace(record, digest=_digest(made, record, name))
    plain = made.node(name)
    arc = Arc(**vars(plain), rounded=record, radius=radius)
    return made.with_node(arc)


def rounded_anew(state: ProductState, arc: Arc, radius: float) -> ProductState:
    """Return the network with a corner that was rounded by another radius.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    arc : Arc
        Of the corner, as it is now.
    radius : float
        mm.

    Raises
    ------
    UserError
        If curves there were changed since, or the radius is too large.
    """
    record = arc.rounded
    if record is None or _digest(state, record, arc.id) != record.digest:
        raise UserError(CHANGED)
    courses = {one.curve: one for one in record.courses}
    boundaries = dict(record.boundaries)
    nodes: list[Any] = []
    for node in state.nodes:
        if isinstance(node, Curve) and node.id in courses:
            was = courses[node.id]
            nodes.append(replace(node, spline=was.spline, laid=was.laid, stretches=was.stretches))
        elif isinstance(node, Patch) and node.id in boundaries:
            nodes.append(replace(node, boundary=boundaries[node.id]))
        elif node.id != arc.id:
            nodes.append(node)
    told = {*record.added, *(one.id for one in record.joints)}
    kept = tuple(one for one in state.joints if one.id not in told)
    before = replace(
        state, nodes=tuple(nodes), joints=(*kept, *record.joints), rejected=record.rejected
    )
    corner = (record.joint, record.first, record.second)
    made = rounded_corner(before, *corner, radius, record.ways)
    # All but its course stays what it was, its id and its place in the list among them.
    fresh = made.node(made.selected)
    number = next(k for k, node in enumerate(state.nodes) if node.id == arc.id)
    new = replace(arc, spline=fresh.spline, rounded=fresh.rounded, radius=radius)
    others = [node for node in made.nodes if node.id != fresh.id]
    made = replace(made, nodes=(*others[:number], new, *others[number:]))
    return replace(made, selected=state.selected)


def _digest(state: ProductState, record: Rounded, arc: str) -> str:
    """Return a digest of what a rounded corner says of a network, as that is in a state."""
    courses = {arc, *(one.curve for one in record.courses)}
    joints = {*record.added, *(one.id for one in record.joints)}
    patches = {name for name, _ in record.boundaries}
    found = sha256()
    for curve in state.of_kind(Curve):
        if curve.id in courses and curve.spline is not None:
            found.update(curve.spline.knots.tobytes() + curve.spline.control_points.tobytes())
            found.update(repr((curve.id, curve.mirrored, curve.stretches)).encode())
    for joint in sorted(state.joints, key=lambda one: one.id):
        if joint.id in joints:
            found.update(repr(joint).encode())
    for patch in state.of_kind(Patch):
        if patch.id in patches:
            found.update(repr((patch.id, patch.boundary)).encode())
    found.update(repr(state.rejected).encode())
    return found.hexdigest()
