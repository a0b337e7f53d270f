"""Commands on surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Final

from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Command, Context
from bozzetto_product.model.curves import Curve, EdgeKind
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.found_patches import confirmed, with_patches_found, without_patches

SURFACE: Final = "Surface"
EDGE: Final = "Edge"


def surface_commands() -> Sequence[Command]:
    """Return the commands on surfaces and on how they meet."""
    return (
        Command(
            "delete-surface",
            "Switch the chosen surface off",
            "Leave the area open; the curves stay.",
            _without_surface,
            enabled=_has_surface,
            menu=SURFACE,
        ),
        Command(
            "forget-pulls",
            "Forget the pulls of the chosen surface",
            "It follows none of the strokes that pull it any more; the curves stay.",
            _without_pulls,
            enabled=_is_pulled,
            menu=SURFACE,
        ),
        Command(
            "confirm-all",
            "Confirm all surfaces",
            "What is surfaced now stays so, whatever is drawn besides.",
            lambda state, context: confirmed(state),
            enabled=_has_surfaces,
            menu=SURFACE,
        ),
        Command(
            "find-surfaces",
            "Find all surfaces again",
            "Forget which areas were switched off, and find all areas that curves enclose.",
            _found_again,
            enabled=_has_curves,
            menu=SURFACE,
        ),
        Command(
            "edge-smooth",
            "Meet smoothly",
            "Surfaces run smoothly over the chosen curve.",
            partial(_with_edge, "smooth"),
            key="Shift+K",
            enabled=_has_curve,
            menu=EDGE,
        ),
        Command(
            "edge-crease",
            "Meet in a crease",
            "Surfaces meet at an angle over the chosen curve.",
            partial(_with_edge, "crease"),
            key="K",
            enabled=_has_curve,
            menu=EDGE,
        ),
        Command(
            "edge-auto",
            "Meet as drawn",
            "The network decides how surfaces meet over the chosen curve.",
            partial(_with_edge, "auto"),
            enabled=_has_curve,
            menu=EDGE,
        ),
    )


def _has_surface(state: ProductState) -> bool:
    return state.chosen_of(Patch) is not None


def _has_surfaces(state: ProductState) -> bool:
    return bool(state.of_kind(Patch))


def _has_curves(state: ProductState) -> bool:
    return bool(state.of_kind(Curve))


def _has_curve(state: ProductState) -> bool:
    return state.chosen_of(Curve) is not None


def _without_surface(state: ProductState, context: Context) -> ProductState:
    patch = state.chosen_of(Patch)
    if patch is None:
        raise UserError("No surface is chosen. Choose one in the list.")
    return without_patches(state, [patch])


def _is_pulled(state: ProductState) -> bool:
    patch = state.chosen_of(Patch)
    return patch is not None and bool(len(patch.pulls) or len(patch.pulls_mirrored))


def _without_pulls(state: ProductState, context: Context) -> ProductState:
    patch = state.chosen_of(Patch)
    if patch is None:
        raise UserError("No surface is chosen. Choose one in the list.")
    return state.with_node(replace(patch, pulls=Strokes(), pulls_mirrored=Strokes()))


def _found_again(state: ProductState, context: Context) -> ProductState:
    return with_patches_found(replace(state, rejected=()))


def _with_edge(kind: EdgeKind, state: ProductState, context: Context) -> ProductState:
    curve = state.chosen_of(Curve)
    if curve is None:
        raise UserError("No curve is chosen. Choose one in the list, or touch it.")
    return state.with_node(replace(curve, edge=kind, stretches=()))
