"""Commands on rough shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, get_args

from bozzetto.plugin import Command, Context
from bozzetto_product.model.rough_shapes import FollowedShape, RoughKind, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.rough_shapes.shapes import SIZES

MENU: Final = "Rough shape"


def rough_commands() -> Sequence[Command]:
    """Return a command for each kind of rough shape, and those to hide and remove them."""
    kinds: tuple[RoughKind, ...] = get_args(RoughKind)
    return (
        *(
            Command(
                f"add-{kind.replace(' ', '-')}",
                f"Add rough {kind}",
                f"Put a {kind} on the sheet to draw on; it is no part of the product.",
                _adding(kind),
                menu=MENU,
            )
            for kind in kinds
        ),
        Command(
            "hide-rough",
            "Hide or show the rough shape",
            "The curves stay.",
            _hidden,
            key="H",
            enabled=_has_rough,
            menu=MENU,
        ),
        Command(
            "remove-rough",
            "Remove the rough shape",
            "The curves stay where they are, and follow no other object any more.",
            _removed,
            enabled=_has_rough,
            menu=MENU,
        ),
    )


def _has_rough(state: ProductState) -> bool:
    return bool(state.of_kind(RoughShape) or state.of_kind(FollowedShape))


def _adding(kind: RoughKind) -> Callable[[ProductState, Context], ProductState]:
    return lambda state, context: with_rough_shape(_without_idle_box(state), kind)


def begun_on_box(state: ProductState) -> ProductState:
    """Return an empty product with a box to draw on, until another rough shape is asked for."""
    return replace(with_rough_shape(state, "box"), selected="")


def _without_idle_box(state: ProductState) -> ProductState:
    """Return the state without the box that it began with, if nobody drew on it or chose it."""
    empty = replace(state, nodes=())
    return empty if len(state.nodes) == 1 and state == begun_on_box(empty) else state


def with_rough_shape(state: ProductState, kind: RoughKind) -> ProductState:
    """Return the state with a rough shape that stands on the ground, in the symmetry plane."""
    length, width, height = SIZES[kind]
    x, y, _ = state.symmetry.point
    part = RoughShape(
        state.unused_id(),
        state.unused_name(f"Rough {kind}"),
        centre=(float(x), float(y), 0.5 * height),
        kind=kind,
        length=length,
        width=width,
        height=height,
    )
    return state.with_node(part)


def _hidden(state: ProductState, context: Context) -> ProductState:
    parts = (*state.of_kind(RoughShape), *state.of_kind(FollowedShape))
    show = not any(part.visible for part in parts)
    ids = {part.id for part in parts}
    nodes = tuple(replace(node, visible=show) if node.id in ids else node for node in state.nodes)
    return replace(state, nodes=nodes)


def _removed(state: ProductState, context: Context) -> ProductState:
    """Return the state without what was drawn on; curves stay where they have gone with it.

    All commands get them there; see `all_commands`.
    """
    parts = (*state.of_kind(RoughShape), *state.of_kind(FollowedShape))
    return state.without_nodes(*(part.id for part in parts))
