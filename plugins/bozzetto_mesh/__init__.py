"""Meshes made elsewhere: things to draw on, to look at and to hand on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_mesh.modeler import ImportedMesh

    return [ImportedMesh()]
