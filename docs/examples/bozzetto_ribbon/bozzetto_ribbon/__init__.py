"""A modeler for Bozzetto: a stroke becomes a ribbon."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """The one modeler of this plugin."""
    from bozzetto_ribbon.modeler import Ribbon

    return [Ribbon()]
