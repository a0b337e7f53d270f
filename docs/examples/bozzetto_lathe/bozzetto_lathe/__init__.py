"""A modeler for Bozzetto: a profile turns about an axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_lathe.modeler import Lathe

    return [Lathe()]
