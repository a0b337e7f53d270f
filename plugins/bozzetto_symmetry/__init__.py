"""The symmetry modeler: both sides drawn in perspective become a symmetric curve in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_symmetry.modeler import Symmetry

    return [Symmetry()]
