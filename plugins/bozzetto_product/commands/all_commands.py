"""All commands, in the order of the menu."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.plugin import Command
from bozzetto_product.commands.curve_commands import curve_commands
from bozzetto_product.commands.rough_commands import rough_commands
from bozzetto_product.commands.surface_commands import surface_commands


def all_commands() -> Sequence[Command]:
    """Return the commands in the order of the menu."""
    return (*rough_commands(), *curve_commands(), *surface_commands())
