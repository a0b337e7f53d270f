"""Posing: joints that were turned, joints that are dragged, and the skin that follows.

A free end draws its whole limb along, up to where that leaves the body (`inverse_kinematics`). Any
other joint turns the bone that it ends, and with it all joints beyond it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Placement, Rig, Skin
from bozzetto.plugin import Drag, remembered
from bozzetto.scene import Handle, Layer, Lines, Points, Scene, Shaded
from bozzetto_silhouette.appearance.surface_look import Painted
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.model.sketch_plane import Point
from bozzetto_silhouette.model.state import SilhouetteState, Turn
from bozzetto_silhouette.rigging.armature import Armature, armature_of
from bozzetto_silhouette.rigging.inverse_kinematics import least_turn, limb_of, reached
from bozzetto_silhouette.rigging.skinning import followed, loosely_followed
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.draft import Drafted

JOINT = "joint:"
"""Beginning of the names of joints' handles; their number in the rig follows."""

SAME = 0.5
"""A turn belongs to a joint that is nearer to its place than this share of the radius there:
after small edits joints are still the same."""

SMALLEST = 0.005
"""The same as a share of the rig's longest side: at a pointed tip there is no radius."""

STILL: Final = 3.0
"""A joint that the pen moves by less, pixels, stays: that was a tap."""

BONES: Final = ("paper", 5.0), ("accent", 2.0)
DOTS: Final = ("paper", 12.0), ("accent", 9.0)
"""Colours and pixels of bones and roots, one over the other: the lighter rim shows them on shapes
that have about the colour of the accent."""


class Posed(NamedTuple):
    """A shape as its joints were turned.

    Attributes
    ----------
    mesh, shown : Mesh
        For files and for the screen.
    skin : Skin or None
        The joints and weights of `mesh`; None without joints.
    """

    mesh: Mesh
    shown: Mesh
    skin: Skin | None


class _Rest(NamedTuple):
    """A mesh for the screen before any turn, and what its vertices follow."""

    mesh: Mesh
    joints: NDArray[np.int32]
    weights: NDArray[np.float32]

    def posed(self, rig: Rig) -> Mesh:
        return Skin(rig, self.joints, self.weights).posed(self.mesh)


@remembered(limit=16, key=lambda nodes, armature, body, checkpoint: (nodes, body))
def _weights(
    nodes: tuple[Any, ...], armature: Armature, body: Body, checkpoint: Checkpoint
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    return followed(armature, body, checkpoint)


@remembered(
    limit=4,
    key=lambda nodes, armature, draft, checkpoint: (
        nodes, tuple(shell.lump.held for shell in draft.shells),
    ),
)  # fmt: skip
def _draft_weights(
    nodes: tuple[Any, ...], armature: Armature, draft: Drafted, checkpoint: Checkpoint
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    return loosely_followed(armature, draft, checkpoint)


@remembered(limit=16)
def _shown_last(nodes: tuple[Any, ...]) -> _Rest | None:
    """Return the shape that was shown last of some nodes: a drag does not change them."""
    return None


def rig_of(state: SilhouetteState) -> Rig | None:
    """Return the rig of a state with its turned joints; None without joints.

    Turns whose joint is not there (the ink was changed) wait until it is there again.
    """
    armature = armature_of(state)
    return None if armature is None else _turned(armature, state.turns)


def skinned(
    state: SilhouetteState,
    body: Body,
    look: Painted,
    checkpoint: Checkpoint = ignore,
) -> Posed:
    """Return a shape in the pose of its turned joints, and its skin weights.

    Parameters
    ----------
    state : SilhouetteState
        What was drawn, and how its joints were turned.
    body, look : Body, Painted
        The shape at rest.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.
    """
    armature = armature_of(state)
    if armature is None:
        return Posed(look.mesh, look.shown, None)
    joints, weights = _weights(state.unpainted, armature, body, checkpoint)
    # What is shown has the same faces; where colours meet some of its vertices are copies.
    original = np.zeros(len(look.shown.vertices), np.intp)
    original[look.shown.faces] = look.mesh.faces
    rest = _Rest(look.shown, joints[original], weights[original])
    _shown_last.put(rest, state.nodes)
    rig = _turned(armature, state.turns)
    skin = Skin(rig, joints, weights, None if rig.turns is None else look.mesh)
    mesh = skin.posed(look.mesh)
    return Posed(mesh, mesh if look.shown is look.mesh else rest.posed(rig), skin)


def bent(state: SilhouetteState, body: Body, mesh: Mesh) -> Mesh:
    """Return a mesh of a body, vertex for vertex, in the pose of the turned joints."""
    armature = armature_of(state) if state.turns else None
    if armature is None:
        return mesh
    joints, weights = _weights(state.unpainted, armature, body, ignore)
    return Skin(_turned(armature, state.turns), joints, weights).posed(mesh)


def skinned_draft(
    state: SilhouetteState, draft: Drafted, mesh: Mesh, checkpoint: Checkpoint = ignore
) -> Mesh:
    """Return the mesh of a draft in the pose of its turned joints.

    Every surface in it follows the joints of its own part, and fillets those of the parts beside
    them: what bends where parts meet is seen when the hand rests.
    """
    armature = armature_of(state)
    if armature is None:
        return mesh
    rest = _Rest(mesh, *_draft_weights(state.unpainted, armature, draft, checkpoint))
    _shown_last.put(rest, state.nodes)
    return rest.posed(_turned(armature, state.turns))


def rig_facts(rig: Rig) -> dict[str, Any]:
    """Return the number of joints, and the pairs of joints between which loops were cut."""
    cuts = [] if rig.cuts is None else rig.cuts.tolist()
    return {"joints": len(rig.joints), "cuts": [[rig.names[a], rig.names[b]] for a, b in cuts]}


def joints_layer(state: SilhouetteState) -> Layer | None:
    """Return bones as lines and joints as handles; None without joints."""
    rig = rig_of(state)
    if rig is None:
        return None
    _, places = rig.posed()
    ends = np.flatnonzero(rig.parents >= 0)
    bones = np.stack([places[rig.parents[ends]], places[ends]], axis=1).reshape(-1, 3)
    roots = places[rig.parents < 0]
    handles = tuple(
        Handle(f"{JOINT}{joint}", _triple(places[joint]), tip=rig.names[joint])
        for joint in ends.tolist()
    )
    around = roots.astype(np.float32)
    dots = tuple(Points(around, color=color, size=size, hidden="show") for color, size in DOTS)
    if not handles:
        return Layer("joints", dots)
    starts = np.arange(0, len(bones), 2, dtype=np.int32)
    between = bones.astype(np.float32)
    lines = tuple(
        Lines(between, starts, color=color, width=width, hidden="show") for color, width in BONES
    )
    return Layer("joints", (*lines, *dots, *handles))


def posed(state: SilhouetteState, drag: Drag) -> SilhouetteState:
    """Return the state after a joint was dragged parallel to the screen, as far as the pen went.

    Raises
    ------
    UserError
        If the joint is gone, is a root, or lies behind the eye.
    """
    armature = armature_of(state)
    rig = None if armature is None else _turned(armature, state.turns)
    digits = drag.handle.removeprefix(JOINT)
    number = int(digits) if digits.isdecimal() and digits.isascii() else -1
    if armature is None or rig is None or not 0 <= number < len(rig.joints):
        raise UserError("This joint is not there any more. Drag another one.")
    if rig.parents[number] < 0:
        raise UserError("All other joints follow this one. Drag another one.")
    path = drag.path.points
    if float(np.ptp(path, axis=0).max()) < STILL:
        return state
    rotations, places = rig.posed()
    axes = drag.camera.axes
    pixel = drag.camera.project(places[number : number + 1])[0] + path[-1] - path[0]
    target = drag.camera.on_plane(pixel, places[number], axes[2])[0]
    if not np.isfinite(target).all():
        raise UserError("The joint lies behind the eye. Turn the view, then drag.")

    row = limb_of(rig.parents, number)
    there = reached(places[row], target, axes[0])
    matched = _matched(armature, state.turns)
    others = tuple(turn for k, turn in enumerate(state.turns) if k not in matched.values())
    turns = {joint: state.turns[k] for joint, k in matched.items()}
    for k, joint in enumerate(row[:-1]):
        old, new = places[row[k + 1]] - places[joint], there[k + 1] - there[k]
        rotations[joint] = least_turn(old, new, axes[2]) @ rotations[joint]
        above = int(rig.parents[joint])
        own = rotations[joint] if above < 0 else rotations[above].T @ rotations[joint]
        turns[joint] = _turn_of(armature, joint, own)
    return replace(state, turns=(*others, *(turns[joint] for joint in sorted(turns))))


def posed_scene(state: SilhouetteState, drag: Drag) -> Scene:
    """Return a scene of what `posed` would give: the shape from before, moved by its skin alone."""
    try:
        after = posed(state, drag)
    except UserError:
        return Scene()
    rig, layer = rig_of(after), joints_layer(after)
    layers = [] if layer is None else [layer]
    rest = _shown_last.known(state.nodes)
    if rest is not None and rig is not None:
        layers.insert(0, Layer("shape", (Shaded(rest.posed(rig), pickable=False),)))
    return Scene(tuple(layers))


def _turn_of(armature: Armature, joint: int, matrix: Array) -> Turn:
    """Return the turn of a joint by a rotation in the model's frame."""
    from scipy.spatial.transform import Rotation

    limbs = armature.limbs_of(joint)
    home = limbs.placement.inverse()
    place = home.points(armature.rig.joints[joint])[0]
    x, y, z, w = Rotation.from_matrix(matrix).as_quat().tolist()
    x, y, z = _carried_axis(home, np.array([x, y, z])).tolist()
    return Turn(_triple(place), (w, x, y, z), limbs.part)


def _carried_axis(placement: Placement, axis: Array) -> Array:
    """Carry the axis of a rotation into another frame: a mirror also reverses its sense."""
    return np.asarray((-1.0 if placement.mirrors else 1.0) * placement.directions(axis)[0])


def _matched(armature: Armature, turns: tuple[Turn, ...]) -> dict[int, int]:
    """Match joints and turns: the nearest pairs first, each once."""
    if not turns:
        return {}
    joints = armature.rig.joints
    gaps = np.full((len(turns), len(joints)), np.inf)
    for k, turn in enumerate(turns):
        if not turn.part:
            gaps[k] = np.linalg.norm(joints - turn.joint, axis=1)
        for limbs in armature.limbs:
            if limbs.part == turn.part:
                place = limbs.placement.points(turn.joint)
                gaps[k, limbs.numbers] = np.linalg.norm(limbs.places - place, axis=1)
    reach = np.maximum(SAME * armature.radii, SMALLEST * float(np.ptp(joints, axis=0).max()))
    found: dict[int, int] = {}
    taken: set[int] = set()
    for flat in np.argsort(gaps, axis=None, kind="stable").tolist():
        number, joint = divmod(flat, len(joints))
        if gaps[number, joint] <= reach[joint] and joint not in found and number not in taken:
            found[joint] = number
            taken.add(number)
    return found


def _turned(armature: Armature, turns: tuple[Turn, ...]) -> Rig:
    """Return the rig with the turns of the joints that it has."""
    if not _matched(armature, turns):
        return armature.rig
    return replace(armature.rig, turns=quaternions_of(armature, turns))


def turns_of(armature: Armature, quaternions: Array) -> tuple[Turn, ...]:
    """Return the turns that pose an armature by quaternions, (n, 4), x, y, z, w."""
    from scipy.spatial.transform import Rotation

    turned = np.flatnonzero(np.abs(quaternions[:, :3]).max(axis=1) > 0.0)
    matrices = Rotation.from_quat(quaternions).as_matrix()
    return tuple(_turn_of(armature, joint, matrices[joint]) for joint in turned.tolist())


def quaternions_of(armature: Armature, turns: tuple[Turn, ...]) -> Array:
    """Return the quaternions, (n, 4), x, y, z, w, by which turns pose an armature."""
    matched = _matched(armature, turns)
    quaternions = np.tile([0.0, 0.0, 0.0, 1.0], (len(armature.rig.joints), 1))
    for joint, k in matched.items():
        w, *axis = turns[k].rotation
        largest = max(abs(w), *(abs(v) for v in axis))
        if largest > 0.0:  # a file may hold any finite numbers
            quaternion = np.array([*axis, w]) / largest
            if turns[k].part:
                placement = armature.limbs_of(joint).placement
                quaternion[:3] = _carried_axis(placement, quaternion[:3])
            quaternions[joint] = quaternion / np.linalg.norm(quaternion)
    return quaternions


def _triple(values: Array) -> Point:
    x, y, z = (float(v) for v in values)
    return x, y, z
