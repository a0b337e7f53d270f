"""The silhouette modeler: a closed outline becomes a solid in the round."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, PanelHost, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_silhouette.modeler import Silhouette

    return [Silhouette()]


@hookimpl
def bozzetto_panel(modeler_id: str, parent: object, host: PanelHost) -> object:
    """Return the motion panel: the key poses of a shape, and what can be done to them."""
    from PySide6.QtWidgets import QWidget

    from bozzetto_silhouette.panel.motion_panel import MotionPanel

    assert isinstance(parent, QWidget)
    return MotionPanel(host, parent)
