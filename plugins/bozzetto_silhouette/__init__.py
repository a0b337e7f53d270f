"""The silhouette modeler: a closed outline becomes a solid in the round."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_silhouette.modeler import Silhouette

    return [Silhouette()]
