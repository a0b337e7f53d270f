"""Rough skins: a closed surface over the curves of any other model, or of a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_skin.modeler import RoughSkin

    return [RoughSkin()]
