"""Polyhedra: line drawings become solids with exact planes.

After Masry, Kang, Susilo & Lipson, "A Freehand Sketching Interface for Progressive Construction
and Analysis of 3D Objects", 2004.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, PanelHost, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_polyhedron.modeler import PolyhedronModeler

    return [PolyhedronModeler()]


@hookimpl
def bozzetto_panel(modeler_id: str, parent: object, host: PanelHost) -> object:
    """Return the answers panel: pictures of the solids that the drawing could mean."""
    from PySide6.QtWidgets import QWidget

    from bozzetto_polyhedron.panel.answers_panel import AnswersPanel

    assert isinstance(parent, QWidget)
    return AnswersPanel(host, parent)
