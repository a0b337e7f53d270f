"""Handles of the chosen node: its middle moves it, two places on a ring turn and size it.

Beside the ring of a tool stands one more, which sets how deep it goes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto.scene import Handle, Item, Layer, Lines
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.extrude import acts_on
from bozzetto_silhouette.solids.placements import carried, is_shown, placement_of

ARRANGE = "arrange"
"""Id of the tool that shows handles: to any other pen they would only be in the way."""

ROOM = 1.12
"""Radius of the ring over that of the node's ink around its middle."""

RING_STEPS = 96

DEPTH_ANGLE = np.deg2rad(-110.0)
"""Where over the ring the handle stands that sets how deep a tool goes."""

ANGLES = np.deg2rad([-30.0, 70.0])
"""Where on the ring the handles for turning and for the size stand: apart from each other and
from the middle also where the ring is seen edge-on."""


@dataclass(frozen=True, eq=False)
class Grip:
    """The ring by which a node is held, in the model's frame, mm.

    Attributes
    ----------
    middle : (3,) float array
    right, up : (3,) float array
        Unit vectors of the plane of the ring.
    radius : float
        Of the ring.
    """

    middle: Array
    right: Array
    up: Array
    radius: float

    def on_ring(self, angles: Array) -> Array:
        """Return places on the ring, (n, 3)."""
        circle = np.outer(np.cos(angles), self.right) + np.outer(np.sin(angles), self.up)
        return np.asarray(self.middle + self.radius * circle, np.float64)


def members(state: SilhouetteState, node: Part | Group) -> tuple[Part, ...]:
    """Return the part itself, or all parts of a group and of the groups in it."""
    if isinstance(node, Part):
        return (node,)
    inside, size = {node.id}, 0
    while len(inside) > size:
        size = len(inside)
        inside |= {other.id for other in state.nodes if other.within in inside}
    return tuple(part for part in state.parts if part.id in inside)


def grip_of(state: SilhouetteState, node: Part | Group) -> Grip | None:
    """Return where a node is held; None where it has no ink that can be seen on its sheet."""
    parts = members(state, node)
    found = [places for part in parts if len(places := _inked(state, part))]
    if not found:
        return None
    sheet = parts[0].sheet
    right, up = carried(state, node).directions(np.stack([sheet.right, sheet.up]))
    points = np.concatenate(found)
    flat = np.column_stack([points @ right, points @ up])
    across = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    normal = np.cross(right, up)
    depth = points @ normal
    middle = across[0] * right + across[1] * up + 0.5 * (depth.min() + depth.max()) * normal
    radius = ROOM * float(np.hypot(*(flat - across).T).max())
    return Grip(middle, right, up, radius) if radius > 0.0 else None


@dataclass(frozen=True, eq=False)
class DepthGrip:
    """The handle that sets how deep a tool goes, in the model's frame.

    Attributes
    ----------
    start, place : (3,) float array
        Beside its outline, and as far behind it as the tool is deep.
    inwards : (3,) float array
        Unit vector.
    scale : float
        Millimetres there in one of the part's own.
    """

    start: Array
    place: Array
    inwards: Array
    scale: float

    def items(self, node: Part | Group) -> tuple[Item, ...]:
        """Return the handle and the line that it runs along."""
        line = np.stack([self.start, self.place]).astype(np.float32)
        return (
            Lines(line, color="accent", width=1.0, opacity=0.45, hidden="show"),
            _handle(f"depth:{node.id}", self.place, "Depth"),
        )


def depth_grip(state: SilhouetteState, node: Part | Group) -> DepthGrip | None:
    """Return where the depth of a tool is set; None for what has none."""
    grip = grip_of(state, node)
    if grip is None or not isinstance(node, Part) or not acts_on(node):
        return None
    (start,) = grip.on_ring(np.array([DEPTH_ANGLE]))
    stands = placement_of(state, node)
    inwards = -carried(state, node).directions(node.sheet.normal)[0]
    inwards = inwards / np.linalg.norm(inwards)
    return DepthGrip(start, start + stands.scale * node.depth * inwards, inwards, stands.scale)


def handles_layer(state: SilhouetteState) -> Layer | None:
    """Return the handles of the chosen node; None where nothing is chosen that can be seen."""
    node = next((node for node in state.nodes if node.id == state.selected), None)
    if node is None or not is_shown(state, node):
        return None
    grip = grip_of(state, node)
    if grip is None:
        return None
    turn, size = grip.on_ring(ANGLES)
    ring = grip.on_ring(np.linspace(0.0, 2.0 * np.pi, RING_STEPS + 1))
    depth = depth_grip(state, node)
    return Layer(
        "handles",
        (
            Lines(ring.astype(np.float32), color="accent", width=1.0, opacity=0.45, hidden="show"),
            _handle(f"move:{node.id}", grip.middle, "Move"),
            _handle(f"turn:{node.id}", turn, "Turn; with Shift by 15°"),
            _handle(f"size:{node.id}", size, "Size"),
            *([] if depth is None else depth.items(node)),
        ),
        tool=ARRANGE,
    )


def _handle(name: str, point: Array, tip: str) -> Handle:
    x, y, z = (float(v) for v in point)
    return Handle(name, (x, y, z), tip=tip)


def _inked(state: SilhouetteState, part: Part) -> Array:
    """Return a part's ink where it stands now, (n, 3)."""
    lines = [part.sheet.from_pixels(s.points, s.camera) for s in part.strokes]
    points = np.concatenate([np.zeros((0, 2)), *lines])
    points = points[np.isfinite(points).all(axis=1)]
    flat = np.column_stack([points, np.zeros(len(points))])
    return placement_of(state, part).points(flat)
