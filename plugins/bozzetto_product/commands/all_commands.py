"""All commands, in the order of the menu."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

from bozzetto.plugin import Command, Context
from bozzetto_product.commands.curve_commands import curve_commands
from bozzetto_product.commands.rough_commands import rough_commands
from bozzetto_product.commands.surface_commands import surface_commands
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.following import where_it_stands

Run: TypeAlias = Callable[[ProductState, Context], Any]


def all_commands() -> Sequence[Command]:
    """Return the commands in the order of the menu."""
    made = (*rough_commands(), *curve_commands(), *surface_commands())
    return tuple(replace(one, run=_on_what_it_follows(one.run)) for one in made)


def _on_what_it_follows(run: Run) -> Run:
    """Return what a command does to the product where it stands on what it follows."""

    def on_curves_there(state: ProductState, context: Context) -> Any:
        return run(where_it_stands(state, context.sources), context)

    return on_curves_there
