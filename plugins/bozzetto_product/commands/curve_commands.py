"""Commands on curves and joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto.plugin import Command, Context
from bozzetto.scene import Scene, Shaded
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.rough_shapes import FollowedShape, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.crease_split import split_at_creases
from bozzetto_product.operations.curve_edits import (
    make_in_plane,
    make_planar,
    make_symmetric,
    straighten,
)
from bozzetto_product.operations.drawing_plane import plane_of_places
from bozzetto_product.operations.meetings import is_end, splines_of
from bozzetto_product.operations.offset import offset_curve
from bozzetto_product.operations.pieces import delete_curves, join_curves, split_curve
from bozzetto_product.operations.proposals import accept
from bozzetto_product.operations.rounded_corners import rounded_corner
from bozzetto_product.operations.tangents import match_tangents
from bozzetto_product.operations.trim import trim
from bozzetto_product.solve.found_patches import with_patches_found
from bozzetto_product.view.scene import canvas_layer_name

Edit = Callable[[ProductState, Curve, Context], ProductState]

MENU: Final = "Curve"


def curve_commands() -> Sequence[Command]:
    """Return the commands on curves, most used first."""
    return (
        Command(
            "trim",
            "Trim: join ends that nearly meet",
            "Join all ends that nearly meet one another or a curve.",
            _trimmed,
            key="J",
            enabled=_has_curves,
            menu=MENU,
        ),
        Command(
            "join-wider",
            "Join the nearest gap",
            "Close the narrowest gap that is too wide to be joined by itself.",
            _joined_wider,
            enabled=_has_curves,
            menu=MENU,
        ),
        _command("split", "Split the curve", "Cut the chosen curve at its joints.", _split),
        _command(
            "split-creases",
            "Split at edges of the surface",
            "Cut the chosen curve where the surface that it was drawn on has an edge.",
            _split_at_creases,
        ),
        _command(
            "join",
            "Join curves to one",
            "Make one smooth curve of the chosen one and the one that it ends at.",
            _joined,
        ),
        _command("straighten", "Straighten", "Make the chosen curve a straight line.", _straight),
        _command(
            "planar",
            "Make planar",
            "Lay the chosen curve in the nearest plane, or in the one that new curves lie in.",
            _planar,
        ),
        _command(
            "mirror",
            "Mirror the curve",
            "Give the chosen curve its exact mirror image, or take it away.",
            _mirrored,
            key="M",
        ),
        _command(
            "in-plane",
            "Lay in the symmetry plane",
            "Lay the chosen curve in the symmetry plane, where it stays.",
            lambda state, curve, context: make_in_plane(state, curve.id),
        ),
        _command(
            "fillet",
            "Fillet",
            "Round the corner at which the chosen curve meets another one, by the radius “Fillet”.",
            _filleted,
        ),
        _command(
            "offset",
            "Offset along the surface",
            "Add a curve beside the chosen one, by the distance “Offset”.",
            _offset,
        ),
        _command(
            "match-tangents",
            "Match tangents",
            "Let the chosen curve and the one that it ends at run on without a kink.",
            _matched,
        ),
        _command(
            "delete-curve",
            "Delete the curve",
            "Take the chosen curve away, and its surfaces with it.",
            lambda state, curve, context: delete_curves(state, curve.id),
        ),
    )


def _command(name: str, title: str, help_text: str, edit: Edit, key: str = "") -> Command:
    """Return a command that edits the chosen curve; surfaces are found again after it."""

    def run(state: ProductState, context: Context) -> ProductState:
        curve = state.chosen_of(Curve)
        if curve is None or curve.spline is None:
            raise UserError("No curve is chosen. Choose one in the list, or touch it.")
        return with_patches_found(edit(state, curve, context))

    return Command(name, title, help_text, run, key, _has_curve, menu=MENU)


def _has_curves(state: ProductState) -> bool:
    return bool(state.of_kind(Curve))


def _has_curve(state: ProductState) -> bool:
    return state.chosen_of(Curve) is not None


def _trimmed(state: ProductState, context: Context) -> ProductState:
    done = trim(state)
    if done.state is state:
        if done.proposals:
            gap = done.proposals[0].distance
            raise UserError(
                f"No ends are near enough to be joined by themselves; the nearest are {gap:.3g} "
                "mm apart. Use “Join the nearest gap” to join them all the same."
            )
        raise UserError("All ends are joined already, or far from any curve.")
    return with_patches_found(done.state)


def _joined_wider(state: ProductState, context: Context) -> ProductState:
    proposals = trim(state).proposals
    if not proposals:
        raise UserError("There is no gap left that could be meant. Draw a curve over it.")
    return with_patches_found(accept(trim(state).state, proposals[0]))


def _split(state: ProductState, curve: Curve, context: Context) -> ProductState:
    shares = sorted(
        {
            meeting.at
            for joint in state.joints
            for meeting in joint.meetings
            if meeting.curve == curve.id and 0.0 < meeting.at < 1.0
        }
    )
    return split_curve(state, curve.id, shares or [0.5])[0]


def _straight(state: ProductState, curve: Curve, context: Context) -> ProductState:
    return straighten(state, curve.id)


def _planar(state: ProductState, curve: Curve, context: Context) -> ProductState:
    plane = plane_of_places(state) if state.lay == "plane" else None
    return make_planar(state, curve.id, plane)


def _split_at_creases(state: ProductState, curve: Curve, context: Context) -> ProductState:
    shapes = (*state.shown(RoughShape), *state.shown(FollowedShape))
    names = {canvas_layer_name(part.id) for part in shapes}
    layers = tuple(layer for layer in context.scene.layers if layer.name in names)
    return split_at_creases(state, curve.id, Scene(layers) if layers else context.scene)


def _mirrored(state: ProductState, curve: Curve, context: Context) -> ProductState:
    if curve.mirrored:
        return state.with_node(replace(curve, mirrored=False))
    return make_symmetric(state, curve.id)


def _filleted(state: ProductState, curve: Curve, context: Context) -> ProductState:
    joint, _, other = _partner(state, curve)
    if len(joint.meetings) > 2:
        raise UserError(
            "More than two curves end at this corner. Touch it between those that are meant, with "
            "the tool “Fillet”."
        )
    return rounded_corner(state, joint.id, curve.id, other.curve, state.rounding)


def _joined(state: ProductState, curve: Curve, context: Context) -> ProductState:
    _, own, other = _partner(state, curve)
    return join_curves(state, curve.id, own.at, other.curve, other.at)


def _matched(state: ProductState, curve: Curve, context: Context) -> ProductState:
    joint, _, other = _partner(state, curve)
    return match_tangents(state, joint.id, curve.id, other.curve)


def _partner(state: ProductState, curve: Curve) -> tuple[Joint, Meeting, Meeting]:
    """Return the joint at which a curve ends with another one, and both meetings there.

    A joint of two ends comes before one of more, the end of the curve before its start.

    Raises
    ------
    UserError
        If it ends with no other curve.
    """
    splines = splines_of(state)
    found: list[tuple[int, float, Joint, Meeting, Meeting]] = []
    for joint in state.joints:
        ends = [m for m in joint.meetings if m.curve in splines and is_end(splines, m)]
        own = [m for m in ends if m.curve == curve.id]
        others = (
            [m for m in ends if m.curve != curve.id and m.mirrored == own[0].mirrored]
            if own
            else []
        )
        if others:
            found.append((len(ends), -own[0].at, joint, own[0], others[0]))
    if not found:
        raise UserError("The chosen curve ends at no other one. Choose one that does.")
    *_, joint, first, second = min(found, key=lambda entry: entry[:2])
    return joint, first, second


def _offset(state: ProductState, curve: Curve, context: Context) -> ProductState:
    assert curve.spline is not None
    return offset_curve(state, curve.id, state.spacing, _nearest_surface(curve, context))[0]


def _nearest_surface(curve: Curve, context: Context) -> Mesh:
    """Return the visible surface that a curve lies on.

    Raises
    ------
    UserError
        If there is none.
    """
    from bozzetto.geometry import closest_on_mesh

    assert curve.spline is not None
    points = curve.spline.sampled(17)
    meshes = [
        item.mesh
        for _, item in context.scene.items()
        if isinstance(item, Shaded) and item.pickable and len(item.mesh.faces)
    ]
    if not meshes:
        raise UserError("There is no surface to measure along. Show the rough shape first.")
    gaps = [float(np.median(closest_on_mesh(mesh, points).distances)) for mesh in meshes]
    return meshes[int(np.argmin(gaps))]
